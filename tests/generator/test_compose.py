"""Clips hold what their labels say."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from generator.config import MAX_FRAMES, MIN_FRAMES
from generator.corpus.actions import perform
from generator.corpus.compose import ComposedClip, compose_clip, is_motion
from generator.corpus.excerpts import Excerpt
from generator.corpus.plan import SEGMENT_SHARES, draw_plan
from generator.corpus.scene import Scene
from generator.corpus.words import STILL, VOCABULARY
from ros_free_stack.skeleton import INDEX


@pytest.fixture(scope="module")
def excerpts() -> tuple[Excerpt, ...]:
    made = []
    for seed in range(2):
        scene = Scene(seed=seed)
        perform(scene, "walk", steps=5)
        params = {"direction": "forward", "curve": 0.0, "speed": 1.0}
        made.append(Excerpt("walk", params, scene.solve(), f"take {seed}", cyclic=True))
        made.append(Excerpt("skip", {}, scene.solve(), f"take {seed}", words=("<skip> along",), legs="skips along"))
    return tuple(made)


@pytest.fixture(scope="module")
def clips(excerpts: tuple[Excerpt, ...]) -> list[ComposedClip]:
    return [compose_clip(np.random.default_rng([0, i]), excerpts) for i in range(25)]


def test_segments_tile_the_clip(clips: list[ComposedClip]) -> None:
    for clip in clips:
        frames = len(clip.joints) - 1
        assert MIN_FRAMES <= frames <= MAX_FRAMES
        edges = [segment.start for segment in clip.segments] + [frames]
        assert edges[0] == 0
        assert [segment.end for segment in clip.segments] == edges[1:]
        assert all(a < b for a, b in pairwise(edges))


def test_each_caption_words_each_segment(clips: list[ComposedClip]) -> None:
    for clip in clips:
        assert 1 <= len(clip.captions) <= 3
        for caption in clip.captions:
            assert len(caption.segments) == len(clip.segments) == len(clip.names)
            assert all(text.startswith("a person ") and not text.endswith(".") for text in caption.segments)


def test_clips_are_motion(clips: list[ComposedClip]) -> None:
    assert all(is_motion(clip.joints) for clip in clips)
    broken = clips[0].joints.copy()
    broken[3] += 1.0
    assert not is_motion(broken)
    broken[3] = np.nan
    assert not is_motion(broken)


def test_real_and_authored_actions_mix(clips: list[ComposedClip]) -> None:
    sources = {clip.source for clip in clips}
    assert "authored" in sources
    assert sources & {"cmu", "mixed"}
    for clip in clips:
        captured = any(segment.actions[0][0] == "skip" for segment in clip.segments)
        assert not captured or clip.source != "authored"


def test_the_same_seed_gives_the_same_clip(clips: list[ComposedClip], excerpts: tuple[Excerpt, ...]) -> None:
    again = compose_clip(np.random.default_rng([0, 3]), excerpts)
    assert np.array_equal(again.joints, clips[3].joints)
    assert again.captions == clips[3].captions


def test_who_sits_stands_up_before_anything_else_on_the_feet() -> None:
    rng = np.random.default_rng(0)
    seen = 0
    for _ in range(400):
        names = [part.name for part in draw_plan(rng, 5)]
        for i, name in enumerate(names[:-1]):
            if name == "sit_down":
                seen += 1
                later = names[i + 1 :]
                up = later.index("stand_up") if "stand_up" in later else len(later)
                assert not set(later[:up]) & {"walk", "turn", "step", "squat", "jump", "kick", "sit_down"}
    assert seen > 5


def test_a_side_in_the_parameters_is_the_side_that_moves() -> None:
    checked = 0
    for i in range(40):
        clip = compose_clip(np.random.default_rng([1, i]))
        for segment in clip.segments:
            name, params = segment.actions[0]
            if name != "wave" or params["side"] == "both":
                continue
            checked += 1
            window = slice(segment.start, segment.end)
            tops = {s: clip.joints[window, INDEX[f"{s}_wrist"], 2].max() for s in ("left", "right")}
            assert max(tops, key=lambda s: tops[s]) == params["side"]
            assert params["side"] in segment.arms
    assert checked > 0


def test_parts_that_stay_still_say_so() -> None:
    clip = next(
        c
        for i in range(60)
        if (c := compose_clip(np.random.default_rng([2, i]))).segments[0].actions[0][0]
        in ("wave", "clap", "point", "bow")
    )
    assert clip.segments[0].legs == STILL


def test_long_actions_are_not_rarer_than_short_ones() -> None:
    """Swaying takes too long for most clips, and is drawn the more often where it fits."""
    rng = np.random.default_rng(4)
    names: Counter[str] = Counter()
    for _ in range(3000):
        count = 1 + int(rng.choice(len(SEGMENT_SHARES), p=SEGMENT_SHARES))
        names.update(part.name for part in draw_plan(rng, count) if part.arms is None)
    alike = ("crouch", "tiptoes", "lean")  # of the same weight, and short
    usual = np.mean([names[name] / VOCABULARY[name].weight for name in alike])
    for name in ("sway", "conduct", "sneak"):
        assert names[name] / VOCABULARY[name].weight > 0.4 * usual
