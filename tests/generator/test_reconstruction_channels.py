"""What the committed tokenizer keeps of each of the 263 features, on motions that it was not trained on.

A mean joint error hides a dead channel: a tokenizer of millimetres can lose all turning. So each channel is named.
"""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from generator import weights
from generator.corpus.build import make_mirrored_pair
from generator.datasets.authored import AuthoredCorpus
from generator.models.segmo.config import TokenizerConfig
from generator.models.segmo.objectives.tokenizer import channel_errors
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.registry import DEFAULT, WEIGHTS_FOLDER
from ros_free_stack.formats.features import CHANNELS

SEED, CLIPS = 98_765, 12

ROOT_BOUND, POSITION_BOUND, OTHER_BOUND = 0.2, 0.3, 0.8
"""Mean squared error over variance: 0 is exact, 1 is as bad as the mean of all motions. Positions and the root's
motion draw the figure; velocities and contacts repeat what they say, noisily, and weigh less in training. Rotations
hardly weigh at all: nothing reads them, and those of the trunk vary so little that any error of theirs is large."""


@pytest.fixture(scope="module")
def errors() -> np.ndarray:
    folder = WEIGHTS_FOLDER / DEFAULT / "tokenizer"
    if not (folder / weights.WEIGHTS).is_file():
        pytest.skip(f"there are no trained weights at {folder}")
    saved = weights.load(folder, "tokenizer")
    tokenizer = MotionTokenizer(saved.config_as(TokenizerConfig)).eval()
    saved.fill(tokenizer)
    made = [mirrored for number in range(CLIPS // 2) for mirrored in make_mirrored_pair(SEED, number)]
    starts = itertools.accumulate((mirrored.clip.length for mirrored in made), initial=0)
    clips = tuple(replace(mirrored.clip, start=start) for mirrored, start in zip(made, starts, strict=False))
    held = AuthoredCorpus(Path(), clips, np.concatenate([mirrored.rows for mirrored in made]), {})
    return channel_errors(tokenizer, held, clips)


def bound(channel: str) -> float:
    if channel.startswith("root_"):
        return ROOT_BOUND
    return POSITION_BOUND if "_position_" in channel else OTHER_BOUND


def test_no_channel_is_lost(errors: np.ndarray) -> None:
    lost = {
        name: round(float(error), 2)
        for name, error in zip(CHANNELS, errors, strict=True)
        if "_rotation_" not in name and not error <= bound(name)
    }
    assert not lost, f"relative squared error beyond the bound: {lost}"


def test_most_of_the_motion_is_kept(errors: np.ndarray) -> None:
    positions = [error for name, error in zip(CHANNELS, errors, strict=True) if "_position_" in name]
    assert len(errors) == 263
    assert np.median(positions) < 0.1
