"""Timing of a sentence: parts of long ones, whole tokens, boundaries of segments."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.model import FeatureSpec
from generator.timing import HURRY, part_sizes, segment_lengths, uniform_lengths, whole_frames
from ros_free_stack.errors import InvalidOption


def test_parts_are_few_and_even() -> None:
    assert part_sizes([3.0, 3.0, 3.0, 3.0], 9.8, 8.8) == (2, 2)
    assert part_sizes([3.0, 7.0, 1.0, 4.0], 9.8, 8.8) == (2, 2)
    assert part_sizes([5.0, 5.0], 9.8, 8.8) == (2,), "a little faster is no reason for another part"
    assert part_sizes([12.0], 9.8, 8.8) == (1,)
    assert part_sizes([0.5] * 6, 9.8, 8.8) == (3, 3), "no more segments at a time than the models take"
    assert part_sizes([0.5] * 6, 9.8, 8.8, first=2) == (2, 4)
    assert sum(part_sizes([2.0] * 20, 9.8, 8.8)) == 20


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


@settings(max_examples=200, deadline=None)
@given(st.lists(st.floats(0.05, 30), min_size=1, max_size=5))
def test_whole_frames(durations: list[float]) -> None:
    frames = whole_frames(np.array(durations), FeatureSpec(263, 20.0, 40, 196, token_frames=4))
    assert (frames % 4 == 0).all()
    tokens = frames // 4
    assert tokens.min() >= 1
    assert 10 <= tokens.sum() <= 49
    if 2.0 <= sum(durations) <= 9.8:
        assert abs(tokens.sum() - 5 * sum(durations)) <= 0.5 + 1e-9


def test_frames_of_a_model_without_tokens_and_of_uniform_layout() -> None:
    free = FeatureSpec(263, 20.0, 40, 196)
    assert whole_frames(np.array([1.05, 2.0]), free).tolist() == [21, 40]
    uniform = FeatureSpec(263, 20.0, 40, 196, token_frames=4, layout="uniform")
    assert whole_frames(np.array([1.0, 3.0]), uniform).tolist() == [40, 40]
    assert whole_frames(np.array([1.0, 3.0]), free, least=60, most=60).tolist() == [15, 45]


def test_boundary_lies_midway_between_segments() -> None:
    assert segment_lengths([(0, 36), (44, 80)], 20, 4).tolist() == [10, 10]
    assert segment_lengths([(0, 40), (40, 81)], 20, 4).tolist() == [10, 10]


@settings(max_examples=100, deadline=None)
@given(data=st.data(), count=st.integers(1, 5))
def test_every_segment_gets_a_token_and_none_is_lost(data: st.DataObject, count: int) -> None:
    tokens = data.draw(st.integers(count, 49))
    cuts = sorted(data.draw(st.lists(st.integers(0, 4 * tokens), min_size=count - 1, max_size=count - 1)))
    edges = [0, *cuts, 4 * tokens]
    lengths = segment_lengths(list(pairwise(edges)), tokens, 4)
    assert lengths.sum() == tokens
    assert lengths.min() >= 1
    uniform = uniform_lengths(count, tokens)
    assert uniform.sum() == tokens
    assert uniform.max() - uniform.min() <= 1


def test_too_many_segments_are_refused() -> None:
    with pytest.raises(InvalidOption, match="1 to 5 segments, found 6"):
        uniform_lengths(6, 30)
    with pytest.raises(InvalidOption, match="do not fit"):
        uniform_lengths(4, 3)
