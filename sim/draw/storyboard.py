"""The motion as one picture: the human above, the robot below, eight moments from left to right."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from ros_free_stack.files import atomic_path
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import CHAINS, INDEX, PARTS
from sim.draw.shapes import Shape, body_shapes
from sim.draw.synchrony import human_at, lead_in_s
from sim.reference import Reference

COLUMNS = 8
INK, PAPER, FLOOR = "#1f2937", "#ffffff", "#d1d5db"
LEFT, RIGHT, TRUNK = "#d97706", "#2563eb", "#475569"
"""The left side, the right side and the trunk have one colour in every picture."""

_CAMERA_AZIMUTH = np.radians(35)
_CAMERA_ELEVATION = np.radians(12)


def write_storyboard(path: Path, motion: HumanMotion | None, reference: Reference, title: str = "") -> None:
    """Write the storyboard as PNG; without a motion only the robot is shown.

    Raises:
        InvalidFile: the folder cannot be written.
    """
    figure = storyboard(motion, reference, title)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110, facecolor=PAPER, metadata={"Software": None})


def storyboard(motion: HumanMotion | None, reference: Reference, title: str = "") -> Any:
    """The storyboard as a matplotlib figure of 8 columns."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    frames = _moments(motion, reference)
    times = frames * reference.dt
    rows = 1 if motion is None else 2
    figure = Figure(figsize=(2.0 * COLUMNS, 3.0 * rows + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, len(frames), squeeze=False)
    if motion is not None:
        _human_row(axes[0], human_at(motion, reference.trajectory, times))
    _robot_row(axes[-1], reference, frames)
    for axis, time in zip(axes[-1], times, strict=True):
        axis.text(0.5, -0.02, f"{time:.1f} s", transform=axis.transAxes, ha="center", va="top", color=INK)
    axes[-1][0].set_ylabel(reference.robot.title, color=INK)
    if motion is not None:
        axes[0][0].set_ylabel("human", color=INK)
    if title:
        figure.suptitle(title, color=INK, fontsize=14)
    return figure


def _moments(motion: HumanMotion | None, reference: Reference) -> np.ndarray:
    """Up to 8 frames spread over the motion, without most of the standing before and after it."""
    last = len(reference.qpos) - 1
    skipped = 0.0 if motion is None else max(0.0, 0.6 * lead_in_s(motion, reference.trajectory))
    skip = min(skipped / reference.dt, last / 2)
    return np.unique(np.linspace(skip, last - skip, COLUMNS).round().astype(int))


def _human_row(axes: Any, joints: Floats) -> None:
    view = _view(joints[0, INDEX["left_hip"]] - joints[0, INDEX["right_hip"]])
    height, reach = float(joints[..., 2].max()), 0.0
    for axis, pose in zip(axes, joints, strict=True):
        centre = pose[INDEX["pelvis"]] * [1, 1, 0]
        flat, depth = _project(pose - centre, view)
        for chain in sorted(CHAINS, key=lambda chain: depth[list(chain)].mean()):
            axis.plot(*flat[list(chain)].T, color=_side_colour(chain[-1]), lw=5, solid_capstyle="round",
                      solid_joinstyle="round")  # fmt: skip
        axis.plot(*flat[INDEX["head"]], "o", color=TRUNK, ms=13)
        reach = max(reach, float(np.abs(flat[:, 0]).max()))
    fit(axes, 1.1 * height, reach)


def _robot_row(axes: Any, reference: Reference, frames: np.ndarray) -> None:
    shapes = body_shapes(reference.model, reference.robot)
    view = robot_view(reference)
    root = reference.model.body(reference.robot.root_body).id
    height, reach = 0.0, 0.0
    colours = body_colours(reference)
    for axis, frame in zip(axes, frames, strict=True):
        position, rotation = reference.body_pos[frame], reference.body_rot[frame]
        spread = draw_pose(axis, shapes, position - position[root] * [1, 1, 0], rotation, view, colours)
        reach, height = max(reach, spread[0]), max(height, spread[1])
    fit(axes, height, reach)


def robot_view(reference: Reference) -> Floats:
    """(3, 3) rows right, up, towards the viewer, who stands before the robot's first pose, a little to its left."""
    pair = "hip" if "left_hip" in reference.attachments else "shoulder"
    return _view(reference.attachments[f"left_{pair}"][0] - reference.attachments[f"right_{pair}"][0])


def draw_pose(
    axis: Any,
    shapes: tuple[Shape, ...],
    position: Floats,
    rotation: Floats,
    view: Floats,
    colours: list[str],
    alpha: float = 1.0,
) -> tuple[float, float]:
    """Draw a robot's shapes on a matplotlib axis, far ones first.

    Args:
        axis: the axis.
        shapes: of the robot.
        position: (B, 3) m, of each body.
        rotation: (B, 3, 3) world from body.
        view: (3, 3) rows right, up, towards the viewer.
        colours: of each body.
        alpha: opacity.

    Returns:
        How far the picture reaches to a side and up, m.
    """
    parts = []
    for shape in shapes:
        flat, depth = _project(shape.points @ rotation[shape.body].T + position[shape.body], view)
        parts.append((float(depth.mean()), flat[ConvexHull(flat).vertices], colours[shape.body]))
    for _, outline, colour in sorted(parts, key=lambda part: part[0]):
        axis.fill(*outline.T, facecolor=colour, edgecolor=PAPER, lw=0.6, alpha=alpha)
    outlines = np.concatenate([outline for _, outline, _ in parts])
    return float(np.abs(outlines[:, 0]).max()), float(outlines[:, 1].max())


def body_colours(reference: Reference) -> list[str]:
    """A colour for each body of the model: by the side that its name states, else the trunk's."""
    names = [reference.model.body(index).name for index in range(reference.model.nbody)]
    return [
        LEFT if name.startswith(("l_", "left")) else RIGHT if name.startswith(("r_", "right")) else TRUNK
        for name in names
    ]


def _side_colour(joint: int) -> str:
    if joint in PARTS["left_arm"] or joint in PARTS["left_leg"]:
        return LEFT
    return TRUNK if joint in PARTS["backbone"] else RIGHT


def _view(to_the_left: Floats) -> Floats:
    """(3, 3) rows right, up, towards the viewer; the viewer stands before the body, a little to its left."""
    facing = np.arctan2(-to_the_left[0], to_the_left[1])
    azimuth = facing + _CAMERA_AZIMUTH
    elevation = _CAMERA_ELEVATION
    towards = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return np.stack([right, np.cross(towards, right), towards])


def _project(points: Floats, view: Floats) -> tuple[Floats, Floats]:
    """Orthographic picture coordinates (n, 2) and depth towards the viewer (n,)."""
    seen = points @ view.T
    return seen[:, :2], seen[:, 2]


def fit(axes: Any, height: float, reach: float) -> None:
    """The same limits for a row of pictures, wide enough for what is in them."""
    width = max(1.05 * reach, 0.35 * height)
    for axis in axes:
        axis.set(xlim=(-width, width), ylim=(-0.12 * height, 1.05 * height), xticks=[], yticks=[])
        axis.set_aspect("equal")
        axis.axhline(0, color=FLOOR, lw=1, zorder=-1)
        for spine in axis.spines.values():
            spine.set_visible(False)
