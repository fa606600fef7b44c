"""The corpus benchmark: its numbers tell good motion from bad, its sheet is the same for the same seed."""

from pathlib import Path

import numpy as np

from benchmarks.corpus import measure, performance
from benchmarks.corpus_sheet import draw_sheet, human_figures
from ros_free_stack.formats.features import encode
from ros_free_stack.skeleton import JOINT_COUNT


def features(joints: np.ndarray) -> np.ndarray:
    return encode(joints).astype(np.float64)


def test_sliding_and_shaking_are_measured():
    joints = performance("walk", seed=1).joints
    times = np.arange(len(joints))[:, None, None] / 20
    slid = joints + 0.3 * times * [1, 0, 0]
    shaken = joints + 0.01 * np.random.default_rng(0).standard_normal((len(joints), JOINT_COUNT, 3))
    good, sliding, shaking = (measure([features(motion)], []) for motion in (joints, slid, shaken))
    assert sliding.foot_skate_cm_s > good.foot_skate_cm_s + 15
    assert shaking.jerk > good.jerk + 0.5
    assert shaking.still < good.still


def test_distance_is_nothing_to_itself_and_large_to_another_action():
    walks, waves = ([features(performance(name, seed).joints) for seed in range(8)] for name in ("walk", "wave"))
    same, other = measure(walks, walks).frechet, measure(waves, walks).frechet
    assert same is not None
    assert other is not None
    assert same < 1e-6
    assert other > 0.1


def test_sheet_is_reproducible(tmp_path: Path):
    for name in ("a.png", "b.png"):
        shown = performance("bow", seed=3)
        draw_sheet([(shown.title, human_figures(shown.joints, 4))], tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
