"""A proposal as a picture: the skeleton over the robot's shapes, from the front and from the side, with labels."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from retarget.describe.proposal import Proposal
from retarget.describe.shapes import body_geoms, geom_points
from ros_free_stack.files import atomic_path
from ros_free_stack.messages import Floats

CHAINS = (
    ("pelvis", "left_hip", "left_knee", "left_ankle"),
    ("pelvis", "right_hip", "right_knee", "right_ankle"),
    ("left_shoulder", "left_elbow", "left_wrist"),
    ("right_shoulder", "right_elbow", "right_wrist"),
)
COLOURS = {"left": "#c0392b", "right": "#2456a6", "": "#222222"}
VIEWS = (("front", 1, 1.0), ("left side", 0, -1.0))
"""Title, the coordinate across the picture, and its direction: seen from the front, left is at the right."""


def draw_proposal(proposal: Proposal, path: Path, title: str) -> None:
    """Write a PNG of the standing pose; InvalidFile where it cannot be written."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    data = mujoco.MjData(proposal.model)
    data.qpos[:] = proposal.standing_qpos
    mujoco.mj_kinematics(proposal.model, data)
    figure = Figure(figsize=(13, 9), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (view, across, sign) in zip(figure.subplots(1, 2), VIEWS, strict=True):
        _draw_view(axes, proposal, data, across, sign, labelled=("left", "right", "") if across else ("left", ""))
        axes.set_title(f"{title}, {view}")
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110, format="png")


def _draw_view(
    axes: Any, proposal: Proposal, data: mujoco.MjData, across: int, sign: float, *, labelled: tuple[str, ...]
) -> None:
    from matplotlib.patches import Polygon

    def flat(points: Floats) -> Floats:
        return np.column_stack([sign * points[:, across], points[:, 2]])

    for body in range(1, proposal.model.nbody):
        for geom in body_geoms(proposal.model, body):
            outline = _outline(flat(_world(data, body, geom_points(proposal.model, geom))))
            if outline is not None:
                axes.add_patch(Polygon(outline, facecolor="#b9c0c7", edgecolor="#8b939b", alpha=0.35, linewidth=0.5))
    for name, capsules in proposal.capsules.items():
        for capsule in capsules:
            ends = flat(_world(data, proposal.model.body(name).id, np.array([capsule.start, capsule.end])))
            axes.plot(*ends.T, color="#2e8b57", alpha=0.35, linewidth=1)
    for name, corners in proposal.soles.values():
        outline = flat(_world(data, proposal.model.body(name).id, corners))[[0, 1, 3, 2, 0]]
        axes.plot(*outline.T, color="#d98200", linewidth=2.5)
    points = {
        joint: flat(_world(data, proposal.model.body(item.body).id, np.array([item.offset])))[0]
        for joint, item in proposal.attachments.items()
    }
    for chain in CHAINS:
        line = np.array([points[joint] for joint in chain if joint in points])
        if len(line):
            axes.plot(*line.T, color=COLOURS[_side(chain[-1])], linewidth=2, marker="o", markersize=5)
    for joint in points.keys() & {"head", "pelvis"}:
        axes.plot(*points[joint], color=COLOURS[""], marker="o", markersize=6)
    axes.set_aspect("equal")
    axes.autoscale_view()
    _label(axes, {joint: at for joint, at in points.items() if _side(joint) in labelled}, proposal)
    axes.set_xlabel("m")
    axes.spines[["top", "right"]].set_visible(False)


def _label(axes: Any, points: dict[str, Floats], proposal: Proposal) -> None:
    """Joint and body names in columns beside the robot, spread so that none covers another."""
    low, high = axes.get_xlim()
    middle, width, height = (low + high) / 2, (high - low) / 2, float(np.ptp(axes.get_ylim()))
    width = max(width, 0.2 * height)
    axes.set_xlim(middle - 2.2 * width, middle + 2.2 * width)
    for right in (False, True):
        names = [name for name, at in points.items() if (at[0] > middle + 1e-3) == right]
        last = np.inf
        for name in sorted(names, key=lambda name: -points[name][1]):
            last = min(float(points[name][1]), last - 0.045 * height)
            axes.annotate(
                f"{name}\n{proposal.attachments[name].body}",
                xy=tuple(points[name]),
                xytext=(middle + (1.1 * width if right else -1.1 * width), last),
                ha="left" if right else "right",
                va="center",
                fontsize=7,
                color=COLOURS[_side(name)],
                arrowprops={"arrowstyle": "-", "color": "#999999", "linewidth": 0.6},
            )


def _side(joint: str) -> str:
    return joint.split("_", maxsplit=1)[0] if "_" in joint else ""


def _world(data: mujoco.MjData, body: int, points: Floats) -> Floats:
    return data.xpos[body] + points @ data.xmat[body].reshape(3, 3).T


def _outline(points: Floats) -> Floats | None:
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        return None
