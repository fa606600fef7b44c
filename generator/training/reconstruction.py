"""What a reconstruction is measured by: MoMask's losses, and ones weighted so that the root's motion survives."""

from functools import cache
from typing import Final

import torch
from torch import Tensor
from torch.nn import functional

from ros_free_stack.formats.features import HUMANML3D, Skeleton

ROOT, YAW, HEIGHT = slice(0, 3), slice(0, 1), slice(3, 4)
CONTACTS = slice(-4, None)

VELOCITY_WEIGHT, JOINT_WEIGHT, BONE_WEIGHT, DRIFT_WEIGHT, FEET_WEIGHT = 0.5, 2.0, 0.3, 0.5, 3.0
POSITION_WEIGHT: Final = 0.5
"""Of the joint positions in MoMask's loss; its paper and code name it after velocities."""
COMMITMENT_WEIGHT = 0.02
STIFF = 0.1  # of its length; bones that hardly move are not blown up
PLANTED = 4.0  # how much more a planted foot's slip counts than a swinging one's


def positions(skeleton: Skeleton) -> slice:
    """Features that are joint positions."""
    return slice(4, 4 + 3 * (len(skeleton.joints) - 1))


def _rotations(skeleton: Skeleton) -> slice:
    start = positions(skeleton).stop
    return slice(start, start + 6 * (len(skeleton.joints) - 1))


@cache
def channel_weights(skeleton: Skeleton = HUMANML3D) -> Tensor:
    """(F,) loss weights of the standardised features, of mean 1.

    Three channels carry the whole path of the body; at equal weight their error drowns in the rest.
    Rotations are not used to draw the motion, velocities follow from the positions.
    """
    weights = torch.ones(skeleton.width)
    weights[ROOT], weights[HEIGHT] = 4.0, 2.0
    weights[_rotations(skeleton)], weights[_rotations(skeleton).stop : CONTACTS.start] = 0.1, 0.15
    return weights / weights.mean()


def published_losses(found: Tensor, target: Tensor, skeleton: Skeleton = HUMANML3D) -> dict[str, Tensor]:
    """MoMask's losses between standardised features (B, T, F): smooth L1 of all and, half as much, of positions."""
    features = functional.smooth_l1_loss(found, target)
    own = positions(skeleton)
    joints = functional.smooth_l1_loss(found[..., own], target[..., own])
    return {"loss": features + POSITION_WEIGHT * joints, "features": features, "positions": joints}


def reconstruction_losses(
    found: Tensor, target: Tensor, mean: Tensor, std: Tensor, skeleton: Skeleton = HUMANML3D
) -> dict[str, Tensor]:
    """Weighted losses between standardised features (B, T, F).

    "features" and "velocity": smooth L1 of values and of their differences in time; "joints": mean distance
    of joint positions in m; "drift": error of root yaw (rad) and path (m) summed up over time, which catches the
    small steady errors that add up to a wrong heading; "feet": error of the feet's steps over the ground in m a
    frame, planted ones above all, because root and pose may each be nearly right and the feet skate all the same;
    "bones": error of each bone's vector by how much that bone varies, because a nod or a shrug is all that head and
    collars do, and yet moves the joints by no more than the usual error of their places.
    """
    weights = channel_weights(skeleton).to(found.device)
    features = (functional.smooth_l1_loss(found, target, reduction="none") * weights).mean()
    velocity = functional.smooth_l1_loss(found.diff(dim=1), target.diff(dim=1), reduction="none") * weights
    error, own = (found - target) * std, positions(skeleton)
    places = error[..., own].unflatten(-1, (-1, 3))
    joints = _length(places).mean()
    drift = error[..., ROOT].cumsum(1).abs().mean()
    bones = _bone_error(places, (target * std + mean)[..., own].unflatten(-1, (-1, 3)), skeleton)
    feet = _feet_error(found * std + mean, target * std + mean, skeleton)
    total = features + VELOCITY_WEIGHT * velocity.mean() + JOINT_WEIGHT * joints + BONE_WEIGHT * bones
    total = total + DRIFT_WEIGHT * drift + FEET_WEIGHT * feet
    return {"loss": total, "features": features, "joints": joints, "bones": bones, "drift": drift, "feet": feet}


def joint_error(found: Tensor, target: Tensor, std: Tensor, skeleton: Skeleton = HUMANML3D) -> Tensor:
    """Mean distance of the joint positions of standardised features (B, T, F), in the unit of the features."""
    own = positions(skeleton)
    return _length(((found - target) * std)[..., own].unflatten(-1, (-1, 3))).mean()


def foot_steps(features: Tensor, skeleton: Skeleton = HUMANML3D) -> Tensor:
    """How the four foot joints move over the ground: (B, T, F) in their own units to (B, T - 1, 4, 3) a frame.

    The root's step and the change of the joint's place around the root add up, as `features.decode` integrates them;
    the axes are left, up and forward of the later frame.
    """
    feet = [4 + 3 * (joint - 1) + axis for joint in skeleton.feet for axis in range(3)]
    places = features[..., feet].unflatten(-1, (-1, 3))
    turn = 2 * features[:, :-1, :1]  # the feature is half the yaw, backwards
    left, up, forward = places[:, :-1].unbind(-1)
    before = torch.stack(
        [turn.cos() * left + turn.sin() * forward, up, turn.cos() * forward - turn.sin() * left], dim=-1
    )
    root = functional.pad(features[:, :-1, None, 1:3], (0, 1))[..., (0, 2, 1)]
    return root + places[:, 1:] - before


def _feet_error(found: Tensor, target: Tensor, skeleton: Skeleton) -> Tensor:
    error = _length(foot_steps(found, skeleton) - foot_steps(target, skeleton))
    return (error * (1 + PLANTED * target[:, :-1, CONTACTS])).mean()


def _bone_error(error: Tensor, places: Tensor, skeleton: Skeleton) -> Tensor:
    """Mean over the bones of the error of their vector by how much it varies in the batch, from (B, T, J - 1, 3)."""
    limbs = [(parent - 1, child) for child, parent in enumerate(skeleton.parents) if parent > 0]
    parents, children = zip(*limbs, strict=True)
    wrong = _length(error[..., children, :] - error[..., parents, :])
    bones = (places[..., children, :] - places[..., parents, :]).flatten(0, 1)
    varies = (bones - bones.mean(0)).square().sum(-1).mean(0).sqrt()
    return (wrong / varies.maximum(STIFF * _length(bones).mean(0))).mean()


def _length(vectors: Tensor) -> Tensor:
    """Euclidean length of (..., 3), with a gradient at zero."""
    return (vectors.square().sum(-1) + 1e-8).sqrt()
