"""Motion that goes farther, turns more or takes longer: by as much as asked, on feet that stand."""

import numpy as np
import pytest

from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from generator.postprocess.foot_lock import find_stances, standing_height
from generator.postprocess.legs import ANKLES, BALLS, HIPS, KNEES
from generator.postprocess.path_warp import Change, Path, warped
from ros_free_stack.formats.features import encode
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS


def authored(action: str, seed: int = 1, **values) -> HumanMotion:
    scene = Scene(seed)
    perform(scene, action, **values)
    positions = joints(scene.solve(0.5))
    return HumanMotion(positions, FPS, action, (Segment(action, 0.0, len(positions) / FPS),))


def stances(motion: HumanMotion) -> np.ndarray:
    contacts = encode(motion.joints)[:, -4:].astype(float)
    return find_stances(motion.joints, np.concatenate([contacts, contacts[-1:]]), standing_height(motion.joints))


def slide(motion: HumanMotion, standing: np.ndarray) -> float:
    """Mean speed of the balls of standing feet, m/s."""
    speed = np.linalg.norm(np.diff(motion.joints[:, BALLS, :2], axis=0), axis=-1) * FPS
    return float(speed[standing[1:] & standing[:-1]].mean())


@pytest.mark.parametrize("travel", [0.6, 1.0, 1.35])
@pytest.mark.parametrize(("action", "values"), [("walk", {"steps": 5}), ("step", {"direction": "left"})])
def test_warped_goes_as_far_as_asked_on_feet_that_stand(action, values, travel):
    motion = authored(action, **values)
    bent = warped(motion, [Change(0.0, motion.duration_s, travel=travel)])
    before, after = Path.of(motion.joints), Path.of(bent.joints)
    ways = [np.linalg.norm(path.place[-1] - path.place[0]) for path in (before, after)]
    assert ways[1] == pytest.approx(travel * ways[0], rel=1e-6)
    standing = stances(motion)
    assert slide(bent, standing) < slide(motion, standing) + 0.01
    for upper, lower in ((HIPS, KNEES), (KNEES, ANKLES)):
        bones = np.linalg.norm(bent.joints[:, upper] - bent.joints[:, lower], axis=-1)
        assert np.ptp(bones, axis=0).max() < 0.02


@pytest.mark.parametrize("turn", [0.4, 1.5])
def test_warped_turns_as_much_as_asked_and_feet_do_not_slide(turn):
    motion = authored("turn", angle=90.0)
    bent = warped(motion, [Change(0.0, motion.duration_s, turn=turn)])
    angles = [np.ptp(Path.of(m.joints).heading[[0, -1]]) for m in (motion, bent)]
    assert angles[1] == pytest.approx(turn * angles[0], rel=1e-6)
    standing = stances(motion)
    assert slide(bent, standing) < slide(motion, standing) + 0.01


def test_warped_changes_a_range_and_carries_the_rest_along():
    motion = authored("walk", steps=6)
    half = motion.duration_s / 2
    bent = warped(motion, [Change(0.0, half, travel=1.3)])
    middle = round(half * FPS)
    old, new = Path.of(motion.joints), Path.of(bent.joints)
    assert np.linalg.norm(new.place[middle] - new.place[0]) > 1.25 * np.linalg.norm(old.place[middle] - old.place[0])
    assert np.allclose(np.diff(new.place[middle:], axis=0), np.diff(old.place[middle:], axis=0), atol=1e-9)


def test_warped_takes_as_long_as_asked_with_its_segments():
    motion = authored("walk", steps=4)
    half = motion.duration_s / 2
    motion = HumanMotion(motion.joints, FPS, "", (Segment("a", 0, half), Segment("b", half, motion.duration_s)))
    bent = warped(motion, [Change(half, motion.duration_s, time=1.5)])
    assert bent.duration_s == pytest.approx(1.25 * motion.duration_s, abs=1 / FPS)
    first, second = bent.segments
    assert first.end_s == pytest.approx(half) and second.end_s == pytest.approx(1.25 * motion.duration_s)
    frames = round(half * FPS)
    assert np.allclose(bent.joints[:frames], motion.joints[:frames], atol=1e-9)


def test_warped_by_nothing_is_the_same():
    motion = authored("walk", steps=3)
    assert np.array_equal(warped(motion, [Change(0.0, 1.0)]).joints, motion.joints)
