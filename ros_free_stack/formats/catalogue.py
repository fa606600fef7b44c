"""The table of motion file formats: what each is, which options it takes, who reads and writes it."""

from dataclasses import dataclass
from typing import Final, Literal

Kind = Literal["human motion", "robot trajectory"]


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        name: as given to `--format` and `--to`.
        title: for people.
        suffix: of its files.
        kinds: what its files may hold.
        read, write: "module:function" below this package, or "" where there is none.
        options: fields of `SourceOptions` that its reader takes.
    """

    name: str
    title: str
    suffix: str
    kinds: tuple[Kind, ...]
    read: str = ""
    write: str = ""
    options: tuple[str, ...] = ()


HUMAN: Final[tuple[Kind, ...]] = ("human motion",)
ROBOT: Final[tuple[Kind, ...]] = ("robot trajectory",)
_SIZE: Final = ("units", "height", "up")
_ROBOT: Final = ("robot", "units", "angles", "floor")

COMMON: Final = ("start", "end")
"""Options that every format takes."""

FORMATS: Final = {
    item.name: item
    for item in (
        Format(
            name="native",
            title="this project's own",
            suffix=".npz",
            kinds=HUMAN + ROBOT,
            read="native:read",
            write="native:write",
            options=("floor",),
        ),
        Format(
            name="bvh",
            title="BVH: CMU, LaFAN1, SOMA/BONES, Xsens, Mixamo, others with a mapping",
            suffix=".bvh",
            kinds=HUMAN,
            read="bvh_motion:read",
            write="bvh_motion:write",
            options=("source_fps", *_SIZE, "mapping", "clip"),
        ),
        Format(
            name="asf-amc",
            title="Acclaim ASF/AMC",
            suffix=".amc",
            kinds=HUMAN,
            read="amc_motion:read",
            options=("source_fps", *_SIZE, "skeleton", "mapping"),
        ),
        Format(
            name="amass",
            title="SMPL poses: AMASS, GVHMR, WHAM, SLAHMR and others",
            suffix=".npz",
            kinds=HUMAN,
            read="amass:read",
            options=("source_fps", "up", "skeleton"),
        ),
        Format(
            name="humanml3d-joints",
            title="joints' places: HumanML3D, MDM, SMPL, KIT-ML",
            suffix=".npy",
            kinds=HUMAN,
            read="joint_arrays:read",
            options=("source_fps", *_SIZE, "clip"),
        ),
        Format(
            name="humanml3d-features",
            title="HumanML3D features (T, 263)",
            suffix=".npy",
            kinds=HUMAN,
            read="humanml3d:read_features",
            options=("source_fps",),
        ),
        Format(
            name="deepmimic",
            title="DeepMimic JSON text",
            suffix=".txt",
            kinds=HUMAN,
            read="deepmimic:read",
            options=("source_fps",),
        ),
        Format(
            name="phc",
            title="pickles of PHC, H2O, ASAP, AIST++, WHAM",
            suffix=".pkl",
            kinds=HUMAN + ROBOT,
            read="phc:read",
            options=("source_fps", "height", "up", *_ROBOT, "clip", "skeleton"),
        ),
        Format(
            name="gmr",
            title="GMR pickle",
            suffix=".pkl",
            kinds=ROBOT,
            read="gmr:read",
            write="gmr:write",
            options=("source_fps", *_ROBOT),
        ),
        Format(
            name="mimickit",
            title="MimicKit pickle",
            suffix=".pkl",
            kinds=ROBOT,
            read="mimickit:read",
            options=("source_fps", *_ROBOT),
        ),
        Format(
            name="unitree-csv",
            title="Unitree LAFAN1 csv, quaternions xyzw",
            suffix=".csv",
            kinds=ROBOT,
            read="robot_csv:read_unitree",
            write="robot_csv:write_unitree",
            options=("source_fps", *_ROBOT, "quaternion"),
        ),
        Format(
            name="kimodo-csv",
            title="Kimodo csv, quaternions wxyz",
            suffix=".csv",
            kinds=ROBOT,
            read="robot_csv:read_kimodo",
            write="robot_csv:write_kimodo",
            options=("source_fps", *_ROBOT, "quaternion"),
        ),
        Format(
            name="csv-names",
            title="robot csv with names of columns: BONES-SEED, this project's tables and others",
            suffix=".csv",
            kinds=ROBOT,
            read="robot_table:read",
            options=("source_fps", *_ROBOT, "quaternion"),
        ),
        Format(
            name="robot-arrays",
            title="named arrays of a robot: mjlab, BeyondMimic, holosoma, loco-mujoco and others",
            suffix=".npz",
            kinds=ROBOT,
            read="robot_arrays:read",
            options=("source_fps", *_ROBOT, "quaternion", "clip"),
        ),
        Format(
            name="mjlab",
            title="mjlab and BeyondMimic, with velocities",
            suffix=".npz",
            kinds=ROBOT,
            read="robot_arrays:read",
            write="mjlab:write",
            options=("source_fps", *_ROBOT, "quaternion", "clip"),
        ),
    )
}
"""By name. Of several that write one suffix the first is what a file of that suffix is written as."""

READABLE: Final = tuple(name for name, item in FORMATS.items() if item.read)
WRITABLE: Final = tuple(name for name, item in FORMATS.items() if item.write)
