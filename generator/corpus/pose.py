"""The pose space: one Euclidean description of a body for authored and captured motion alike.

Because every channel is a plain vector, poses of either origin blend, layer and mirror by simple arithmetic. Channels
(time first; angles in rad; `*` is left or right):
    root (3)      pelvis position                 heading (1)   direction of travel and of the body's front
    pelvis (3)    tilt x, tilt y, yaw from the heading           spine (3), neck (3)   rotation vectors
    collar_* (2)  elevation, protraction          arm_* (4)     direction chart (2), reach, elbow swivel
    foot_* (4)    ball of the flat foot, yaw      roll_* (1)    heel up positive, toes up negative
    knee_* (1)    outward swivel
Arm directions live in a frame that follows the chest's yaw but stays upright: arms hang when the trunk bends.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from generator.corpus import body
from generator.corpus.body import SIDES, SIGN, Floats, Side, mirrored, rotate, rotation_matrix, unit, yaw_matrix
from ros_free_stack.errors import InvalidMessage
from ros_free_stack.skeleton import INDEX, JOINT_COUNT

Pose = dict[str, Floats]

ARM_CHANNELS: Final = tuple(f"{name}_{side}" for name in ("collar", "arm") for side in SIDES)
LEG_CHANNELS: Final = tuple(f"{name}_{side}" for name in ("foot", "roll", "knee") for side in SIDES)
TRUNK_CHANNELS: Final = ("root", "heading", "pelvis", "spine", "neck")
CHANNELS: Final = TRUNK_CHANNELS + ARM_CHANNELS + LEG_CHANNELS

_STRAIGHT: Final = 0.02  # m: a knee that is less far off the leg's line shows little of the direction it bends to

# (proximal joint, distal joint, share of the body's mass, centre along the bone), after Winter's tables.
_SEGMENTS: Final = (
    ("pelvis", "spine3", 0.355, 0.55),
    ("spine3", "neck", 0.142, 0.5),
    ("neck", "head", 0.081, 1.2),
    *(
        (f"{side}_{a}", f"{side}_{b}", mass, share)
        for side in SIDES
        for a, b, mass, share in (
            ("hip", "knee", 0.100, 0.433),
            ("knee", "ankle", 0.0465, 0.433),
            ("ankle", "foot", 0.0145, 0.4),
            ("shoulder", "elbow", 0.028, 0.436),
            ("elbow", "wrist", 0.022, 0.68),
        )
    ),
)


def _mass_shares() -> Floats:
    """(22,) share of each joint in the centre of mass."""
    shares = np.zeros(JOINT_COUNT)
    for proximal, distal, mass, along in _SEGMENTS:
        shares[INDEX[proximal]] += mass * (1 - along)
        shares[INDEX[distal]] += mass * along
    return shares / shares.sum()


_MASS_SHARES: Final = _mass_shares()


def trunk_frames(pose: Pose) -> tuple[Floats, Floats, Floats, Floats]:
    """Rotations (T, 3, 3) of the pelvis and of the three spine joints, which share the spine's bend equally."""
    pelvis = yaw_matrix(pose["heading"] + pose["pelvis"][:, 2]) @ rotation_matrix(pose["pelvis"] * [1.0, 1.0, 0.0])
    third = rotation_matrix(pose["spine"] / 3)
    lower = pelvis @ third
    middle = lower @ third
    return pelvis, lower, middle, middle @ third


def arm_frame(chest: Floats) -> Floats:
    """(T, 3, 3) upright frame with the chest's yaw, in which arm directions are given."""
    return yaw_matrix(np.arctan2(-chest[:, 0, 1], chest[:, 1, 1]))


@dataclass(frozen=True)
class Leg:
    """One leg of a pose, wherever its pelvis is.

    Attributes:
        hip: (T, 3) from the root, along the world's axes.
        ankle, ball: (T, 3) where the foot wants them.
        pole: (T, 3) direction in the pelvis into which the knee of a leg that hangs down bends at swivel 0.
        swivel: (T,) of the knee about the leg.
        pelvis: (T, 3, 3) its frame.
    """

    hip: Floats
    ankle: Floats
    ball: Floats
    pole: Floats
    swivel: Floats
    pelvis: Floats

    @classmethod
    def of(cls, pose: Pose, side: str, pelvis: Floats) -> "Leg":
        ankle, ball = body.ankle_and_ball(pose[f"foot_{side}"], pose[f"roll_{side}"])
        hip = rotate(pelvis, mirrored(body.HIP, side))
        return cls(hip, ankle, ball, _knee_pole(pose, side), pose[f"knee_{side}"] * SIGN[side], pelvis)

    def joints(self, root: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Hip, knee, ankle and ball (T, 3) of the leg on a pelvis at `root` (T, 3); out of reach it ends short."""
        hip = root + self.hip
        pole = _swung_pole(self.pole, self.ankle - hip, self.pelvis)
        knee, ankle = body.two_bone(hip, self.ankle, body.THIGH, body.SHANK, pole, self.swivel)
        return hip, knee, ankle, self.ball + ankle - self.ankle


def _knee_pole(pose: Pose, side: str) -> Floats:
    """(T, 3) in the pelvis: between its front and the foot's."""
    outward = 0.5 * np.sin(pose[f"foot_{side}"][:, 3] - pose["heading"])  # half the foot's; no angle makes it jump
    return rotate(yaw_matrix(outward), mirrored([1.0, 0.08, 0.0], side))


def _swung_pole(pole: Floats, leg: Floats, pelvis: Floats) -> Floats:
    """(T, 3) in the world: the pole of a hanging leg after it swung to `leg` (T, 3; from hip to ankle)."""
    return rotate(pelvis, body.swung(pole, rotate(np.swapaxes(pelvis, 1, 2), leg)))


def joints(pose: Pose) -> Floats:
    """Joint positions (T, 22, 3) of a pose."""
    frames = trunk_frames(pose)
    out = upper_body(pose, frames)
    place_legs({side: Leg.of(pose, side, frames[0]) for side in SIDES}, out)
    return out


def upper_body(pose: Pose, frames: tuple[Floats, Floats, Floats, Floats]) -> Floats:
    """Joint positions (T, 22, 3) with those of the legs left at zero; `frames` are the pose's `trunk_frames`."""
    out = np.zeros((len(pose["root"]), JOINT_COUNT, 3))
    out[:, 0] = pose["root"]
    for parent, child, frame, offset in zip(
        ("pelvis", "spine1", "spine2"), ("spine1", "spine2", "spine3"), frames, body.SPINE, strict=False
    ):
        out[:, INDEX[child]] = out[:, INDEX[parent]] + rotate(frame, offset)
    chest = frames[3]
    out[:, INDEX["neck"]] = out[:, INDEX["spine3"]] + rotate(chest, body.NECK)
    out[:, INDEX["head"]] = out[:, INDEX["neck"]] + rotate(chest @ rotation_matrix(pose["neck"]), body.HEAD)
    for side in SIDES:
        _arm_joints(pose, side, chest, out)
    return out


def place_legs(legs: dict[Side, Leg], out: Floats) -> None:
    """Set the legs' joints of `out` (T, 22, 3) so that they hang on its pelvis."""
    for side, leg in legs.items():
        for name, place in zip(("hip", "knee", "ankle", "foot"), leg.joints(out[:, 0]), strict=True):
            out[:, INDEX[f"{side}_{name}"]] = place


def _arm_joints(pose: Pose, side: str, chest: Floats, out: Floats) -> None:
    collar = pose[f"collar_{side}"]
    turn = np.stack([collar[:, 0], np.zeros(len(collar)), -collar[:, 1]], -1) * SIGN[side]
    root = out[:, INDEX["spine3"]] + rotate(chest, mirrored(body.COLLAR, side))
    shoulder = root + rotate(chest @ rotation_matrix(turn), mirrored(body.SHOULDER, side))
    arm, frame = pose[f"arm_{side}"], arm_frame(chest)
    reach = np.clip(arm[:, 2:3], 0.25, 0.999) * body.ARM
    target = shoulder + rotate(frame, body.chart_to_direction(arm[:, :2], side)) * reach
    pole = rotate(frame, body.elbow_pole(side))
    elbow, wrist = body.two_bone(shoulder, target, body.UPPER_ARM, body.FOREARM, pole, arm[:, 3] * SIGN[side])
    for name, place in (("collar", root), ("shoulder", shoulder), ("elbow", elbow), ("wrist", wrist)):
        out[:, INDEX[f"{side}_{name}"]] = place


def centre_of_mass(joints: Floats) -> Floats:
    """(T, 3) centre of mass of joints (T, 22, 3), from the segments' shares of the body's mass."""
    return np.einsum("j,tjk->tk", _MASS_SHARES, joints)


def mirror(pose: Pose) -> Pose:
    """The left-right reflection of a pose (about the plane y = 0)."""
    flipped = {"root": (1, -1, 1), "pelvis": (-1, 1, -1), "spine": (-1, 1, -1), "neck": (-1, 1, -1)}
    out = {name: pose[name] * np.array(signs, dtype=float) for name, signs in flipped.items()}
    out["heading"] = -pose["heading"]
    for name in ("collar", "arm", "foot", "roll", "knee"):
        signs = np.array([1.0, -1.0, 1.0, -1.0]) if name == "foot" else 1.0
        for side in SIDES:
            out[f"{name}_{side}"] = pose[f"{name}_{body.OTHER[side]}"] * signs
    return out


def fit(joints: Floats) -> Pose:
    """Pose of captured joints (T, 22, 3), scaled to the reference body and set on its floor: inverse of `joints`.

    Raises:
        InvalidMessage: `joints` has another shape or is not finite.
    """
    joints = np.asarray(joints, dtype=float)
    if joints.ndim != 3 or joints.shape[1:] != (JOINT_COUNT, 3) or not len(joints):
        raise InvalidMessage("fit", "joints", f"expected shape (any, {JOINT_COUNT}, 3), found {joints.shape}")
    if not np.isfinite(joints).all():
        raise InvalidMessage("fit", "joints", "expected finite values")
    places = _on_reference_body(joints)
    pose = _fit_trunk(places)
    chest = trunk_frames(pose)[3]
    for side in SIDES:
        _fit_arm(places, pose, side, arm_frame(chest))
        _fit_leg(places, pose, side)
    return pose


def _on_reference_body(joints: Floats) -> dict[str, Floats]:
    """Joints by name, scaled by the length of the legs, the balls' lowest places on the floor."""

    def length(a: str, b: str) -> Floats:
        return np.linalg.norm(joints[:, INDEX[a]] - joints[:, INDEX[b]], axis=-1)

    legs = np.median([length(f"{s}_hip", f"{s}_knee") + length(f"{s}_knee", f"{s}_ankle") for s in SIDES])
    balls = np.minimum(joints[:, INDEX["left_foot"], 2], joints[:, INDEX["right_foot"], 2])
    scaled = (joints - [0.0, 0.0, np.percentile(balls, 5)]) * (body.LEG / legs) + [0.0, 0.0, body.BALL_HEIGHT]
    return {name: scaled[:, i] for name, i in INDEX.items()}


def _frame(left: Floats, up: Floats) -> Floats:
    """(T, 3, 3) frame with the given left axis and, as nearly as can be, the given up axis."""
    forward = unit(np.cross(left, up))
    return np.stack([forward, left, np.cross(forward, left)], -1)


def _near(angle: Floats, reference: Floats | float) -> Floats:
    """The unwrapped angle, moved by whole turns to lie about the reference."""
    angle = np.unwrap(angle)
    return angle - 2 * np.pi * np.round(np.median(angle - reference) / (2 * np.pi))


def _fit_trunk(places: dict[str, Floats]) -> Pose:
    hips, shoulders = (unit(places[f"left_{n}"] - places[f"right_{n}"]) for n in ("hip", "shoulder"))
    middle = 0.5 * (places["left_hip"] + places["right_hip"])
    pelvis = _frame(hips, unit(places["spine2"] - middle))
    chest = _frame(shoulders, unit(places["neck"] - places["spine2"]))
    both = hips + shoulders
    heading = np.unwrap(np.arctan2(-both[:, 0], both[:, 1]))
    yaw = _near(np.arctan2(-hips[:, 0], hips[:, 1]), heading)
    tilt = Rotation.from_matrix(np.swapaxes(yaw_matrix(yaw), 1, 2) @ pelvis).as_rotvec()
    pose: Pose = {"heading": heading, "pelvis": np.column_stack([tilt[:, :2], yaw - heading])}
    pelvis = trunk_frames({**pose, "spine": np.zeros_like(tilt)})[0]
    pose["spine"] = Rotation.from_matrix(np.swapaxes(pelvis, 1, 2) @ chest).as_rotvec()
    pose["root"] = middle - rotate(pelvis, body.HIP * [1.0, 0.0, 1.0])
    chest = trunk_frames(pose)[3]
    skull, rest = rotate(np.swapaxes(chest, 1, 2), unit(places["head"] - places["neck"])), unit(body.HEAD)
    axis = np.cross(rest, skull)
    pose["neck"] = unit(axis) * np.arctan2(np.linalg.norm(axis, axis=-1), skull @ rest)[:, None]
    return pose


def _fit_arm(places: dict[str, Floats], pose: Pose, side: str, frame: Floats) -> None:
    shoulder, elbow, wrist = (places[f"{side}_{name}"] for name in ("shoulder", "elbow", "wrist"))
    bones = np.linalg.norm(elbow - shoulder, axis=-1) + np.linalg.norm(wrist - elbow, axis=-1)
    chart = body.direction_to_chart(rotate(np.swapaxes(frame, 1, 2), wrist - shoulder), side)
    reach = np.linalg.norm(wrist - shoulder, axis=-1) / np.median(bones)
    ahead, aside = body.bend(shoulder, elbow, wrist, rotate(frame, body.elbow_pole(side)))
    swivel = np.arctan2(aside, ahead) * SIGN[side]
    pose[f"arm_{side}"] = np.column_stack([chart, reach, _near(swivel, 0.0)])
    pose[f"collar_{side}"] = np.zeros((len(wrist), 2))


def _fit_leg(places: dict[str, Floats], pose: Pose, side: str) -> None:
    hip, knee, ankle, ball = (places[f"{side}_{name}"] for name in ("hip", "knee", "ankle", "foot"))
    yaw = _near(_foot_yaw(knee, ankle, ball), pose["heading"])
    sole = rotate(np.swapaxes(yaw_matrix(yaw), 1, 2), ball - ankle)
    pitch = np.arctan2(-sole[:, 2], sole[:, 0])
    low = ball[:, 2] <= np.percentile(ball[:, 2], 40)
    roll = pitch - np.percentile(pitch[low], 20)  # captured feet differ in height: flat is how this one mostly stands
    foot = np.column_stack([np.zeros((len(yaw), 3)), yaw])
    foot[:, :3] = ankle - body.ankle_and_ball(foot, roll)[0]
    foot[:, 2] -= np.percentile(foot[:, 2], 3) - body.BALL_HEIGHT
    pose[f"foot_{side}"], pose[f"roll_{side}"] = foot, roll
    pole = _swung_pole(_knee_pole(pose, side), ankle - hip, trunk_frames(pose)[0])
    ahead, aside = body.bend(hip, knee, ankle, pole)
    pose[f"knee_{side}"] = np.arctan2(aside, np.maximum(ahead, 0.0) + _STRAIGHT) * SIGN[side]  # knees bend one way


def _foot_yaw(knee: Floats, ankle: Floats, ball: Floats) -> Floats:
    """(T,) where a foot points, also when its sole is upright or past it, as behind a runner.

    A sole alone cannot tell a foot past the vertical from one that points the other way, the ankle's axis can.
    """
    sole = unit(ball - ankle)
    across = np.cross(unit(knee - ankle), sole)  # to the left, the longer the nearer to a right angle the ankle is
    level = sole[:, :2]
    ahead = np.stack([across[:, 1], -across[:, 0]], -1) + 0.5 * level  # a stretched ankle shows nothing
    along = np.sum(level * ahead, -1, keepdims=True) * level  # a level sole shows it better than the ankle
    course = along + (1 - np.sum(level**2, -1, keepdims=True)) * ahead
    return np.arctan2(course[:, 1], course[:, 0])
