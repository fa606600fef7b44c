"""Ranking: motions are ordered by the evaluator's distance to the sentence, at any length."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from generator.corpus.build import make_mirrored_pair
from generator.evaluation.embedder import CorpusEmbedder
from generator.nn.evaluator import EvaluatorConfig, MotionTextEvaluator
from generator.ranking import Ranker
from ros_free_stack.errors import NoWeights
from ros_free_stack.formats.features import decode
from ros_free_stack.messages import HumanMotion, Segment

SENTENCE = "a person waves with the left hand"


def motions(count: int) -> list[HumanMotion]:
    rows = [make_mirrored_pair(5, number)[0].rows for number in range(count)]
    return [HumanMotion(joints=decode(part), fps=20.0, prompt=SENTENCE, segments=(), source="corpus") for part in rows]


def test_distances_are_those_of_the_evaluator_and_each_motion_stands_alone() -> None:
    torch.manual_seed(0)
    model = MotionTextEvaluator(EvaluatorConfig(16, 1, 4, 8)).eval()
    ranker = Ranker(CorpusEmbedder(model, "tiny"))
    chosen = motions(3)
    together = ranker.distances(SENTENCE, chosen)
    assert together.shape == (3,)
    assert len(set(together.round(6))) == 3
    np.testing.assert_allclose(together[1:2], ranker.distances(SENTENCE, chosen[1:2]), rtol=1e-4)
    assert not np.allclose(together, ranker.distances("a person squats", chosen))


def test_a_long_motion_is_compared_part_by_part() -> None:
    """Longer than the evaluator sees: the mean over parts of whole segments with their own texts."""
    torch.manual_seed(0)
    ranker = Ranker(CorpusEmbedder(MotionTextEvaluator(EvaluatorConfig(16, 1, 4, 8)).eval(), "tiny"))
    texts = ("a person squats", "a person waves", "a person bows")
    segments = tuple(Segment(text, 4.0 * i, 4.0 * i + 4.0) for i, text in enumerate(texts))
    still = HumanMotion(np.tile(motions(1)[0].joints[:1], (241, 1, 1)), 20.0, "", segments)
    first = ranker.distances("a person squats, then a person waves", [replace(still, joints=still.joints[:161])])
    last = ranker.distances("a person bows", [replace(still, joints=still.joints[:81])])
    np.testing.assert_allclose(ranker.distances("of no matter", [still]), (first + last) / 2, rtol=1e-4)
    untold, seen = replace(still, segments=()), replace(still, joints=still.joints[:197], segments=())
    np.testing.assert_allclose(*(ranker.distances("a person bows", [motion]) for motion in (untold, seen)), rtol=1e-4)


def test_an_evaluator_that_was_never_trained_is_named(tmp_path: Path) -> None:
    with pytest.raises(NoWeights, match="evaluator"):
        Ranker.load(tmp_path)
