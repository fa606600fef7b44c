"""Joining generated frames to given ones: placed on the floor where these are, without a jump in place or velocity."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BLEND: Final = 8
"""Frames over which the difference between given and generated poses decays."""


def stitch(before: Floats, window: Floats, after: Floats) -> tuple[Floats, Floats]:
    """The middle of a generated window, joined to the given motions that its ends repeat.

    At either end the difference in place and velocity between given and generated frames decays over `BLEND` frames
    of the middle (inertialisation, Bollo, GDC 2018); given frames do not change, but `after` moves over the floor as a
    whole to where the middle leads.

    Args:
        before: (P, 22, 3) given frames before the middle; P is 0 or at least 2.
        window: (P + M + Q, 22, 3) generated frames, M >= 2.
        after: (Q, 22, 3) given frames after the middle; Q is 0 or at least 2.

    Returns:
        (M, 22, 3) the middle and (Q, 22, 3) `after` in its new place.
    """
    first, last = len(before), len(window) - len(after)
    if len(before):
        window = placed(window, window[:first], before)
    middle = window[first:last].copy()
    if len(before):
        middle += _decay(before[-2:], window[first - 2 : first], len(middle))
    if len(after):
        after = placed(after, after, window[last:])
        middle += _decay(after[1::-1], window[last + 1 : last - 1 : -1], len(middle))[::-1]
    return middle, after


def placed(motion: Floats, own: Floats, onto: Floats) -> Floats:
    """The motion turned and moved over the floor as `own` (N, 22, 3) has to be to lie best on `onto` (N, 22, 3).

    Least squares over all joints in the plane (Kabsch).
    """
    centre, there = own[..., :2].mean(axis=(0, 1)), onto[..., :2].mean(axis=(0, 1))
    a, b = (own[..., :2] - centre).reshape(-1, 2), (onto[..., :2] - there).reshape(-1, 2)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    c, s = np.cos(angle), np.sin(angle)
    out = motion.copy()
    out[..., :2] = (motion[..., :2] - centre) @ np.array([[c, s], [-s, c]]) + there
    return out


def _decay(given: Floats, generated: Floats, frames: int) -> Floats:
    """(frames, 22, 3) quintic from the difference at a joint to nothing.

    Args:
        given: (2, 22, 3) the last frame but one and the last one before the joint.
        generated: (2, 22, 3) the generated frames in the place of these.
        frames: how many there are; those beyond `BLEND` are zero.
    """
    span = min(BLEND, frames) + 1
    s = (np.arange(1, frames + 1) / span).clip(max=1)[:, None, None]
    place = given[1] - generated[1]
    rate = (place - given[0] + generated[0]) * span
    return place * (1 - s**3 * (10 - 15 * s + 6 * s**2)) + rate * (s - s**3 * (6 - 8 * s + 3 * s**2))
