"""What makes a verdict one: the checks that a robot and its mount require, and their limits at a level.

The judge makes these checks and the servo driver demands them, so both read them here.
"""

from ros_free_stack.messages import Level, Mount
from ros_free_stack.robots import RobotDescription
from ros_free_stack.thresholds import Threshold, load_thresholds

_JOINTS = ("joint_range", "joint_velocity", "joint_acceleration", "jerk", "self_collision")
_FLOOR = ("ground_penetration", "floating", "foot_skate", "foot_skate_peak", "zmp_outside")
_COHERENCE = ("temporal_coherence", "spatial_coherence")
_STANDING = ("fall_height", "fall_orientation", "mpjpe_global")
_PLAYBACK = ("mpjpe_relative", "joint_velocity_error", "torque_peak", "torque_saturation")
_ELECTRIC = ("power_peak", "servo_heat")


def required_checks(robot: RobotDescription, mount: Mount, *, physics: bool = True) -> tuple[str, ...]:
    """Names of the checks without which a verdict of this robot on this mount says too little.

    Args:
        robot: one without arms or legs has no coherence, one of unknown motors no electricity.
        mount: a robot held by its root has neither floor nor balance.
        physics: with those of the playback.
    """
    free = mount == "free"
    names = _JOINTS + (_FLOOR if free else ()) + (_COHERENCE if robot.has_all_limbs else ())
    if not physics:
        return names
    electric = robot.servos is not None and robot.servos.motor is not None
    return names + (_STANDING if free else ()) + _PLAYBACK + (_ELECTRIC if electric else ())


def limits_of(robot: RobotDescription, level: Level) -> dict[str, Threshold]:
    """Every check's limit at one level, for a robot of this size.

    Raises:
        UnknownName: no such level.
        InvalidFile: the robot's model cannot be read.
    """
    from ros_free_stack.robot_model import kinematic_model, size_scale

    return load_thresholds(level, scale=size_scale(robot, kinematic_model(robot)))
