"""The evaluator: padding does not matter, contrast of pairs, reflected features, and that it learns."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from generator import weights
from generator.bodies import channels
from generator.config import Training
from generator.corpus.mirror import mirror_joints
from generator.corpus.mirrored_features import mirror_features
from generator.datasets.authored import AuthoredCorpus
from generator.nn.evaluator import EvaluatorConfig, MotionTextEvaluator
from generator.text.word_vectors import WordVectors
from generator.training.evaluator import EvaluatorObjective, contrastive_loss
from generator.training.loop import Run, train
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import encode
from tests.generator.tiny_dataset import tiny_joints, write_tiny_dataset

TINY = EvaluatorConfig(32, 1, 4, 16)
TRAINING = Training(16, 60, 3e-3, warm_up=5, ema=0.0)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> AuthoredCorpus:
    return AuthoredCorpus.open(write_tiny_dataset(tmp_path_factory.mktemp("data") / "tiny", clips=40))


@pytest.fixture(scope="module")
def model() -> MotionTextEvaluator:
    torch.manual_seed(0)
    return MotionTextEvaluator(TINY).eval().requires_grad_(False)


def test_a_motions_embedding_does_not_depend_on_its_batch(model: MotionTextEvaluator) -> None:
    motions = [torch.randn(frames, 263) for frames in (41, 196, 4)]
    together = model.motion_embeddings(motions)
    assert together.shape == (3, 16)
    for row, motion in zip(together, motions, strict=True):
        assert torch.allclose(model.motion_embeddings([motion])[0], row, atol=1e-5)


@pytest.mark.parametrize("body", ["arms", "legs"])
def test_an_evaluator_of_a_part_looks_at_nothing_else(body: str) -> None:
    torch.manual_seed(0)
    model = MotionTextEvaluator(replace(TINY, body=body)).eval()
    motion, own = torch.randn(40, 263), list(channels(body))
    rest = [i for i in range(263) if i not in own]
    other, moved = motion.clone(), motion.clone()
    other[:, rest] += 3.0
    moved[:, own] += 3.0
    assert torch.equal(model.motion_embeddings([motion]), model.motion_embeddings([other]))
    assert not torch.allclose(model.motion_embeddings([motion]), model.motion_embeddings([moved]))


def test_foot_contacts_and_the_rest_of_a_token_are_not_looked_at(model: MotionTextEvaluator) -> None:
    motion = torch.randn(40, 263)
    other = torch.cat([motion, torch.randn(3, 263)])
    other[:, -4:] = 1.0
    assert torch.equal(model.motion_embeddings([motion]), model.motion_embeddings([other]))


def test_left_and_right_are_different_texts(model: MotionTextEvaluator) -> None:
    texts = ["a person waves with the left hand", "a person waves with the right hand", "a person bows"]
    together = model.text_embeddings(WordVectors()(texts, TINY.words))
    alone = model.text_embeddings(WordVectors()(texts[:1], TINY.words))
    assert torch.allclose(together[:1], alone, atol=1e-5)
    assert not torch.allclose(together[0], together[1], atol=1e-3)


def test_words_are_read_in_order_and_cut_at_the_longest() -> None:
    vectors = WordVectors()
    there, back = vectors(["left right", "right left"], 80)
    assert torch.equal(there, back.flip(0))
    assert there.shape == (2, 384)
    assert len(vectors(["a person somersaults"], 2)[0]) == 2
    assert len(vectors([""], 2)[0]) == 1


def test_reflected_features_are_the_features_of_the_reflected_motion() -> None:
    rng = np.random.default_rng(0)
    joints = tiny_joints(["a person waves with the left hand", "a person walks forward"], 30, rng)
    features, expected = encode(joints), encode(mirror_joints(joints))
    assert np.allclose(mirror_features(features.astype(np.float32)), expected, atol=1e-5)
    assert not np.allclose(features, expected, atol=1e-2)


def test_contrast_is_least_when_pairs_match_and_forgives_equal_words() -> None:
    text = torch.tensor([[0.0, 0.0], [20.0, 0.0], [0.0, 20.0]])
    nothing = torch.eye(3, dtype=torch.bool)
    assert contrastive_loss(text, text, nothing) < 1e-6
    swapped = text[[1, 0, 2]]
    assert contrastive_loss(swapped, text, nothing) > 5
    same = nothing.clone()
    same[0, 1] = same[1, 0] = True
    # With the swap forgiven, rows 0 and 1 only compete with row 2, which is 28 away instead of 20.
    assert contrastive_loss(swapped, text, same) < contrastive_loss(swapped, text, nothing)


def test_it_learns_to_find_the_motion_of_a_text(dataset: AuthoredCorpus, tmp_path: Path) -> None:
    torch.manual_seed(0)
    objective = EvaluatorObjective(dataset, TINY, TRAINING, seed=0)
    before = objective.validate(objective.model.eval())
    result = train(objective, TRAINING, tmp_path, Run(TRAINING.iterations))
    assert result["validation_loss"] < 0.7 * before["loss"]
    assert result["validation_top1"] > 2 * max(before["top1"], 1 / 16)
    saved = weights.load(tmp_path, "evaluator")
    restored = MotionTextEvaluator(saved.config_as(EvaluatorConfig))
    saved.fill(restored)
    assert np.allclose(restored.mean, dataset.mean)


def test_an_odd_batch_is_refused(dataset: AuthoredCorpus) -> None:
    with pytest.raises(InvalidOption, match="half of it are mirror images, found 15"):
        EvaluatorObjective(dataset, TINY, replace(TRAINING, batch=15), seed=0)
