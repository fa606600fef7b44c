"""What a robot's trajectory comes to is measured on the trajectory, by the moments of the motion that it follows."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from generator.amounts import Wanted
from generator.text.frame import Amount, Kind
from pipeline.amounts import robot_measured
from retarget.pipeline import RetargetResult
from ros_free_stack.messages import HumanMotion, RobotTrajectory, Segment
from ros_free_stack.robots import load_robot

OP3 = load_robot("op3")
MOTION = HumanMotion(np.zeros((80, 22, 3)), 20.0, "", (Segment("walks", 0.0, 2.0), Segment("turns", 2.0, 4.0)))


def wanted(kind: Kind, segment: int) -> Wanted:
    return Wanted(segment, segment + 1, Amount(kind, 1.0, "1", (0, 1)))


@pytest.fixture
def result() -> RetargetResult:
    """Half a second of standing at either end; twice as slow as the person; 0.6 m in 4 s, then 200 degrees in 4 s."""
    human_s = np.concatenate([np.zeros(25), np.arange(401) / 100, np.full(25, 4.0)])
    root_pos = np.zeros((len(human_s), 3))
    root_pos[:, 0] = 0.3 * np.minimum(human_s, 2.0)
    turn = np.radians(100.0) * np.maximum(human_s - 2.0, 0.0)
    trajectory = RobotTrajectory(
        robot="op3",
        model_sha256=OP3.sha256,
        joint_names=OP3.joint_names,
        fps=50.0,
        root_pos=root_pos,
        root_quat=Rotation.from_rotvec(np.outer(turn, [0, 0, 1])).as_quat(scalar_first=True),
        joint_pos=np.tile(OP3.standing_pos, (len(human_s), 1)),
        contacts=np.ones((len(human_s), 2), bool),
        foot_names=OP3.foot_names,
    )
    return RetargetResult(trajectory, report=None, human_s=human_s)  # pyright: ignore[reportArgumentType]


def test_robot_measured_is_by_segment(result):
    walks, turns = robot_measured(MOTION, result, [wanted("distance", 0), wanted("angle", 1)])
    assert (walks.distance, walks.angle) == (pytest.approx(0.6), pytest.approx(0.0, abs=1e-9))
    assert (turns.distance, turns.angle) == (pytest.approx(0.0, abs=1e-9), pytest.approx(200.0, abs=0.01))
    assert walks.duration == pytest.approx(4.0, abs=0.021) and turns.duration == pytest.approx(4.0, abs=0.021)


def test_robot_measured_over_several_segments(result):
    (both,) = robot_measured(MOTION, result, [replace(wanted("duration", 0), last=2)])
    assert both.duration == pytest.approx(8.0, abs=0.021)
    assert (both.distance, both.angle) == (pytest.approx(0.6), pytest.approx(200.0, abs=0.01))
