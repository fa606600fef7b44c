"""Small synthetic human motions for the retargeter's tests: a stick person of 1.7 m moved by hand-written curves."""

from collections.abc import Callable

import numpy as np
import pytest

from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import FPS, INDEX

REST = {
    "pelvis": (0.0, 0.0, 0.94),
    "left_hip": (0.0, 0.085, 0.865),
    "spine1": (-0.02, 0.0, 1.055),
    "left_knee": (0.02, 0.085, 0.47),
    "spine2": (-0.015, 0.0, 1.185),
    "left_ankle": (-0.02, 0.085, 0.075),
    "spine3": (-0.005, 0.0, 1.25),
    "left_foot": (0.11, 0.085, 0.02),
    "neck": (-0.02, 0.0, 1.455),
    "left_collar": (-0.015, 0.075, 1.365),
    "head": (0.0, 0.0, 1.555),
    "left_shoulder": (-0.02, 0.18, 1.40),
    "left_elbow": (-0.03, 0.21, 1.13),
    "left_wrist": (0.02, 0.22, 0.90),
}


def rest_pose(frames: int) -> Floats:
    """(T, 22, 3) of a person who stands."""
    pose = np.zeros((22, 3))
    for name, place in REST.items():
        pose[INDEX[name]] = place
        if name.startswith("left"):
            pose[INDEX[name.replace("left", "right")]] = np.array(place) * [1, -1, 1]
    return np.repeat(pose[None], frames, axis=0)


def rise(phase: Floats) -> Floats:
    """0 to 1 and back, smoothly, as phase goes from 0 to 1."""
    return np.sin(np.pi * np.clip(phase, 0, 1)) ** 2


def stand() -> Floats:
    return rest_pose(40)


def wave() -> Floats:
    """Right hand raised and swung three times, for 4 s."""
    joints = rest_pose(80)
    time = np.arange(80) / FPS
    up = rise(time / 4)
    swing = 0.5 * np.sin(2 * np.pi * 0.8 * time) * up
    shoulder = joints[:, INDEX["right_shoulder"]]
    upper = np.stack([0.1 + 0 * up, -0.2 - 0.8 * up, -1 + 1.1 * up], 1)
    fore = np.stack([0.2 + 0 * up, -0.1 + swing, -1 + 2 * up], 1)
    joints[:, INDEX["right_elbow"]] = shoulder + 0.27 * upper / np.linalg.norm(upper, axis=1, keepdims=True)
    joints[:, INDEX["right_wrist"]] = joints[:, INDEX["right_elbow"]] + 0.24 * fore / np.linalg.norm(
        fore, axis=1, keepdims=True
    )
    return joints


def squat() -> Floats:
    """Hips 0.3 m down and back up within 3 s, feet still."""
    joints = rest_pose(60)
    depth = 0.3 * rise(np.arange(60) / 59)
    feet = [INDEX[f"{side}_{name}"] for side in ("left", "right") for name in ("ankle", "foot")]
    for index in set(range(22)) - set(feet):
        joints[:, index, 2] -= depth
    for side in ("left", "right"):
        hip, ankle = joints[:, INDEX[f"{side}_hip"]], joints[:, INDEX[f"{side}_ankle"]]
        half = np.linalg.norm(hip - ankle, axis=1) / 2
        bend = np.sqrt(np.maximum(0.396**2 - half**2, 0))
        joints[:, INDEX[f"{side}_knee"]] = (hip + ankle) / 2 + bend[:, None] * [1, 0, 0]
    return joints


def steps() -> Floats:
    """Four slow steps forward of 0.3 m, one foot after the other, each with its time of double support."""
    frames, period = 110, 20
    joints = rest_pose(frames)
    travel = {"left": np.zeros(frames), "right": np.zeros(frames)}
    lift = {"left": np.zeros(frames), "right": np.zeros(frames)}
    for step, side in enumerate(("left", "right", "left", "right")):
        start = 15 + step * period
        phase = np.clip((np.arange(frames) - start) / 14, 0, 1)
        length = 0.15 if step in (0, 3) else 0.3
        travel[side] += length * (phase - np.sin(2 * np.pi * phase) / (2 * np.pi))
        lift[side] += 0.1 * rise(phase)
    middle = (travel["left"] + travel["right"]) / 2
    joints[..., 0] += middle[:, None]
    sway = 0.05 * np.interp(np.arange(frames), [0, 15, 22, 42, 62, 82, 95, 109], [0, 0, -1, 1, -1, 1, 0, 0])
    joints[..., 1] += sway[:, None]
    for side in ("left", "right"):
        for name in ("ankle", "foot"):
            joints[:, INDEX[f"{side}_{name}"], 0] += travel[side] - middle
            joints[:, INDEX[f"{side}_{name}"], 1] -= sway
            joints[:, INDEX[f"{side}_{name}"], 2] += lift[side]
        hip, ankle = joints[:, INDEX[f"{side}_hip"]], joints[:, INDEX[f"{side}_ankle"]]
        joints[:, INDEX[f"{side}_knee"]] = (hip + ankle) / 2 + [0.05, 0, 0]
    return joints


MOTIONS: dict[str, Callable[[], Floats]] = {"stand": stand, "wave": wave, "squat": squat, "steps": steps}


@pytest.fixture(scope="session")
def motions() -> dict[str, HumanMotion]:
    return {name: HumanMotion(make(), FPS, prompt=name, source="test") for name, make in MOTIONS.items()}
