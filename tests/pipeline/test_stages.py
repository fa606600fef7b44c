"""Stages are made once, whoever asks first, and a failure is told to whoever asks."""

from threading import Barrier, Event, Thread, current_thread, main_thread

import pytest

from pipeline.stages import Stages
from ros_free_stack.errors import NoWeights


def test_get_makes_once():
    stages, made = Stages(), []
    for _ in range(3):
        assert stages.get("a", lambda: made.append(1) or "stage") == "stage"
    assert made == [1]


def test_begin_makes_in_the_background_and_get_waits_for_it():
    stages, go, where = Stages(), Event(), []

    def make() -> str:
        go.wait()
        where.append(current_thread())
        return "stage"

    stages.begin("a", make)
    stages.begin("a", lambda: pytest.fail("it is on its way"))
    go.set()
    assert stages.get("a", lambda: pytest.fail("it is on its way")) == "stage"
    assert where[0] is not main_thread()


def test_a_stage_may_ask_for_another_one():
    stages = Stages()
    stages.begin("a", lambda: stages.get("b", lambda: 1) + 1)
    assert stages.get("b", lambda: 1) == 1
    assert stages.get("a", lambda: 0) == 2


def test_many_who_ask_at_once_get_the_same_one():
    stages, barrier, made, got = Stages(), Barrier(8), [], []

    def ask() -> None:
        barrier.wait()
        got.append(stages.get("a", lambda: made.append(1) or object()))

    threads = [Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1 and len(set(map(id, got))) == 1


@pytest.mark.parametrize("early", [False, True])
def test_a_failure_is_raised_where_the_stage_is_asked_for_and_may_be_tried_again(early: bool):
    stages, tries = Stages(), []

    def make() -> str:
        tries.append(1)
        if len(tries) < 3:
            raise NoWeights("folder", "durations")
        return "stage"

    if early:
        stages.begin("a", make)
    failed = 0
    while len(tries) < 3:
        try:
            stages.get("a", make)
        except NoWeights:
            failed += 1
    assert failed in ((1, 2) if early else (2,)), "one that nobody waited for is not lost, but tried again"
    assert stages.get("a", make) == "stage" and len(tries) == 3
