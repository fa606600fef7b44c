"""A raw prompt becomes known segments or one clear refusal."""

from contextlib import suppress
from pathlib import Path

import pytest

from benchmarks.hostile import strings
from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from generator.text.understanding import DOMAIN, Understanding
from ros_free_stack.errors import InvalidFile, InvalidPrompt, OutOfDomain, StackError


@pytest.fixture(scope="module")
def encoder() -> TextEncoder:
    return TextEncoder()


@pytest.fixture(scope="module")
def understanding(tmp_path_factory: pytest.TempPathFactory, encoder: TextEncoder) -> Understanding:
    folder = tmp_path_factory.mktemp("weights")
    Domain.fit(["a person bows", "a person waves", "a person walks forward"], encoder).save(folder / DOMAIN)
    return Understanding(folder, lambda: encoder)


def test_known_actions_come_in_temporal_order(understanding: Understanding):
    segments, known = understanding.segments("bows after waving")
    assert segments == ("a person waves", "a person bows")
    assert known


def test_unknown_action_is_named_with_the_nearest_known(understanding: Understanding):
    with pytest.raises(OutOfDomain, match="photosynthesises") as caught:
        understanding.segments("a person bows, then photosynthesises")
    assert set(caught.value.nearest) <= {"a person bows", "a person waves", "a person walks forward"}


def test_anyway_goes_on_and_says_that_it_is_unknown(understanding: Understanding):
    assert understanding.segments("photosynthesises", anyway=True) == (("a person does photosynthesises",), False)


def test_hopeless_prompt_needs_neither_parser_nor_known_texts(tmp_path: Path):
    def never() -> TextEncoder:
        raise AssertionError

    with pytest.raises(InvalidPrompt):
        Understanding(tmp_path, never).segments("   ")


def test_missing_known_texts_name_the_file(tmp_path: Path, encoder: TextEncoder):
    with pytest.raises(InvalidFile, match=DOMAIN):
        Understanding(tmp_path, lambda: encoder).segments("photosynthesises")


def test_notes_of_the_segmenter_are_handed_on(understanding: Understanding):
    understood = understanding.read("wavs without turning around")
    assert understood.segments == ("a person waves",)
    assert understood.known
    assert understood.notes == (
        "read 'wavs' as 'waves'",
        "understood: waves",
        "not shown: 'without turning around'",
    )


def test_read_words_segments_as_the_corpus_does(understanding: Understanding) -> None:
    understood = understanding.read("hey robot, could you raise your left arm, no, your right arm for me, please?")
    assert understood.segments == ("a person raises the right arm",)
    assert understood.not_shown == ()


def test_read_manner_that_no_motion_shows_is_told_in_the_words_of_the_prompt(understanding: Understanding) -> None:
    understood = understanding.read("The man waves Gracefully")
    assert understood.segments == ("a person waves",)
    assert understood.known
    assert understood.not_shown == ("Gracefully",)


def test_read_unknown_way_of_a_known_action_is_left_out_only_on_request(understanding: Understanding) -> None:
    with pytest.raises(OutOfDomain, match=r"does not know 'walk with a limp'.*a person walks"):
        understanding.read("walk with a limp")
    understood = understanding.read("walk with a limp", anyway=True)
    assert understood.segments == ("a person walks",)
    assert not understood.known
    assert understood.not_shown == ("walk with a limp",)


@pytest.mark.parametrize(("prompt", "near"), [("do a backflip", "jumps"), ("crawl", "kneels"), ("limp", "walks")])
def test_read_unknown_action_is_refused_with_what_is_near_in_meaning(
    understanding: Understanding, prompt: str, near: str
) -> None:
    with pytest.raises(OutOfDomain) as caught:
        understanding.read(prompt)
    assert any(near in text for text in caught.value.nearest)


def test_read_absurd_amount_is_refused_with_the_range_that_works(understanding: Understanding) -> None:
    with pytest.raises(InvalidPrompt, match=r"'3000 metres' is out of range: 0.05 to 9 m"):
        understanding.read("walk 3 km")


def test_read_hostile_strings_end_in_a_reading_or_a_named_error(understanding: Understanding) -> None:
    for text in ("!, no, wait, ,", *strings(80, seed=1)):
        with suppress(StackError):
            understanding.read(text)


def test_read_amounts_are_in_the_frames(understanding: Understanding) -> None:
    understood = understanding.read("walk forward 2 meters, then turn 90 degrees to the left")
    assert understood.segments == ("a person walks forward", "a person turns 90 degrees to the left")
    assert [frame.value("distance") for moment in understood.moments for frame in moment.actions] == [2.0, None]
    assert understood.notes == ("understood: walks forward, then turns 90 degrees to the left",)
