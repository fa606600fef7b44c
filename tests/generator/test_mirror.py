import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from generator.corpus.mirror import mirror_joints, mirror_words
from generator.corpus.mirrored_features import mirror_features
from ros_free_stack.formats.features import KIT, encode
from ros_free_stack.skeleton import INDEX

WORDS = ["left", "Right", "LEFT", "clockwise", "Counterclockwise", "leftward", "right-handed", "upright", "bright", "a"]


@pytest.mark.parametrize(
    ("text", "mirrored"),
    [
        ("a person waves with the left hand", "a person waves with the right hand"),
        ("Left foot, then RIGHT foot.", "Right foot, then LEFT foot."),
        ("turns clockwise", "turns counterclockwise"),
        ("turns counter-clockwise", "turns clockwise"),
        ("Anti clockwise, to his left", "Clockwise, to his right"),
        ("leans rightwards, left-handed", "leans leftwards, right-handed"),
        ("stands upright in bright light", "stands upright in bright light"),
        ("", ""),
    ],
)
def test_words(text: str, mirrored: str) -> None:
    assert mirror_words(text) == mirrored


@given(st.lists(st.sampled_from(WORDS)).map(" ".join))
def test_words_twice_is_the_same_text(text: str) -> None:
    assert mirror_words(mirror_words(text)) == text


@given(st.text())
def test_any_text_twice_changes_spelling_at_most(text: str) -> None:
    once = mirror_words(text)
    assert mirror_words(mirror_words(once)) == once


def test_joints_swap_sides_and_twice_is_the_same() -> None:
    joints = np.random.default_rng(0).normal(size=(3, 22, 3))
    mirrored = mirror_joints(joints)
    left, right = INDEX["left_wrist"], INDEX["right_wrist"]
    np.testing.assert_array_equal(mirrored[:, left], joints[:, right] * (1, -1, 1))
    np.testing.assert_array_equal(mirrored[:, INDEX["head"]], joints[:, INDEX["head"]] * (1, -1, 1))
    np.testing.assert_array_equal(mirror_joints(mirrored), joints)


def test_mirror_features_of_kit_ml_are_those_of_the_mirrored_joints() -> None:
    """Of a body that leans and shifts as a whole: no rotation is at the edge of what its encoding takes."""
    rng = np.random.default_rng(1)
    rest = np.array([KIT.joints.index(joint) for joint in KIT.joints])[:, None] * (0.0, 0.0, 0.02) + (0, 0, 1)
    sides = np.array([{"L": 0.2, "R": -0.2}.get(joint[0], 0.0) for joint in KIT.joints])
    points = np.tile(rest, (12, 1, 1)) + rng.normal(scale=0.01, size=(12, len(KIT.joints), 3)).cumsum(0)
    points[..., 1] += sides
    other = {"L": "R", "R": "L"}
    opposite = [KIT.joints.index(other[j[0]] + j[1:] if j[0] in other else j) for j in KIT.joints]
    features, expected = encode(points, KIT), encode(points[:, opposite] * (1, -1, 1), KIT)
    found = mirror_features(features, KIT)
    assert found.shape == (11, 251)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    np.testing.assert_allclose(mirror_features(found, KIT), features, atol=1e-12)
