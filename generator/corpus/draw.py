"""A storyboard of a motion: stick figures side by side, so that a person can judge a clip at a glance."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from generator.corpus.body import Floats
from ros_free_stack.errors import InvalidMessage, InvalidOption
from ros_free_stack.files import atomic_path
from ros_free_stack.skeleton import BONES, FPS, INDEX, JOINT_COUNT, JOINT_NAMES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS: Final = {"left": "tab:blue", "right": "tab:red"}
_VIEW_YAW: Final = np.radians(50)  # three-quarter view: the camera stands in front, towards the person's right
_SPACING: Final = 1.05


def draw_motion(joints: ArrayLike, path: Path, title: str, frames: int = 8) -> None:
    """Write a PNG of `frames` poses of joints (T, 22, 3), evenly spaced in time; left side blue, right side red.

    Places on the floor are relative to the first frame's heading; the camera moves along, the numbers under
    each figure say how far the pelvis went (forward, left).

    Raises:
        InvalidMessage: `joints` is not (T, 22, 3).
        InvalidOption: `frames` is below 1.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    joints = np.asarray(joints, dtype=float)
    if joints.ndim != 3 or joints.shape[1:] != (JOINT_COUNT, 3) or not len(joints):
        raise InvalidMessage("draw_motion", "joints", f"expected shape (any, {JOINT_COUNT}, 3), found {joints.shape}")
    if frames < 1:
        raise InvalidOption("frames", f"expected at least 1, found {frames}")
    figure = Figure(figsize=(1.35 * frames, 3.2), dpi=75, layout="tight")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    shown = np.linspace(0, len(joints) - 1, frames).round().astype(int)
    local = _from_first_heading(joints)
    for slot, frame in enumerate(shown):
        _draw_figure(axes, local[frame], slot * _SPACING)
        forward, left = local[frame, 0, :2]
        note = f"{frame / FPS:.1f} s\n{forward:+.2f} {left:+.2f} m"
        axes.text(slot * _SPACING, -0.30, note, ha="center", va="top", fontsize=6, color="grey")
    axes.axhline(0, color="lightgrey", lw=0.8, zorder=0)
    axes.set(xlim=(-0.7, (frames - 1) * _SPACING + 0.7), ylim=(-0.55, 2.3), aspect="equal")
    axes.axis("off")
    axes.set_title(title, fontsize=9, loc="left")
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format="png")


def _from_first_heading(joints: Floats) -> Floats:
    """Joints with the first pelvis over the origin and the first heading along x."""
    across = joints[0, INDEX["left_hip"]] - joints[0, INDEX["right_hip"]]
    yaw = np.arctan2(-across[0], across[1])
    c, s = np.cos(yaw), np.sin(yaw)
    return (joints - joints[0, 0] * [1, 1, 0]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _draw_figure(axes: "Axes", pose: Floats, x: float) -> None:
    """One stick figure (22, 3), the pelvis at `x`; nearer points lie lower, as seen from slightly above."""
    c, s = np.cos(_VIEW_YAW), np.sin(_VIEW_YAW)
    flat = pose - pose[0] * [1, 1, 0]
    across, near = c * flat[:, 1] + s * flat[:, 0], c * flat[:, 0] - s * flat[:, 1]
    screen = np.stack([x + across, flat[:, 2] - 0.15 * near], -1)
    for parent, child in BONES:
        colour = _COLOURS.get(JOINT_NAMES[child].split("_")[0], "black")
        axes.plot(*screen[[parent, child]].T, color=colour, lw=1.6, solid_capstyle="round")
    axes.plot(*(screen[INDEX["head"]] + [0, 0.04]), "o", color="black", ms=5)
