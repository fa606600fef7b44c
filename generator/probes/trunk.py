"""Probes of the trunk and the head."""

from collections.abc import Mapping
from typing import Any

from generator.probes.spec import Probe, above, below, within


def _direction(params: Mapping[str, Any]) -> str:
    return params.get("direction", "")


PROBES = (
    Probe(
        "bow",
        "",
        {
            "one_leg": below(0.6),
            "pitch_high": within(20, 63),
            "pelvis_low": above(0.9),
            "turn_range": below(20),
            "travel": below(0.25),
        },
    ),
    Probe("bend_forward", "", {"pitch_high": above(56), "pelvis_low": above(0.84)}),
    Probe(
        "lean",
        "",
        {"one_leg": below(0.6), "turn_range": below(20), "travel": below(0.25), "pelvis_low": above(0.9)},
        {
            "left": {"roll_high": above(15), "roll_low": above(-8)},
            "right": {"roll_low": below(-15), "roll_high": below(8)},
            "forward": {"pitch_high": above(18), "roll_range": below(12)},
            "back": {"pitch_low": below(-14), "roll_range": below(12)},
        },
        wanted=_direction,
    ),
    Probe(
        "twist",
        "",
        {"twist_low": below(-32), "twist_high": above(32), "pelvis_low": above(0.93), "travel": below(0.2)},
        count="twists",
    ),
    Probe(
        "sway",
        "hands",
        {
            "hand.lift": below(-0.4),
            "one_leg": below(0.6),
            "sways": above(1),
            "sway": above(0.1),
            "roll_range": above(8),
            "path": above(0.2),
            "turn_range": below(15),
        },
        count="sways",
    ),
    Probe(
        "look_around",
        "",
        {
            "look_low": below(-20),
            "look_high": above(20),
            "turn_range": below(20),
            "travel": below(0.2),
            "gap_low": above(0.5),
        },
        count="looks",
    ),
    Probe(
        "look",
        "",
        {"path": below(0.3), "turn_range": below(12)},
        {
            "left": {"look_high": above(20), "look_low": above(-10)},
            "right": {"look_low": below(-20), "look_high": below(10)},
            "up": {"nod_low": below(-20)},
            "down": {"nod_high": above(22), "nods": below(1), "nod_hold": above(0.5), "pitch_high": below(25)},
        },
        wanted=_direction,
    ),
    Probe(
        "nod",
        "",
        {"nod_high": above(12), "nods": above(1), "nod_hold": below(0.5), "path": below(0.3), "pitch_high": below(18)},
        count="nods",
    ),
    Probe(
        "shake_head",
        "",
        {
            "shake_range": above(8),
            "shakes": above(1),
            "shake_high": above(3.5),
            "shake_low": below(-3.5),
            "turn_range": below(6),
            "path": below(0.2),
        },
        count="shakes",
    ),
    Probe(
        "circle_hips",
        "hands",
        {
            "roll_range": above(8),
            "hand.away": below(0.4),
            "sway": within(0.08, 0.4),
            "shakes": above(0),
            "one_leg": below(0.3),
            "pitch_range": above(6),
        },
        count="sways",
    ),
)
