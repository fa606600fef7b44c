"""How fast the robot goes through the human's motion: slower where a step leaves it no time to shift its weight.

People hand their weight over in a tenth of a second, rolling over heel and toes. A robot with flat feet needs about the
time constant of its own pendulum, sqrt(h / g), with both soles down; until then the motion is played more slowly.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from retarget.clip.human import SIDES, HumanClip, foot_angles, joint, unit
from retarget.clip.runs import runs
from retarget.plan.footsteps import hand_overs
from retarget.plan.timeline import Pace
from ros_free_stack.messages import Floats

GRAVITY = 9.81
DOUBLE_SUPPORT = 1.3
"""Time on both feet while walking, in time constants of the pendulum."""
SWING = 2.0
"""Least time of a swing, in time constants of the pendulum."""
SWING_SPEED = 0.35
"""Mean speed of a swinging foot, in sqrt(g h)."""
PEAK_SPEED = 2.3
"""Peak speed of a joint in a swing over its mean speed, and a little to spare."""
LEAST_ANGLE = 0.9
"""Way in rad of the joints of a leg that steps with a robot's bent knees, however little the human's bend."""
WINDOW_S = 0.12
"""Least time of the human's own motion that is slowed down around a change of feet."""
SLOWEST = 0.35
_SMOOTHING_S = 0.05


@dataclass(frozen=True)
class Swing:
    """A foot in the air from frame `start` to `end` while the other one stands: `step` and `way` in m, `angle` in rad.

    `step` is from foothold to foothold over the floor; `way` adds up and down; `angle` is the larger of the foot's turn
    and the knee's bend.
    """

    start: int
    end: int
    step: float
    way: float
    angle: float


def swings(clip: HumanClip) -> list[Swing]:
    """Every swing between two footholds; jumps and feet that never land are none."""
    found: list[Swing] = []
    for foot, side in enumerate(SIDES):
        ankle = joint(clip.joints, f"{side}_ankle")
        yaw, _ = foot_angles(clip.joints, side, clip.foot_pitch_rest)
        knee = _knee_angle(clip, side)
        for start, end in runs(~clip.contacts[:, foot]):
            if start > 0 and end < len(ankle) and clip.contacts[start:end, 1 - foot].mean() > 0.5:
                step = float(np.linalg.norm((ankle[end] - ankle[start - 1])[:2]))
                height = max(float(ankle[start:end, 2].max()) - clip.ankle_rest, 0.0)
                turn = abs(float(np.mod(yaw[end] - yaw[start - 1] + np.pi, 2 * np.pi) - np.pi))
                angle = max(turn, float(np.ptp(knee[start - 1 : end + 1])))
                found.append(Swing(start, end, step, float(np.hypot(step, 2 * height)), angle))
    return found


def _knee_angle(clip: HumanClip, side: str) -> Floats:
    hip, knee, ankle = (joint(clip.joints, f"{side}_{name}") for name in ("hip", "knee", "ankle"))
    return np.arccos(np.clip((unit(knee - hip) * unit(ankle - knee)).sum(axis=1), -1, 1))


def double_support_s(hip_height: float) -> float:
    """Time on both feet in s that a robot of this height needs to shift its weight."""
    return DOUBLE_SUPPORT * float(np.sqrt(hip_height / GRAVITY))


def walking_pace(clip: HumanClip, hip_height: float, *, leg_speed: float, scale: float) -> Pace:
    """Slow down where feet take turns or swing too quickly.

    Args:
        clip: the human.
        hip_height: of the robot, m.
        leg_speed: largest speed of the slowest joint of a leg, rad/s.
        scale: of the robot's strides over the human's.
    """
    constant = float(np.sqrt(hip_height / GRAVITY))
    needed = DOUBLE_SUPPORT * constant
    rate = 200.0
    fastest = SWING_SPEED * np.sqrt(GRAVITY * hip_height)
    times = np.arange(round(clip.duration_s * rate) + 1) / rate
    if len(times) < 2:
        return Pace(np.array([0.0, max(clip.duration_s, 1e-9)]), np.array([0.0, max(clip.duration_s, 1e-9)]))
    slowness = np.ones(len(times))
    for change in hand_overs(clip.contacts, clip.fps):
        shared = max((change.lifted - change.landed) / clip.fps, WINDOW_S)
        middle = (change.lifted + change.landed) / 2 / clip.fps
        inside = np.abs(times - middle) <= shared / 2
        slowness[inside] = np.maximum(slowness[inside], min(needed / shared, 1 / SLOWEST))
    for swing in swings(clip):
        start, end = swing.start / clip.fps, swing.end / clip.fps
        inside = (times >= start) & (times <= end)
        wanted = max(
            scale * swing.way / fastest, SWING * constant, PEAK_SPEED * max(swing.angle, LEAST_ANGLE) / leg_speed
        )
        slowness[inside] = np.maximum(slowness[inside], min(wanted / (end - start), 1 / SLOWEST))
    slowness = gaussian_filter1d(slowness, _SMOOTHING_S * rate, mode="nearest")
    robot = np.concatenate([[0.0], np.cumsum((slowness[1:] + slowness[:-1]) / 2 / rate)])
    human = times * clip.duration_s / times[-1]
    return Pace(robot, human)
