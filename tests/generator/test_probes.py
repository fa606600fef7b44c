"""Probes: present where the action is, absent elsewhere, with side, count and direction."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from generator.corpus import pose as poses
from generator.corpus.actions import perform
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Draw
from generator.corpus.words import VOCABULARY, entry
from generator.probes import measures
from generator.probes.catalogue import PROBES
from generator.probes.checks import Wanted, check_motion, check_segment
from generator.probes.named import named
from generator.probes.signals import Signals
from generator.probes.spec import lookup
from ros_free_stack.errors import InvalidOption, UnknownName
from ros_free_stack.skeleton import FPS, MIRRORED

SIDED = ("wave", "kick", "punch", "knee_lift", "balance", "salute", "touch")


@cache
def performed(*actions: tuple[str, tuple[tuple[str, Any], ...]]) -> tuple[np.ndarray, tuple[tuple[int, int], ...]]:
    """Joints of actions that follow each other, and their frames."""
    scene, windows = Scene(seed=3), []
    scene.time = 0.2
    for name, params in actions:
        start = scene.time
        scene.time = perform(scene, name, **dict(params))
        windows.append((round(start * FPS), round(scene.time * FPS)))
        scene.time += 0.1
    return poses.joints(scene.solve(tail=0.3)), tuple(windows)


def action(name: str, **params: Any) -> tuple[str, tuple[tuple[str, Any], ...]]:
    return name, tuple(params.items())


def test_every_action_of_the_vocabulary_has_a_probe():
    assert set(VOCABULARY) <= set(PROBES)


def test_every_bound_names_a_measure():
    """A misspelt measure must not wait for the motion that asks for it."""
    joints, ((start, stop),) = performed(action("stand", hold=1.0))
    measured = measures.Measures(Signals.of(joints), start, stop)
    for probe in PROBES.values():
        keys = {*probe.bounds, *(key for bounds in probe.variants.values() for key in bounds)}
        keys |= {probe.count} - {""} | ({probe.extent.measure} if probe.extent else set())
        for key in keys:
            assert np.isfinite(lookup(measured, key, "left")), (probe.action, key)


@pytest.mark.parametrize("name", sorted(set(VOCABULARY) - {"stand_up"}))
def test_probe_finds_its_action(name: str):
    params = entry(name).sample(Draw(np.random.default_rng(5), brief=True))
    joints, (window,) = performed(action(name, **params))
    checks = check_segment(Signals.of(joints), window, name, {})
    assert checks.action, params


def test_standing_up_is_found_after_sitting():
    joints, windows = performed(action("sit_down"), action("stand_up"))
    signals = Signals.of(joints)
    assert check_segment(signals, windows[0], "sit_down", {}).action
    assert check_segment(signals, windows[1], "stand_up", {}).action
    assert not check_segment(signals, windows[0], "stand_up", {}, exact=True).action


@pytest.mark.parametrize("name", sorted(set(VOCABULARY) - {"stand"}))
def test_no_probe_fires_on_standing(name: str):
    joints, (window,) = performed(action("stand", hold=2.0))
    assert not check_segment(Signals.of(joints), window, name, {}, exact=True).action


@pytest.mark.parametrize("name", SIDED)
@pytest.mark.parametrize("side", ["left", "right"])
def test_side_is_told_and_reflected(name: str, side: str):
    other = {"left": "right", "right": "left"}[side]
    joints, (window,) = performed(action(name, side=side))
    signals = Signals.of(joints)
    assert check_segment(signals, window, name, {"side": side}).passed
    wrong = check_segment(signals, window, name, {"side": other})
    assert wrong.action and wrong.side is False and not wrong.passed
    mirrored = Signals.of(joints[:, MIRRORED] * (1, -1, 1))
    assert check_segment(mirrored, window, name, {"side": other}).passed


@pytest.mark.parametrize("name", ["wave", "clap", "squat", "jump", "kick", "punch", "nod", "knock"])
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_count_is_told(name: str, count: int):
    joints, (window,) = performed(action(name, count=count))
    signals = Signals.of(joints)
    assert check_segment(signals, window, name, {"count": count}).count is True
    assert check_segment(signals, window, name, {"count": count + 1}, exact=True).count is False


@pytest.mark.parametrize(
    ("name", "params", "wrong"),
    [
        ("turn", {"angle": 90.0}, {"angle": -90.0}),
        ("walk", {"direction": "backward"}, {"direction": "forward"}),
        ("step", {"direction": "left"}, {"direction": "right"}),
        ("raise_arm", {"side": "both", "to": "up"}, {"to": "forward"}),
        ("lean", {"direction": "left"}, {"direction": "right"}),
        ("look", {"direction": "up"}, {"direction": "down"}),
        ("jump", {"distance": 0.5}, {"distance": -0.5}),
    ],
)
def test_direction_is_told(name: str, params: dict[str, Any], wrong: dict[str, Any]):
    joints, (window,) = performed(action(name, **params))
    signals = Signals.of(joints)
    assert check_segment(signals, window, name, params).direction is True
    assert check_segment(signals, window, name, wrong).direction is False


def test_how_far_is_told():
    joints, (window,) = performed(action("turn", angle=90.0))
    signals = Signals.of(joints)
    assert check_segment(signals, window, "turn", {"extent": 90.0}).extent is True
    assert check_segment(signals, window, "turn", {"extent": 180.0}).extent is False


def test_order_and_presence_of_a_whole_motion():
    joints, (first, second) = performed(action("wave", side="right"), action("squat"))
    signals = Signals.of(joints)
    wave, squat = ("wave", {"side": "right"}), ("squat", {})
    assert check_motion(signals, (Wanted(first, (wave,)), Wanted(second, (squat,)))).passed
    assert not check_motion(signals, (Wanted(first, (squat,)), Wanted(second, (wave,)))).present
    swapped = check_motion(signals, (Wanted(second, (squat,)), Wanted(first, (wave,))))
    assert not swapped.ordered and not swapped.passed


def test_two_actions_at_the_same_time():
    scene = Scene(seed=1)
    scene.time = 0.2
    end = perform(scene, "walk", steps=6)
    perform(scene, "wave", start=0.4, advance=False, side="left")
    scene.time = end
    signals = Signals.of(poses.joints(scene.solve(tail=0.2)))
    window = (4, round(end * FPS))
    both = check_motion(signals, (Wanted(window, (("walk", {}), ("wave", {"side": "left"}))),))
    assert both.passed


def test_a_motion_may_be_a_little_early_or_late():
    joints, ((start, stop),) = performed(action("salute", side="left"))
    signals = Signals.of(joints)
    assert check_segment(signals, (start + 6, min(len(signals), stop + 6)), "salute", {}).action


def test_errors_name_what_is_wrong():
    joints, (window,) = performed(action("stand", hold=1.0))
    signals = Signals.of(joints)
    with pytest.raises(UnknownName, match="moonwalk"):
        check_segment(signals, window, "moonwalk", {})
    for wrong in ((0, 3), (-1, 20), (0, len(signals) + 1)):
        with pytest.raises(InvalidOption, match="window"):
            check_segment(signals, wrong, "wave", {})


@pytest.mark.parametrize(
    ("action", "params", "text", "expected"),
    [
        ("wave", {"side": "left", "count": 2}, "a person waves the left hand twice", {"side": "left", "count": 2}),
        ("wave", {"side": "left", "count": 2}, "a person waves", {}),
        ("raise_arm", {"side": "both", "to": "up"}, "a person raises both arms", {"side": "both"}),
        ("turn", {"angle": 180.0}, "a person turns around", {"extent": 180.0}),
        ("turn", {"angle": -90.0}, "a person turns to the right", {"angle": -90.0}),
        ("squat", {"count": 3}, "a person does three squats", {"count": 3}),
        ("knock", {"count": 1}, "a person knocks at the door with one hand", {}),
    ],
)
def test_only_what_is_named_is_asked(action: str, params: dict[str, Any], text: str, expected: dict[str, Any]):
    assert named(PROBES[action], params, text) == expected
