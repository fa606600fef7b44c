"""Timing of a sentence: parts of long ones."""

from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.timing import HURRY, part_sizes


def test_parts_are_few_and_even() -> None:
    assert part_sizes([3.0, 3.0, 3.0, 3.0], 9.8, 8.8) == (2, 2)
    assert part_sizes([3.0, 7.0, 1.0, 4.0], 9.8, 8.8) == (2, 2)
    assert part_sizes([5.0, 5.0], 9.8, 8.8) == (2,), "a little faster is no reason for another part"
    assert part_sizes([12.0], 9.8, 8.8) == (1,)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.floats(0.2, 14), min_size=1, max_size=5), st.floats(8, 9.8))
def test_parts_hold_all_segments_and_hurry_least(seconds: list[float], first_s: float) -> None:
    sizes = part_sizes(seconds, first_s, 8.8)
    assert sum(sizes) == len(seconds) and min(sizes) >= 1
    if sum(seconds) <= first_s:
        assert sizes == (len(seconds),)
    edges = np.cumsum((0, *sizes))
    if max(seconds) <= 8.0:
        for i, (start, end) in enumerate(pairwise(edges)):
            assert sum(seconds[start:end]) <= HURRY * (8.8 if i else first_s) + 1e-5
