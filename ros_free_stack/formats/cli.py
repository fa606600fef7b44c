"""The `convert` subcommand, and the options with which every command reads motion files."""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from ros_free_stack.console import Command, say
from ros_free_stack.formats.source import Angles, QuaternionOrder, SourceOptions, Units, UpAxis

if TYPE_CHECKING:
    from ros_free_stack.formats.registry import Content


@dataclass(frozen=True, kw_only=True)
class ReadsMotion(Command):
    """What a user can say of a motion file that the file does not say itself."""

    format: str | None = None
    """Format of the file, where suffix and content do not tell."""
    source_fps: float | None = None
    """Frames a second of the file, where it does not say or says wrong."""
    units: Units | None = None
    """Unit of lengths; without it, the one that gives the person a person's size."""
    height: float | None = None
    """Height of the person in m, where lengths are in no known unit."""
    up: UpAxis | None = None
    """Up axis of human motion; without it, the one that the person stands along."""
    mapping: Path | None = None
    """YAML file that maps the joints of an unknown skeleton; the error about one shows how to write it."""
    skeleton: Path | None = None
    """Skeleton of a motion without one: SMPL model .npz or rest joints .json (AMASS, PHC), .asf (AMC)."""
    clip: str | None = None
    """Which clip or skeleton of a file that holds several."""
    start: float | None = None
    """Take the motion from this time on, in s from the file's first frame."""
    end: float | None = None
    """Take the motion up to this time."""

    def source_options(self, **others: Any) -> SourceOptions:
        """The options for the readers; `others` are those that not every command has."""
        names = {item.name for item in fields(SourceOptions)} & {item.name for item in fields(ReadsMotion)}
        return SourceOptions(**{name: getattr(self, name) for name in names}, **others)  # pyright: ignore[reportArgumentType]


@dataclass(frozen=True, kw_only=True)
class ReadsMotionOrRobot(ReadsMotion):
    """What a user can say of a file that may hold a robot's trajectory."""

    robot: str | None = None
    """Robot of a trajectory that does not name its own (csv, pickles, arrays)."""
    quaternion: QuaternionOrder | None = None
    """Order of quaternions, where nothing in the file tells it."""
    angles: Angles | None = None
    """Unit of a robot's joint angles; without it rad, where that can be."""
    floor: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Lower or raise a robot's trajectory so that its lowest sole stands on the floor."""

    def source_options(self, **others: Any) -> SourceOptions:
        """The options for the readers."""
        return super().source_options(
            robot=self.robot, quaternion=self.quaternion, angles=self.angles, floor=self.floor or None, **others
        )


@dataclass(frozen=True, kw_only=True)
class Convert(ReadsMotionOrRobot):
    """Convert a motion file: human motion to human motion, robot trajectory to robot trajectory.

    Examples:
        python launch.py convert walk1_subject1.bvh walk.npz
        python launch.py convert out/human_motion.npz out/human_motion.bvh
        python launch.py convert take.bvh take.npz --mapping mapping.yaml --units cm --fps 20
        python launch.py convert stageii.npz motion.npz --skeleton SMPLX_NEUTRAL.npz
        python launch.py convert dance1_subject1.csv dance.npz --robot g1 --quaternion xyzw
        python launch.py convert trajectory.npz trajectory.pkl
        python launch.py convert trajectory.npz reference.npz --to mjlab --fps 50
    """

    source: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """File to read: .npz, .npy, .bvh, .amc, .txt (DeepMimic), .pkl (GMR, PHC) or .csv."""
    out: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="OUT")]
    """File to write: .npz, .bvh, .csv or .pkl."""
    to: str | None = None
    """Format to write, where the suffix does not tell: `mjlab` for its .npz, `kimodo-csv` for quaternions wxyz."""
    fps: float | None = None
    """Frames a second to write; without it those of the source, or the format's own."""

    def run(self) -> int:
        """Read, resample on request, write, and say what had to be assumed."""
        from ros_free_stack.files import make_folder
        from ros_free_stack.formats.rates import check_rate
        from ros_free_stack.formats.registry import load, output_format, save
        from ros_free_stack.messages import HumanMotion

        if self.fps is not None:
            check_rate("--fps", self.fps)
        target = output_format(self.out, self.to)
        source = load(self.source, self.source_options(), self.format)
        for note in source.notes:
            say(note)
        content = source.content
        if self.fps is not None and self.fps != content.fps:
            say(f"resampled from {content.fps:g} to {self.fps:g} fps, linearly (orientations by slerp)")
            content = _resampled(content, self.fps)
        make_folder(self.out.parent)
        for note in save(self.out, content, target.name):
            say(note)
        kind = "human motion" if isinstance(content, HumanMotion) else f"trajectory of {content.robot}"
        self.report(
            {"out": str(self.out), "format": target.name, "kind": kind, "duration_s": content.duration_s},
            f"{self.out}: {kind}, {content.duration_s:.1f} s, as {target.name}",
        )
        return 0


def _resampled(content: "Content", fps: float) -> "Content":
    from ros_free_stack.formats.frames import resample
    from ros_free_stack.formats.robot_resample import resample_trajectory
    from ros_free_stack.messages import HumanMotion

    if isinstance(content, HumanMotion):
        return replace(content, joints=resample(content.joints, fps=content.fps, to=fps), fps=fps)
    return resample_trajectory(content, fps)
