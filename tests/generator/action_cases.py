"""Authored actions performed on the spot, and what is read from their joints."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from ros_free_stack.skeleton import INDEX

Floats = NDArray[np.float64]

LEAD_S = 0.5
OTHER = {"left": "right", "right": "left"}
SIGN = {"left": 1, "right": -1}
CATALOGUE = [
    "wave",
    "raise_arm",
    "clap",
    "point",
    "salute",
    "scratch_head",
    "cross_arms",
    "hands_on_hips",
    "reach",
    "push",
    "swing_arms",
    "circle_arms",
    "flap_arms",
    "drink",
    "wipe",
    "shrug",
    "touch",
    "beckon",
    "shake_hand",
    "bow",
    "bend_forward",
    "lean",
    "twist",
    "sway",
    "look_around",
    "look",
    "nod",
    "shake_head",
    "punch",
    "alternate",
    "throw",
    "stretch",
    "pick_up",
    "sit_down",
    "stand_up",
    "sit_and_stand",
    "squat",
    "crouch",
    "kneel",
    "jump",
    "hop",
    "jumping_jacks",
    "kick",
    "knee_lift",
    "balance",
    "lunge",
    "tiptoes",
    "stand",
    "step",
    "walk",
    "walk_circle",
    "turn",
    "march",
    "jog_in_place",
    "jog",
    "sneak",
    "stomp",
    "dance",
    "lift_arms",
    "eat",
    "brush_teeth",
    "comb_hair",
    "rub_hands",
    "check_watch",
    "phone",
    "pray",
    "cover",
    "hug",
    "flex",
    "wipe_table",
    "stir",
    "chop",
    "hammer",
    "knock",
    "open_door",
    "pour",
    "pull",
    "carry",
    "lift_weights",
    "play_guitar",
    "play_violin",
    "play_drums",
    "play_piano",
    "conduct",
    "bounce_ball",
    "catch",
    "swim",
    "guard",
    "swing_club",
    "swing_racket",
    "circle_hips",
    "bounce",
    "swing_leg",
]


def act(name: str, *, seed: int = 1, tail: float = 0.6, **params: Any) -> Floats:
    """Joints (T, 22, 3) of half a second of standing, the action, and a short rest."""
    scene = Scene(seed)
    scene.time = LEAD_S
    if name == "stand_up":
        perform(scene, "sit_down")
    perform(scene, name, **params)
    return joints(scene.solve(tail))


def at(places: Floats, name: str, axis: int | slice = slice(None)) -> Floats:
    return places[:, INDEX[name]][:, axis]


def facing(places: Floats) -> Floats:
    """(T,) unwrapped heading of the hips."""
    across = at(places, "left_hip") - at(places, "right_hip")
    return np.unwrap(np.arctan2(-across[:, 0], across[:, 1]))


def rise(places: Floats, side: str) -> float:
    """How far a foot gets off the floor, in m."""
    ball = at(places, f"{side}_foot", 2)
    return float(ball.max() - ball[0])


def peaks(signal: Floats, prominence: float) -> int:
    return len(find_peaks(np.round(signal, 3), prominence=prominence, distance=4)[0])
