"""The corpus judged by numbers, next to captured takes, and by looking: strips of the actions on one sheet.

python benchmarks/corpus.py --dataset data/corpus --cmu path/to/cmu_mocap    # the table
python benchmarks/corpus.py --sheet out/actions.png --actions wave bow       # the sheet, also with --robot g1

Every motion is measured as the models see it: encoded, in half precision, and decoded. Captured takes are scaled to the
leg length of the corpus. The Frechet distance compares windows of 2 s with those of every other captured take; the row
of captured takes holds the takes in between, and so shows what two halves of one source differ by.
"""

import json
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
import tyro

from benchmarks.corpus_sheet import draw_sheet, human_figures, robot_figures
from generator.corpus import body
from generator.corpus import pose as poses
from generator.corpus.actions import perform
from generator.corpus.captions import segment_text
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Draw, Voice
from generator.corpus.words import VOCABULARY, entry
from generator.datasets.authored import AuthoredCorpus
from generator.evaluation.metrics import frechet_distance
from ros_free_stack.coherence import leg_length, spatial_coherence, temporal_coherence
from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats import cmu
from ros_free_stack.formats.features import HUMANML3D, decode, encode
from ros_free_stack.messages import Floats
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import FPS, INDEX

if TYPE_CHECKING:
    pass

SOURCES: Final = ("authored", "mixed", "cmu")
CAPTURED: Final = "captured takes"
PIECE: Final = 120
"""Frames of one piece of a captured take."""
WINDOW: Final = 40
COMPONENTS: Final = 32
_MOMENTS: Final = (0, 13, 26, 39)
_DIRECTIONS: Final = (
    ("pelvis", "neck"),
    ("neck", "head"),
    *(
        (f"{side}_{upper}", f"{side}_{lower}")
        for side in body.SIDES
        for upper, lower in (
            ("hip", "knee"), ("knee", "ankle"), ("ankle", "foot"), ("shoulder", "elbow"), ("elbow", "wrist"))
    ),
)  # fmt: skip
_FLAT_M, _SLOW, _MOVING = 0.03, 0.05, 0.25
_ENDS: Final = [INDEX[name] for name in ("left_wrist", "right_wrist", "left_ankle", "right_ankle", "head")]


@dataclass(frozen=True)
class Arguments:
    """Measure a data set, draw a sheet of the actions, or both."""

    dataset: Path | None = None
    """Data set to measure."""
    cmu: Path | None = None
    """Folder of the captured takes to compare with."""
    clips: int = 300
    """Clips of each source, drawn evenly over the data set."""
    sheet: Path | None = None
    """PNG to draw."""
    robot: Literal["", "op3", "g1"] = ""
    """Draw the actions as this robot does them."""
    actions: tuple[str, ...] = ()
    """Draw these actions only."""
    seed: int = 0
    """Draws the parameters and the performers of the sheet."""
    frames: int = 6
    """Figures a strip."""
    json: bool = False
    """Print one JSON object."""


@dataclass(frozen=True)
class Quality:
    """What the numbers say of the clips of one source.

    Attributes:
        clips, minutes: how much was measured.
        foot_skate_cm_s: mean level speed of the ball of a planted foot: both its contact channels on, its ankle within
            3 cm of the lowest place that it keeps in the clip.
        jerk: log dimensionless jerk (Hogan and Sternad 2009) of wrists, ankles and head in windows of 2 s, median over
            those that exceed 0.25 m/s; higher is less smooth.
        temporal, spatial: coherence, see `ros_free_stack.coherence`.
        still: share of joint frames below 5 cm/s.
        frechet: distance of windows of 2 s to those of captured takes, or None without them.
    """

    clips: int
    minutes: float
    foot_skate_cm_s: float
    jerk: float
    temporal: float
    spatial: float
    still: float
    frechet: float | None


def captured(folder: Path) -> tuple[list[Floats], list[Floats]]:
    """Features (120, 263) of pieces of captured takes: every other take as the reference, and the takes in between."""
    halves: tuple[list[Floats], list[Floats]] = ([], [])
    for number, take in enumerate(progress(cmu.index(folder), "captured takes")):
        joints = cmu.read_take(folder, take.name)
        joints = joints * (body.LEG / leg_length(joints))
        for start, end in cmu.sound_spans(joints):
            for first in range(start, end - PIECE, PIECE):
                piece = encode(joints[first : first + PIECE + 1]).astype(np.float16)
                halves[number % 2].append(piece.astype(np.float64))
    return halves


def clips_of(dataset: AuthoredCorpus, source: str, count: int) -> list[Floats]:
    """Features (T, 263) of up to `count` clips of a source, evenly over the data set."""
    clips = [clip for clip in dataset.clips if clip.source == source]
    chosen = np.unique(np.linspace(0, len(clips) - 1, min(count, len(clips))).round().astype(int))
    return [dataset.features(clips[index]).astype(np.float64) for index in chosen]


def measure(clips: list[Floats], reference: list[Floats]) -> Quality:
    """The quality of clips, given as features (T, 263); the reference may be empty."""
    motions = [decode(features) for features in clips]
    speeds = [np.linalg.norm(np.diff(joints, axis=0), axis=-1) * FPS for joints in motions]
    skating = [planted_speed(joints, features) for joints, features in zip(motions, clips, strict=True)]
    return Quality(
        clips=len(clips),
        minutes=sum(len(features) for features in clips) / FPS / 60,
        foot_skate_cm_s=100 * float(np.concatenate(skating).mean()),
        jerk=float(np.median(np.concatenate([log_jerk(joints) for joints in motions]))),
        temporal=float(np.mean([temporal_coherence(joints) for joints in motions])),
        spatial=float(np.mean([spatial_coherence(joints) for joints in motions])),
        still=float(np.mean(np.concatenate([speed.ravel() for speed in speeds]) < _SLOW)),
        frechet=window_distance(reference, clips) if reference else None,
    )


def planted_speed(joints: Floats, features: Floats) -> Floats:
    """(n,) level speeds (m/s) of the balls of planted feet."""
    found = []
    contacts = features[:-1, -len(HUMANML3D.feet) :].reshape(-1, 2, 2).min(axis=-1) > 0.5
    for foot, side in enumerate(("left", "right")):
        height = joints[:-1, INDEX[f"{side}_ankle"], 2]
        planted = contacts[:, foot] & (height < np.percentile(height, 5) + _FLAT_M)
        steps = np.diff(joints[:, INDEX[f"{side}_foot"], :2], axis=0)
        found.append(np.linalg.norm(steps, axis=-1)[planted] * FPS)
    return np.concatenate(found)


def log_jerk(joints: Floats) -> Floats:
    """(n,) ln(D^3 / v^2 * integral of the squared jerk) of the moving ends in windows of D s, v the peak speed."""
    found = []
    for start in range(0, len(joints) - WINDOW + 1, WINDOW):
        path = joints[start : start + WINDOW, _ENDS]
        peak = np.linalg.norm(np.diff(path, axis=0), axis=-1).max(axis=0) * FPS
        jerk = (np.diff(path, 3, axis=0) ** 2).sum(axis=(0, 2)) * FPS**5
        moving = peak > _MOVING
        found.append(np.log((WINDOW / FPS) ** 3 / peak[moving] ** 2 * jerk[moving]))
    return np.concatenate([np.empty(0), *found])


def window_distance(reference: list[Floats], clips: list[Floats]) -> float:
    """Frechet distance between windows of two sets of clips, in the 32 principal components of the reference's."""
    first, second = windows(reference), windows(clips)
    mean = first.mean(axis=0)
    axes = np.linalg.svd(first - mean, full_matrices=False)[2][:COMPONENTS]
    return frechet_distance((first - mean) @ axes.T, (second - mean) @ axes.T)


def windows(clips: list[Floats]) -> Floats:
    """(n, 160) four moments of each window of 2 s, one window a second.

    Of each moment the directions of trunk, head and limbs as seen from the heading, which do not depend on the
    proportions of a body, and the root's velocity and height (m/s, m).
    """
    found = [np.empty((0, 4 * (3 * len(_DIRECTIONS) + 4)))]
    start, end = np.array([[INDEX[a], INDEX[b]] for a, b in _DIRECTIONS]).T
    for features in clips:
        places = np.concatenate([np.zeros((len(features), 1, 3)), features[:, 4:67].reshape(-1, 21, 3)], axis=1)
        places[:, 0, 1] = features[:, 3]
        bones = places[:, end] - places[:, start]
        bones /= np.linalg.norm(bones, axis=-1, keepdims=True) + 1e-9
        root = features[:, :4] * [2 * FPS, FPS, FPS, 1]
        moments = np.concatenate([bones.reshape(len(features), -1), root], axis=1)
        starts = np.arange(0, len(features) - WINDOW + 1, WINDOW // 2)
        found.append(moments[starts[:, None] + _MOMENTS].reshape(len(starts), found[0].shape[1]))
    return np.concatenate(found)


def table(rows: dict[str, Quality]) -> str:
    """The rows in Markdown."""
    head = ("source", "clips", "minutes", "foot skate, cm/s", "jerk", "TC", "SC", "still", "distance")
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for name, q in rows.items():
        far = "" if q.frechet is None else f"{q.frechet:.2f}"
        lines.append(
            f"| {name} | {q.clips} | {q.minutes:.1f} | {q.foot_skate_cm_s:.1f} | {q.jerk:.2f} | {q.temporal:.3f} "
            f"| {q.spatial:.3f} | {q.still:.0%} | {far} |"
        )
    return "\n".join(lines)


@dataclass(frozen=True)
class Performance:
    """One action as the vocabulary draws it: its words, and joints (T, 22, 3) from shortly before to shortly after."""

    title: str
    joints: Floats


def performance(name: str, seed: int) -> Performance:
    """Perform an action with drawn parameters; the same name and seed give the same bytes."""
    rng = np.random.default_rng((seed, zlib.crc32(name.encode())))
    params = entry(name).sample(Draw(rng, brief=True))
    scene, start = Scene(seed=int(rng.integers(2**31))), 0.0
    scene.time = 0.1
    if name == "stand_up":
        start = perform(scene, "sit_down")
    perform(scene, name, **params)
    words = segment_text(entry(name).phrase(params, Voice(), rng)).removeprefix("a person ")
    joints = poses.joints(scene.solve(tail=0.1))[round(start * FPS) :]
    values = ", ".join(f"{key}={value}" for key, value in params.items())
    return Performance(f"{name}({values}): {words}", joints)


def _measured(arguments: Arguments) -> dict[str, Quality]:
    reference, rest = captured(arguments.cmu) if arguments.cmu else ([], [])
    rows: dict[str, Quality] = {}
    if arguments.dataset:
        dataset = AuthoredCorpus.open(arguments.dataset)
        for source in progress([s for s in SOURCES if dataset.manifest["sources"].get(s)], "sources"):
            rows[source] = measure(clips_of(dataset, source, arguments.clips), reference)
    if rest:
        rows[CAPTURED] = measure(rest, reference)
    return rows


def _drawn(arguments: Arguments, path: Path) -> list[str]:
    retargeter = None
    if arguments.robot:
        from retarget.pipeline import Retargeter

        retargeter = Retargeter(load_robot(arguments.robot))
    strips = []
    for name in progress(arguments.actions or tuple(VOCABULARY), "strips"):
        shown = performance(name, arguments.seed)
        if retargeter is None:
            strips.append((shown.title, human_figures(shown.joints, arguments.frames)))
        else:
            strips.append((shown.title, robot_figures(retargeter, shown.joints, arguments.frames)))
    draw_sheet(strips, path)
    return [title for title, _ in strips]


def main(arguments: Arguments) -> None:
    """Print the table, write the sheet."""
    if not (arguments.dataset or arguments.cmu or arguments.sheet):
        raise InvalidOption("corpus", "nothing to do: give --dataset, --cmu or --sheet")
    if arguments.clips < 1 or arguments.frames < 1:
        raise InvalidOption("clips, frames", f"expected at least 1, found {arguments.clips}, {arguments.frames}")
    rows = _measured(arguments)
    strips = _drawn(arguments, arguments.sheet) if arguments.sheet else []
    if arguments.json:
        result: dict[str, Any] = {"rows": {name: asdict(quality) for name, quality in rows.items()}, "strips": strips}
        print(json.dumps(result))
    elif rows:
        print(table(rows))


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
