from pathlib import Path

import pytest

from generator.text.splitter import PERSON, Splitter
from ros_free_stack.errors import InvalidPrompt

CASES = [
    tuple(line.split("\t"))
    for line in Path(__file__).with_name("splitter_cases.tsv").read_text(encoding="utf-8").splitlines()
    if line and not line.startswith("#")
]


@pytest.fixture(scope="module")
def splitter() -> Splitter:
    return Splitter()


@pytest.mark.parametrize(("prompt", "expected"), CASES)
def test_sentence(splitter: Splitter, prompt: str, expected: str) -> None:
    assert splitter.split(prompt) == tuple(f"{PERSON} {segment.strip()}" for segment in expected.split("|"))


def test_the_table_is_wide() -> None:
    assert len({prompt for prompt, _ in CASES}) >= 120


@pytest.mark.parametrize("expected", sorted({expected for _, expected in CASES}))
def test_segments_are_a_fixed_point(splitter: Splitter, expected: str) -> None:
    """What the splitter writes it reads again as the same single segment."""
    for segment in expected.split("|"):
        text = f"{PERSON} {segment.strip()}"
        assert splitter.split(text) == (text,)


def test_five_actions_pass(splitter: Splitter) -> None:
    assert len(splitter.split("walk, wave, bow, jump, then clap")) == 5


def test_more_than_twenty_actions_are_refused(splitter: Splitter) -> None:
    assert len(splitter.split("walk, wave, bow, jump, clap, squat and kick")) == 7
    with pytest.raises(InvalidPrompt, match="describes 21 actions in order, at most 20"):
        splitter.split(", ".join(["walk", "wave", "bow"] * 7))


@pytest.mark.parametrize("prompt", ["", "eine Person winkt mit der rechten Hand", "wave " * 200])
def test_unusable_prompts_are_refused(splitter: Splitter, prompt: str) -> None:
    with pytest.raises(InvalidPrompt):
        splitter.split(prompt)


def test_other_subjects_are_kept(splitter: Splitter) -> None:
    assert splitter.split("the stock market fell") == ("the stock market falls",)
    assert splitter.split("a dog eats a sandwich") == ("a dog eats a sandwich",)


@pytest.mark.parametrize("prompt", ["do not walk", "forward left, back right"])
def test_no_action_is_refused(splitter: Splitter, prompt: str) -> None:
    with pytest.raises(InvalidPrompt, match=r"only says what not to do|no action was found"):
        splitter.split(prompt)


def test_corrections_and_omissions_are_told(splitter: Splitter) -> None:
    reading = splitter.read("jmups twice without moving the arms")
    assert reading.segments == ("a person jumps twice",)
    assert reading.notes == ("read 'jmups' as 'jumps'",)
    assert reading.left_out == ("without moving the arms",)


def test_attributes_of_the_subject_are_kept(splitter: Splitter) -> None:
    assert splitter.split("a person with legs bent raises the arms") == ("a person raises the arms with legs bent",)
    assert splitter.split("he runs as fast as he can") == ("a person runs as fast as he can",)


def gold(half: str) -> list[tuple[str, tuple[str, ...]]]:
    lines = Path(__file__).with_name("splitting_gold.tsv").read_text(encoding="utf-8").splitlines()
    rows = [line.split("\t") for line in lines if line.startswith(half)]
    return [(prompt, tuple(f"{PERSON} {text.strip()}" for text in texts.split("|"))) for _, _, prompt, texts in rows]


@pytest.mark.parametrize(("half", "least"), [("dev", 0.95), ("held-out", 0.90)])
def test_accuracy_on_the_gold_set(splitter: Splitter, half: str, least: float) -> None:
    right = [splitter.split(prompt) == expected for prompt, expected in gold(half)]
    assert len(right) >= 100
    assert sum(right) / len(right) >= least
