"""Joint angles to goal positions and back, through direction, offset and range."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hw.calibration import Calibration, JointCalibration
from hw.rig import Rig
from ros_free_stack.errors import InvalidOption, UnknownName, UnsafeCommand
from ros_free_stack.robots import load_robot

OP3 = load_robot("op3")
JOINTS = ("head_pan", "r_el")


def calibrated(*, direction: int = -1, offset: float = 0.3, lower: float = -1.0, upper: float = 0.5) -> Rig:
    known = {
        "head_pan": JointCalibration(19, direction, offset, lower, upper),
        "r_el": JointCalibration(5),
    }
    return Rig.of_robot(OP3, calibration=Calibration("op3", known), only=JOINTS)


@given(st.sampled_from([1, -1]), st.floats(-1, 1), st.floats(-1.0, 0.5))
def test_an_angle_comes_back_through_the_servo(direction: int, offset: float, angle: float) -> None:
    rig = calibrated(direction=direction, offset=offset)
    raw = rig.to_raw(np.array([angle, 0.2]))
    assert np.abs(rig.to_angles(raw) - [angle, 0.2]).max() <= rig.tick.max() / 2 + 1e-12
    servo_angle = (raw[0] - rig.zero[0]) * rig.tick[0]
    assert servo_angle == pytest.approx(direction * angle + offset, abs=rig.tick[0])


def test_the_narrower_of_description_and_calibration_holds() -> None:
    inside, outside = calibrated(lower=-0.2, upper=0.1), calibrated(lower=-9.0, upper=9.0)
    assert (inside.lower[0], inside.upper[0]) == (-0.2, 0.1)
    limits = OP3.joints["head_pan"]
    assert (outside.lower[0], outside.upper[0]) == (limits.lower, limits.upper)


@pytest.mark.parametrize("wrong", [-1.1, 0.6, float("nan"), float("inf")])
def test_a_goal_outside_the_range_or_no_number_never_becomes_a_position(wrong: float) -> None:
    with pytest.raises(UnsafeCommand, match=r"goal of head_pan \(servo 19\).*outside -1.000 to 0.500"):
        calibrated().to_raw(np.array([[0.0, 0.0], [wrong, 0.0]]))


def test_the_first_step_is_measured_from_where_the_servo_is() -> None:
    rig = calibrated()
    step = rig.velocity * rig.cycle_s
    goals = np.array([[0.0, 0.0], 0.99 * step])
    rig.check_steps(np.zeros(2), goals)
    with pytest.raises(UnsafeCommand, match="goal 0 of r_el"):
        rig.check_steps(np.array([0.0, -1.1 * step[1]]), goals)
    with pytest.raises(UnsafeCommand, match="goal 1 of head_pan"):
        rig.check_steps(np.zeros(2), np.array([[0.0, 0.0], [-1.1 * step[0], 0.0]]))


def test_joints_that_are_not_there_are_named() -> None:
    with pytest.raises(UnknownName, match="tail"):
        Rig.of_robot(OP3, only=("tail",))
    with pytest.raises(InvalidOption, match="names no joint"):
        Rig.of_robot(OP3, only=())
    with pytest.raises(InvalidOption, match="no Dynamixel servos"):
        Rig.of_robot(replace(OP3, servos=None))
