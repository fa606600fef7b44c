"""Probes of what the hands do every day: at the head and the chest, at work, in music and sport."""

from collections.abc import Mapping
from typing import Any

from generator.probes.spec import Probe, above, below, within


def _to(params: Mapping[str, Any]) -> str:
    return params.get("to", "")


def _target(params: Mapping[str, Any]) -> str:
    return params.get("target", "")


def _style(params: Mapping[str, Any]) -> str:
    return params.get("style", "")


PROBES = (
    Probe(
        "lift_arms",
        "hand",
        {
            "hand.speed": above(3.5),
            "hand.folded": above(0.82),
            "hand.back": above(-0.2),
            "hand.pulses": above(1),
            "hand.lift": above(-0.5),
        },
        {"up": {"hand.top": above(0.6)}, "side": {"hand.y": above(0.5)}, "forward": {"hand.x": above(0.5)}},
        wanted=_to,
        count="hand.pulses",
    ),
    Probe(
        "eat",
        "hand",
        {
            "hand.to_head": below(0.46),
            "hand.still_z": below(0.35),
            "nod_high": above(9),
            "other_hand.lift": below(-0.25),
            "other_hand.extension": below(0.9),
        },
        count="hand.bites",
    ),
    Probe(
        "brush_teeth",
        "hand",
        {
            "hand.extension": below(0.53),
            "hand.range_y": above(0.18),
            "gap_mid": above(0.9),
            "hand.head_mid": below(0.6),
        },
    ),
    Probe("comb_hair", "hand", {"hand.shortest": below(0.48), "hand.lift": above(0.36), "hand.to_head": below(0.6)}),
    Probe(
        "rub_hands",
        "hands",
        {
            "hand.y": above(-0.42),
            "gap_low": below(0.3),
            "hand.range_x": above(0.1),
            "hand.lift": within(-0.75, -0.2),
            "hand.shortest": below(0.82),
            "gap_mid": below(0.7),
        },
    ),
    Probe(
        "check_watch",
        "hand",
        {
            "hand.y": below(-0.25),
            "other_hand.lift": below(-0.6),
            "hand.lift": within(-0.5, 0.05),
            "hand.extension": within(0.45, 0.85),
        },
    ),
    Probe("phone", "hand", {"hand.extension": below(0.34), "hand.lift": within(-0.05, 0.28), "hand.hold": above(0.4)}),
    Probe(
        "pray",
        "hands",
        {
            "gap_low": below(0.2),
            "hand.extension": below(0.7),
            "hand.hold": above(0.5),
            "hand.lift": within(-0.6, 0.0),
            "claps": below(1),
        },
    ),
    Probe(
        "cover",
        "hands",
        {"hand.head_mid": below(0.55), "hand.extension": below(0.58), "gap_low": below(0.9)},
        {
            "face": {"hand.still_x": above(0.3)},
            "ears": {"hand.still_x": below(0.32)},
            "mouth": {"hand.still_x": above(0.3)},
        },
        wanted=_target,
    ),
    Probe("hug", "hands", {"hand.range_y": above(0.9), "gap_low": below(0.6), "hand.lift": within(-0.6, 0.3)}),
    Probe("flex", "hand", {"hand.extension": below(0.58), "hand.y": above(0.24), "hand.lift": above(0.1)}),
    Probe(
        "wipe_table",
        "hand",
        {"other_hand.away": below(0.6), "hand.range_y": above(0.45), "hand.lift": within(-0.75, -0.45)},
        count="hand.ins",
    ),
    Probe(
        "stir",
        "hand",
        {
            "hand.range_y": above(0.24),
            "hand.extension": below(0.9),
            "hand.lift": within(-0.8, -0.22),
            "nod_high": above(14),
            "hand.ins": above(1),
        },
    ),
    Probe(
        "chop",
        "hand",
        {
            "hand.downs": above(1),
            "hand.range_z": above(0.22),
            "hand.y": below(0.0),
            "hand.lift": within(-0.75, -0.2),
            "nod_high": above(13),
            "other_hand.extension": below(0.96),
        },
        count="hand.downs",
    ),
    Probe(
        "hammer",
        "hand",
        {"hand.tops": above(2), "hand.shortest": below(0.62), "hand.front": within(0.55, 0.92)},
        count="hand.downs",
    ),
    Probe(
        "knock",
        "hand",
        {
            "hand.shortest": within(0.5, 0.62),
            "hand.folded": above(0.5),
            "hand.lift": within(-0.2, 0.15),
            "hand.x": above(0.5),
            "hand.longest": below(1.0),
            "hand.range_x": within(0.12, 0.35),
        },
        count="hand.pulses_x",
    ),
    Probe(
        "open_door",
        "hand",
        {
            "twist_range": above(16),
            "hand.front": within(0.68, 0.97),
            "hand.lift": within(-0.75, -0.35),
            "nod_high": above(6),
            "hand.still_y": above(-0.25),
        },
    ),
    Probe(
        "pour",
        "hand",
        {
            "hand.to_head": above(0.6),
            "nod_high": above(13),
            "hand.lift": within(-0.3, 0.05),
            "hand.y": below(0.05),
            "other_hand.lift": within(-0.8, -0.3),
            "other_hand.extension": below(0.92),
            "hand.hold": above(0.3),
        },
    ),
    Probe(
        "pull",
        "hand",
        {
            "hand.thrust": below(2.7),
            "hand.front": within(0.86, 1.0),
            "hand.range_x": above(0.5),
            "hand.lift": within(-0.5, 0.0),
            "hand.pulls": above(1),
            "hand.back": above(-0.2),
        },
        count="hand.pulls",
    ),
    Probe(
        "carry",
        "hands",
        {
            "gap_mid": below(0.85),
            "gap_low": above(0.42),
            "hand.to_head": above(0.95),
            "hand.extension": below(0.93),
            "hand.hold": above(0.8),
            "hand.lift": above(-0.75),
        },
    ),
    Probe(
        "lift_weights",
        "hand",
        {
            "hand.head_mid": above(0.6),
            "hand.folded": below(0.5),
            "hand.still_y": above(-0.1),
            "hand.x": below(0.6),
            "hand.lift_range": above(0.55),
        },
        {"curl": {"hand.top": below(0.3)}, "press": {"hand.top": above(0.6)}},
        wanted=_style,
        count="hand.curls",
    ),
    Probe(
        "play_guitar",
        "hand",
        {
            "hand.ups": above(1),
            "hand.lift": within(-0.85, -0.35),
            "hand.y": below(0.0),
            "other_hand.y": above(0.15),
            "other_hand.lift": within(-0.5, 0.1),
        },
    ),
    Probe(
        "play_violin",
        "hand",
        {
            "hand.range_y": above(0.4),
            "other_hand.extension": below(0.75),
            "other_hand.lift": above(-0.25),
            "other_hand.y": within(-0.1, 0.4),
        },
    ),
    Probe(
        "play_drums",
        "hands",
        {
            "hand.thrust": above(1.3),
            "hand.lift": within(-0.5, -0.12),
            "hand.range_z": above(0.25),
            "hand.downs": above(1),
            "gap_mid": within(0.4, 1.1),
        },
    ),
    Probe(
        "play_piano",
        "hands",
        {
            "gap_low": below(0.72),
            "hand.head_mid": above(1.0),
            "hand.lift": within(-0.65, -0.35),
            "hand.top": above(-0.52),
            "hand.range_y": above(0.12),
            "hand.extension": below(0.95),
        },
    ),
    Probe(
        "conduct",
        "hands",
        {
            "hand.range_y": above(0.35),
            "hand.range_z": above(0.35),
            "hand.range_x": below(0.3),
            "hand.x": above(0.5),
            "hand.top": above(0.0),
        },
    ),
    Probe(
        "bounce_ball",
        "hand",
        {
            "hand.y": above(0.12),
            "hand.front": below(0.82),
            "hand.lift": within(-0.95, -0.35),
            "hand.downs": above(1),
            "hand.range_z": within(0.2, 0.6),
            "hand.x": above(0.4),
        },
        count="hand.downs",
    ),
    Probe(
        "catch",
        "hand",
        {
            "hand.front": within(0.83, 0.98),
            "hand.folded": within(0.5, 0.66),
            "hand.lift": within(-0.4, 0.3),
            "hand.hold": below(0.6),
            "hand.pulses_x": below(1),
        },
    ),
    Probe(
        "swim",
        "hand",
        {"hand.longest": above(0.9), "hand.y": below(0.75), "pelvis_range": below(0.13)},
        {
            "breast": {"hand.range_y": above(0.8), "hand.front": above(0.85), "gap_low": below(0.45)},
            "crawl": {"hand.top": above(0.6), "hand.range_x": above(1.0)},
        },
        wanted=lambda params: params.get("stroke", ""),
    ),
    Probe(
        "guard",
        "hands",
        {
            "gap_mid": below(0.62),
            "gap_low": above(0.22),
            "hand.extension": within(0.38, 0.75),
            "hand.hold": above(0.4),
            "hand.lift": within(-0.5, 0.1),
            "hand.x": above(0.3),
        },
    ),
    Probe(
        "swing_club",
        "hands",
        {"gap_mid": below(0.78), "turn_range": within(30, 60), "twist_range": above(30), "hand.range_y": above(0.2)},
    ),
    Probe(
        "swing_racket",
        "hand",
        {
            "twist_range": above(38),
            "hand.range_z": above(0.3),
            "other_hand.folded": above(0.75),
            "hand.speed": above(4),
        },
    ),
)
