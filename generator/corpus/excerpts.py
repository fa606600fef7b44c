"""Excerpts: single actions of captured motion, and the recordings that they are cut out of."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from generator.corpus import pose as poses
from generator.corpus.joins import cut
from generator.corpus.mirror import mirror_words
from generator.corpus.pose import Pose
from ros_free_stack.formats import cmu
from ros_free_stack.skeleton import FPS, INDEX


@dataclass(frozen=True)
class Excerpt:
    """One action of real motion.

    Attributes:
        name: action of the vocabulary, or a name of its own where the catalogue has none (then with `words`).
        params: what was measured of it, as the vocabulary's parameters.
        pose: the motion.
        take: where it was cut from.
        words: real or extra wordings (verbs in angle brackets), used beside the vocabulary's.
        arms, legs: what the parts do where the vocabulary does not say it.
        cyclic: whether any window of it is the same action.
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
    def mirrored(self) -> "Excerpt":
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
    """The parameters of the reflected action: sides swapped, angles to the left turned to the right."""
    out: dict[str, Any] = {
        key: mirror_words(value) if isinstance(value, str) else value for key, value in params.items()
    }
    for key in ("angle", "aside", "curve", "azimuth"):
        if key in params:
            out[key] = -params[key]
    return out


@dataclass(frozen=True)
class Recording:
    """A take on the common body with the signals that cuts are made by (per frame, SI units).

    `sound` are its stretches of frames without a jump.
    """

    take: str
    pose: Pose
    joints: np.ndarray
    sound: tuple[tuple[int, int], ...]
    speeds: dict[str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, take: str, joints: np.ndarray) -> "Recording":
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

    def excerpt(
        self, span: tuple[int, int], name: str, params: dict[str, Any], *, cyclic: bool = False, **options: Any
    ) -> Excerpt:
        """An action; a cyclic one loses what a jump cuts off, while one about a kick's peak is as fast as a jump."""
        span = self.sound_part(*span) if cyclic else span
        return Excerpt(name, params, cut(self.pose, *span), self.take, cyclic=cyclic, **options)
