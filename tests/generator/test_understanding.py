"""A raw prompt becomes known segments or one clear refusal."""

from pathlib import Path

import pytest

from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from generator.text.understanding import DOMAIN, Understanding
from ros_free_stack.errors import InvalidFile, InvalidPrompt, OutOfDomain


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
    with pytest.raises(OutOfDomain, match="plays the piano") as caught:
        understanding.segments("a person bows, then plays the piano")
    assert set(caught.value.nearest) <= {"a person bows", "a person waves", "a person walks forward"}


def test_anyway_goes_on_and_says_that_it_is_unknown(understanding: Understanding):
    assert understanding.segments("plays the piano", anyway=True) == (("a person plays the piano",), False)


def test_hopeless_prompt_needs_neither_parser_nor_known_texts(tmp_path: Path):
    def never() -> TextEncoder:
        raise AssertionError

    with pytest.raises(InvalidPrompt):
        Understanding(tmp_path, never).segments("   ")


def test_missing_known_texts_name_the_file(tmp_path: Path, encoder: TextEncoder):
    with pytest.raises(InvalidFile, match=DOMAIN):
        Understanding(tmp_path, lambda: encoder).segments("wave")


def test_notes_of_the_segmenter_are_handed_on(understanding: Understanding):
    understood = understanding.read("wavs without turning around")
    assert understood.segments == ("a person waves",)
    assert understood.known
    assert len(understood.notes) == 2
