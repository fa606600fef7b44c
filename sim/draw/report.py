"""`report.html`: one file, no network, that shows what was asked, what the robot does, and why it passes or not."""

import base64
import html
import io
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ros_free_stack.files import make_folder, write_text
from ros_free_stack.messages import Check, Floats, HumanMotion, RobotTrajectory, ServoTelemetry
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import BONES
from sim.draw.plots import feet_plot, joints_plot, servo_angles_plot, servo_health_plot, torque_plot
from sim.draw.shapes import body_shapes
from sim.draw.storyboard import body_colours, storyboard
from sim.draw.synchrony import human_at, lead_in_s
from sim.draw.worst import worst_moment
from sim.judge.verdict import Judgement

SCENE_FPS = 25.0
"""Frame rate of the animation in the report."""

_JOINTS_CAPTION = "Planned joint angles; red lines are the ends of each range."

_FILES = ("human_motion.npz", "trajectory.npz", "trajectory.csv", "verdict.json", "telemetry.npz")
"""What may lie beside the report and is linked from it."""

_TEMPLATE = Path(__file__).with_name("report.html")


def write_report(
    folder: Path,
    motion: HumanMotion | None,
    trajectory: RobotTrajectory,
    judgement: Judgement,
    robot: RobotDescription,
    title: str = "",
    timings: dict[str, float] | None = None,
    telemetry: ServoTelemetry | None = None,
    notes: Sequence[str] = (),
    not_shown: Sequence[str] = (),
    faithful: bool = True,
    facts: Mapping[str, str] | None = None,
) -> Path:
    """Write `report.html` into a folder and return its path.

    Args:
        folder: made if missing.
        motion: the human motion that the trajectory follows, or None.
        trajectory: what was judged; its digest is shown.
        judgement: its verdict and playback.
        robot: the robot.
        title: the motion's prompt where it is empty.
        timings: seconds by stage.
        telemetry: what the servos did when the trajectory was streamed, or None.
        notes: shown below those of the verdict.
        not_shown: what the motion does not show of what was asked for, a line each.
        faithful: whether every action that was asked for is there; a feasible motion that lacks one did not pass.
        facts: how the motion was made, by name: seed, command line, versions.

    Raises:
        InvalidFile: the folder cannot be written.
    """
    folder = make_folder(folder)
    verdict = judgement.verdict
    path = judgement.reference.trajectory
    word = "infeasible" if not verdict.passed else "feasible" if faithful else "feasible, but not as asked"
    lacking = "" if faithful else " The motion lacks an action that was asked for."
    parts = {
        "title": html.escape(title or (motion.prompt if motion else "") or robot.title),
        "robot": html.escape(robot.title),
        "duration": f"{path.duration_s:.1f} s",
        "state": "passed" if verdict.passed and faithful else "failed",
        "word": word,
        "summary": html.escape(_summary(judgement) + lacking),
        "segments": _segments(motion, path),
        "checks": "\n".join(_row(check, path.fps) for check in verdict.checks),
        "worst": _worst_moments(judgement),
        "notes": "".join(f"<li>{html.escape(note)}</li>" for note in _notes(verdict.notes, not_shown, notes)),
        "origin": _origin(facts or {}, folder),
        "timings": _timings(timings or {}),
        "storyboard": _png(storyboard(motion, judgement.reference)),
        "joints": _timed(joints_plot(judgement.reference), "joints", _JOINTS_CAPTION),
        "feet": _feet(judgement),
        "torque": _torque(judgement),
        "servos": _servos(telemetry),
        "digest": verdict.trajectory_digest[:16],
        "model": verdict.model_sha256[:16],
        "scene": json.dumps(_scene(motion, judgement), separators=(",", ":")).replace("<", "\\u003c"),
    }
    template = _TEMPLATE.read_text(encoding="utf-8")
    page = re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], template)
    path = folder / "report.html"
    write_text(path, page)
    return path


def _summary(judgement: Judgement) -> str:
    verdict, playback = judgement.verdict, judgement.playback
    count = len(verdict.checks)
    if verdict.passed:
        kept = playback and verdict.mount == "free"
        return f"All {count} checks passed" + ("; the robot kept its feet in physics." if kept else ".")
    failed = ", ".join(check.name.replace("_", " ") for check in verdict.failures)
    fell = f" It fell after {playback.fell_at_s:.1f} s." if playback and playback.fell_at_s is not None else ""
    return f"{len(verdict.failures)} of {count} checks failed: {failed}.{fell}"


def _notes(verdict: Sequence[str], not_shown: Sequence[str], further: Sequence[str]) -> list[str]:
    return [*(f"not shown: {line}" for line in not_shown), *verdict, *further]


def _segments(motion: HumanMotion | None, trajectory: RobotTrajectory) -> str:
    """The segments as bars over the trajectory's time."""
    if motion is None or not motion.segments:
        return ""
    lead = lead_in_s(motion, trajectory)
    bars = []
    for segment in motion.segments:
        left = 100 * (segment.start_s + lead) / trajectory.duration_s
        width = 100 * (segment.end_s - segment.start_s) / trajectory.duration_s
        text = html.escape(segment.text)
        bars.append(f'<span class="segment" style="left:{left:.2f}%;width:{width:.2f}%" title="{text}">{text}</span>')
    return f'<div class="segments">{"".join(bars)}</div>'


def _row(check: Check, fps: float) -> str:
    word = "pass" if check.passed else "fail"
    sign = "&le;" if check.passed == (check.value <= check.limit) else "&ge;"
    unit = "" if check.unit == "1" else f" {html.escape(check.unit)}"
    where = html.escape(check.worst_item)
    if check.worst_frame >= 0:
        time = check.worst_frame / fps
        where += f' <button class="jump" data-time="{time:.3f}">{time:.2f} s</button>'
    return (
        f'<tr class="{word}"><td><span class="badge">{word}</span></td>'
        f"<th>{html.escape(check.name.replace('_', ' '))}</th>"
        f'<td class="number" data-label="worst value">{check.value:.3g}{unit}</td>'
        f'<td class="number" data-label="limit">{sign} {check.limit:.3g}{unit}</td>'
        f'<td data-label="where">{where}</td><td>{html.escape(check.meaning)}</td></tr>'
    )


def _timings(timings: dict[str, float]) -> str:
    rows = "".join(
        f'<tr><th>{html.escape(name.replace("_", " "))}</th><td class="number">{value:.2f} s</td></tr>'
        for name, value in timings.items()
    )
    return f"<h2>Time taken</h2><table>{rows}</table>" if rows else ""


def _feet(judgement: Judgement) -> str:
    if not judgement.reference.robot.soles:
        return ""
    caption = "Height of each sole over the floor; shaded where the foot should stand."
    return _timed(feet_plot(judgement.reference, judgement.playback), "feet", caption)


def _torque(judgement: Judgement) -> str:
    if judgement.playback is None:
        return ""
    limit = next((check.limit for check in judgement.verdict.checks if check.name == "torque_peak"), 1.0)
    source = _svg(torque_plot(judgement.reference, judgement.playback, limit))
    caption = f"Greatest torque that the motion needs of each servo; the red line is the verdict's limit, {limit:g}."
    return f'<figure class="wide"><img alt="torques" src="{source}"><figcaption>{caption}</figcaption></figure>'


def _servos(telemetry: ServoTelemetry | None) -> str:
    """What a stream commanded and measured; nothing where there was none."""
    if telemetry is None:
        return ""
    lost = 1 - telemetry.fresh.mean()
    angles = f"Commanded (green) and measured (violet) angles of {len(telemetry.joint_names)} joints."
    health = f"All servos in grey, the highest in violet; {lost:.1%} of the readings were not fresh."
    return (
        "<h2>Servos</h2>"
        f'<figure class="wide"><img alt="servo angles" src="{_svg(servo_angles_plot(telemetry))}">'
        f"<figcaption>{angles}</figcaption></figure>"
        f'<figure class="wide"><img alt="servo health" src="{_svg(servo_health_plot(telemetry))}">'
        f"<figcaption>{health}</figcaption></figure>"
    )


def _timed(figure: Any, name: str, caption: str) -> str:
    """A figure over time with a cursor in each of its plots, which the page moves with the playback."""
    picture = _svg(figure)  # drawing it settles where its plots are
    plots = {axis.get_position().bounds: axis.get_xlim() for axis in figure.axes if axis.get_visible()}
    cursors = "".join(
        f'<span class="plot" data-start="{start:.4f}" data-end="{end:.4f}" style="left:{100 * left:.3f}%;'
        f'width:{100 * width:.3f}%;bottom:{100 * bottom:.3f}%;height:{100 * height:.3f}%"><i></i></span>'
        for (left, bottom, width, height), (start, end) in plots.items()
    )
    return (
        f'<figure class="wide"><div class="timed"><img alt="{name}" src="{picture}">{cursors}</div>'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _worst_moments(judgement: Judgement) -> str:
    """A picture of the worst frame of every failed check that has one."""
    fps = judgement.reference.trajectory.fps
    cards = []
    for check in judgement.verdict.failures:
        if check.worst_frame < 0:
            continue
        name, time = html.escape(check.name.replace("_", " ")), check.worst_frame / fps
        cards.append(
            f'<figure class="worst"><img alt="worst frame: {name}" src="{_png(worst_moment(judgement, check))}">'
            f'<figcaption><b>{name}</b> <button class="jump" data-time="{time:.3f}">{time:.2f} s</button> '
            f"{html.escape(check.worst_item)}</figcaption></figure>"
        )
    return f'<h2>Worst moments</h2><div class="grid">{"".join(cards)}</div>' if cards else ""


def _png(figure: Any) -> str:
    """A matplotlib figure as a data URL."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=110, metadata={"Software": None})
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()


def _svg(figure: Any) -> str:
    """A matplotlib figure as a data URL that stays sharp at every size."""
    stream = io.BytesIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(stream.getvalue()).decode()


def _origin(facts: Mapping[str, str], folder: Path) -> str:
    """How the motion was made, and the files beside the report."""
    rows = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>" for name, value in facts.items()
    )
    there = [name for name in _FILES if (folder / name).is_file()]
    links = " &middot; ".join(f'<a href="{name}">{name}</a>' for name in there)
    table = f'<div class="card scroll"><table>{rows}</table></div>' if rows else ""
    return (f"<h2>How it was made</h2>{table}" if rows else "") + (f"<p>Files: {links}</p>" if links else "")


def _scene(motion: HumanMotion | None, judgement: Judgement) -> dict[str, Any]:
    """What the page animates: shapes once, then body poses (position and quaternion) for every frame."""
    reference, playback = judgement.reference, judgement.playback
    trajectory = reference.trajectory
    count = max(1, round(trajectory.duration_s * SCENE_FPS))
    times = np.minimum(np.arange(count) / SCENE_FPS, (len(reference.qpos) - 1) * reference.dt)
    frames = np.rint(times / reference.dt).astype(int)
    shapes = body_shapes(reference.model, reference.robot)
    colours = body_colours(reference)
    scene: dict[str, Any] = {
        "fps": SCENE_FPS,
        "shapes": [
            {"body": shape.body, "colour": colours[shape.body], "points": _rounded(shape.points)} for shape in shapes
        ],
        "root": reference.model.body(reference.robot.root_body).id,
        "height": float(reference.body_pos[0, :, 2].max()),
        "robot": _poses(reference.body_pos[frames], reference.body_rot[frames]),
        "soles": [
            {"body": reference.model.body(sole.body).id, "points": sole.corners}
            for sole in reference.robot.soles.values()
        ],
        "contacts": trajectory.contacts[frames].astype(int).tolist(),
    }
    if playback is not None:
        shown = np.minimum(frames, playback.frames - 1)
        scene["simulated"] = _poses(playback.body_pos[shown], playback.body_rot[shown])
        scene["fell"] = playback.fell_at_s
    if motion is not None:
        scene["human"] = _rounded(human_at(motion, trajectory, times))
        scene["bones"] = [list(bone) for bone in BONES]
    return scene


def _poses(position: Floats, rotation: Floats) -> list[Any]:
    """[T][B] rows of x, y, z and the first two columns of the rotation, from which the third follows."""
    return _rounded(np.concatenate([position, rotation[..., 0], rotation[..., 1]], axis=-1))


def _rounded(values: Floats) -> list[Any]:
    return np.round(values, 3).tolist()
