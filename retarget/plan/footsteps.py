"""Clean footsteps from noisy feet: standing feet locked and flat, swinging feet lifted, flat touch-downs.

A robot's short flat soles roll over whatever a human foot does on its way to and from the floor, so the plan keeps the
human's footholds, times and swing paths, and little of the foot's own tilt.
"""

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter1d
from scipy.spatial import ConvexHull

from retarget.clip.human import pitch_rotation, yaw_rotation
from retarget.clip.runs import runs
from retarget.plan.timeline import minimum_jerk
from ros_free_stack.messages import Bools, Floats

SWING_PITCH = 0.35
"""Share of the human's foot pitch that a swinging foot keeps."""
CLEARANCE_M = 0.045
"""Height of the sole at mid-swing, at human size."""
SHORTEST_S = 0.08
"""Shorter stances are dropped and shorter swings filled."""
SHORTEST_FLIGHT_S = 0.10
"""Shorter times without any contact are gaps of the detection, not flight."""
LONGEST_HAND_OVER_S = 0.5
"""A foot that lifts later than this after the other has landed does not take turns with it."""
SWING_SHARE = 0.15
LIFT_OFF, LANDED = 0.06, 0.88
"""Phases of a swing between which the foot travels over the floor: it rises first and comes down last."""
LIFTS = 4
RISE_S = 0.3
"""Longest time from a standing foot to one that has its clearance and follows the human's own path, and back."""


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


@dataclass(frozen=True)
class HandOver:
    """A change of the standing foot: foot `to` lands at frame `landed`, foot `off` lifts at frame `lifted`."""

    to: int
    off: int
    landed: int
    lifted: int


def hand_overs(contacts: Bools, fps: float) -> list[HandOver]:
    """Every landing of a foot that is soon followed by, or that soon follows, the lift-off of another."""
    found: list[HandOver] = []
    for to, off in permutations(range(contacts.shape[1]), 2):
        lifts = [end for _, end in runs(contacts[:, off]) if end < len(contacts)]
        for landed in (start for start, _ in runs(contacts[:, to]) if start > 0):
            near = [lift for lift in lifts if -SHORTEST_FLIGHT_S <= (lift - landed) / fps <= LONGEST_HAND_OVER_S]
            if near:
                found.append(HandOver(to, off, landed, near[0]))
    return found


def prolong_double_support(contacts: Bools, fps: float, wanted_s: float) -> Bools:
    """(N, F) contacts in which a foot lands earlier and the other one lifts later, until both stand for `wanted_s`.

    No swing gives up more than `SWING_SHARE` of its time at either end.
    """
    longer = contacts.copy()
    for change in hand_overs(contacts, fps):
        missing = max(round((wanted_s * fps - (change.lifted - change.landed)) / 2), 0)
        before = next(end - start for start, end in runs(~contacts[:, change.to]) if end == change.landed)
        after = next(end - start for start, end in runs(~contacts[:, change.off]) if start == change.lifted)
        longer[change.landed - min(missing, int(SWING_SHARE * before)) : change.landed, change.to] = True
        longer[change.lifted : change.lifted + min(missing, int(SWING_SHARE * after)), change.off] = True
    return longer


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


def spread_footholds(paths: list[FootPath], corners: list[Floats], gap: float) -> list[FootPath]:
    """Paths whose feet never land closer than `gap` m to a standing sole: the foothold is moved away as a whole.

    Swings are moved along.

    Args:
        paths: the scaled human feet, with their planned contacts.
        corners: (4, 3) of each sole from its ankle, in the sole's frame, m.
        gap: m.
    """
    ankles = [path.ankle.copy() for path in paths]
    landings = [(start, end, i) for i, path in enumerate(paths) for start, end in runs(path.contact) if start > 0]
    for start, end, i in sorted(landings):
        for k, other in enumerate(paths):
            standing = next(((a, b) for a, b in runs(other.contact) if a < start < b), None)
            if k != i and standing:
                here = _sole_outline(ankles[i][start:end], paths[i].yaw[start:end], corners[i])
                there = _sole_outline(ankles[k][slice(*standing)], other.yaw[slice(*standing)], corners[k])
                ankles[i][start:end, :2] += _way_apart(here, there, gap)
    moved: list[FootPath] = []
    for path, ankle in zip(paths, ankles, strict=True):
        away = carried(ankle - path.ankle, path.contact)
        moved.append(replace(path, ankle=path.ankle + away))
    return moved


def carried(moves: Floats, contact: Bools) -> Floats:
    """(N, D) `moves` (N, D) of the stances, and smoothly from one stance's last to the next one's first between."""
    found = np.where(contact[:, None], moves, 0.0)
    for start, end in runs(~contact):
        before = found[start - 1] if start else found[min(end, len(found) - 1)]
        after = found[end] if end < len(found) else before
        share = minimum_jerk(np.arange(1, end - start + 1) / (end - start + 1))[:, None]
        found[start:end] = before + share * (after - before)
    return found


def _sole_outline(ankle: Floats, yaw: Floats, corners: Floats) -> Floats:
    """(4, 2) corners on the floor of a foot that stands at the median of its path."""
    turn = yaw_rotation(np.array(np.median(yaw)))[:2, :2]
    return np.median(ankle[:, :2], axis=0) + corners[:, :2] @ turn.T


def _way_apart(moving: Floats, fixed: Floats, gap: float) -> Floats:
    """(2,) shortest move that leaves `gap` between two convex outlines, by their separating axis."""
    normals = np.concatenate([ConvexHull(outline).equations[:, :2] for outline in (moving, fixed)])
    normals = np.concatenate([normals, -normals])
    gaps = (moving @ normals.T).min(axis=0) - (fixed @ normals.T).max(axis=0)
    best = int(gaps.argmax())
    return max(gap - float(gaps[best]), 0.0) * normals[best]


def clean_path(path: FootPath, *, ankle_height: float, clearance: float, corners: Floats, fps: float) -> FootPath:
    """Lock the stances of a path, join them by smooth swings and give those clearance.

    A swing is a smooth step from foothold to foothold plus the human's own deviation from one, which is faded out
    toward the ends: the foot leaves and lands at rest.

    Args:
        path: the scaled human foot, with its planned contacts.
        ankle_height: height of the ankle above a flat sole, m.
        clearance: height of the sole at mid-swing, m.
        corners: (4, 3) sole corners from the ankle, in the sole's frame, m.
        fps: frames a second.
    """
    own = np.column_stack([path.ankle, path.yaw])
    held = own.copy()
    for start, end in runs(path.contact):
        stance = slice(start, end)
        held[stance] = [*np.median(path.ankle[stance, :2], axis=0), ankle_height, np.median(path.yaw[stance])]
    moved = held.copy()
    for start, end in runs(~path.contact):
        moved[start:end] = _swing(own, held, start, end, fps)
    ankle, yaw = moved[:, :3], moved[:, 3]
    frames_away = np.asarray(distance_transform_edt(~path.contact))
    fade = np.clip((frames_away - 2) / 8, 0, 1)
    pitch = gaussian_filter1d(SWING_PITCH * path.pitch * fade, 1.5) * ~path.contact
    return _lifted(FootPath(ankle, yaw, pitch, path.contact), clearance, corners, fps)


def _swing(own: Floats, held: Floats, start: int, end: int, fps: float) -> Floats:
    """(end - start, D) values from those held before `start` to those held at `end`, as much as possible `own`."""
    if end - start == len(own):
        return own
    fade = min(RISE_S * fps, (end - start) / 2)
    first, last = max(start - 1, 0), min(end, len(own) - 1)
    step = np.arange(1, end - start + 1)
    share = minimum_jerk((step / (end - start + 1) - LIFT_OFF) / (LANDED - LIFT_OFF))[:, None]
    known = [k for k in (start - 1, end) if 0 <= k < len(own)]
    before, after = (held[known[0]] - own[known[0]], held[known[-1]] - own[known[-1]])
    landing = held[first] + share * (held[last] - held[first])
    following = own[start:end] + before + share * (after - before)
    away = np.minimum(step if start > 0 else fade, step[::-1] if end < len(own) else fade)
    free = minimum_jerk(away / fade)
    # Over the floor a foot goes its own way later than up: it must not scrape.
    return landing + np.column_stack([free**2, free**2, free, free**2]) * (following - landing)


def _rise(count: int, fps: float) -> Floats:
    """(count,) height of a swinging foot, as a share of its clearance."""
    step = np.arange(1, count + 1)
    phase = np.minimum(np.minimum(step, step[::-1]) / min(count + 1, 2 * RISE_S * fps), 0.5)
    return 16 * (phase * (1 - phase)) ** 2


def _lifted(path: FootPath, clearance: float, corners: Floats, fps: float) -> FootPath:
    """Raise swings so that the lowest corner follows at least a smooth bump of height `clearance`."""
    lowest = path.ankle[:, 2] + np.einsum("nij,cj->nci", path.rotation, corners)[..., 2].min(axis=1)
    wanted = np.zeros(len(lowest))
    for start, end in runs(~path.contact):
        wanted[start:end] = clearance * _rise(end - start, fps)
    lift = np.zeros(len(lowest))
    for _ in range(LIFTS):
        # Smoothing takes the tops off: what is still missing is smoothed and added in turn.
        lift += gaussian_filter1d(np.maximum(wanted - lowest - lift, 0.0), 1.5) * ~path.contact
    lift = np.maximum(lift, -lowest)
    ankle = path.ankle.copy()
    ankle[:, 2] += lift
    return FootPath(ankle, path.yaw, path.pitch, path.contact)
