"""Robot trajectories as tables and arrays of other programs, and how they are read back."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ros_free_stack.formats.registry import load
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.messages import Floats, RobotTrajectory

G1 = SourceOptions(robot="g1")

ROOT = ("x", "y", "z", "qw", "qx", "qy", "qz")


def values(trajectory: RobotTrajectory) -> dict[str, Floats]:
    """Columns by name."""
    root = np.concatenate([trajectory.root_pos, trajectory.root_quat], axis=1)
    return dict(zip(ROOT, root.T, strict=True)) | dict(zip(trajectory.joint_names, trajectory.joint_pos.T, strict=True))


def write_csv(path: Path, columns: Mapping[str, Any], separator: str = ",") -> Path:
    rows = np.stack(list(columns.values()), axis=1)
    lines = [separator.join(columns), *(separator.join(f"{value:.9g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines))
    return path


def read(path: Path, options: SourceOptions = G1, format_name: str | None = None) -> RobotTrajectory:
    content = load(path, options, format_name).content
    assert isinstance(content, RobotTrajectory)
    return content


def assert_same(found: RobotTrajectory, wanted: RobotTrajectory, *, fps: float = 50.0, atol: float = 1e-6) -> None:
    assert found.fps == pytest.approx(fps)
    for name in ("root_pos", "joint_pos"):
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), atol=atol)
    same = np.abs((found.root_quat * wanted.root_quat).sum(axis=1))
    np.testing.assert_allclose(same, 1, atol=1e-6)
