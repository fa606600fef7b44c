"""AMASS (Mahmood et al., ICCV 2019) and other `.npz` files of SMPL, SMPL-H or SMPL-X poses.

AMASS is z up and states mocap_framerate or mocap_frame_rate; what video models write (GVHMR, WHAM, SLAHMR and others)
has other names and any up axis. Bone lengths are in the body model, which the user supplies.
"""

from pathlib import Path

from ros_free_stack.formats.archives import load_npz
from ros_free_stack.formats.person import Habits
from ros_free_stack.formats.smpl_poses import smpl_source
from ros_free_stack.formats.source import Source, SourceOptions


def read(path: Path, options: SourceOptions) -> Source:
    """The human motion in an archive of poses.

    Raises:
        InvalidFile: the file or the skeleton is damaged or lacks a part.
        InvalidOption: no skeleton was named, or the frame rate is nowhere stated.
    """
    entries = load_npz(path)
    published = "mocap_framerate" in entries or "mocap_frame_rate" in entries
    return smpl_source(path, entries, options, Habits(title="SMPL poses", up="z" if published else None, units="m"))
