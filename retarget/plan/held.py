"""Targets of a robot that is held by its root: what the human does with arms, legs and trunk, seen from its own body.

Where the person goes and turns does not matter; limbs are followed against the pelvis, or against the chest by a robot
whose chest cannot move.
"""

from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from retarget.body.geometry import LIMBS, RobotGeometry
from retarget.clip import human as hm
from retarget.clip.human import HumanClip, joint, unit
from retarget.plan.targets import Targets
from retarget.plan.timeline import Pace, Timeline
from ros_free_stack.messages import Floats


def own_pace(clip: HumanClip) -> Pace:
    """The human's pace: without steps nothing needs more time."""
    ends = np.array([0.0, max(clip.duration_s, 1e-9)])
    return Pace(ends, ends)


def held_targets(clip: HumanClip, geometry: RobotGeometry, timeline: Timeline) -> Targets:
    """Targets for a clip, from the standing pose and back to it."""
    joints = _seen_from_body(clip.sample(timeline.human_s)[0], by_pelvis="torso" in geometry.frames)
    count, standing, weight = len(joints), geometry.points, timeline.weight
    torso = hm.torso_rotation(joints)
    points = {name: np.repeat(standing[name][None], count, axis=0) for name in geometry.followed}
    for chain in LIMBS:
        if chain[0] not in standing:
            continue
        reach = standing[chain[0]] - standing["pelvis"]
        place = standing["pelvis"] + (torso @ reach if chain[0].endswith("shoulder") else reach)
        for parent, child in pairwise(name for name in chain if name in standing):
            bone = unit(joint(joints, child) - joint(joints, parent)) * geometry.length(parent, child)
            place = place + bone
            points[child] = place
    followed = np.stack([points[name] for name in geometry.followed], axis=1)
    own = np.stack([standing[name] for name in geometry.followed])
    rotations = {"pelvis": np.repeat(np.eye(3)[None], count, axis=0), "torso": torso, "head": hm.head_rotation(joints)}
    return Targets(
        fps=timeline.fps,
        points=own + weight[:, None, None] * (followed - own),
        rotations=np.stack(
            [_partly(rotations[name], weight) @ geometry.references[name] for name in geometry.frames], axis=1
        ),
        soles=np.zeros((count, 0, 3)),
        sole_rotations=np.zeros((count, 0, 3, 3)),
        contacts=np.zeros((count, 0), dtype=bool),
        following=weight,
        scale=geometry.limb_length / clip.length(*LIMBS[0] if LIMBS[0][0] in standing else LIMBS[2]),
    )


def _seen_from_body(joints: Floats, *, by_pelvis: bool) -> Floats:
    """(N, 22, 3) joints in the frame of the human's pelvis or chest, the hips' middle at the origin."""
    frame = hm.pelvis_rotation(joints) if by_pelvis else hm.torso_rotation(joints)
    hips = (joint(joints, "left_hip") + joint(joints, "right_hip")) / 2
    return (joints - hips[:, None]) @ frame


def _partly(rotations: Floats, share: Floats) -> Floats:
    """Rotations (N, 3, 3) `share` (N,) of their own angle."""
    return Rotation.from_rotvec(share[:, None] * Rotation.from_matrix(rotations).as_rotvec()).as_matrix()
