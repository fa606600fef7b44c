"""How high a robot's trajectory runs over the floor, and putting it down."""

from dataclasses import replace
from typing import Final

import numpy as np

from ros_free_stack.formats.frames import FLOOR_PERCENTILE
from ros_free_stack.formats.robot_places import body_places, configurations
from ros_free_stack.messages import Floats, RobotTrajectory
from ros_free_stack.robot_model import kinematic_model
from ros_free_stack.robots import load_robot

WORTH_A_WORD_M: Final = 0.01


def off_the_floor(corners: Floats, *, lower: bool) -> tuple[float, tuple[str, ...]]:
    """How far a motion is to be lowered so that its lowest sole stands on the floor, and what has to be said.

    Args:
        corners: (T, F, 4, 3) m of the soles; a robot without feet stays where it is.
        lower: whether the user asked for it; without, nothing is lowered, and what hovers or sinks is told.
    """
    if not corners.size:
        return 0.0, ()
    height = float(np.percentile(corners[..., 2].min(axis=(1, 2)), FLOOR_PERCENTILE))
    if lower:
        way = "lowered" if height > 0 else "raised"
        return height, (f"{way} by {100 * abs(height):.1f} cm: the lowest sole stands on the floor",)
    if abs(height) < WORTH_A_WORD_M:
        return 0.0, ()
    where = "above" if height > 0 else "below"
    return 0.0, (f"the lowest sole is {100 * abs(height):.1f} cm {where} the floor: --floor puts it there",)


def on_floor(trajectory: RobotTrajectory, *, lower: bool) -> tuple[RobotTrajectory, tuple[str, ...]]:
    """A trajectory on the floor, as `off_the_floor` has it."""
    robot = load_robot(trajectory.robot)
    model = kinematic_model(robot)
    qpos = configurations(model, robot, trajectory.root_pos, trajectory.root_quat, trajectory.joint_pos)
    height, said = off_the_floor(body_places(model, robot, qpos)[1], lower=lower)
    return replace(trajectory, root_pos=trajectory.root_pos - (0.0, 0.0, height)), said
