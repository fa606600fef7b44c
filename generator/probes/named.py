"""What a segment's text names of an action: only that can be asked of a motion.

`named` picks it out of the parameters of a performance, `required` takes it from a frame, and `told` reads it where
there is nothing but the text.
"""

import re
from collections.abc import Mapping
from typing import Any

from generator.probes.checks import Details
from generator.probes.spec import Probe
from generator.text.counts import repetitions
from generator.text.frame import ActionFrame

_LIMBS = r"(hand|hands|arm|arms|leg|foot|knee|fist|shoulder)"
_DIRECTIONS = {
    "up": "up|upwards|overhead|above|over|high|air",
    "down": "down|downwards|floor|ground",
    "side": r"side|sides|sideways",
    "forward": "forward|forwards|ahead|front",
    "back": "back|backwards|backward",
    "backward": "back|backwards|backward",
    "left": "left|counterclockwise",
    "right": "right|clockwise",
    "diagonal_left": "left",
    "diagonal_right": "right",
    "turning left": "left",
    "turning right": "right",
    "head": "head|overhead|hair",
}
_WAYS = {("clap", "up"): "head", ("lift_weights", "up"): "press"}
"""Ways of frames that probes name otherwise."""
_ANGLES = r"degrees|quarter|around|circle"
_SIDED = re.compile(rf"\b(left|right) {_LIMBS}\b")
_PLURAL = re.compile(rf"\bboth\b|\b{_LIMBS}s\b")
_TURNS = (
    (re.compile(r"\bquarter\b"), 90.0),
    (re.compile(r"\bfull\b|\ball the way\b|\bcircle\b|\bcomplete"), 360.0),
    (re.compile(r"\baround\b|\bhalf\b"), 180.0),
)


def named(probe: Probe, params: Mapping[str, Any], text: str) -> dict[str, Any]:
    """The parameters that the text of one segment tells: side, count, direction, angle."""
    out = {key: value for key, value in params.items() if key not in ("side", "count")}
    side, count = params.get("side", ""), params.get("count")
    if side and re.search(rf"\bboth\b|\b{_LIMBS}s\b" if side == "both" else rf"\b{side} {_LIMBS}\b", text):
        out["side"] = side
    if count and count == repetitions(text):
        out["count"] = count
    direction = probe.wanted(params)
    if direction and not re.search(rf"\b({_DIRECTIONS.get(direction, direction)})\b", text):
        out = {key: value for key, value in out.items() if key in ("side", "count")}
    if probe.extent and probe.extent.param in params and re.search(rf"\b({_ANGLES})\b", text):
        out["extent"] = params[probe.extent.param]
    return out


def told(probe: Probe, clause: str) -> Details:
    """What the text of one clause tells of an action. Of directions that are told at once none is asked for."""
    sides = {side for side, _ in _SIDED.findall(clause)}
    side = "both" if not sides and _PLURAL.search(clause) else ""
    rest = _SIDED.sub("", clause)
    directions = [d for d in probe.variants if re.search(rf"\b({_DIRECTIONS.get(d, d)})\b", rest)]
    return Details(
        side=sides.pop() if len(sides) == 1 else side,
        count=repetitions(clause) or None,
        direction=directions[0] if len(directions) == 1 else "",
        extent=_angle(rest) if probe.extent else None,
    )


def required(probe: Probe, frame: ActionFrame) -> Details:
    """What a frame says of an action, as far as its probe can tell."""
    way = _WAYS.get((frame.action, frame.way), frame.way)
    angle = frame.value("angle")
    if frame.action == "jump" and angle is not None:
        way = f"turning {frame.way}" if frame.way in {"left", "right"} else ""
    return Details(
        side=frame.side,
        count=frame.count,
        direction=way if way in probe.variants else "",
        extent=angle if probe.extent else None,
    )


def _angle(text: str) -> float | None:
    """Degrees of a turn."""
    if degrees := re.search(r"\b(\d+) degrees\b", text):
        return float(degrees[1])
    return next((angle for pattern, angle in _TURNS if pattern.search(text)), None)
