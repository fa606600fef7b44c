"""The skeleton's tables agree with each other."""

import itertools

from ros_free_stack.skeleton import BONES, CHAINS, INDEX, JOINT_NAMES, MIRRORED, PARENTS, PARTS


def test_parents_come_before_children():
    assert all(parent < child for child, parent in enumerate(PARENTS))
    assert len(BONES) == len(JOINT_NAMES) - 1


def test_mirror_swaps_left_and_right_and_is_its_own_inverse():
    for i, j in enumerate(MIRRORED):
        assert MIRRORED[j] == i
        swapped = JOINT_NAMES[i].replace("left", "?").replace("right", "left").replace("?", "right")
        assert JOINT_NAMES[j] == swapped


def test_chains_follow_parents_and_parts_cover_every_joint_once():
    for chain in CHAINS:
        assert all(PARENTS[child] == parent for parent, child in itertools.pairwise(chain))
    assert sorted(i for part in PARTS.values() for i in part) == list(range(len(JOINT_NAMES)))
    assert all(JOINT_NAMES[i].startswith("left") for i in PARTS["left_arm"] + PARTS["left_leg"])
    assert INDEX["right_wrist"] == 21
