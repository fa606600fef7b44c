import pytest

from generator.text.prompt import MAX_CHARACTERS, check_prompt
from ros_free_stack.errors import InvalidPrompt

ENGLISH = (
    "wave", "squats twice", "Wave!", "bow", "moonwalk", "a person waves with the right hand", "robot, wave",
    "two squats", "jumping jacks", "punch, punch, kick", "hand wave", "do a t-pose", "die like a hero", "lie down",
    "karate chop", "raise arm", "arm up", "somersault", "point to the sun", "left leg", "he is angry",
    "walk 3 steps", "salute", "a person plays the piano", "she does three squats", "someone greets with the left hand",
)  # fmt: skip
FOREIGN = (
    "eine Person winkt mit der rechten Hand", "una persona saluda", "une personne marche", "人が手を振る",
    "человек машет рукой", "il salue de la main", "een persoon zwaait met de hand", "hombre camina hacia adelante",
    "un homme saute", "wink mit der Hand", "geh vorwärts", "ein Mann geht vorwärts und winkt",
    "l'homme lève le bras droit", "uma pessoa acena", "osoba macha ręką", "en person vinkar", "손을 흔든다",
    "ένας άνθρωπος", "bir kişi el sallıyor", "la persona cammina in avanti", "er springt", "sie tanzt und lacht",
    "levanta o braço", "lever le bras droit", "alza la mano", "hebe den rechten Arm", "un uomo salta due volte",
)  # fmt: skip


@pytest.mark.parametrize("prompt", ENGLISH)
def test_english_passes(prompt: str) -> None:
    assert check_prompt(prompt) == prompt


@pytest.mark.parametrize("prompt", FOREIGN)
def test_other_languages_are_refused(prompt: str) -> None:
    with pytest.raises(InvalidPrompt, match="is not English"):
        check_prompt(prompt)


@pytest.mark.parametrize("prompt", ["", "   ", "\n\t"])
def test_empty(prompt: str) -> None:
    with pytest.raises(InvalidPrompt, match="empty"):
        check_prompt(prompt)


@pytest.mark.parametrize("prompt", ["...", "123", "!?", "👋"])
def test_no_words(prompt: str) -> None:
    with pytest.raises(InvalidPrompt, match="no words"):
        check_prompt(prompt)


def test_length() -> None:
    longest = ("wave " * MAX_CHARACTERS)[: MAX_CHARACTERS - 1] + "e"
    assert check_prompt(longest) == longest
    with pytest.raises(InvalidPrompt, match="10000 characters, at most 500"):
        check_prompt("wave with " * 999 + "wave hands")


def test_white_space_is_put_in_order() -> None:
    assert check_prompt("  wave\n with  the\tright hand ") == "wave with the right hand"
