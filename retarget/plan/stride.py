"""How far and how fast a robot can step: the share of the human's travel that its legs can make with flat feet."""

import mujoco
import numpy as np
from scipy.ndimage import maximum_filter1d

from retarget.body.geometry import RobotGeometry
from retarget.clip import human as hm
from retarget.clip.human import HumanClip, joint
from retarget.plan.pace import swings

LONGEST_LEG = 0.97
"""Share of its full length to which a leg that bears weight is stretched."""
LOWERED_HIP = 0.93
"""Height, in leg lengths, to which the hips may come down in a long step."""
SHORTEST_STRIDE = 0.6
LONGEST_STEP = 0.85
"""Way of a swinging foot from foothold to foothold, in heights of the hips."""
WIDER_STANCE = 1.2
"""Width of a stance over the one in which the body could still rest on one foot: it is passed through in motion."""
LANDING_S = 0.1
"""Time before touch-down and after lift-off in which a leg counts as bearing weight."""


def leg_speed(geometry: RobotGeometry) -> float:
    """Largest speed in rad/s of the slowest joint between the free base and a foot."""
    model, speeds = geometry.model, [np.inf]
    for foot in geometry.feet:
        body, above = foot.body, set[int]()
        while body != geometry.frames["pelvis"] and body != 0:
            above.add(body)
            body = int(model.body_parentid[body])
        speeds += [
            limits.velocity
            for name, limits in geometry.robot.joints.items()
            if int(model.jnt_bodyid[model.joint(name).id]) in above
        ]
    return float(min(speeds))


def stride_share(clip: HumanClip, geometry: RobotGeometry) -> float:
    """Share of the human's travel over the floor that the robot's legs can make with flat feet.

    A person's long step rests on the toes behind and the heel in front; a flat foot ends where the leg is straight.
    """
    leg = clip.leg_length
    reach = LONGEST_LEG * geometry.length("left_hip", "left_knee", "left_ankle") / geometry.hip_height * leg
    share = min(1.0, _longest_step(clip, geometry), _widest_stance(clip, geometry))
    for i, side in enumerate(hm.SIDES):
        standing = maximum_filter1d(clip.contacts[:, i], 2 * round(LANDING_S * clip.fps) + 1).astype(bool)
        across = (joint(clip.joints, f"{side}_hip") - joint(clip.joints, f"{side}_ankle"))[standing]
        height = np.minimum(across[:, 2], LOWERED_HIP * leg)
        allowed = np.sqrt(np.maximum(reach**2 - height**2, 0))
        flat = np.linalg.norm(across[:, :2], axis=1)
        share = min(share, float((allowed / np.maximum(flat, 1e-6)).min(initial=1.0)))
    return max(share, SHORTEST_STRIDE)


def _longest_step(clip: HumanClip, geometry: RobotGeometry) -> float:
    """Share of the human's travel at which no swing is longer than `LONGEST_STEP`."""
    longest = max((swing.step for swing in swings(clip)), default=0.0) * geometry.hip_height / clip.leg_length
    return LONGEST_STEP * geometry.hip_height / max(longest, 1e-6)


def _widest_stance(clip: HumanClip, geometry: RobotGeometry) -> float:
    """Share of the human's travel at which the ankles can roll far enough to bring the body over either foot."""
    both = clip.contacts.all(axis=1)
    if not both.any():
        return 1.0
    facing = hm.heading(clip.joints)[both]
    between = (joint(clip.joints, "left_ankle") - joint(clip.joints, "right_ankle"))[both]
    apart = between[:, 1] * np.cos(facing) - between[:, 0] * np.sin(facing)
    scale = geometry.hip_height / clip.leg_length
    hips = geometry.length("left_hip", "right_hip")
    leaning = np.tan(_ankle_roll(geometry)) * geometry.hip_height
    allowed = WIDER_STANCE * (leaning + hips / 2) - hips
    return allowed / max(float(apart.max() - clip.hip_width) * scale, 1e-6)


def _ankle_roll(geometry: RobotGeometry) -> float:
    """Least range in rad to either side of the joints that roll a foot; a right angle where none does."""
    model = geometry.model
    data = mujoco.MjData(model)
    data.qpos[:] = geometry.standing
    mujoco.mj_kinematics(model, data)
    ranges = [1.2]
    for foot in geometry.feet:
        for name, limits in geometry.robot.joints.items():
            hinge = model.joint(name).id
            near = model.jnt_bodyid[hinge] in (foot.body, model.body_parentid[foot.body])
            if near and abs(data.xaxis[hinge][0]) > 0.7:
                ranges.append(min(limits.upper, -limits.lower))
    return max(min(ranges), 0.0)
