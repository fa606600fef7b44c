"""Paths of the hands that several actions share: there and back, and round and round."""

from collections.abc import Sequence

import numpy as np

from generator.corpus.actions.record import AnySide, sides
from generator.corpus.body import Floats
from generator.corpus.scene import Scene


def there_and_back(
    scene: Scene, t: float, side: AnySide, place: Floats, *, up: float, hold: float, via: Floats | None = None
) -> float:
    """Bring the wrist to a place, stay there and let the arm hang again; the end time."""
    for s in sides(side):
        start = [] if via is None else [(t + 0.5 * up, via)]
        back = [] if via is None else [(t + 1.45 * up + hold, via)]
        scene.move(f"arm_{s}", t, *start, (t + up, place), (t + up + hold, place), *back)
        scene.relax(s, t + 2 * up + hold)
    return t + 2 * up + hold


def around(
    scene: Scene, t: float, side: AnySide, places: Sequence[Floats], *, count: int, up: float, beat: float
) -> float:
    """Raise the wrist to the first place, pass the others and return to it `count` times, and relax; the end time.

    One round takes `beat` seconds; with two places it is to and fro.
    """
    end = t + up + count * beat
    for s in sides(side):
        keys = [(t + up, places[0])]
        for i in range(1, count * len(places) + 1):
            scatter = np.array([0.02, 0.02, 0.0, 0.0]) * [scene.normal(), scene.normal(), 0, 0]
            keys.append((t + up + i / len(places) * beat, places[i % len(places)] + scatter))
        scene.move(f"arm_{s}", t, *keys)
        scene.relax(s, end + 0.75)
    return end + 0.75


def look_at_hands(scene: Scene, t: float, end: float, *, left: float = 0.0, down: float = 28.0) -> None:
    """Look down at what the hands do, from `t` on, and up again at `end`; degrees."""
    scene.move("gaze", t, (t + 0.6, [left, down]), (end - 0.7, [left, down]), (end, [0, 0]))
