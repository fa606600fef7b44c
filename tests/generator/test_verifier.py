"""What can be read from the text alone, and whether authored motion is found to show it."""

from typing import Any

import numpy as np
import pytest

from generator.corpus import pose as poses
from generator.corpus.actions import perform
from generator.corpus.scene import Scene
from generator.probes.catalogue import PROBES
from generator.probes.checks import Details
from generator.probes.measures import Measures
from generator.probes.named import told
from generator.probes.signals import Signals
from generator.registry import SHARED_WEIGHTS
from generator.text.encoder import TextEncoder
from generator.verifier import ABSENT, FLIGHT, Mismatch, Verifier
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS

WAVE_LEFT: tuple[str, dict[str, Any]] = ("wave", {"side": "left", "count": 3})
TURN: tuple[str, dict[str, Any]] = ("turn", {"angle": 90.0})


@pytest.fixture(scope="module")
def check() -> Verifier:
    return Verifier.load(SHARED_WEIGHTS, TextEncoder())


def motion(*told_of: tuple[str, tuple[str, dict[str, Any]]]) -> HumanMotion:
    """Authored deeds one after the other, each told of in its text."""
    scene, segments = Scene(seed=3), list[Segment]()
    scene.time = 0.2
    for text, (name, params) in told_of:
        start = scene.time
        segments.append(Segment(text, start, perform(scene, name, **params)))
        scene.time += 0.1
    joints = poses.joints(scene.solve(tail=0.3))
    return HumanMotion(joints=joints, fps=FPS, prompt="", segments=tuple(segments), source="test")


@pytest.mark.parametrize(
    ("action", "clause", "details"),
    [
        ("wave", "a person waves three times with the left hand", Details(side="left", count=3)),
        ("wave", "a person waves", Details()),
        ("wave", "a person waves both arms twice", Details(side="both", count=2)),
        ("raise_arm", "a person lifts the left arm out to the side", Details(side="left", direction="side")),
        ("point", "a person points to the right with the left hand", Details(side="left", direction="right")),
        ("touch", "a person touches the left shoulder with the right hand", Details()),
        ("kick", "a person kicks forward with one leg", Details(direction="forward")),
        ("turn", "a person turns 90 degrees to the left", Details(direction="left", extent=90.0)),
        ("turn", "a person turns all the way around to the right", Details(direction="right", extent=360.0)),
        ("turn", "a person turns around", Details(extent=180.0)),
    ],
)
def test_details_are_read_from_the_text(action: str, clause: str, details: Details) -> None:
    found = told(PROBES[action], clause)
    for name in ("side", "count", "extent"):
        assert getattr(found, name) == getattr(details, name), name
    if details.direction:
        assert found.direction == details.direction


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("a person waves with the left hand", [["wave"]]),
        ("a person walks forward while clapping", [["walk", "step"], ["clap"]]),
        ("a person does a squat", [["squat", "crouch"]]),
        ("a person photosynthesises", [[]]),
    ],
)
def test_texts_mean_actions(check: Verifier, text: str, names: list[list[str]]) -> None:
    (parts,) = check.requirements([text])
    assert [list(part.actions) for part in parts] == names


def test_motion_that_shows_its_texts(check: Verifier) -> None:
    shown = motion(
        ("a person waves three times with the left hand", WAVE_LEFT),
        ("a person turns 90 degrees to the left", TURN),
    )
    assert check.mismatches(shown) == ()


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("a person waves three times with the right hand", "side"),
        ("a person waves once with the left hand", "number"),
        ("a person squats", "action"),
    ],
)
def test_what_is_missing_is_said(check: Verifier, text: str, wrong: str) -> None:
    shown = motion(("a person turns 90 degrees to the left", TURN), (text, WAVE_LEFT))
    (found,) = check.mismatches(shown)
    start, end = shown.segments[1].start_s, shown.segments[1].end_s
    assert found.words == f"{start:.1f} to {end:.1f} s: does not show the {wrong} of `{text}`"
    assert found.violations == (ABSENT if wrong == "action" else 1)


def test_feet_that_leave_the_floor_unasked_are_said(check: Verifier) -> None:
    hop: tuple[str, dict[str, Any]] = ("jump", {"height": 0.2})
    assert check.mismatches(motion(("a person jumps", hop))) == ()
    shown = motion(("a person waves", WAVE_LEFT), ("a person bows", hop))
    start, end = shown.segments[1].start_s, shown.segments[1].end_s
    words = f"{start:.1f} to {end:.1f} s: leaves the floor in `a person bows`"
    assert Mismatch(FLIGHT, words) in check.mismatches(shown)
    windows = [(round(s.start_s * FPS), round(s.end_s * FPS)) for s in shown.segments]
    required = check.requirements(["a person waves", "a person photosynthesises"])
    assert check.violations(Signals.of(shown.joints), windows, required).tolist() == [0, 0], (
        "of the unknown nothing is asked"
    )
    required = check.requirements(["a person waves", "a person bows"])
    assert check.violations(Signals.of(shown.joints), windows, required).tolist() == [0, ABSENT + FLIGHT]


@pytest.mark.parametrize("name", sorted(PROBES.keys() - {"stand_up"}))
def test_actions_that_fly_do_and_others_do_not(name: str) -> None:
    scene = Scene(seed=4)
    end = perform(scene, name)
    signals = Signals.of(poses.joints(scene.solve(tail=0.3)))
    flights = Measures(signals, 0, min(len(signals), round(end * FPS))).body.flights
    assert (flights > 0) == PROBES[name].flies


def test_violations_of_each_segment(check: Verifier) -> None:
    shown = motion(("", WAVE_LEFT), ("", TURN))
    windows = [(round(s.start_s * FPS), round(s.end_s * FPS)) for s in shown.segments]
    required = check.requirements(["a person squats", "a person turns 90 degrees to the right"])
    found = check.violations(Signals.of(shown.joints), windows, required)
    np.testing.assert_array_equal(found, [ABSENT, 1])


def test_nothing_is_asked_of_an_unknown_text_or_too_short_a_time(check: Verifier) -> None:
    shown = motion(("a person photosynthesises", WAVE_LEFT))
    assert check.mismatches(shown) == ()
    signals = Signals.of(shown.joints)
    assert check.violations(signals, [(0, 4)], check.requirements(["a person squats"])).tolist() == [0]
