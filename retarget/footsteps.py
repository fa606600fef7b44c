"""Clean footsteps from noisy feet: standing feet locked and flat, swinging feet lifted, flat touch-downs.

A robot's short flat soles roll over whatever a human foot does on its way to and from the floor, so the plan keeps the
human's footholds, times and swing paths, and little of the foot's own tilt.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter1d

from retarget.human import pitch_rotation, yaw_rotation
from retarget.timeline import minimum_jerk
from ros_free_stack.messages import Bools, Floats

SWING_PITCH = 0.35
"""Share of the human's foot pitch that a swinging foot keeps."""
CLEARANCE_M = 0.045
"""Height of the sole at mid-swing, at human size."""
SHORTEST_S = 0.08
"""Shorter stances are dropped and shorter swings filled."""
SHORTEST_FLIGHT_S = 0.10
"""Shorter times without any contact are gaps of the detection, not flight."""


@dataclass(frozen=True)
class FootPath:
    """One foot over time: `ankle` (N, 3) m, `yaw` (N,) rad, `pitch` (N,) rad, `contact` (N,)."""

    ankle: Floats
    yaw: Floats
    pitch: Floats
    contact: Bools

    @property
    def rotation(self) -> Floats:
        """(N, 3, 3) orientation of the sole; the identity is flat and facing x."""
        return yaw_rotation(self.yaw) @ pitch_rotation(self.pitch)


def runs(mask: Bools) -> list[tuple[int, int]]:
    """(start, end) of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def plan_contacts(contacts: Bools, heights: Floats, hold: Bools, fps: float) -> Bools:
    """(N, F) contacts without gaps: every frame has a foot down unless it belongs to a real flight.

    Args:
        contacts: (N, F) detected contacts.
        heights: (N, F) ankle heights, to choose the foot that stands where none was detected.
        hold: (N,) frames in which all feet stand.
        fps: frames a second.
    """
    planned = contacts.copy()
    planned[hold] = True
    for start, end in runs(np.asarray(~planned.any(axis=1))):
        if end - start < SHORTEST_FLIGHT_S * fps:
            planned[start:end, heights[start:end].mean(axis=0).argmin()] = True
    shortest = SHORTEST_S * fps
    for i in range(planned.shape[1]):
        foot = planned[:, i]
        for start, end in runs(~foot):
            if end - start < shortest:
                foot[start:end] = True
        for start, end in runs(foot):
            if end - start < shortest:
                foot[start:end] = False
    return planned


def clean_path(path: FootPath, *, ankle_height: float, clearance: float, corners: Floats) -> FootPath:
    """Lock the stances of a path and give its swings clearance.

    Args:
        path: the scaled human foot, with its planned contacts.
        ankle_height: height of the ankle above a flat sole, m.
        clearance: height of the sole at mid-swing, m.
        corners: (4, 3) sole corners from the ankle, in the sole's frame, m.
    """
    shift, turn = np.zeros_like(path.ankle), np.zeros((len(path.yaw), 1))
    for start, end in runs(path.contact):
        stance = slice(start, end)
        foothold = np.array([*np.median(path.ankle[stance, :2], axis=0), ankle_height])
        shift[stance] = foothold - path.ankle[stance]
        turn[stance, 0] = np.median(path.yaw[stance]) - path.yaw[stance]
    ankle = path.ankle + _bridged(shift, path.contact)
    yaw = path.yaw + _bridged(turn, path.contact)[:, 0]
    frames_away = np.asarray(distance_transform_edt(~path.contact))
    fade = np.clip((frames_away - 2) / 8, 0, 1)
    pitch = gaussian_filter1d(SWING_PITCH * path.pitch * fade, 1.5) * ~path.contact
    return _lifted(FootPath(ankle, yaw, pitch, path.contact), clearance, corners)


def _bridged(values: Floats, known: Bools) -> Floats:
    """(N, D) values with every unknown stretch filled smoothly from the known values around it."""
    filled = values.copy()
    for start, end in runs(~known):
        before = values[start - 1] if start > 0 else values[min(end, len(values) - 1)]
        after = values[end] if end < len(values) else before
        share = minimum_jerk(np.arange(1, end - start + 1) / (end - start + 1))
        filled[start:end] = before + share[:, None] * (after - before)
    return filled


def _lifted(path: FootPath, clearance: float, corners: Floats) -> FootPath:
    """Raise swings so that the lowest corner follows at least a smooth bump of height `clearance`."""
    lowest = path.ankle[:, 2] + np.einsum("nij,cj->nci", path.rotation, corners)[..., 2].min(axis=1)
    wanted = np.zeros(len(lowest))
    for start, end in runs(~path.contact):
        phase = np.arange(1, end - start + 1) / (end - start + 1)
        wanted[start:end] = clearance * np.minimum(1.0, 16 * (phase * (1 - phase)) ** 2)
    lift = gaussian_filter1d(np.maximum(wanted - lowest, 0.0), 1.5) * ~path.contact
    lift = np.maximum(lift, -lowest)
    ankle = path.ankle.copy()
    ankle[:, 2] += lift
    return FootPath(ankle, path.yaw, path.pitch, path.contact)
