"""Which parameters of an action a segment's text names: only these can be asked of a motion."""

import re
from collections.abc import Mapping
from typing import Any

from generator.probes.spec import Probe

_LIMBS = r"(hand|hands|arm|arms|leg|foot|knee|fist|shoulder)"
_NUMBERS = {1: "once|one|a single", 2: "twice|two|2", 3: "three|3", 4: "four|4", 5: "five|5", 6: "six|6"}
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
_ANGLES = r"degrees|quarter|around|circle"


def named(probe: Probe, params: Mapping[str, Any], text: str) -> dict[str, Any]:
    """The parameters that the text of one segment tells: side, count, direction, angle."""
    out = {key: value for key, value in params.items() if key not in ("side", "count")}
    side, count = params.get("side", ""), params.get("count")
    if side and re.search(rf"\bboth\b|\b{_LIMBS}s\b" if side == "both" else rf"\b{side} {_LIMBS}\b", text):
        out["side"] = side
    if count in _NUMBERS and re.search(rf"\b({_NUMBERS[count]}) times\b|\b({_NUMBERS[count]})\b", text):
        out["count"] = count
    direction = probe.wanted(params)
    if direction and not re.search(rf"\b({_DIRECTIONS.get(direction, direction)})\b", text):
        out = {key: value for key, value in out.items() if key in ("side", "count")}
    if probe.extent and probe.extent.param in params and re.search(rf"\b({_ANGLES})\b", text):
        out["extent"] = params[probe.extent.param]
    return out
