"""In which order candidates are tried, when the search ends, and that its choice does not depend on when."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from generator.verifier import ABSENT
from pipeline.candidate import Sample
from pipeline.pipeline import Pipeline
from pipeline.timings import Timings
from ros_free_stack.messages import HumanMotion
from ros_free_stack.robots import load_robot

PROMPT = "a person waves"


class Scripted(Pipeline):
    """A pipeline whose samples, and what the judge finds in them, are given; it notes what was retargeted."""

    def __init__(self, samples: list[tuple[int, float, int]]) -> None:
        """`samples` are violations, distance and failed checks."""
        super().__init__(load_robot("op3"))
        self.given, self.tried = samples, list[int]()

    def generate(self, *_: Any, **__: Any) -> tuple[HumanMotion, ...]:
        still = HumanMotion(np.random.default_rng(0).normal(size=(40, 22, 3)), 20.0, PROMPT)
        return tuple(replace(still, source=str(k)) for k in range(len(self.given)))

    def compared(self, prompt: str, motions: Any) -> list[Sample]:
        found = []
        for motion in motions:
            violations, distance, _ = self.given[int(motion.source)]
            found.append(Sample(motion, violations, (), distance, faithful=violations < ABSENT))
        return sorted(found, key=lambda sample: sample.order)

    def retarget(self, motion: HumanMotion) -> Any:
        self.tried.append(int(motion.source))
        return int(motion.source), None

    def judge(self, trajectory: Any, controller: Any = None) -> Any:
        failed = self.given[trajectory][2]
        return SimpleNamespace(passed=not failed, verdict=SimpleNamespace(failures=(None,) * failed))


def search(samples: list[tuple[int, float, int]], *, exhaustive: bool) -> tuple[list[int], list[int]]:
    """What was tried, and what was found in order of preference."""
    pipeline = Scripted(samples)
    found = pipeline.candidates(
        PROMPT, (PROMPT,), seed=0, candidates=len(samples), timings=Timings(), exhaustive=exhaustive
    )
    return pipeline.tried, [int(candidate.motion.source) for candidate in found]


def test_candidates_what_shows_most_is_tried_first_and_the_first_that_passes_ends_it():
    samples = [(4, 0.1, 0), (0, 0.9, 0), (0, 0.5, 2), (1, 0.2, 0)]
    assert search(samples, exhaustive=False) == ([2, 1], [1, 2])
    assert search(samples, exhaustive=True) == ([2, 1, 3, 0], [1, 3, 0, 2])


def test_candidates_where_none_shows_every_action_the_first_feasible_one_ends_it():
    assert search([(ABSENT, 0.1, 1), (ABSENT, 0.2, 0), (ABSENT + 1, 0.1, 0)], exhaustive=False) == ([0, 1], [1, 0])


def test_candidates_one_that_lacks_an_action_does_not_end_the_search_while_another_one_may_not():
    """Samples as they may come from another verifier, with many small faults and all actions."""
    pipeline = Scripted([(ABSENT, 0.1, 0), (ABSENT + 1, 0.1, 0)])
    pipeline.compared = lambda prompt, motions: [  # type: ignore[method-assign]
        Sample(motions[0], ABSENT, (), 0.1, faithful=False),
        Sample(motions[1], ABSENT + 1, (), 0.1, faithful=True),
    ]
    found = pipeline.candidates(PROMPT, (PROMPT,), seed=0, candidates=2, timings=Timings())
    assert pipeline.tried == [0, 1] and found[0].motion.source == "1"


def test_candidates_where_none_passes_the_fewest_failed_checks_come_first():
    assert search([(0, 0.1, 3), (0, 0.2, 1)], exhaustive=False) == ([0, 1], [1, 0])


@given(st.lists(st.tuples(st.integers(0, 5), st.floats(0, 9), st.integers(0, 2)), min_size=1, max_size=8))
def test_candidates_exhaustive_search_changes_how_much_is_known_and_not_what_is_chosen(samples):
    tried, found = search(samples, exhaustive=False)
    all_tried, all_found = search(samples, exhaustive=True)
    assert all_found[0] == found[0]
    assert all_tried[: len(tried)] == tried and sorted(all_tried) == list(range(len(samples)))
    assert samples[tried[-1]][2] == 0 or len(tried) == len(samples)


@pytest.mark.parametrize("exhaustive", [False, True])
def test_candidates_repair_gets_what_was_judged_already(exhaustive: bool, monkeypatch: pytest.MonkeyPatch):
    """The best of the failed ones is handed on with its verdict, once."""
    handed = []
    monkeypatch.setattr(Scripted, "repair", lambda _, candidate: handed.append(candidate) or candidate)
    pipeline = Scripted([(0, 0.0, 2), (1, 0.0, 1)])
    found = pipeline.candidates(
        PROMPT, (PROMPT,), seed=0, candidates=2, timings=Timings(), repair=True, exhaustive=exhaustive
    )
    assert handed == [found[0]] and len(found[0].judgement.verdict.failures) == 1
