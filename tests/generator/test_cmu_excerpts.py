"""Excerpts are labelled by what was measured; the takes themselves are used where RFS_CMU names them."""

import os
from pathlib import Path

import numpy as np
import pytest

from generator.corpus import pose as poses
from generator.corpus.actions import perform
from generator.corpus.cmu_excerpts import load_excerpts, marked_caption
from generator.corpus.cmu_rules import MIN_S
from generator.corpus.excerpts import Excerpt, mirror_params
from generator.corpus.joins import length
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats import cmu
from ros_free_stack.skeleton import FPS, INDEX, MIRRORED


@pytest.mark.parametrize(
    ("caption", "marked"),
    [
        ("a person walks forward at a slow pace.", "<walk> forward at a slow pace"),
        ("a person is walking in a straight line", "<walk> in a straight line"),
        ("the man jumps in the air", "<jump> in the air"),
        ("a person walks forward and waves", ""),
        ("a person walks, then waves", ""),
        ("walking forward", ""),
    ],
)
def test_captions_of_a_single_action_become_phrases(caption: str, marked: str) -> None:
    assert marked_caption(caption) == marked


def test_reflection_swaps_sides_and_angles() -> None:
    assert mirror_params({"side": "left", "curve": 30.0, "count": 2}) == {"side": "right", "curve": -30.0, "count": 2}


def test_a_mirrored_excerpt_is_reflected_in_motion_and_words() -> None:
    scene = Scene(seed=0)
    perform(scene, "kick", side="left")
    excerpt = Excerpt(
        "kick", {"side": "left"}, scene.solve(), "1", words=("<kick> with the left leg",), legs="kicks left"
    )
    reflected = excerpt.mirrored
    assert reflected.params == {"side": "right"}
    assert reflected.words == ("<kick> with the right leg",)
    assert reflected.legs == "kicks right"
    expected = poses.joints(excerpt.pose)[:, MIRRORED] * [1, -1, 1]
    assert np.allclose(poses.joints(reflected.pose), expected, atol=1e-6)


def test_a_folder_without_index_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match="index"):
        load_excerpts(tmp_path)


def test_what_a_jump_cuts_off_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene(seed=0)
    perform(scene, "walk", steps=9)
    places = poses.joints(scene.solve())
    jump = 2 * len(places) // 3
    broken = places.copy()
    broken[jump:, INDEX["left_wrist"]] += 1.5
    take = cmu.Take("01_01", "walk", "1", 120.0, ())

    def excerpt_of(joints: np.ndarray) -> Excerpt:
        monkeypatch.setattr(cmu, "read_take", lambda folder, name: joints)
        return load_excerpts(tmp_path, [take])[0]

    whole, sound = excerpt_of(places), excerpt_of(broken)
    assert MIN_S * FPS <= length(sound.pose) < length(whole.pose)
    steps = np.linalg.norm(np.diff(poses.joints(sound.pose), axis=0), axis=-1)
    assert steps.max() * FPS < cmu.MAX_SPEED


@pytest.fixture(scope="module")
def real() -> tuple[Excerpt, ...]:
    folder = os.environ.get("RFS_CMU")
    if not folder:
        pytest.skip("RFS_CMU does not name a folder of CMU takes")
    wanted = {"02_01", "07_04", "09_01", "10_01", "13_11", "13_40", "14_31", "13_18", "49_19"}
    takes = [take for take in cmu.index(Path(folder)) if take.name in wanted]
    return load_excerpts(Path(folder), takes)


def test_real_takes_give_excerpts_with_measured_labels(real: tuple[Excerpt, ...]) -> None:
    by_name: dict[str, list[Excerpt]] = {}
    for excerpt in real:
        by_name.setdefault(excerpt.name, []).append(excerpt)
        assert 0.9 * FPS <= length(excerpt.pose) <= 10 * FPS
    assert {"walk", "jog", "kick", "jump", "balance"} <= set(by_name)
    assert all(excerpt.params["direction"] == "forward" for excerpt in by_name["walk"])
    assert any(excerpt.params["distance"] > 0.5 for excerpt in by_name["jump"])
    assert any(excerpt.params["distance"] == 0.0 for excerpt in by_name["jump"])
