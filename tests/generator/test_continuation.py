"""Going on from a motion, editing a range, and appending prompts: continuity, what stays, refusals."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from generator.continuation import Continuation, concatenated
from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from generator.editing import edit
from generator.model import Sampling
from generator.performer import Performer, PerformerSettings
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import decode, encode
from ros_free_stack.messages import HumanMotion, Segment

WAVE = ("a person waves",)
BOTH = ("a person waves", "a person bows")
QUICK = PerformerSettings(Sampling(steps=3))


@pytest.fixture(scope="module")
def generator() -> Performer:
    """The models that come with the program."""
    return Performer.load()


@pytest.fixture(scope="module")
def walk() -> HumanMotion:
    """An authored walk of several seconds."""
    scene = Scene(0)
    perform(scene, "walk", steps=6)
    places = decode(encode(joints(scene.solve(0.5))))
    frames = len(places) // 4 * 4
    segments = (Segment("a person walks forward", 0.0, frames / 20),)
    return HumanMotion(joints=places[:frames], fps=20.0, prompt="a person walks forward", segments=segments)


def speeds(motion: np.ndarray) -> np.ndarray:
    """(T - 1,) the fastest joint's step from frame to frame, m."""
    return np.linalg.norm(np.diff(motion, axis=0), axis=-1).max(axis=1)


def bends(motion: np.ndarray) -> np.ndarray:
    """(T - 2,) the greatest change of a joint's step, m."""
    return np.linalg.norm(np.diff(motion, n=2, axis=0), axis=-1).max(axis=1)


@pytest.mark.parametrize("cut", [0, 13, 26])
def test_a_motion_goes_on_without_a_jump(generator: Performer, walk: HumanMotion, cut: int) -> None:
    start = replace(walk, joints=walk.joints[: len(walk.joints) - cut])
    (motion,) = generator.generate("a person waves", WAVE, seed=0, duration_s=3.0, start=start, settings=QUICK)
    assert motion.duration_s == pytest.approx(3.0)
    assert [segment.text for segment in motion.segments] == list(WAVE)
    whole = np.concatenate([start.joints, motion.joints])
    edge = len(start.joints)
    assert speeds(whole)[edge - 3 : edge + 3].max() < 0.25
    assert bends(whole)[edge - 3 : edge + 1].max() < 0.1


def test_parts_of_a_long_sentence_join_without_a_jump(generator: Performer) -> None:
    texts = ("a person walks forward", "a person squats four times", "a person claps four times", "a person bows")
    (motion,) = generator.generate(", then ".join(texts), texts, seed=0, settings=QUICK)
    assert motion.duration_s > 11
    assert [segment.text for segment in motion.segments] == list(texts)
    assert speeds(motion.joints).max() < 0.25
    edges = [round(segment.end_s * 20) for segment in motion.segments[:-1]]
    assert max(bends(motion.joints)[edge - 3 : edge + 1].max() for edge in edges) < 0.1


def test_a_range_is_replaced_and_the_rest_kept(generator: Performer, walk: HumanMotion) -> None:
    for start_s, end_s in ((1.0, 3.0), (0.0, 1.4), (2.0, walk.duration_s)):
        (edited,) = edit(generator, walk, "a person waves", WAVE, start_s=start_s, end_s=end_s, seed=0, settings=QUICK)
        first, last = round(start_s * 20), min(round(end_s * 20), len(walk.joints))
        assert len(edited.joints) == len(walk.joints)
        assert edited.joints[:first].tobytes() == walk.joints[:first].tobytes()
        assert not np.allclose(edited.joints[first:last], walk.joints[first:last], atol=0.01)
        np.testing.assert_allclose(  # the same poses, moved over the floor as a whole
            np.linalg.norm(np.diff(edited.joints[last:], axis=0), axis=-1),
            np.linalg.norm(np.diff(walk.joints[last:], axis=0), axis=-1),
            atol=1e-9,
        )
        for edge in (first, last):
            if 2 < edge < len(walk.joints) - 2:
                assert speeds(edited.joints)[edge - 2 : edge + 1].max() < 0.25
                assert bends(edited.joints)[edge - 2 : edge].max() < 0.16
        assert "a person waves" in [segment.text for segment in edited.segments]
        ends = [(segment.start_s, segment.end_s) for segment in edited.segments]
        assert all(a[1] == pytest.approx(b[0]) for a, b in pairwise(ends))


def test_prompts_are_appended_in_one_world(generator: Performer) -> None:
    def run() -> list[HumanMotion]:
        continuation = Continuation(generator, seed=3)
        return [continuation.append(text, (text,), duration_s=2.4) for text in (*BOTH, "a person walks forward")]

    chunks = run()
    whole = concatenated(chunks)
    assert whole.joints.tobytes() == concatenated(run()).joints.tobytes()
    assert len(whole.joints) == sum(len(chunk.joints) for chunk in chunks) == 144
    assert [segment.start_s for segment in whole.segments] == pytest.approx([0.0, 2.4, 4.8])
    edges = np.array([48, 96])
    assert max(bends(whole.joints)[edge - 3 : edge + 1].max() for edge in edges) < 0.16
    assert abs(chunks[2].joints[:, [10, 11], 2].min() - chunks[0].joints[:, [10, 11], 2].min()) < 0.01


def test_same_seed_same_bytes(generator: Performer, walk: HumanMotion) -> None:
    def run(seed: int) -> list[bytes]:
        motions = edit(
            generator, walk, "a person waves", WAVE, start_s=1, end_s=2, seed=seed, candidates=2, settings=QUICK
        )
        return [motion.joints.tobytes() for motion in motions]

    assert run(1) == run(1)
    assert run(1) != run(2)
    assert len(set(run(1))) == 2


@pytest.mark.parametrize(
    ("start_s", "end_s", "message"),
    [
        (-1.0, 1.0, "is not a range of a motion of"),
        (1.0, 60.0, "is not a range of a motion of"),
        (2.0, 1.0, "is not a range of a motion of"),
        (1.0, 1.2, "must last 0.4 to 7.8 s, found 0.2 s"),
    ],
)
def test_unusable_ranges(generator: Performer, walk: HumanMotion, start_s: float, end_s: float, message: str) -> None:
    with pytest.raises(InvalidOption, match=message):
        edit(generator, walk, "a person waves", WAVE, start_s=start_s, end_s=end_s, seed=0)


def test_the_whole_motion_is_no_range(generator: Performer, walk: HumanMotion) -> None:
    short = replace(walk, joints=walk.joints[:60])
    with pytest.raises(InvalidOption, match="is the whole motion"):
        edit(generator, short, "a person waves", WAVE, start_s=0, end_s=3, seed=0)


@pytest.mark.parametrize(
    ("change", "message"),
    [({"fps": 30.0}, "has 30 frames a second, the models need 20"), ({}, "needs at least 1 s to go on from")],
)
def test_unusable_starts(generator: Performer, walk: HumanMotion, change: dict[str, Any], message: str) -> None:
    start = replace(walk, **change) if change else replace(walk, joints=walk.joints[:10])
    with pytest.raises(InvalidOption, match=message):
        generator.generate("a person waves", WAVE, seed=0, start=start)


def test_no_room_for_so_much_after_a_start(generator: Performer, walk: HumanMotion) -> None:
    with pytest.raises(InvalidOption, match=r"outside of 2 to 8.8 s"):
        generator.generate("a person waves", WAVE, seed=0, start=walk, duration_s=9.5)
    with pytest.raises(InvalidOption, match="expected 1 to 4 where durations are given, found 5"):
        generator.generate("a person waves", WAVE * 5, seed=0, start=walk, duration_s=8.0)
    with pytest.raises(InvalidOption, match="expected 1 to 20, found 21"):
        generator.generate("a person waves", WAVE * 21, seed=0, start=walk)


def test_more_actions_than_the_model_takes_go_on_in_parts(generator: Performer, walk: HumanMotion) -> None:
    (motion,) = generator.generate("waves a lot", WAVE * 7, seed=0, start=walk)
    assert tuple(segment.text for segment in motion.segments) == WAVE * 7
    assert len(motion.joints) == round(motion.segments[-1].end_s * motion.fps)
