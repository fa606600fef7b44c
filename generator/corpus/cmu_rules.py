"""How takes of the CMU database are cut into excerpts, by what their descriptions say.

Each take is retargeted to the common body and cut by plain kinematics: the speed of the pelvis for walking and
running, its height for jumps and sitting, the speed of feet and wrists for kicks and punches.
"""

import re
from collections.abc import Callable
from itertools import pairwise
from typing import Any, Final

import numpy as np
from scipy.ndimage import gaussian_filter1d

from generator.corpus.excerpts import Excerpt, Recording
from generator.corpus.joins import length
from ros_free_stack.skeleton import FPS, INDEX

MIN_S: Final = 1.0
MAX_S: Final = 6.0

Rule = Callable[[Recording], list[Excerpt]]


def rule_for(description: str) -> Rule | None:
    """What cuts a take of that description, None where no rule knows it."""
    return next((rule for pattern, rule in _RULES if re.search(pattern, description)), None)


def _spans(mask: np.ndarray, low: float = 1.4, high: float = MAX_S) -> list[tuple[int, int]]:
    """Runs of True of at least `low` seconds, cut into equal pieces of at most `high` seconds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    spans: list[tuple[int, int]] = []
    for start, stop in edges.reshape(-1, 2):
        if stop - start >= low * FPS:
            pieces = int(np.ceil((stop - start) / (high * FPS)))
            spans += pairwise(np.linspace(start, stop, pieces + 1).astype(int).tolist())
    return spans


def _around(frame: int, before_s: float, after_s: float, frames: int) -> tuple[int, int]:
    return max(0, frame - round(before_s * FPS)), min(frames, frame + round(after_s * FPS))


def _gait(recording: Recording, span: tuple[int, int], ordinary: float) -> dict[str, Any]:
    """Direction, curve (deg) and relative speed of a window of walking."""
    root = gaussian_filter1d(recording.joints[span[0] : span[1], 0, :2], 5, axis=0)
    velocity = np.gradient(root, axis=0) * FPS
    course = np.unwrap(np.arctan2(velocity[:, 1], velocity[:, 0]))
    heading = recording.pose["heading"][span[0] : span[1]]
    offset = float(np.degrees(np.angle(np.mean(np.exp(1j * (course - heading))))))
    direction = (
        "forward" if abs(offset) < 50 else "backward" if abs(offset) > 130 else "left" if offset > 0 else "right"
    )
    speed = float(np.median(np.linalg.norm(velocity, axis=-1)))
    size = max(2, len(course) // 6)
    curve = float(np.degrees(np.mean(course[-size:]) - np.mean(course[:size])))
    return {"direction": direction, "curve": round(curve, 1), "speed": round(speed / ordinary, 3)}


def _walk(recording: Recording, **options: Any) -> list[Excerpt]:
    spans = _spans(recording.speeds["travel"] > 0.35)
    return [recording.excerpt(s, "walk", _gait(recording, s, 1.25), cyclic=True, **options) for s in spans]


def _stride(recording: Recording) -> list[Excerpt]:
    return _walk(recording, words=("<walk> forward with long strides", "<take> long steps forward", "<stride> forward"))


def _run(recording: Recording) -> list[Excerpt]:
    excerpts = []
    for span in _spans(recording.speeds["travel"] > 0.6, low=MIN_S):
        params = _gait(recording, span, 2.4)
        del params["direction"]
        excerpts.append(recording.excerpt(span, "jog", {**params, "speed": 1.21}, cyclic=True))
    return excerpts


def _peaks(signal: np.ndarray, floor: float, apart_s: float) -> list[int]:
    from scipy.signal import find_peaks

    return find_peaks(signal, height=floor, distance=max(1, round(apart_s * FPS)))[0].tolist()


def _jump(recording: Recording) -> list[Excerpt]:
    height = recording.height
    feet = recording.joints[:, [INDEX["left_foot"], INDEX["right_foot"]], 2].min(1)
    air = np.where(feet > 0.07, height, 0.0)
    excerpts = []
    for peak in _peaks(air, float(np.median(height)) + 0.08, 1.2):
        start, stop = _around(peak, 1.2, 1.1, len(height))
        moved = recording.joints[min(stop, peak + 8) - 1, 0, :2] - recording.joints[max(start, peak - 8), 0, :2]
        heading = recording.pose["heading"][peak]
        distance = float(moved @ [np.cos(heading), np.sin(heading)])
        rise = float(height[peak] - np.median(height))
        params = {"count": 1, "height": round(rise, 2), "distance": round(distance, 2) if abs(distance) > 0.25 else 0.0}
        excerpts.append(recording.excerpt((start, stop), "jump", params))
    return excerpts


def _kick(recording: Recording) -> list[Excerpt]:
    fastest = {side: recording.speeds[f"{side}_foot"] for side in ("left", "right")}
    side = max(fastest, key=lambda s: float(fastest[s].max()))
    frame = int(fastest[side].argmax())
    span = _around(frame, 1.0, 1.1, length(recording.pose))
    words = ("<kick> a ball with {leg}", "<kick> a ball with {foot}", "<kick> a ball")
    words = tuple(w.format(leg=f"the {side} leg", foot=f"the {side} foot") for w in words)
    params = {"side": side, "height": "low", "direction": "forward", "count": 1}
    return [recording.excerpt(span, "kick", params, words=words)]


def _punch(recording: Recording) -> list[Excerpt]:
    wrists = {side: recording.speeds[f"{side}_wrist"] for side in ("left", "right")}
    active = gaussian_filter1d(np.maximum(wrists["left"], wrists["right"]), 8) > 0.7
    excerpts = []
    for span in _spans(active, low=1.8, high=3.6):
        left, right = (float(np.percentile(wrists[side][span[0] : span[1]], 95)) for side in ("left", "right"))
        if max(left, right) < 2.0:
            continue
        if max(left, right) > 1.7 * min(left, right):
            side = "left" if left > right else "right"
            words = (f"<punch> with the {side} hand repeatedly", f"<throw> punches with the {side} hand")
            excerpts.append(recording.excerpt(span, "punch", {"side": side}, words=words))
        else:
            words = ("<box>", "<throw> punches", "<practice> boxing", "<shadow> box", "<throw> several punches")
            excerpts.append(recording.excerpt(span, "alternate", {}, words=words, cyclic=True))
    return excerpts


def _sit(recording: Recording) -> list[Excerpt]:
    height = gaussian_filter1d(recording.joints[:, 0, 2], 3)
    low, high = np.percentile(height, [4, 96])
    if high - low < 0.15:
        return []
    seated = height < 0.5 * (low + high)
    changes = np.flatnonzero(np.diff(seated.astype(int)))
    excerpts, frames = [], len(height)
    downs = [int(c) for c in changes if seated[c + 1]]
    ups = [int(c) for c in changes if not seated[c + 1]]
    for down in downs:
        excerpts.append(recording.excerpt(_around(down, 1.3, 1.3, frames), "sit_down", {}, role="last"))
        up = next((u for u in ups if u > down), None)
        if up is not None and up - down < 3.6 * FPS:
            span = (max(0, down - 24), min(frames, up + 24))
            excerpts.append(recording.excerpt(span, "sit_and_stand", {}))
    excerpts += [recording.excerpt(_around(up, 1.1, 1.4, frames), "stand_up", {}, role="first") for up in ups]
    return excerpts


def _balance(recording: Recording) -> list[Excerpt]:
    feet = {side: recording.joints[:, INDEX[f"{side}_foot"], 2] for side in ("left", "right")}
    excerpts = []
    for stands, lifted in (("left", "right"), ("right", "left")):
        for span in _spans(feet[lifted] - feet[stands] > 0.12, low=1.6):
            words = (f"<balance> on the {stands} leg with outstretched arms", f"<stand> on the {stands} leg, arms out")
            excerpts.append(recording.excerpt(span, "balance", {"side": stands}, words=words))
    return excerpts


def _at_head(recording: Recording) -> list[Excerpt]:
    """Drinking: a wrist that stays near the head."""
    head = recording.joints[:, INDEX["head"]]
    excerpts = []
    for side in ("left", "right"):
        near = np.linalg.norm(recording.joints[:, INDEX[f"{side}_wrist"]] - head, axis=-1) < 0.27
        for start, stop in _spans(near, low=0.4, high=3.5):
            span = max(0, start - 20), min(len(head), stop + 20)
            excerpts.append(recording.excerpt(span, "drink", {"side": side}))
    return excerpts


def _wipe(recording: Recording) -> list[Excerpt]:
    wrists = {side: recording.speeds[f"{side}_wrist"] for side in ("left", "right")}
    active = gaussian_filter1d(np.maximum(wrists["left"], wrists["right"]), 8) > 0.35
    excerpts = []
    for span in _spans(active, low=2.0, high=4.5):
        left, right = (float(np.mean(wrists[side][span[0] : span[1]])) for side in ("left", "right"))
        high = recording.joints[span[0] : span[1], [INDEX["left_wrist"], INDEX["right_wrist"]], 2].max(1)
        if float(np.median(high)) > 1.0:
            side = "left" if left > right else "right"
            excerpts.append(recording.excerpt(span, "wipe", {"side": side}, cyclic=True))
    return excerpts


def _windows(name: str, words: tuple[str, ...], arms: str, legs: str) -> Rule:
    """A rule for takes that are one action throughout: windows of three to five seconds."""

    def rule(recording: Recording) -> list[Excerpt]:
        busy = gaussian_filter1d(np.maximum(recording.speeds["left_wrist"], recording.speeds["right_wrist"]), 10) > 0.3
        spans = _spans(busy, low=2.0, high=4.8)
        return [recording.excerpt(s, name, {}, words=words, arms=arms, legs=legs, cyclic=True) for s in spans]

    return rule


_RULES: Final[tuple[tuple[str, Rule], ...]] = (
    (r"exaggerated stride", _stride),
    (r"^(slow )?walk(/stride)?$|^navigate|^Start Walk", _walk),
    (r"^run(/jog)?$", _run),
    (r"^(forward )?jump$", _jump),
    (r"kick ball", _kick),
    (r"^boxing$|^punch", _punch),
    (r"^sit on", _sit),
    (r"^balance on one leg", _balance),
    (r"drink soda", _at_head),
    (r"wash windows", _wipe),
    (
        r"basketball - (forward|backward|sideways) dribble",
        _windows(
            "dribble",
            ("<dribble> a ball", "<walk> while dribbling a ball", "<dribble> a basketball"),
            "dribbles a ball",
            "walks",
        ),
    ),
    (
        r"^direct traffic",
        _windows(
            "direct_traffic",
            ("<direct> traffic", "<direct> traffic with both arms", "<signal> with both arms"),
            "directs traffic",
            "",
        ),
    ),
    (
        r"^swordplay",
        _windows(
            "swordplay",
            ("<swing> a sword", "<fight> with a sword", "<practice> with a sword"),
            "swings a sword",
            "steps around",
        ),
    ),
    (
        r"^dance -",
        _windows(
            "ballet",
            ("<dance> ballet", "<perform> a ballet dance", "<dance> gracefully"),
            "moves gracefully",
            "dances ballet",
        ),
    ),
)
