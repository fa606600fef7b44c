"""The catalogue of authored actions, and how one is put into a scene."""

from typing import Any, Final

from generator.corpus.actions import (
    bending,
    clubs,
    daily,
    gestures,
    handling,
    jumps,
    kicks,
    legs,
    looking,
    music,
    paces,
    pointing,
    poses,
    punches,
    raising,
    reaching,
    seats,
    sport,
    squats,
    stances,
    steps,
    tools,
    touching,
    turns,
)
from generator.corpus.actions.record import Action
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidOption, UnknownName

_FAMILIES = (
    raising,
    pointing,
    gestures,
    reaching,
    touching,
    daily,
    poses,
    tools,
    handling,
    music,
    sport,
    clubs,
    bending,
    looking,
    punches,
    kicks,
    squats,
    seats,
    stances,
    legs,
    jumps,
    steps,
    turns,
    paces,
)
ACTIONS: Final[dict[str, Action]] = {
    item.name: item for family in _FAMILIES for item in vars(family).values() if isinstance(item, Action)
}
"""Every action by name; what is drawn from a seed follows this order."""

_SEATED: Final = ("stand_up", "look", "look_around", "nod", "shake_head")


def perform(scene: Scene, name: str, *, start: float | None = None, advance: bool = True, **params: Any) -> float:
    """Put an action into a scene and return its end time in s.

    Args:
        scene: where to.
        name: a key of `ACTIONS`.
        start: start time in s; by default the scene's cursor.
        advance: move the cursor to the action's end (False for one layered under another).
        **params: the action's parameters; the others keep their defaults.

    Raises:
        UnknownName: no such action, or a word that is not among a parameter's choices.
        InvalidOption: an unknown parameter or unusable value, or an action that cannot follow (walking while seated).
    """
    if name not in ACTIONS:
        raise UnknownName("action", name, ACTIONS)
    action = ACTIONS[name]
    if not scene.standing and action.part != "arms" and name not in _SEATED:
        raise InvalidOption(name, "the person sits; stand_up must come first")
    if scene.standing and name == "stand_up":
        raise InvalidOption(name, "the person stands already; sit_down must come first")
    end = action(scene, scene.time if start is None else start, **params)
    if advance:
        scene.time = max(scene.time, end)
    return end
