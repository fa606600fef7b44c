import numpy as np
import pytest

from retarget.clip.human import align, pelvis_rotation, torso_rotation
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import INDEX


def test_alignment_puts_the_clip_on_the_floor_at_the_origin_facing_x(motions):
    turned = np.array(motions["steps"].joints) @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    clip = align(HumanMotion(turned + np.array([3, -2, 0.7]), 20.0))
    reference = align(motions["steps"])
    np.testing.assert_allclose(clip.joints, reference.joints, atol=1e-9)
    assert (clip.contacts == reference.contacts).all()


def test_contacts_follow_the_steps(motions):
    contacts = align(motions["steps"]).contacts
    assert contacts[:14].all() and contacts[-10:].all()
    assert contacts.any(axis=1).all()
    lifted = [tuple(np.flatnonzero(~contacts[start : start + 20].all(axis=0))) for start in (15, 35, 55, 75)]
    assert lifted == [(0,), (1,), (0,), (1,)]


def test_a_foot_that_only_drags_its_toes_does_not_stand(motions):
    joints = np.array(motions["stand"].joints)
    joints[:, 8, 2] += 0.25
    assert not align(HumanMotion(joints, 20.0)).contacts[:, 1].any()


@pytest.mark.parametrize("rotation", [pelvis_rotation, torso_rotation])
def test_an_upright_person_has_no_lean(motions, rotation):
    np.testing.assert_allclose(rotation(motions["stand"].joints)[0], np.eye(3), atol=0.05)


def test_feet_that_are_never_still_stand_while_they_touch_the_floor(motions):
    joints = np.array(motions["stand"].joints)
    joints[..., 0] += 0.05 * np.arange(len(joints))[:, None]
    joints[15:25, :, 2] += 0.2
    standing = align(HumanMotion(joints, 20.0)).contacts
    assert standing[:15].all() and standing[25:].all() and not standing[15:25].any()


def test_a_heel_that_lands_before_the_toes_have_left_leaves_no_flight(motions):
    joints, roll = np.array(motions["stand"].joints), slice(15, 20)
    joints[roll, INDEX["left_ankle"], 2] += 0.12
    joints[roll, INDEX["left_foot"], 0] += 0.05 * np.arange(1, 6)
    joints[20:, INDEX["left_foot"], 0] += 0.25
    joints[roll, INDEX["right_foot"], 2] += 0.08
    assert align(HumanMotion(joints, 20.0)).contacts.any(axis=1).all()
