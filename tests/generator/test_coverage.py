"""Coverage of real captions counts what the vocabulary can say, and names what it cannot."""

import json
from pathlib import Path

import pytest

from generator.corpus.coverage import Speech, measure, read_captions, sample_captions
from ros_free_stack.errors import InvalidFile, InvalidPrompt


@pytest.fixture(scope="module")
def speech() -> Speech:
    return Speech()


@pytest.mark.parametrize(
    "segment",
    [
        "a person waves with the right hand",
        "a person slowly walks forward",
        "a person walks forward while waving with the left hand",
        "a person picks up a box",
        "a person does two squats",
        "a person raises both arms and lowers them",
    ],
)
def test_what_the_vocabulary_utters_is_covered(speech: Speech, segment: str) -> None:
    assert all(speech.covers(said) for said in speech.actions(segment))


@pytest.mark.parametrize(
    ("segment", "lacking"),
    [
        ("a person moonwalks", 0),  # an unknown verb
        ("a person waves the left leg", 0),  # no such limb with this verb
        ("a person does a cartwheel", 0),  # a vague verb's object
        ("a person walks forward while juggling", 1),
        ("a person punches up", 0),  # the particle
    ],
)
def test_what_it_never_utters_is_not(speech: Speech, segment: str, lacking: int) -> None:
    actions = speech.actions(segment)
    assert not speech.covers(actions[lacking])
    assert all(speech.covers(said) for said in actions[:lacking])


def split(caption: str) -> tuple[str, ...]:
    if not caption:
        raise InvalidPrompt("it is empty")
    return tuple(f"a person {part}" for part in caption.split(", "))


def test_shares_are_of_captions_and_of_segments(speech: Speech) -> None:
    found = measure(["walks forward, waves", "waves, moonwalks", "does a cartwheel", ""], split, speech)
    assert (found.captions, found.segments, found.unreadable) == (3, 5, 1)
    assert found.covered_captions == pytest.approx(1 / 3)
    assert found.covered_segments == pytest.approx(3 / 5)
    assert dict(found.uncovered) == {"moonwalks": 1, "do cartwheel": 1}


def test_captions_are_read_and_drawn_with_a_seed(tmp_path: Path) -> None:
    path = tmp_path / "captions.json"
    path.write_text(json.dumps({"train": {"1": [["a", 0, 1], ["b", 0, 1]]}, "val": {"2": [["c", 0, 1]]}}))
    texts = read_captions(path)
    assert texts == ("a", "b", "c")
    assert sorted(sample_captions(texts, 9, seed=1)) == ["a", "b", "c"]
    assert sample_captions(texts, 2, seed=1) == sample_captions(texts, 2, seed=1)


@pytest.mark.parametrize("content", ["[]", "{}", "no", '{"train": [1]}', '{"train": {"1": [[3]]}}'])
def test_another_file_is_refused(tmp_path: Path, content: str) -> None:
    path = tmp_path / "captions.json"
    path.write_text(content)
    with pytest.raises(InvalidFile, match=r"captions\.json"):
        read_captions(path)
