"""The worst frame of a failed check as a picture: what was planned, what happened in physics, the culprit in red."""

import re
from typing import Any

from ros_free_stack.messages import Check, Floats
from sim.draw.shapes import body_shapes
from sim.draw.storyboard import INK, body_colours, draw_pose, fit, robot_view
from sim.judge.verdict import Judgement
from sim.reference import Reference

CULPRIT = "#dc2626"


def worst_moment(judgement: Judgement, check: Check) -> Any:
    """The robot at a check's worst frame as a matplotlib figure; with physics the simulated robot stands beside it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    reference, playback, frame = judgement.reference, judgement.playback, check.worst_frame
    frame = min(frame, len(reference.qpos) - 1)
    poses = {"planned": (reference.body_pos[frame], reference.body_rot[frame])}
    if playback is not None:
        seen = min(frame, playback.frames - 1)  # a fall ends the simulation early
        poses["simulated"] = (playback.body_pos[seen], playback.body_rot[seen])
    figure = Figure(figsize=(2.4 * len(poses), 2.8), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(poses), squeeze=False)[0]
    _draw(axes, reference, poses, culprits(reference, check.worst_item))
    return figure


def culprits(reference: Reference, item: str) -> set[int]:
    """Bodies that a check's worst item names: bodies, the links of joints, or feet."""
    robot, model = reference.robot, reference.model
    bodies = {model.body(index).name: index for index in range(1, model.nbody)}
    bodies |= {name: int(model.jnt_bodyid[model.joint(name).id]) for name in robot.joint_names}
    bodies |= {foot: model.body(sole.body).id for foot, sole in robot.soles.items()}
    return {bodies[word] for word in re.findall(r"[\w-]+", item) if word in bodies}


def _draw(axes: Any, reference: Reference, poses: dict[str, tuple[Floats, Floats]], red: set[int]) -> None:
    shapes, view = body_shapes(reference.model, reference.robot), robot_view(reference)
    root = reference.model.body(reference.robot.root_body).id
    colours = [CULPRIT if body in red else colour for body, colour in enumerate(body_colours(reference))]
    spreads = []
    for axis, (name, (position, rotation)) in zip(axes, poses.items(), strict=True):
        centred = position - position[root] * [1, 1, 0]
        alpha = 0.45 if red else 1.0
        spreads.append(draw_pose(axis, shapes, centred, rotation, view, colours, alpha=alpha))
        if red:
            guilty = tuple(shape for shape in shapes if shape.body in red)
            draw_pose(axis, guilty, centred, rotation, view, colours)
        axis.set_title(name, fontsize=9, color=INK)
    fit(axes, max(height for _, height in spreads), max(reach for reach, _ in spreads))
