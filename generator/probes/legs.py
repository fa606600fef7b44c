"""Probes of single deeds of the legs and the whole body: strikes, jumps, going down and coming up."""

from collections.abc import Mapping
from typing import Any

from generator.probes.spec import Probe, above, below, within


def _direction(params: Mapping[str, Any]) -> str:
    return params.get("direction", "")


def _jumped(params: Mapping[str, Any]) -> str:
    if angle := params.get("angle", 0.0):
        return "turning left" if angle > 0 else "turning right"
    if aside := params.get("aside", 0.0):
        return "left" if aside > 0 else "right"
    if "distance" not in params:
        return ""
    return "forward" if params["distance"] > 0.1 else "backward" if params["distance"] < -0.1 else "up"


PROBES = (
    Probe(
        "punch",
        "hand",
        {
            "hand.pushes": above(1),
            "hand.thrust": above(1.2),
            "other_hand.front": below(0.78),
            "gap_mid": below(0.97),
            "turn_range": above(12),
        },
        count="hand.pushes",
    ),
    Probe(
        "alternate",
        "hands",
        {"hand.thrust": above(0.8), "hand.pushes": above(1), "turn_range": above(12)},
        count="punches",
    ),
    Probe(
        "throw",
        "hand",
        {"hand.speed": above(4.0), "hand.back": below(-0.05), "twist_range": above(35), "hand.top": above(0.1)},
    ),
    Probe(
        "kick",
        "foot",
        {"foot.toe": above(0.2), "pelvis_mid": above(0.9), "foot.speed": above(2.4), "foot.straightest": below(116)},
        {
            "forward": {"foot.front": above(0.42)},
            "side": {"foot.aside_at_top": above(0.28), "foot.front": below(0.42)},
        },
        wanted=_direction,
        count="foot.reaches",
    ),
    Probe(
        "knee_lift",
        "foot",
        {"foot.knee_high": above(1.02), "foot.knee_at_top": above(70), "foot.front": below(0.62)},
        count="foot.kicks",
    ),
    Probe(
        "stomp",
        "foot",
        {
            "foot.drop": above(1.6),
            "other_foot.knee_high": below(0.64),
            "foot.heel": within(0.2, 0.43),
            "foot.longest_up": below(1.2),
        },
        count="foot.kicks",
    ),
    Probe(
        "jump",
        "",
        {"flights": above(1), "pelvis_low": below(0.8), "jump": above(0.07), "pelvis_high": above(1.06)},
        {
            "up": {"ahead": within(-0.25, 0.25), "aside": within(-0.2, 0.2)},
            "left": {"aside": above(0.15)},
            "right": {"aside": below(-0.15)},
            "turning left": {"turned": above(50)},
            "turning right": {"turned": below(-50)},
            "forward": {"ahead": above(0.25)},
            "backward": {"ahead": below(-0.2)},
        },
        wanted=_jumped,
        count="flights",
    ),
    Probe(
        "hop",
        "foot",
        {"other_foot.longest_up": above(1.2), "flights": above(1), "foot.longest_up": below(0.9)},
        count="flights",
    ),
    Probe(
        "jumping_jacks",
        "hands",
        {"hand.speed": above(5), "stance_range": above(0.25), "hand.top": above(0.6), "flights": above(1)},
        count="hand.tops",
    ),
    Probe(
        "squat",
        "hands",
        {
            "pelvis_low": below(0.75),
            "hand.hip_mid": above(1.5),
            "airborne": below(0.06),
            "pelvis_start": above(0.85),
            "hand.floor": above(0.55),
            "root_back": below(0.26),
            "gap_mid": below(1.4),
            "pelvis_end": above(0.8),
        },
        count="dips",
    ),
    Probe(
        "crouch",
        "hands",
        {
            "pelvis_mid": below(0.88),
            "pelvis_low": below(0.8),
            "hand.shortest": within(0.65, 0.88),
            "hand.hip_mid": within(1.0, 1.5),
            "root_back": below(0.29),
        },
    ),
    Probe("kneel", "foot", {"pelvis_low": below(0.55), "foot.knee_low": below(0.3), "foot.behind": below(-0.4)}),
    Probe(
        "sit_down",
        "",
        {"pelvis_start": above(0.75), "pelvis_end": below(0.82), "pitch_high": above(15), "travel": below(0.95)},
    ),
    Probe("stand_up", "", {"pelvis_start": below(0.82), "pelvis_end": above(0.85), "travel": above(0.15)}),
    Probe(
        "sit_and_stand",
        "",
        {
            "pelvis_low": below(0.7),
            "pelvis_start": above(0.8),
            "pelvis_end": above(0.8),
            "root_back": above(0.25),
            "knee_low": above(0.4),
            "hand_low": above(0.6),
            "airborne": below(0.08),
        },
    ),
    Probe("pick_up", "hand", {"hand.floor": below(0.48), "pelvis_low": below(0.65)}),
    Probe("stretch", "hands", {"hand.away": above(1.8), "gap_low": below(1.2), "roll_range": above(20)}),
    Probe(
        "balance", "foot", {"other_foot.longest_up": above(1.2), "airborne": below(0.08), "foot.longest_up": below(0.6)}
    ),
    Probe(
        "lunge",
        "foot",
        {
            "travel": below(0.3),
            "other_foot.knee_low": below(0.4),
            "foot.front": above(0.35),
            "pelvis_low": within(0.35, 0.86),
            "root_back": below(0.2),
            "foot.toe": below(0.22),
            "lifts": below(8),
        },
        count="foot.lunges",
    ),
    Probe("tiptoes", "", {"tiptoe": above(0.5)}, count="heels"),
    Probe(
        "swing_leg",
        "foot",
        {
            "foot.behind": below(-0.2),
            "foot.front": above(0.22),
            "foot.toe": within(0.15, 0.4),
            "other_foot.longest_up": below(0.3),
            "foot.longest_up": above(0.5),
            "travel": below(0.4),
        },
        count="foot.swings",
    ),
    Probe(
        "bounce",
        "",
        {
            "turn_range": below(8),
            "tiptoe": below(0.2),
            "bounces": above(1),
            "pelvis_range": within(0.03, 0.16),
            "lifts": below(0),
            "pitch_high": below(20),
            "path": below(0.3),
        },
        count="bounces",
    ),
)
