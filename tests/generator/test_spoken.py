"""What is said to the listener, slips of the tongue, what is left out, and where words stand in the prompt."""

import pytest

from generator.text.ellipsis import completed, described, sides_of_the_person
from generator.text.spans import located
from generator.text.spoken import motion_words


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("hey robot, could you wave with your left hand for me, please?", "wave with your left hand"),
        ("i'd appreciate it if you could step back", "step back"),
        ("do me a favor and clap your hands", "clap your hands"),
        ("would it be possible for you to bow", "bow"),
        ("are you able to stand on one foot?", "stand on one foot"),
        ("ok so like wave or something", "wave"),
        ("test prompt: robot bows", "robot bows"),
        ("make the bot wave pls", "wave"),
        ("shake your head no", "shake your head no"),
        ("pick up something", "pick up something"),
    ],
)
def test_motion_words_without_address_and_fillers(said: str, meant: str) -> None:
    assert motion_words(said) == meant


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("raise your right hand, no, your left hand", "raise your left hand"),
        ("sit down, no, wait, stand up", "stand up"),
        ("wave, then sit down, i mean stand up", "wave, then stand up"),
        ("wave three times, i mean four times", "wave four times"),
        ("walk back... er, forward", "walk forward"),
    ],
)
def test_motion_words_slips_of_the_tongue(said: str, meant: str) -> None:
    assert motion_words(said) == meant


@pytest.mark.parametrize(
    ("text", "whole"),
    [
        ("steps to the left, then to the right", "steps to the left, then steps to the right"),
        ("takes a step to the left and a step back", "takes a step to the left, then takes a step back"),
        ("walks forward and to the left", "walks forward and to the left"),
        ("turns the head left and right", "turns the head left and right"),
        ("walks back and forth", "walks forward, then turns around, then walks forward"),
    ],
)
def test_completed_directions_have_their_verb(text: str, whole: str) -> None:
    assert completed(text) == whole


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("someone who is kneeling gets up", "someone gets up"),
        ("a person with hands dangling walks slowly", "a person walks slowly with hands dangling"),
        ("a person starts clapping", "a person claps"),
        ("walks counter clockwise", "walks counterclockwise"),
        ("left hand wave", "wave with the left hand"),
    ],
)
def test_described(text: str, plain: str) -> None:
    assert described(text) == plain


def test_sides_of_the_person_not_of_the_viewer() -> None:
    assert sides_of_the_person("raises the right hand (our left hand)") == "raises the right hand"


def test_located_words_in_another_form() -> None:
    prompt = "Please walk Sneakily, with a limp"
    assert located("walks sneakily", prompt) == ("walk Sneakily", (7, 20))
    assert located("with a limp", prompt) == ("limp", (29, 33))
    assert located("juggles", prompt) == ("juggles", None)
