"""Numbers of repetitions in segment texts."""

import pytest

from generator.text.counts import repetitions, segment_counts


@pytest.mark.parametrize(
    ("clause", "number"),
    [
        ("a person waves twice", 2),
        ("a person waves the right hand once", 1),
        ("a person nods 3 times quickly", 3),
        ("a person jumps one time", 1),
        ("a person takes three steps forward", 3),
        ("a person does 5 star jumps", 5),
        ("a person claps fifteen or 20 times", 8),
        ("a person waves", 0),
        ("a person waves with two hands", 0),
        ("a person raises one arm", 0),
        ("a person spins 360 degrees", 0),
        ("a person does a jump with a 180 degree turn", 0),
        ("a person lifts two heavy weights", 0),
        ("a person claps many times", 0),
        ("a person does two knee lifts", 2),
        ("a person does three arm curls with both arms", 3),
        ("a person performs a single squat", 1),
        ("a person takes one big step", 1),
        ("a person jogs in one place", 0),
        ("a person kicks with one straight leg", 0),
        ("a person lifts one arm at a time", 0),
        ("a person steps one by one", 0),
    ],
)
def test_repetitions(clause: str, number: int) -> None:
    assert repetitions(clause) == number


def test_each_clause_has_its_own_number() -> None:
    texts = ["a person takes two steps while waving three times", "a person bows"]
    assert segment_counts(texts).tolist() == [[2, 3], [0, 0]]
