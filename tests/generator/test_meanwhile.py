"""What happens at the same time, as clauses of its own."""

import numpy as np
import pytest
from numpy.typing import NDArray

from generator.text.meanwhile import clauses_at_once, encode_segments


@pytest.mark.parametrize(
    ("segment", "main", "meanwhile"),
    [
        ("a person waves", "a person waves", ""),
        ("a person walks while waving", "a person walks", "a person waves"),
        ("a person walks while slowly waving twice", "a person walks", "a person slowly waves twice"),
        ("a person walks while waving and clapping", "a person walks", "a person waves and claps"),
        ("a person squats while swinging the arms", "a person squats", "a person swings the arms"),
        ("a person waves while the legs are crossed", "a person waves", "a person the legs are crossed"),
    ],
)
def test_clauses(segment: str, main: str, meanwhile: str) -> None:
    assert clauses_at_once(segment) == (main, meanwhile)


class Lengths:
    """Embeds a text as its length."""

    def encode_sentences(self, texts: list[str]) -> NDArray[np.float32]:
        return np.array([[len(text), 1] for text in texts], np.float32)


def test_absent_clauses_are_zero() -> None:
    found = encode_segments(Lengths(), ["a person walks while waving", "a person bows"])
    np.testing.assert_array_equal(found, [[[14, 1], [14, 1]], [[13, 1], [0, 0]]])
