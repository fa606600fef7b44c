import mujoco
import numpy as np
import pytest

from retarget.solve.differences import Stretch, moved, steps
from ros_free_stack.robot_model import kinematic_model
from ros_free_stack.robots import load_robot

MODEL = kinematic_model(load_robot("op3"))


def random_clip(count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    qpos = rng.normal(size=(count, MODEL.nq))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    return qpos


def test_moves_as_mujoco_does():
    qpos, increments = random_clip(10), np.random.default_rng(1).normal(0, 0.3, (10, MODEL.nv))
    found = moved(qpos, increments)
    for configuration, increment, result in zip(qpos, increments, found, strict=True):
        mujoco.mj_integratePos(MODEL, configuration, increment, 1.0)
        same = np.sign(configuration[3:7] @ result[3:7])
        configuration[3:7] *= same
        np.testing.assert_allclose(result, configuration, atol=1e-12)


def test_steps_as_mujoco_does():
    qpos, step = random_clip(10), np.zeros(MODEL.nv)
    for k, found in enumerate(steps(qpos)):
        mujoco.mj_differentiatePos(MODEL, step, 1.0, qpos[k], qpos[k + 1])
        np.testing.assert_allclose(found, step, atol=1e-9)


@pytest.mark.parametrize(
    ("start", "end", "total"), [(0, 12, 12), (0, 5, 12), (3, 9, 12), (7, 12, 12), (0, 1, 1), (0, 2, 2)]
)
def test_operators_say_how_joints_differences_change(start, end, total):
    clip, stretch = random_clip(total), Stretch(start, end, total)
    increments = np.random.default_rng(2).normal(0, 0.1, (end - start, MODEL.nv))
    before = steps(stretch.around(clip, clip[stretch.frames]))[:, 6:]
    after = steps(stretch.around(clip, moved(clip[stretch.frames], increments)))[:, 6:]
    first, second = stretch.operators()
    np.testing.assert_allclose(after - before, first @ increments[:, 6:], atol=1e-12)
    np.testing.assert_allclose(np.diff(after - before, axis=0), second @ increments[:, 6:], atol=1e-12)


def test_a_clip_rests_before_and_after():
    clip = random_clip(5)
    step = steps(Stretch(0, 5, 5).around(clip, clip))
    np.testing.assert_allclose(step[[0, 1, -2, -1]], 0, atol=1e-12)
    assert len(step) == 8
