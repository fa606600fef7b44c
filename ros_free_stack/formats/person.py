"""What every reader of human motion does last: from joints in a file's frame and unit to a HumanMotion.

The rate is checked, the unit and the up axis are told by the person, frames that are no capture are left out, the
person is put on the floor, and whatever had to be assumed is said.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidMessage, InvalidOption
from ros_free_stack.formats.body import check_body, is_t_pose
from ros_free_stack.formats.frames import floor_height, stand
from ros_free_stack.formats.jumps import find_capture, jump_notes
from ros_free_stack.formats.rates import frame_rate
from ros_free_stack.formats.source import Source, SourceOptions, Units, UpAxis, check_finite
from ros_free_stack.formats.span import frames_between
from ros_free_stack.formats.stature import metres_a_unit
from ros_free_stack.formats.upright import turned_up, up_axis
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import INDEX, JOINT_COUNT

NEAR_FLOOR_M = 0.15
"""A motion that stands on the floor already has it this near to z = 0."""

FASTEST_M_S = 40.0
"""No hand or foot of a person is faster, be it in a pitch or a kick."""


@dataclass(frozen=True, kw_only=True)
class Habits:
    """What files of a kind usually are; None where nothing is usual.

    Attributes:
        title: of the kind, for notes.
        up: the up axis.
        rest: the up axis of the rest pose, for a person who only lies.
        units: the unit of lengths.
        fps: the rate of those that state none.
        stood: whether they stand on the floor and face forward already.
        told: whether unit and up axis are told even where they are as usual.
    """

    title: str
    up: UpAxis | None = None
    rest: UpAxis | None = None
    units: Units | None = None
    fps: float | None = None
    stood: bool = False
    told: bool = False


def person_source(
    path: Path,
    joints: Floats,
    options: SourceOptions,
    habits: Habits,
    *,
    fps: float | None,
    notes: tuple[str, ...] = (),
) -> Source:
    """The Source of (T, 22, 3) joints in a file's frame and unit.

    Args:
        path: the file, for errors.
        joints: its joints.
        options: what the user says.
        habits: what such files usually are.
        fps: the rate that the file states, if it does.
        notes: what the reader had to assume so far.

    Raises:
        InvalidFile: the joints are no person's.
        InvalidOption: rate, unit or up axis cannot be told.
    """
    if joints.ndim != 3 or joints.shape[1:] != (JOINT_COUNT, 3) or not len(joints):
        raise InvalidFile(path, f"expected joints (T, {JOINT_COUNT}, 3), found {joints.shape}")
    check_finite(path, "joints", joints)
    if fps is None and options.source_fps is None and habits.fps is not None:
        fps = habits.fps
        notes += (f"{habits.title} files state no frame rate: {fps:g} assumed (--source-fps)",)
    fps = frame_rate(path, fps, options.source_fps)
    joints = joints[frames_between(path, len(joints), fps, options)]
    metres, unit, doubts = metres_a_unit(joints, options, habits.units)
    up, doubt = (options.up, False) if options.up else up_axis(joints, habits.up)
    up = up or habits.rest
    if up is None:
        raise InvalidOption("--up", f"name the up axis of {path} (y or z): it cannot be told from how the person lies")
    if habits.told or unit != habits.units or up != habits.up:
        usual = f"such files usually have {habits.up}" if habits.up else "which few files have"
        why = f" (the person stands along it; {usual}: --up overrules)" if doubt else ""
        notes += (f"skeleton: {habits.title}; lengths in {unit}, {up} up{why}",)
    joints = turned_up(metres * joints, up)
    stood = habits.stood and abs(floor_height(joints)) < NEAR_FLOOR_M
    if stood:  # no capture: every frame is meant
        capture = replace(find_capture(joints, fps), start=0, end=len(joints))
    else:
        check_body(path, joints)
        capture = find_capture(joints, fps, posed=is_t_pose)
    notes += doubts + jump_notes(capture, len(joints), fps)
    joints = joints[capture.start : capture.end]
    notes += _too_fast(joints, fps)
    try:
        motion = HumanMotion(joints=joints if stood else stand(joints), fps=fps, source=path.name)
    except InvalidMessage as error:
        raise InvalidFile(path, f"not a valid human motion: {error}") from None
    return Source(motion, notes)


def _too_fast(joints: Floats, fps: float) -> tuple[str, ...]:
    """A note where hands and feet go about as nobody's do."""
    ends = joints[:, [INDEX[f"{side}_{name}"] for side in ("left", "right") for name in ("wrist", "ankle")]]
    if len(ends) < 2:
        return ()
    speed = float(np.percentile(np.linalg.norm(np.diff(ends, axis=0), axis=-1).max(axis=1), 90)) * fps
    if speed < FASTEST_M_S:
        return ()
    return (f"hands or feet move at {speed:.0f} m/s: is {fps:g} the right frame rate (--source-fps)?",)
