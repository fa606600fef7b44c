"""Probes of what the arms do. Hands are measured against the chest, so that the legs are free to walk."""

from collections.abc import Mapping
from typing import Any

from generator.probes.spec import Probe, above, below, within


def _to(params: Mapping[str, Any]) -> str:
    return params.get("to", "")


def _pointed(params: Mapping[str, Any]) -> str:
    if "elevation" not in params or "azimuth" not in params:
        return ""
    azimuth, elevation = params["azimuth"], params["elevation"]
    if elevation > 35 or elevation < -25:
        return "up" if elevation > 0 else "down"
    return "left" if azimuth > 35 else "right" if azimuth < -35 else "forward"


def _height(params: Mapping[str, Any]) -> str:
    return params.get("height", "")


def _target(params: Mapping[str, Any]) -> str:
    return params.get("target", "")


PROBES = (
    Probe(
        "wave",
        "hand",
        {
            "hand.extension": within(0.62, 0.9),
            "hand.x": below(0.62),
            "hand.range_x": below(0.6),
            "hand.ins": above(1),
            "hand.y": above(0.3),
            "hand.top": above(-0.1),
            "hand.range_y": above(0.1),
        },
        count="hand.ins",
    ),
    Probe(
        "raise_arm",
        "hand",
        {
            "hand.shortest": above(0.85),
            "hand.to_chest": above(0.97),
            "hand.flaps": below(1),
            "hand.speed": above(1.5),
            "hand.range_x": below(1.35),
            "pelvis_range": below(0.16),
            "pitch_high": below(35),
        },
        {
            "up": {"hand.still_z": above(0.6)},
            "side": {"hand.still_y": above(0.7), "hand.lift": within(-0.35, 0.5)},
            "forward": {"hand.still_x": above(0.7), "hand.lift": within(-0.35, 0.5)},
        },
        wanted=_to,
    ),
    Probe(
        "clap",
        "hands",
        {"gap_low": below(0.27), "hand.y": above(-0.22), "hand.lift": above(-0.5), "claps": above(1)},
        {"chest": {"hand.lift": below(0.15)}, "head": {"hand.lift": above(0.15)}},
        wanted=_height,
        count="claps",
    ),
    Probe(
        "point",
        "hand",
        {
            "pelvis_range": below(0.16),
            "hand.extension": above(0.95),
            "hand.shortest": within(0.6, 0.985),
            "other_hand.lift": below(-0.45),
            "hand.away": above(0.55),
            "hand.hold": above(0.3),
            "hand.strokes": below(2),
        },
        {
            "forward": {"hand.still_x": above(0.75), "hand.lift": within(-0.3, 0.45)},
            "up": {"hand.lift": above(0.45)},
            "down": {"hand.lift": within(-0.85, -0.3), "hand.still_x": above(0.4)},
            "left": {"hand.azimuth": above(35)},
            "right": {"hand.azimuth": below(-35)},
        },
        wanted=_pointed,
    ),
    Probe(
        "salute",
        "hand",
        {
            "hand.head_mid": below(0.62),
            "hand.y": within(-0.12, 0.3),
            "hand.still_z": within(0.05, 0.4),
            "hand.ups": below(1),
            "hand.hold": above(0.3),
            "hand.shortest": above(0.15),
        },
    ),
    Probe(
        "scratch_head",
        "hand",
        {"hand.to_head": below(0.42), "hand.still_z": above(0.33), "hand.ups": above(1)},
        count="hand.ups",
    ),
    Probe("cross_arms", "hands", {"hand.y": below(-0.38), "hand.lift": within(-0.9, -0.1)}),
    Probe("hands_on_hips", "hands", {"hand.range_x": below(0.25), "hand.hip_hold": above(0.45)}),
    Probe(
        "reach",
        "hand",
        {
            "hand.folded": above(0.42),
            "hand.extension": above(0.92),
            "hand.shortest": below(0.82),
            "hand.longest": above(0.96),
            "hand.hold": above(0.25),
            "hand.thrust": above(0.9),
        },
        {
            "forward": {"hand.still_x": above(0.75), "hand.lift": within(-0.3, 0.5)},
            "up": {"hand.lift": above(0.5)},
            "side": {"hand.still_y": above(0.6), "hand.lift": within(-0.4, 0.5)},
        },
        wanted=_to,
    ),
    Probe(
        "push",
        "hand",
        {
            "hand.folded": below(0.47),
            "hand.x": above(0.8),
            "hand.pushes": above(1),
            "hand.front": within(0.85, 1.0),
            "hand.shortest": below(0.8),
            "twist_range": below(24),
        },
        count="hand.pushes",
    ),
    Probe(
        "swing_arms",
        "hands",
        {"hand.back": below(-0.02), "hand.x": above(0.6), "hand.fronts": above(1), "hand.lift": below(0.0)},
        count="hand.fronts",
    ),
    Probe(
        "circle_arms",
        "hand",
        {"hand.range_x": above(1.2), "hand.longest": above(0.9), "hand.tops": above(1)},
        count="hand.tops",
    ),
    Probe("flap_arms", "hands", {"hand.flaps": above(1), "hand.y": above(0.6)}, count="hand.flaps"),
    Probe(
        "drink",
        "hand",
        {
            "hand.ins": below(1),
            "hand.x": above(0.28),
            "hand.still_z": below(0.35),
            "hand.head_mid": below(0.6),
            "hand.y": below(0.06),
            "hand.lift": above(0.0),
            "gap_low": above(0.3),
        },
    ),
    Probe(
        "wipe",
        "hand",
        {
            "other_hand.lift": below(-0.3),
            "hand.top": above(0.15),
            "hand.range_y": above(0.13),
            "hand.extension": within(0.65, 0.93),
            "hand.x": above(0.48),
        },
        count="hand.ins",
    ),
    Probe("shrug", "hands", {"shrug": above(0.06), "hand.lift": below(0.0), "shrugs": within(1, 4)}, count="shrugs"),
    Probe(
        "touch",
        "hand",
        {"hand.active": within(0.4, 2.5), "hand.shortest": below(0.8)},
        {
            "head": {"hand.to_head": below(0.5), "hand.still_z": above(0.25)},
            "shoulder": {
                "hand.still_z": within(-0.1, 0.2),
                "hand.still_y": within(-0.5, 0.2),
                "hand.extension": below(0.45),
            },
            "chest": {"hand.still_y": below(-0.1), "hand.to_chest": below(0.45), "hand.lift": within(-0.7, 0.0)},
            "hip": {"hand.hip_hold": above(0.45), "hand.range_x": below(0.25)},
            "face": {"hand.to_head": below(0.55), "hand.still_z": within(-0.05, 0.25)},
            "stomach": {"hand.still_y": below(-0.05), "hand.lift": within(-0.9, -0.5), "hand.extension": below(0.85)},
        },
        wanted=_target,
    ),
    Probe(
        "beckon",
        "hand",
        {
            "hand.range_x": above(0.3),
            "hand.pulls": above(1),
            "hand.lift": within(-0.42, 0.05),
            "hand.longest": below(1.0),
            "hand.extension": below(0.92),
        },
        count="hand.pulls",
    ),
    Probe(
        "shake_hand",
        "hand",
        {
            "hand.y": below(0.0),
            "hand.lift": within(-0.85, -0.35),
            "hand.downs": above(1),
            "hand.x": above(0.5),
            "gap_low": above(0.5),
        },
        count="hand.downs",
    ),
)
