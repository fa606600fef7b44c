"""Probes of where the feet take the body."""

from collections.abc import Mapping
from typing import Any

from generator.probes.spec import Extent, Probe, above, below, within

MAX_STRAIGHT_DEG = 25.0


def _direction(params: Mapping[str, Any]) -> str:
    return params.get("direction", "")


def _turned(params: Mapping[str, Any]) -> str:
    return "" if "angle" not in params else "left" if params["angle"] > 0 else "right"


PROBES = (
    Probe(
        "stand",
        "hands",
        {
            "hand.speed": below(2.2),
            "shake_range": below(5),
            "pelvis_range": below(0.04),
            "nod_range": below(9),
            "shrug": below(0.03),
            "roll_range": below(6),
            "path": below(0.17),
            "lifts": below(1),
            "turn_range": below(6),
        },
    ),
    Probe(
        "step",
        "",
        {"travel": within(0.15, 2.2), "pelvis_mid": above(0.955), "pace": below(0.7), "turn_range": below(30)},
        {
            "forward": {"ahead": above(0.15), "slant": within(-25, 25)},
            "backward": {
                "ahead": below(-0.15),
            },
            "left": {"slant": within(62, 118)},
            "right": {"slant": within(-118, -62)},
            "diagonal_left": {"slant": within(20, 66)},
            "diagonal_right": {"slant": within(-66, -20)},
        },
        wanted=_direction,
        count="paces",
    ),
    Probe(
        "walk",
        "",
        {"path": above(0.4), "pace": below(1.8), "lifts": above(2)},
        {
            "forward": {"ahead": above(0.4), "aside": within(-1.0, 1.0)},
            "backward": {"ahead": below(-0.35)},
            "left": {"aside": above(0.3), "ahead": within(-0.5, 0.5)},
            "right": {"aside": below(-0.3), "ahead": within(-0.5, 0.5)},
        },
        wanted=_direction,
    ),
    Probe(
        "walk_circle",
        "",
        {"path": above(1.5)},
        {"left": {"turned": above(240)}, "right": {"turned": below(-240)}},
        wanted=_direction,
    ),
    Probe(
        "turn",
        "",
        {"turn_range": above(25), "path": below(1.2), "pelvis_low": above(0.93), "lifts": above(1)},
        {"left": {"turned": above(25)}, "right": {"turned": below(-25)}},
        wanted=_turned,
        extent=Extent("turned", "angle", 0.25, 15.0),
    ),
    Probe(
        "march",
        "feet",
        {"foot.knee_at_top": above(80), "foot.toe": above(0.18), "ahead": within(-0.4, 0.4), "foot.lifts": above(1)},
        count="lifts",
    ),
    Probe(
        "jog_in_place",
        "feet",
        {"foot.drop": above(1.0), "foot.toe": within(0.1, 0.25), "ahead": within(-0.4, 0.4), "foot.lifts": above(2)},
    ),
    Probe("jog", "feet", {"pace": above(1.2), "ahead": above(1.5), "foot.toe": above(0.1), "airborne": above(0.015)}),
    Probe("sneak", "", {"pelvis_mid": below(0.89), "ahead": above(0.8), "pitch_mid": above(1.5), "pace": below(0.8)}),
    Probe(
        "dance",
        "feet",
        {
            "turn_range": below(30),
            "flights": below(0),
            "side_steps": above(2),
            "bounces": above(3),
            "sway": above(0.1),
            "ahead": within(-0.3, 0.3),
        },
    ),
)
