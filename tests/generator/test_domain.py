"""The check of what the model knows, on known texts drawn from the vocabulary and on the shipped ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.domain import HALVES, LISTS, sentences
from generator.corpus.vocabulary.entry import Draw, Voice
from generator.corpus.words import VOCABULARY, entry, phrase
from generator.registry import SHARED_WEIGHTS
from generator.text.domain import Domain, deeds
from generator.text.encoder import TextEncoder
from generator.text.splitter import Splitter
from generator.text.understanding import DOMAIN
from ros_free_stack.errors import InvalidFile, InvalidPrompt, OutOfDomain


@pytest.fixture(scope="module")
def encoder() -> TextEncoder:
    return TextEncoder()


@pytest.fixture(scope="module")
def corpus() -> list[str]:
    """Segment texts with twenty phrasings of every action of the vocabulary."""
    rng = np.random.default_rng(0)
    told = (
        phrase(name, entry(name).sample(Draw(rng)), Voice(), rng).third
        for name in sorted(VOCABULARY)
        for _ in range(20)
    )
    return [f"a person {text}" for text in told]


@pytest.fixture(scope="module")
def domain(corpus: list[str], encoder: TextEncoder) -> Domain:
    return Domain.fit(corpus, encoder)


@pytest.fixture(scope="module")
def shipped(encoder: TextEncoder) -> Domain:
    return Domain.load(SHARED_WEIGHTS / DOMAIN, encoder)


@pytest.fixture(scope="module")
def held_out() -> dict[str, list[tuple[str, ...]]]:
    """Segment texts of the sentences on which nothing was chosen; none where the sentence is refused at once."""
    splitter = Splitter()

    def split(sentence: str) -> tuple[str, ...]:
        try:
            return splitter.split(sentence)
        except InvalidPrompt:
            return ()

    return {name: [split(sentence) for sentence in sentences(name, HALVES[1])] for name in LISTS}


def share_correct(domain: Domain, split: dict[str, list[tuple[str, ...]]], name: str) -> float:
    segments = [segment for row in split[name] for segment in row]
    known = dict(zip(segments, domain.similarity(segments) >= domain.threshold, strict=True))
    accepted = [bool(row) and all(known[segment] for segment in row) for row in split[name]]
    return float(np.mean(np.array(accepted) == LISTS[name]))


def test_lists_are_long_and_apart() -> None:
    known, unknown = ([s for half in HALVES for s in sentences(name, half)] for name in LISTS)
    assert min(len(known), len(unknown)) >= 200
    assert len(set(known + unknown)) == len(known) + len(unknown)


@pytest.mark.parametrize("name", LISTS)
def test_shipped_texts_tell_held_out_sentences_apart(
    shipped: Domain, held_out: dict[str, list[tuple[str, ...]]], name: str
):
    assert share_correct(shipped, held_out, name) >= 0.85


def test_all_but_a_few_of_the_corpus_texts_are_inside(domain: Domain, corpus: list[str]) -> None:
    assert (domain.similarity(corpus[::4]) >= domain.threshold).mean() >= 0.995


@pytest.mark.parametrize(
    "segment",
    [
        "a person {} with the left hand",
        "a person {} with her right hand",
        "a person slowly {} with one hand",
        "a person {} 17 times",
        "a person {} while walking forward",
    ],
)
def test_side_count_and_speed_do_not_matter(domain: Domain, segment: str) -> None:
    domain.check([segment.format("waves"), segment.format("punches")])


@pytest.mark.parametrize(
    ("segment", "expected"),
    [
        ("a person waves twice with her left hand", ["a person waves twice with the right hand"]),
        ("a person does four squats slowly", ["a person does two squats"]),
        ("a person turns left and right", ["a person turns left and right"]),
        ("a person turns 90 degrees to the left", ["a person turns 90 degrees to the right"]),
        ("a person claps several times while walking", ["a person claps twice", "a person walks"]),
        ("the left dog runs", ["the right dog runs"]),
    ],
)
def test_deeds_have_no_side_count_or_speed(segment: str, expected: list[str]) -> None:
    assert list(deeds(segment)) == expected


def test_an_unknown_deed_beside_a_known_one_is_refused(domain: Domain) -> None:
    domain.check(["a person waves with the left hand while walking forward"])
    with pytest.raises(OutOfDomain, match="riding a bike"):
        domain.check(["a person waves with the left hand while riding a bike"])


def test_a_contrasting_deed_that_is_trained_on_is_known(encoder: TextEncoder) -> None:
    assert (Path(__file__).parents[2] / "generator/text/contrast.txt").read_text().count("\ndoes a handspring\n") == 1
    texts = ["a person bows", "a person walks", "a person does a handspring"]
    Domain.fit(texts, encoder).check(texts)
    with pytest.raises(OutOfDomain):
        Domain.fit(texts[:2], encoder).check(texts[2:])


def test_an_unknown_segment_is_named_with_known_ones(domain: Domain) -> None:
    with pytest.raises(OutOfDomain) as caught:
        domain.check(["a person bows", "a person does a cartwheel"])
    assert caught.value.segment == "a person does a cartwheel"
    assert len(set(caught.value.nearest)) == 3 and set(caught.value.nearest) <= set(domain.texts)


@pytest.mark.parametrize("segment", ["the stock market falls", "a dog walks forward"])
def test_only_human_beings(domain: Domain, segment: str) -> None:
    with pytest.raises(OutOfDomain):
        domain.check([segment])


def test_limit_keeps_the_most_different_texts(domain: Domain) -> None:
    texts = ["a person bows", "a person bows down", "a person walks", "a person claps"]
    small = Domain.fit(texts, domain.encoder, limit=3)
    assert len(small.texts) == 3
    assert len({text.split()[2] for text in small.texts}) == 3


def test_clauses_mean_the_actions_of_the_nearest_text(encoder: TextEncoder) -> None:
    actions = {"a person bows": ("bow",), "a person steps back": ("step", "walk")}
    small = Domain.fit(["a person bows", "a person steps back", "a person claps"], encoder, actions=actions)
    clauses = ["a person bows down", "a person takes a step back", "a person claps", "a person sings a song"]
    assert small.meant(clauses) == [("bow",), ("step", "walk"), (), ()]


def test_survives_its_file(domain: Domain, tmp_path: Path) -> None:
    told = replace(domain, actions=(("wave", "greet"), *domain.actions[1:]))
    told.save(tmp_path / "domain.safetensors")
    again = Domain.load(tmp_path / "domain.safetensors", domain.encoder)
    assert (again.texts, again.actions, again.threshold) == (told.texts, told.actions, told.threshold)
    queries = domain.texts[:5]
    np.testing.assert_allclose(again.similarity(queries), domain.similarity(queries), atol=2e-3)


def test_broken_files(domain: Domain, tmp_path: Path) -> None:
    path = tmp_path / "domain.safetensors"
    with pytest.raises(InvalidFile, match="no such file"):
        Domain.load(path, domain.encoder)
    domain.save(path)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(InvalidFile, match="known texts"):
        Domain.load(path, domain.encoder)
