"""Actions of the hands do what they say: the named hand, the place it goes to, and how often."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import find_peaks

from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from ros_free_stack.skeleton import INDEX

Floats = NDArray[np.float64]
OTHER = {"left": "right", "right": "left"}


def act(name: str, **params: Any) -> Floats:
    scene = Scene(2)
    scene.time = 0.3
    perform(scene, name, **params)
    return joints(scene.solve(0.4))


def at(places: Floats, name: str) -> Floats:
    return places[:, INDEX[name]]


def peaks(signal: Floats, prominence: float) -> int:
    return len(find_peaks(signal, prominence=prominence, distance=3)[0])


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("name", ["eat", "brush_teeth", "comb_hair", "phone"])
def test_the_named_hand_goes_to_the_head(name: str, side: str) -> None:
    places = act(name, side=side)
    far = {s: np.linalg.norm(at(places, f"{s}_wrist") - at(places, "head"), axis=-1).min() for s in OTHER}
    assert far[side] < 0.30
    assert far[OTHER[side]] > 0.38


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize(
    ("name", "axis", "sign", "prominence"),
    [("knock", 0, 1, 0.05), ("hammer", 2, -1, 0.15), ("bounce_ball", 2, -1, 0.08), ("lift_arms", 2, 1, 0.2)],
)
def test_counted_strokes_of_the_named_hand(
    name: str, axis: int, sign: int, prominence: float, side: str, count: int
) -> None:
    places = act(name, side=side, count=count)
    height = (at(places, f"{side}_wrist") - at(places, f"{side}_shoulder"))[:, axis]
    busy = sign * height
    found = peaks(busy, prominence)
    # a stroke that starts from a raised hand may show the way up or down as one more
    assert count <= found <= count + (name in ("knock", "hammer", "bounce_ball"))
    still = at(places, f"{OTHER[side]}_wrist") - at(places, f"{OTHER[side]}_shoulder")
    assert np.ptp(still, axis=0).max() < 0.12


def test_hands_meet_where_they_should() -> None:
    for name in ("rub_hands", "pray", "swing_club"):
        places = act(name)
        assert np.linalg.norm(at(places, "left_wrist") - at(places, "right_wrist"), axis=-1).min() < 0.17, name


@pytest.mark.parametrize("sport", ["golf", "baseball"])
def test_a_club_is_swung_from_its_side_to_the_other(sport: str) -> None:
    for side, sign in (("left", 1), ("right", -1)):
        places = act("swing_club", sport=sport, side=side)
        grip = 0.5 * (at(places, "left_wrist") + at(places, "right_wrist")) - at(places, "pelvis")
        aside = sign * grip[:, 1]
        assert aside.max() > 0.15
        assert aside.min() < -0.15
        assert aside.argmax() < aside.argmin()


def test_a_serve_and_a_forehand_differ_in_height() -> None:
    tops = {s: act("swing_racket", stroke=s)[:, INDEX["right_wrist"], 2].max() for s in ("serve", "forehand")}
    assert tops["serve"] > 1.7 > tops["forehand"]


@pytest.mark.parametrize("count", [1, 3])
def test_bounces_and_leg_swings_are_counted(count: int) -> None:
    assert peaks(-at(act("bounce", count=count), "pelvis")[:, 2], 0.03) == count
    places = act("swing_leg", side="left", count=count)
    assert peaks(at(places, "left_foot")[:, 0] - at(places, "pelvis")[:, 0], 0.3) == count
    assert np.ptp(at(places, "right_foot")[:, 2]) < 0.02
