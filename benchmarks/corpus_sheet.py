"""Figures of people and robots in strips, one below the other, as one picture."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from generator.corpus import body
from ros_free_stack.files import atomic_path, make_folder
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import BONES, FPS, INDEX, JOINT_NAMES

if TYPE_CHECKING:
    from retarget.pipeline import Retargeter

_COLOURS: Final = {"left": "#d97706", "right": "#2563eb", "trunk": "#475569"}
_VIEW: Final = np.radians(35)
_CIRCLE: Final = np.linspace(0, 2 * np.pi, 13)
_SPACING, _PITCH = 1.3, 2.75  # m between figures, and between strips


@dataclass(frozen=True)
class Figure:
    """One figure in the plane of the picture, standing at the origin: lines or filled outlines with their colours."""

    parts: tuple[tuple[Floats, str], ...]
    filled: bool = False


def human_figures(joints: Floats, frames: int) -> list[Figure]:
    """The skeleton at moments evenly over a motion, the camera moving along."""
    figures = []
    facing = _facing(joints[0, INDEX["left_hip"]] - joints[0, INDEX["right_hip"]])
    for pose in joints[np.linspace(0, len(joints) - 1, frames).round().astype(int)]:
        flat, _ = _project(pose - pose[0] * [1, 1, 0], facing)
        bones = [(flat[[a, b]], _COLOURS.get(JOINT_NAMES[b].split("_")[0], _COLOURS["trunk"])) for a, b in BONES]
        head = flat[INDEX["head"]] + 0.09 * np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)], axis=1)
        figures.append(Figure((*bones, (head, _COLOURS["trunk"]))))
    return figures


def robot_figures(retargeter: "Retargeter", joints: Floats, frames: int) -> list[Figure]:
    """The robot at the same moments, as tall as the human."""
    from scipy.spatial import ConvexHull

    from sim.draw.shapes import body_shapes
    from sim.draw.storyboard import body_colours
    from sim.model import judging_model
    from sim.reference import make_reference

    robot, motion = retargeter.robot, HumanMotion(joints, FPS)
    result = retargeter.retarget(motion)
    trajectory = result.trajectory
    reference = make_reference(trajectory, robot, judging_model(robot))
    facing = _facing(reference.attachments["left_hip"][0] - reference.attachments["right_hip"][0])
    shapes, colours = body_shapes(reference.model, robot), body_colours(reference)
    root = reference.model.body(robot.root_body).id
    skip = 0.5 * trajectory.fps * max(0.0, trajectory.duration_s - result.report.slowdown * motion.duration_s)
    tall = 0.5 * body.HEIGHT / reference.body_pos[0, root, 2]
    figures = []
    for frame in np.linspace(skip, len(reference.qpos) - 1 - skip, frames).round().astype(int):
        parts = []
        for shape in shapes:
            points = shape.points @ reference.body_rot[frame, shape.body].T + reference.body_pos[frame, shape.body]
            flat, near = _project(tall * (points - reference.body_pos[frame, root] * [1, 1, 0]), facing)
            parts.append((float(near.mean()), flat[ConvexHull(flat).vertices], colours[shape.body]))
        parts.sort(key=lambda part: part[0])
        figures.append(Figure(tuple((outline, colour) for _, outline, colour in parts), filled=True))
    return figures


def _facing(to_the_left: Floats) -> float:
    return float(np.arctan2(-to_the_left[0], to_the_left[1]))


def _project(points: Floats, facing: float) -> tuple[Floats, Floats]:
    """Picture coordinates (n, 2) from in front, towards the body's left and a little above, and nearness (n,)."""
    c, s = np.cos(facing + _VIEW), np.sin(facing + _VIEW)
    near = c * points[:, 0] + s * points[:, 1]
    return np.stack([c * points[:, 1] - s * points[:, 0], points[:, 2] - 0.15 * near], axis=1), near


def draw_sheet(strips: list[tuple[str, list[Figure]]], path: Path) -> None:
    """Write a PNG with one titled strip below the other."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.figure import Figure as Canvas

    columns = max(len(figures) for _, figures in strips)
    width, height = columns * _SPACING, len(strips) * _PITCH
    canvas = Canvas(figsize=(0.8 * width, 0.8 * height), dpi=100)
    FigureCanvasAgg(canvas)
    axes = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
    for row, (title, figures) in enumerate(strips):
        floor = -row * _PITCH - 2.35
        axes.text(0.05, floor + 2.25, title, fontsize=7, va="top")
        axes.plot([0, width], [floor, floor], color="#d1d5db", lw=0.8, zorder=0)
        for column, figure in enumerate(figures):
            place = np.array([(column + 0.5) * _SPACING, floor])
            moved = [points + place for points, _ in figure.parts]
            colours = [colour for _, colour in figure.parts]
            if figure.filled:
                axes.add_collection(PolyCollection(moved, facecolors=colours, edgecolors="white", linewidths=0.4))
            else:
                axes.add_collection(LineCollection(moved, colors=colours, linewidths=1.8, capstyle="round"))
    axes.set(xlim=(0, width), ylim=(-height, 0))
    axes.axis("off")
    make_folder(path.parent)
    with atomic_path(path) as temporary:
        canvas.savefig(temporary, format="png", metadata={"Software": None})
