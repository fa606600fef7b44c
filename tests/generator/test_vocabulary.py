"""Every action is spoken of truthfully, in many ways, in correct English."""

import re

import numpy as np
import pytest

from generator.corpus.actions import ACTIONS
from generator.corpus.vocabulary.english import Phrase, gerund, third_person
from generator.corpus.vocabulary.entry import Draw, Voice
from generator.corpus.words import VOCABULARY, entry, parts, phrase
from ros_free_stack.errors import UnknownName


@pytest.mark.parametrize(
    ("verb", "third", "continuous"),
    [
        ("wave", "waves", "waving"),
        ("clap", "claps", "clapping"),
        ("stretch", "stretches", "stretching"),
        ("do", "does", "doing"),
        ("have", "has", "having"),
        ("carry", "carries", "carrying"),
        ("sway", "sways", "swaying"),
        ("bow", "bows", "bowing"),
    ],
)
def test_verbs_are_inflected(verb: str, third: str, continuous: str) -> None:
    assert third_person(verb) == third
    assert gerund(verb) == continuous


def test_a_phrase_inflects_each_of_its_verbs_and_tidies_spaces() -> None:
    said = Phrase("<squat>  down and <stand> up ")
    assert said.third == "squats down and stands up"
    assert said.gerund == "squatting down and standing up"
    assert said.plain == "squat down and stand up"


def test_vocabulary_and_catalogue_name_the_same_actions() -> None:
    assert set(VOCABULARY) == set(ACTIONS)


def test_an_unknown_action_is_named_with_the_valid_ones() -> None:
    with pytest.raises(UnknownName, match=r"'fly'.*wave"):
        entry("fly")


@pytest.mark.parametrize("name", sorted(VOCABULARY))
def test_each_action_has_six_phrasings_and_no_unfilled_slot(name: str) -> None:
    rng = np.random.default_rng(0)
    item = entry(name)
    params = item.sample(Draw(rng))
    said = {item.phrase(params, Voice(), rng).third for _ in range(300)}
    assert len(said) >= 6
    for text in said:
        assert re.fullmatch(r"[a-z0-9' ,]+", text), text
        assert "  " not in text
    for text in parts(name, params):
        assert re.fullmatch(r"[a-z0-9' ,]*", text), text


@pytest.mark.parametrize("name", sorted(VOCABULARY))
def test_a_named_side_is_the_side_performed(name: str) -> None:
    rng = np.random.default_rng(1)
    item = entry(name)
    for _ in range(80):
        params = item.sample(Draw(rng))
        side = params.get("side")
        text = item.phrase(params, Voice(), rng).third
        if side in ("left", "right") and "direction" not in params and "azimuth" not in params:
            other = {"left": "right", "right": "left"}[side]
            named = re.findall(rf"\b({side}|{other}) (?:hand|arm|leg|foot|knee|fist)", text)
            lifted = [word for word in named if word == other]
            assert len(lifted) == ("lift" in text and name == "balance" and bool(named)), text


def test_sides_are_left_out_in_about_a_third_and_then_mostly_right() -> None:
    rng = np.random.default_rng(2)
    item = entry("wave")
    unnamed = []
    for _ in range(3000):
        side = ("left", "right")[int(rng.integers(2))]
        text = item.phrase({"side": side, "count": 3, "size": 1.0, "speed": 1.0}, Voice(), rng).third
        if side not in text:
            unnamed.append(side)
    assert 0.25 < len(unnamed) / 3000 < 0.42
    assert 0.62 < unnamed.count("right") / len(unnamed) < 0.78


def test_counts_are_said_as_they_are_or_left_vague() -> None:
    rng = np.random.default_rng(3)
    said = {phrase("squat", {"count": 2, "depth": 1.0, "speed": 1.0}, Voice(), rng).third for _ in range(300)}
    assert "squats twice" in said
    assert "does two squats" in said
    assert not any("three" in text or "once" in text for text in said)


@pytest.mark.parametrize(
    ("name", "params", "prompt"),
    [
        ("wave", {"side": "right", "count": 3}, "waves with the right hand"),
        ("wave", {"side": "both", "count": 3}, "waves with both hands"),
        ("bow", {"depth": 1.0}, "bows"),
        ("squat", {"count": 1}, "squats down and stands up"),
        ("raise_arm", {"side": "both", "to": "up", "lower": False}, "raises both arms above the head"),
        ("point", {"side": "left", "azimuth": 0.0, "elevation": 5.0}, "points forward with the left hand"),
        ("turn", {"angle": 90.0}, "turns to the left"),
        ("step", {"direction": "right", "count": 1}, "steps to the right"),
        ("march", {"count": 6}, "marches in place"),
        ("kick", {"side": "left", "height": "low", "direction": "forward", "count": 1}, "kicks with the left leg"),
        ("balance", {"side": "right"}, "balances on the right leg"),
        ("look_around", {"count": 2}, "looks around"),
    ],
)
def test_what_people_type_is_among_the_phrasings(name: str, params: dict, prompt: str) -> None:
    rng = np.random.default_rng(4)
    assert prompt in {phrase(name, params, Voice(), rng).third for _ in range(1500)}


def test_the_catalogue_accepts_every_sampled_parameter() -> None:
    from generator.corpus.actions import perform
    from generator.corpus.scene import Scene

    rng = np.random.default_rng(5)
    for name, item in VOCABULARY.items():
        for brief in (False, True):
            scene = Scene(seed=0)
            if name == "stand_up":
                perform(scene, "sit_down")
            assert perform(scene, name, **item.sample(Draw(rng, brief))) > 0


@pytest.mark.parametrize("brief", [False, True])
@pytest.mark.parametrize("name", ["wave", "squat", "clap", "nod", "kick", "punch", "knock", "lift_arms"])
def test_counts_from_one_to_four_all_occur(name: str, brief: bool) -> None:
    rng = np.random.default_rng(6)
    counts = [entry(name).sample(Draw(rng, brief))["count"] for _ in range(600)]
    assert all(counts.count(n) > 24 for n in (1, 2, 3, 4))
    assert not brief or np.mean(counts) < 2.5
