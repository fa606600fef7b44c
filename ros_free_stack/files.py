"""Native files: `.npz` without pickle for motions and trajectories, csv for people, JSON for verdicts.

A file appears whole or not at all: it is written under a temporary name and renamed.
"""

import csv
import errno
import json
import os
import tempfile
import zipfile
import zlib
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidMessage, InvalidOption
from ros_free_stack.messages import Check, HumanMotion, RobotTrajectory, Segment, ServoTelemetry, Verdict

FORMAT_VERSION = 1
LARGEST_TEXT = 1_000_000
"""Bytes of a file of lines, such as one of prompts."""
CONVENTIONS = "metres, radians, seconds; world z up, x forward; quaternions wxyz"

_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""What writing meets where the disk is full or broken; it carries no file name."""


@contextmanager
def atomic_path(path: Path) -> Generator[Path]:
    """A temporary path beside `path` that replaces it when the block ends well and vanishes when it does not.

    Raises:
        InvalidFile: the folder does not exist, cannot be written or is full.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    except OSError as error:
        raise InvalidFile(path, f"cannot be written: {error.strerror}") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    except OSError as error:
        if error.errno in _DISK or error.filename == name:
            raise InvalidFile(path, f"cannot be written: {error.strerror}") from None
        raise
    finally:
        temporary.unlink(missing_ok=True)


def check_folder(path: Path) -> None:
    """Raise InvalidFile where `make_folder` would, and leave nothing behind: for before long work."""
    there = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    if not there.is_dir():
        raise InvalidFile(path, f"is not a writable folder: {there} is a file")
    try:
        with tempfile.TemporaryDirectory(dir=there):  # the rights alone do not tell: /proc, read-only disks
            pass
    except OSError as error:
        raise InvalidFile(path, f"is not a writable folder: {there} cannot be written ({error.strerror})") from None


def make_folder(path: Path) -> Path:
    """Create an output folder (and its parents), or raise InvalidFile where that is impossible."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise InvalidFile(path, f"is not a writable folder: {error.strerror}") from None
    return path


def check_output(path: Path, suffix: str, option: str = "--out") -> None:
    """Raise where no file of this name can be written: InvalidOption for its suffix, InvalidFile for its folder."""
    if path.suffix.lower() != suffix:
        raise InvalidOption(option, f"expected a name that ends in {suffix}, found {str(path)!r}")
    if path.is_dir():
        raise InvalidFile(path, "is a folder, expected a file")
    check_folder(path.parent)


def check_input(path: Path) -> None:
    """Raise InvalidFile where there is no such file: for before a reader is imported."""
    if not path.is_file():
        raise InvalidFile(path, "is a folder, expected a file" if path.is_dir() else "no such file")


def read_lines(path: Path) -> tuple[str, ...]:
    """The lines of a small text file in UTF-8, a byte-order mark left out; InvalidFile where it is none."""
    try:
        if not path.is_file():
            raise InvalidFile(path, "no such file" if not path.exists() else "is no regular file")
        if (size := path.stat().st_size) > LARGEST_TEXT:
            raise InvalidFile(path, f"has {size} bytes, at most {LARGEST_TEXT} are read")
        return tuple(path.read_text(encoding="utf-8-sig").splitlines())
    except UnicodeDecodeError as error:
        raise InvalidFile(path, f"is no text in UTF-8 (byte {error.start})") from None
    except OSError as error:
        raise InvalidFile(path, f"cannot be read ({error.strerror})") from None


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, data: Any) -> None:
    """Write indented JSON atomically."""
    write_text(path, json.dumps(data, indent=2) + "\n")


def _save(path: Path, kind: str, **arrays: Any) -> None:
    with atomic_path(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, kind=kind, version=FORMAT_VERSION, conventions=CONVENTIONS, **arrays)


def _load(path: Path, kind: str) -> dict[str, np.ndarray[Any, Any]]:
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    try:
        with np.load(path, allow_pickle=False) as archive:
            data = {name: archive[name] for name in archive.files}
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, KeyError, zlib.error) as error:
        raise InvalidFile(path, f"not a readable .npz ({error})") from None
    found = str(data.get("kind", "nothing"))
    if found != kind:
        raise InvalidFile(path, f"holds {found!r}, expected {kind!r}")
    if int(data["version"]) != FORMAT_VERSION:
        raise InvalidFile(path, f"format version {int(data['version'])}, this program reads {FORMAT_VERSION}")
    return data


def save_motion(path: Path, motion: HumanMotion) -> None:
    """Write a HumanMotion as `.npz`."""
    _save(
        path,
        "human_motion",
        joints=motion.joints,
        fps=motion.fps,
        prompt=motion.prompt,
        source=motion.source,
        segment_text=np.array([s.text for s in motion.segments], dtype=np.str_),
        segment_time_s=np.array([(s.start_s, s.end_s) for s in motion.segments]).reshape(-1, 2),
    )


def load_motion(path: Path) -> HumanMotion:
    """Read a HumanMotion; InvalidFile where the file is not one."""
    data = _load(path, "human_motion")
    try:
        segments = tuple(
            Segment(str(text), float(start), float(end))
            for text, (start, end) in zip(data["segment_text"], data["segment_time_s"], strict=True)
        )
        return HumanMotion(
            joints=data["joints"],
            fps=float(data["fps"]),
            prompt=str(data["prompt"]),
            segments=segments,
            source=str(data["source"]),
        )
    except (KeyError, ValueError, InvalidMessage) as error:
        raise InvalidFile(path, f"not a valid human motion: {error}") from None


def save_trajectory(path: Path, trajectory: RobotTrajectory) -> None:
    """Write a RobotTrajectory as `.npz`."""
    _save(
        path,
        "robot_trajectory",
        robot=trajectory.robot,
        model_sha256=trajectory.model_sha256,
        joint_names=np.array(trajectory.joint_names, dtype=np.str_),
        fps=trajectory.fps,
        root_pos=trajectory.root_pos,
        root_quat=trajectory.root_quat,
        joint_pos=trajectory.joint_pos,
        contacts=trajectory.contacts,
        foot_names=np.array(trajectory.foot_names, dtype=np.str_),
    )


def load_trajectory(path: Path) -> RobotTrajectory:
    """Read a RobotTrajectory; InvalidFile where the file is not one."""
    data = _load(path, "robot_trajectory")
    try:
        return RobotTrajectory(
            robot=str(data["robot"]),
            model_sha256=str(data["model_sha256"]),
            joint_names=tuple(data["joint_names"]),
            fps=float(data["fps"]),
            root_pos=data["root_pos"],
            root_quat=data["root_quat"],
            joint_pos=data["joint_pos"],
            contacts=data["contacts"],
            foot_names=tuple(data["foot_names"]),
        )
    except (KeyError, ValueError, InvalidMessage) as error:
        raise InvalidFile(path, f"not a valid robot trajectory: {error}") from None


def save_trajectory_csv(path: Path, trajectory: RobotTrajectory) -> None:
    """Write a csv with a header: time, root position and quaternion (wxyz), then one column a joint in rad."""
    header = ["time_s", "root_x", "root_y", "root_z", "root_qw", "root_qx", "root_qy", "root_qz"]
    times = np.arange(len(trajectory.joint_pos)) / trajectory.fps
    table = np.column_stack([times, trajectory.root_pos, trajectory.root_quat, trajectory.joint_pos])
    with atomic_path(path) as temporary, temporary.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow([*header, *trajectory.joint_names])
        writer.writerows([[f"{value:.8g}" for value in row] for row in table])


def save_telemetry(path: Path, telemetry: ServoTelemetry) -> None:
    """Write a ServoTelemetry as `.npz`."""
    arrays = {item.name: getattr(telemetry, item.name) for item in fields(telemetry)}
    _save(path, "servo_telemetry", **(arrays | {"joint_names": np.array(telemetry.joint_names, dtype=np.str_)}))


def load_telemetry(path: Path) -> ServoTelemetry:
    """Read a ServoTelemetry; InvalidFile where the file is not one."""
    data = _load(path, "servo_telemetry")
    try:
        arrays = {item.name: data[item.name] for item in fields(ServoTelemetry)}
        return ServoTelemetry(**(arrays | {"robot": str(data["robot"]), "joint_names": tuple(data["joint_names"])}))  # pyright: ignore[reportArgumentType]
    except (KeyError, ValueError, InvalidMessage) as error:
        raise InvalidFile(path, f"not valid servo telemetry: {error}") from None


def save_verdict(path: Path, verdict: Verdict) -> None:
    """Write a verdict as JSON, with the overall result first."""
    write_json(path, {"passed": verdict.passed, **asdict(verdict)})


def load_verdict(path: Path) -> Verdict:
    """Read a verdict; InvalidFile where the file is not one."""
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        passed = data.pop("passed")
        data["checks"] = tuple(Check(**check) for check in data["checks"])
        verdict = Verdict(**data)
    except (ValueError, TypeError, KeyError, AttributeError, InvalidMessage) as error:
        raise InvalidFile(path, f"not a verdict: {error}") from None
    if passed is not verdict.passed:
        raise InvalidFile(path, f"says passed: {json.dumps(passed)}, and its checks do not: judge the trajectory again")
    return verdict
