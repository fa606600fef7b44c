"""Human motion from ASF/AMC: the skeleton file lies beside the motion, or the user names it."""

from pathlib import Path
from typing import Final

from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.asf_amc import positions, read_amc, read_asf
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.rigs import asf_skeleton
from ros_free_stack.formats.skeleton_map import select
from ros_free_stack.formats.source import Source, SourceOptions

CMU_FPS: Final = 120.0


def read(path: Path, options: SourceOptions) -> Source:
    """The human motion in an AMC file; files state no frame rate, so without the user's word it is CMU's 120.

    Raises:
        InvalidFile: a file is damaged, or its skeleton is unknown (the message shows how to write a mapping).
        InvalidOption: there is no skeleton file, or more than one that may be it.
        UnknownName: the mapping names a bone that is not there.
    """
    skeleton = read_asf(options.skeleton or _beside(path))
    points = positions(skeleton, read_amc(path, skeleton))
    family, notes = asf_skeleton(path, skeleton.names, options.mapping)
    joints = select(skeleton.names, points, family.weights)
    habits = Habits(title=family.name, up="y", units="m", fps=CMU_FPS)
    return person_source(path, joints, options, habits, fps=None, notes=notes)


def _beside(path: Path) -> Path:
    """SUBJECT_TAKE.amc goes with SUBJECT.asf, NAME.amc with NAME.asf or the folder's only skeleton."""
    for name in (path.stem.partition("_")[0], path.stem):
        candidate = path.with_name(f"{name}.asf")
        if candidate.is_file():
            return candidate
    found = sorted(path.parent.glob("*.asf"))
    if len(found) != 1:
        raise InvalidOption("--skeleton", f"name the .asf skeleton of {path}: {len(found)} files may be it")
    return found[0]
