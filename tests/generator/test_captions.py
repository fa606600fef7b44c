"""Sentences keep the order of time in their segments, whatever order they are told in."""

import numpy as np

from generator.corpus.captions import compose_caption, draw_voice, segment_text, together
from generator.corpus.vocabulary.english import Phrase
from generator.corpus.vocabulary.entry import Voice

WAVE, BOW, WALK = Phrase("<wave> with the right hand"), Phrase("<bow>"), Phrase("<walk> forward")


def captions(*phrases: Phrase, count: int = 400) -> set[tuple[str, tuple[str, ...]]]:
    rng = np.random.default_rng(0)
    made = (compose_caption(phrases, Voice("a person", "he", "the"), rng) for _ in range(count))
    return {(caption.text.rstrip("."), caption.segments) for caption in made}


def test_segment_texts_are_canonical_and_in_temporal_order() -> None:
    expected = ("a person waves with the right hand", "a person bows")
    assert {segments for _, segments in captions(WAVE, BOW)} == {expected}


def test_order_is_told_forwards_and_backwards() -> None:
    texts = {text for text, _ in captions(WAVE, BOW)}
    assert "a person bows after waving with the right hand" in texts
    assert "a person waves with the right hand, then bows" in texts
    assert "before bowing, a person waves with the right hand" in texts
    assert "a person waves with the right hand after bowing" not in texts


def test_every_clause_appears_once_and_later_ones_last_in_long_sentences() -> None:
    for text, _ in captions(WAVE, BOW, WALK):
        assert text.count("walk") == 1
        assert text.index("walk") > max(text.index("wav"), text.index("bow"))


def test_a_voice_without_subject_gives_a_command() -> None:
    rng = np.random.default_rng(0)
    caption = compose_caption((WAVE,), Voice("", "", "the"), rng)
    assert caption.text.rstrip(".") == "wave with the right hand"
    assert caption.segments == ("a person waves with the right hand",)


def test_two_actions_at_once_stay_one_segment() -> None:
    rng = np.random.default_rng(0)
    said = {segment_text(together(WALK, WAVE, rng)) for _ in range(60)}
    assert "a person waves with the right hand while walking forward" in said
    assert "a person walks forward while waving with the right hand" in said
    assert all("while" in text or "at the same time" in text for text in said)


def test_they_takes_the_plain_verb() -> None:
    rng = np.random.default_rng(0)
    texts = [compose_caption((WAVE, BOW), Voice("someone", "they", "their"), rng).text for _ in range(400)]
    assert any("they bow" in text for text in texts)
    assert not any("they bows" in text or "they waves" in text for text in texts)


def test_at_least_six_subjects() -> None:
    rng = np.random.default_rng(0)
    assert len({draw_voice(rng).subject for _ in range(500)}) >= 6


def test_segment_texts_speak_impersonally_and_count_in_one_way() -> None:
    said = {
        "<wave> {} right hand two times": "a person waves the right hand twice",
        "<raise> both {} arms 3 times": "a person raises both arms three times",
        "<touch> {} head with {} left hand": "a person touches the head with the left hand",
    }
    for marked, text in said.items():
        for possessive in ("his", "their", "her", "the"):
            assert segment_text(Phrase(marked.replace("both {}", "both").replace("{}", possessive))) == text
    assert segment_text(Phrase("<raise> both his arms")) == "a person raises both arms"
    assert segment_text(Phrase("<walk> and <wave> his hand at the same time")) == "a person walks while waving the hand"


def test_some_captions_are_in_the_progressive() -> None:
    texts = {text for text, _ in captions(WAVE)} | {text for text, _ in captions(WAVE, BOW)}
    assert "a person is waving with the right hand" in texts
    assert "a person is waving with the right hand, then bows" in texts
