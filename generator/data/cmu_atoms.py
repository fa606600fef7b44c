"""Labelled atoms of real motion: single deeds cut out of CMU takes whose description is clear.

Each take is retargeted to the common body and cut by plain kinematics: the speed of the pelvis for walking and
running, its height for jumps and sitting, the speed of feet and wrists for kicks and punches.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.ndimage import gaussian_filter1d

from generator.data import pose as poses
from generator.data.joins import cut, length
from generator.data.mirror import mirror_words
from generator.data.pose import Pose
from generator.data.vocabulary import VOCABULARY
from generator.data.vocabulary.english import Phrase, gerund, third_person
from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats import cmu
from ros_free_stack.skeleton import FPS, INDEX

MIN_S: Final = 1.0
MAX_S: Final = 6.0
_VERB = re.compile(r"<(\w+)>")
_CAPTION = re.compile(
    r"^(?:an? |the |this )?(?:person|man|woman|figure|someone|individual|sim)(?: (?:is|was))? (\w+)(.*)$"
)
_LEG_VERBS = frozenset(("walk", "step", "jump", "run", "jog", "hop", "shuffle", "sway", "move", "take", "turn"))
_SEVERAL = re.compile(r"\b(and|then|while|whilst|before|after|or|as|with|when|video|all|around)\b|,")


@dataclass(frozen=True)
class Atom:
    """One deed of real motion.

    Attributes:
        name: action of the vocabulary, or a name of its own where the catalogue has none (then with `words`).
        params: what was measured of it, as the vocabulary's parameters.
        pose: the motion.
        take: where it was cut from.
        words: real or extra wordings (verbs in angle brackets), used beside the vocabulary's.
        arms, legs: what the parts do where the vocabulary does not say it.
        cyclic: whether any window of it is the same deed.
        role: "first" or "last" where it can only begin or end a clip (sitting), else "".
    """

    name: str
    params: dict[str, Any]
    pose: Pose
    take: str
    words: tuple[str, ...] = ()
    arms: str = ""
    legs: str = ""
    cyclic: bool = False
    role: str = ""

    @property
    def mirrored(self) -> "Atom":
        """The reflection, in motion and words."""
        return replace(
            self,
            pose=poses.mirror(self.pose),
            params=mirror_params(self.params),
            words=tuple(mirror_words(word) for word in self.words),
            arms=mirror_words(self.arms),
            legs=mirror_words(self.legs),
        )


def mirror_params(params: dict[str, Any]) -> dict[str, Any]:
    """The parameters of the reflected deed: sides swapped, angles to the left turned to the right."""
    out: dict[str, Any] = {
        key: mirror_words(value) if isinstance(value, str) else value for key, value in params.items()
    }
    for key in ("angle", "aside", "curve", "azimuth"):
        if key in params:
            out[key] = -params[key]
    return out


@dataclass(frozen=True)
class _Recording:
    """A take on the common body with the signals that cuts are made by (per frame, SI units).

    `sound` are its stretches of frames without a jump.
    """

    take: str
    pose: Pose
    joints: np.ndarray
    sound: tuple[tuple[int, int], ...]
    speeds: dict[str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, take: str, joints: np.ndarray) -> "_Recording":
        pose = poses.fit(joints)
        places = poses.joints(pose)
        moved = np.linalg.norm(np.gradient(places, axis=0), axis=-1) * FPS
        flat = np.linalg.norm(np.gradient(gaussian_filter1d(places[:, 0, :2], 4, axis=0), axis=0), axis=-1) * FPS
        speeds = {name: gaussian_filter1d(moved[:, i], 1.0) for name, i in INDEX.items()}
        return cls(take, pose, places, cmu.sound_spans(joints), {**speeds, "travel": flat})

    @property
    def height(self) -> np.ndarray:
        return gaussian_filter1d(self.joints[:, 0, 2], 1.0)

    def sound_part(self, start: int, stop: int) -> tuple[int, int]:
        """The longest part of a span without a jump."""
        parts = [(max(start, a), min(stop, b)) for a, b in self.sound if a < stop and b > start]
        return max(parts, key=lambda part: part[1] - part[0], default=(start, start))

    def atom(
        self, span: tuple[int, int], name: str, params: dict[str, Any], *, cyclic: bool = False, **options: Any
    ) -> Atom:
        """A deed; a cyclic one loses what a jump cuts off, while one about a kick's peak is as fast as a jump."""
        span = self.sound_part(*span) if cyclic else span
        return Atom(name, params, cut(self.pose, *span), self.take, cyclic=cyclic, **options)


def load_atoms(folder: Path, takes: Iterable[cmu.Take] | None = None) -> tuple[Atom, ...]:
    """Atoms of all takes that a rule knows, and of the clips whose real captions tell a single deed.

    Raises:
        InvalidFile: the folder has no readable index, or none of its takes gives an atom.
    """
    atoms: list[Atom] = []
    for take in cmu.index(folder) if takes is None else takes:
        rule = next((rule for pattern, rule in _RULES if re.search(pattern, take.description)), None)
        captioned = [clip for clip in take.clips if clip.captions or clip.mirrored_captions]
        if rule is None and not captioned:
            continue
        recording = _Recording.of(take.name, cmu.read_take(folder, take.name))
        atoms += rule(recording) if rule else []
        atoms += [atom for clip in captioned for atom in _captioned(recording, clip)]
    if not atoms:
        raise InvalidFile(folder, "none of its takes gives an atom of motion")
    return tuple(atom for atom in atoms if length(atom.pose) >= MIN_S * FPS)


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


def _gait(recording: _Recording, span: tuple[int, int], ordinary: float) -> dict[str, Any]:
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


def _walk(recording: _Recording, **options: Any) -> list[Atom]:
    spans = _spans(recording.speeds["travel"] > 0.35)
    return [recording.atom(s, "walk", _gait(recording, s, 1.25), cyclic=True, **options) for s in spans]


def _stride(recording: _Recording) -> list[Atom]:
    return _walk(recording, words=("<walk> forward with long strides", "<take> long steps forward", "<stride> forward"))


def _run(recording: _Recording) -> list[Atom]:
    atoms = []
    for span in _spans(recording.speeds["travel"] > 0.6, low=MIN_S):
        params = _gait(recording, span, 2.4)
        del params["direction"]
        atoms.append(recording.atom(span, "jog", {**params, "speed": 1.21}, cyclic=True))
    return atoms


def _peaks(signal: np.ndarray, floor: float, apart_s: float) -> list[int]:
    from scipy.signal import find_peaks

    return find_peaks(signal, height=floor, distance=max(1, round(apart_s * FPS)))[0].tolist()


def _jump(recording: _Recording) -> list[Atom]:
    height = recording.height
    feet = recording.joints[:, [INDEX["left_foot"], INDEX["right_foot"]], 2].min(1)
    air = np.where(feet > 0.07, height, 0.0)
    atoms = []
    for peak in _peaks(air, float(np.median(height)) + 0.08, 1.2):
        start, stop = _around(peak, 1.2, 1.1, len(height))
        moved = recording.joints[min(stop, peak + 8) - 1, 0, :2] - recording.joints[max(start, peak - 8), 0, :2]
        heading = recording.pose["heading"][peak]
        distance = float(moved @ [np.cos(heading), np.sin(heading)])
        rise = float(height[peak] - np.median(height))
        params = {"count": 1, "height": round(rise, 2), "distance": round(distance, 2) if abs(distance) > 0.25 else 0.0}
        atoms.append(recording.atom((start, stop), "jump", params))
    return atoms


def _kick(recording: _Recording) -> list[Atom]:
    fastest = {side: recording.speeds[f"{side}_foot"] for side in ("left", "right")}
    side = max(fastest, key=lambda s: float(fastest[s].max()))
    frame = int(fastest[side].argmax())
    span = _around(frame, 1.0, 1.1, length(recording.pose))
    words = ("<kick> a ball with {leg}", "<kick> a ball with {foot}", "<kick> a ball")
    words = tuple(w.format(leg=f"the {side} leg", foot=f"the {side} foot") for w in words)
    params = {"side": side, "height": "low", "direction": "forward", "count": 1}
    return [recording.atom(span, "kick", params, words=words)]


def _punch(recording: _Recording) -> list[Atom]:
    wrists = {side: recording.speeds[f"{side}_wrist"] for side in ("left", "right")}
    active = gaussian_filter1d(np.maximum(wrists["left"], wrists["right"]), 8) > 0.7
    atoms = []
    for span in _spans(active, low=1.8, high=3.6):
        left, right = (float(np.percentile(wrists[side][span[0] : span[1]], 95)) for side in ("left", "right"))
        if max(left, right) < 2.0:
            continue
        if max(left, right) > 1.7 * min(left, right):
            side = "left" if left > right else "right"
            words = (f"<punch> with the {side} hand repeatedly", f"<throw> punches with the {side} hand")
            atoms.append(recording.atom(span, "punch", {"side": side}, words=words))
        else:
            words = ("<box>", "<throw> punches", "<practice> boxing", "<shadow> box", "<throw> several punches")
            atoms.append(recording.atom(span, "alternate", {}, words=words, cyclic=True))
    return atoms


def _sit(recording: _Recording) -> list[Atom]:
    height = gaussian_filter1d(recording.joints[:, 0, 2], 3)
    low, high = np.percentile(height, [4, 96])
    if high - low < 0.15:
        return []
    seated = height < 0.5 * (low + high)
    changes = np.flatnonzero(np.diff(seated.astype(int)))
    atoms, frames = [], len(height)
    downs = [int(c) for c in changes if seated[c + 1]]
    ups = [int(c) for c in changes if not seated[c + 1]]
    for down in downs:
        atoms.append(recording.atom(_around(down, 1.3, 1.3, frames), "sit_down", {}, role="last"))
        up = next((u for u in ups if u > down), None)
        if up is not None and up - down < 3.6 * FPS:
            span = (max(0, down - 24), min(frames, up + 24))
            atoms.append(recording.atom(span, "sit_and_stand", {}))
    atoms += [recording.atom(_around(up, 1.1, 1.4, frames), "stand_up", {}, role="first") for up in ups]
    return atoms


def _balance(recording: _Recording) -> list[Atom]:
    feet = {side: recording.joints[:, INDEX[f"{side}_foot"], 2] for side in ("left", "right")}
    atoms = []
    for stands, lifted in (("left", "right"), ("right", "left")):
        for span in _spans(feet[lifted] - feet[stands] > 0.12, low=1.6):
            words = (f"<balance> on the {stands} leg with outstretched arms", f"<stand> on the {stands} leg, arms out")
            atoms.append(recording.atom(span, "balance", {"side": stands}, words=words))
    return atoms


def _at_head(recording: _Recording) -> list[Atom]:
    """Drinking: a wrist that stays near the head."""
    head = recording.joints[:, INDEX["head"]]
    atoms = []
    for side in ("left", "right"):
        near = np.linalg.norm(recording.joints[:, INDEX[f"{side}_wrist"]] - head, axis=-1) < 0.27
        for start, stop in _spans(near, low=0.4, high=3.5):
            span = max(0, start - 20), min(len(head), stop + 20)
            atoms.append(recording.atom(span, "drink", {"side": side}))
    return atoms


def _wipe(recording: _Recording) -> list[Atom]:
    wrists = {side: recording.speeds[f"{side}_wrist"] for side in ("left", "right")}
    active = gaussian_filter1d(np.maximum(wrists["left"], wrists["right"]), 8) > 0.35
    atoms = []
    for span in _spans(active, low=2.0, high=4.5):
        left, right = (float(np.mean(wrists[side][span[0] : span[1]])) for side in ("left", "right"))
        high = recording.joints[span[0] : span[1], [INDEX["left_wrist"], INDEX["right_wrist"]], 2].max(1)
        if float(np.median(high)) > 1.0:
            side = "left" if left > right else "right"
            atoms.append(recording.atom(span, "wipe", {"side": side}, cyclic=True))
    return atoms


def _windows(name: str, words: tuple[str, ...], arms: str, legs: str) -> Callable[[_Recording], list[Atom]]:
    """A rule for takes that are one deed throughout: windows of three to five seconds."""

    def rule(recording: _Recording) -> list[Atom]:
        busy = gaussian_filter1d(np.maximum(recording.speeds["left_wrist"], recording.speeds["right_wrist"]), 10) > 0.3
        spans = _spans(busy, low=2.0, high=4.8)
        return [recording.atom(s, name, {}, words=words, arms=arms, legs=legs, cyclic=True) for s in spans]

    return rule


_RULES: Final[tuple[tuple[str, Callable[[_Recording], list[Atom]]], ...]] = (
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


def _captioned(recording: _Recording, clip: cmu.Clip) -> list[Atom]:
    """The clip with those of its real captions that tell a single deed, as one atom; [] where none does."""
    start, stop = recording.sound_part(round(clip.start_s * FPS), round(clip.end_s * FPS))
    said = [*clip.captions, *(mirror_words(caption) for caption in clip.mirrored_captions)]
    words = tuple(dict.fromkeys(word for caption in said if (word := marked_caption(caption))))
    if not words or stop - start < MIN_S * FPS:
        return []
    verb, plainest = _VERB.findall(words[0])[0], Phrase(words[0]).third
    arms, legs = ("", plainest) if verb in _LEG_VERBS else (plainest, "")
    return [Atom(f"{verb} as told", {}, cut(recording.pose, start, stop), recording.take, words, arms, legs)]


def marked_caption(caption: str) -> str:
    """A caption of a single deed as a phrase with its verb marked, or "" where it is not of that form.

    `a person is walking forward.` -> `<walk> forward`
    """
    text = " ".join(caption.lower().rstrip(". ").split())
    match = _CAPTION.match(text)
    if not match or _SEVERAL.search(match[2]) or len(text.split()) > 12:
        return ""
    word, rest = match[1], match[2]
    return next((f"<{verb}>{rest}" for verb in _known_verbs() if word in (third_person(verb), gerund(verb))), "")


def _known_verbs() -> tuple[str, ...]:
    return tuple(
        sorted({verb for entry in VOCABULARY.values() for text in entry.phrases for verb in _VERB.findall(text)})
    )
