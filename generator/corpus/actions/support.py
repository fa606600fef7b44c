"""Shifts of the weight that several actions share."""

from typing import Final

from generator.corpus.body import SIGN, Side
from generator.corpus.scene import Scene

ZERO: Final = (0.0, 0.0, 0.0)


def share(side: Side) -> float:
    """Value of the weight track when `side` carries everything."""
    return 0.5 + 0.5 * SIGN[side]


def on_one_leg(scene: Scene, t: float, side: Side, span: float = 0.4) -> float:
    """Shift the weight onto one leg; the time from which the other foot is free."""
    weight = scene.tracks["weight"]
    weight.hold(t)
    weight.key(t + span, share(side))
    return t + span + 0.12


def stand_evenly(scene: Scene, t: float, span: float = 0.45) -> float:
    """Share the weight between both feet from `t` on; the time at which it is done."""
    weight = scene.tracks["weight"]
    weight.hold(t - 0.05)
    weight.key(t + span, 0.5)
    return t + span


def some_side(scene: Scene) -> Side:
    """Either side, drawn by lot."""
    return "left" if scene.rng.random() < 0.5 else "right"


def lower(scene: Scene, t: float, depth: float, lean: float, span: float) -> None:
    """Bring the pelvis to `depth` metres below standing, the trunk leaning forward by degrees."""
    scene.move("crouch", t, (t + span, depth))
    scene.move("pelvis", t, (t + 0.9 * span, [0, 0.6 * lean, 0]))
    scene.move("spine", t, (t + span, [0, 0.4 * lean, 0]))
