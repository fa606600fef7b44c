"""Biovision hierarchies (BVH): what such a file says, where its joints are, and writing one.

Rotations apply from left to right in the order of the channels; position channels stand in place of the offset, as
the programs that write such files (MotionBuilder, Blender) mean them.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.files import write_text

Floats = NDArray[np.float64]

PULLED_OUT: Final = 0.3
"""Position channels that are shorter than this share of a joint's offset are no places but changes of them."""


@dataclass(frozen=True)
class Joint:
    """A joint or an end site (named after its parent, with "_end"); the offset is in the file's unit."""

    name: str
    parent: int
    offset: Floats
    channels: tuple[str, ...]


@dataclass(frozen=True)
class Bvh:
    """A BVH file: joints, parents first, and (T, channels) values in the file's unit and in degrees.

    The rate is 0 where the file states none that is positive; `notes` say in words what its reader had to decide.
    """

    joints: tuple[Joint, ...]
    values: Floats
    fps: float
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)


def positions(bvh: Bvh, only: Sequence[int] | None = None) -> Floats:
    """(T, J, 3) positions of all joints and end sites, or of some by their number, in the file's frame and unit."""
    frames, column = len(bvh.values), 0
    wanted = range(len(bvh.joints)) if only is None else only
    needed = _with_parents(bvh, wanted)
    turns: dict[int, Floats] = {}
    points: dict[int, Floats] = {}
    for i, joint in enumerate(bvh.joints):
        values = bvh.values[:, column : column + len(joint.channels)]
        column += len(joint.channels)
        if i not in needed:
            continue
        offset = np.tile(joint.offset, (frames, 1))
        turning = [k for k, channel in enumerate(joint.channels) if channel.endswith("rotation")]
        for k, channel in enumerate(joint.channels):
            if k not in turning:
                offset[:, "XYZ".index(channel[0])] = values[:, k]
        turn = np.broadcast_to(np.eye(3), (frames, 3, 3))
        if turning:
            order = "".join(joint.channels[k][0] for k in turning)
            turn = Rotation.from_euler(order, values[:, turning], degrees=True).as_matrix()
        if joint.parent < 0:
            points[i], turns[i] = offset, turn
            continue
        base = turns[joint.parent]
        points[i] = points[joint.parent] + (base @ offset[..., None])[..., 0]
        turns[i] = base @ turn
    return np.stack([points[i] for i in wanted], axis=1)


def _with_parents(bvh: Bvh, joints: Iterable[int]) -> set[int]:
    """The joints and all above them."""
    needed: set[int] = set()
    for joint in joints:
        above = joint
        while above >= 0 and above not in needed:
            needed.add(above)
            above = bvh.joints[above].parent
    return needed


def with_offsets(bvh: Bvh) -> Bvh:
    """The file with its position channels in place of the offsets, also where they were meant to be added to these.

    Some programs give every joint position channels and leave them at zero, or write only how far a joint is pulled
    out of its place. Channels in place of the offsets are about as long as these.
    """
    shares: dict[int, float] = {}
    columns: dict[int, list[int]] = {}
    column = 0
    for i, joint in enumerate(bvh.joints):
        places = [column + k for k, name in enumerate(joint.channels) if name.endswith("position")]
        column += len(joint.channels)
        length = float(np.linalg.norm(joint.offset))
        if joint.parent >= 0 and len(places) == 3 and length > 0:
            columns[i] = places
            shares[i] = float(np.median(np.linalg.norm(bvh.values[:, places], axis=1))) / length
    added = [i for i, places in columns.items() if not bvh.values[:, places].any()]
    how = "are zero: its offset stands"
    if len(added) < len(shares) and float(np.median(list(shares.values()))) <= PULLED_OUT:
        added, how = list(columns), "are far shorter than its offset: they are added to it"
    if not added:
        return bvh
    values = np.array(bvh.values)
    for i in added:
        joint = bvh.joints[i]
        axes = ["XYZ".index(name[0]) for name in joint.channels if name.endswith("position")]
        values[:, columns[i]] += joint.offset[axes]
    which = "each joint" if len(added) == len(columns) else ", ".join(bvh.joints[i].name for i in added[:8])
    return replace(bvh, values=values, notes=(*bvh.notes, f"the position channels of {which} {how}"))


def write_bvh(path: Path, bvh: Bvh) -> None:
    """Write a file, whole or not at all; the joints must be in depth-first order."""
    lines = ["HIERARCHY"]
    open_joints: list[int] = []
    for i, joint in enumerate(bvh.joints):
        while open_joints and open_joints[-1] != joint.parent:
            open_joints.pop()
            lines.append("\t" * len(open_joints) + "}")
        indent = "\t" * len(open_joints)
        title = f"{'JOINT' if open_joints else 'ROOT'} {joint.name}" if joint.channels else "End Site"
        lines += [indent + title, indent + "{", f"{indent}\tOFFSET {_numbers(joint.offset)}"]
        if joint.channels:
            lines.append(f"{indent}\tCHANNELS {len(joint.channels)} {' '.join(joint.channels)}")
        open_joints.append(i)
    lines += ["\t" * k + "}" for k in reversed(range(len(open_joints)))]
    lines += ["MOTION", f"Frames: {len(bvh.values)}", f"Frame Time: {1 / bvh.fps:.9f}"]
    write_text(path, "\n".join([*lines, *map(_numbers, bvh.values)]) + "\n")


def _numbers(values: Floats) -> str:
    return " ".join(f"{value:.6f}" for value in values)
