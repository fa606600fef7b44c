"""Building the corpus: every pair of clips from its own seed, split by the order of actions, written as one folder.

The test set asks for compositions that training never shows: about 8 % of all ordered pairs of actions are held out
for it and 4 % for validation. Which ones depends on their names alone. Clips of a single action are in every split.
"""

import hashlib
import io
import multiprocessing
import os
import shutil
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain, islice, pairwise
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from generator.corpus.cmu_excerpts import load_excerpts
from generator.corpus.compose import ComposedClip, compose_clip, plain
from generator.corpus.excerpts import Excerpt, mirror_params
from generator.corpus.mirror import mirror_words
from generator.corpus.mirrored_features import mirror_features
from generator.datasets.authored import VERSION, clip_to_json
from generator.datasets.dataset import Caption, Clip
from ros_free_stack.console import progress, say
from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import make_folder, write_json
from ros_free_stack.formats.features import CHANNELS, encode, to_float16
from ros_free_stack.skeleton import FPS

TEST_PAIRS: Final = 0.08
VAL_PAIRS: Final = 0.04
SINGLE_TEST: Final = 0.04
SINGLE_VAL: Final = 0.04
WEIGHTS: Final = {"authored": 1.0, "mixed": 1.2, "cmu": 1.5}
"""Real motion is drawn a little more often in training, but a rare action must not look like its few takes alone."""


@dataclass(frozen=True)
class Made:
    """A clip that starts at row 0, with its (length, 263) float16 features, not yet placed in the file."""

    clip: Clip
    rows: np.ndarray


def pair_split(first: str, second: str) -> str:
    """The split that an ordered pair of actions belongs to, from the hash of their names."""
    digest = hashlib.sha256(f"{first} > {second}".encode()).digest()
    share = int.from_bytes(digest[:8], "big") / 2**64
    return "test" if share < TEST_PAIRS else "val" if share < TEST_PAIRS + VAL_PAIRS else "train"


def clip_split(names: tuple[str, ...], chance: float) -> str:
    """The split of a clip with actions in that order; `chance` in [0, 1) decides where a single action goes."""
    if len(names) == 1:
        return "test" if chance < SINGLE_TEST else "val" if chance < SINGLE_TEST + SINGLE_VAL else "train"
    splits = {pair_split(a, b) for a, b in pairwise(names)}
    return next(split for split in ("test", "val", "train") if split in splits)


def make_mirrored_pair(seed: int, number: int, excerpts: tuple[Excerpt, ...] = ()) -> tuple["Made", "Made"]:
    """Clips 2 `number` and 2 `number` + 1 of the corpus with that seed: a performance and its reflection.

    Reflecting costs nothing beside composing, and shows every action with either side.
    """
    rng = np.random.default_rng([seed, number])
    composed = compose_clip(rng, excerpts)
    rows = to_float16(encode(composed.joints))
    split = clip_split(composed.names, float(rng.random()))
    clip = _label(composed, 2 * number, split, len(rows))
    return Made(clip, rows), Made(mirror_clip(clip, 2 * number + 1), mirror_features(rows))


def mirror_clip(clip: Clip, index: int) -> Clip:
    """The labels of a reflected clip, under another number."""
    segments = tuple(
        replace(
            segment,
            text=mirror_words(segment.text),
            arms=mirror_words(segment.arms),
            legs=mirror_words(segment.legs),
            actions=tuple((name, mirror_params(params)) for name, params in segment.actions),
        )
        for segment in clip.segments
    )
    captions = tuple(
        Caption(mirror_words(caption.text), tuple(map(mirror_words, caption.segments))) for caption in clip.captions
    )
    return replace(clip, id=f"{index:06d}", segments=segments, captions=captions)


def _label(composed: ComposedClip, index: int, split: str, length: int) -> Clip:
    segments = tuple(
        replace(segment, actions=tuple((name, plain(params)) for name, params in segment.actions))
        for segment in composed.segments
    )
    source = composed.source
    return Clip(f"{index:06d}", split, 0, length, source, WEIGHTS[source], segments, composed.captions)


def build_dataset(out: Path, *, clips: int, seed: int, cmu: Path | None, workers: int) -> dict[str, Any]:
    """Write a data set and return its manifest. The bytes depend on `clips`, `seed` and the CMU data alone.

    Args:
        out: folder to make; it must not exist yet, or be empty.
        clips: how many.
        seed: of all randomness.
        cmu: unpacked CMU takes, or None for authored motion only.
        workers: processes.

    Raises:
        InvalidOption: no clips or no workers asked for, or a negative seed.
        InvalidFile: `out` holds something already or cannot be written; `cmu` cannot be read.
    """
    for option, value, least in (("--clips", clips, 1), ("--workers", workers, 1), ("--seed", seed, 0)):
        if value < least:
            raise InvalidOption(option, f"expected {least} or more, found {value}")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InvalidFile(out, "exists already; give a new folder")
    excerpts = load_excerpts(cmu) if cmu else ()
    if excerpts:
        minutes = sum(len(excerpt.pose["root"]) for excerpt in excerpts) / FPS / 60
        say(f"{len(excerpts)} excerpts of real motion, {minutes:.1f} minutes")
    with _new_folder(out) as folder:
        counts, rows = _write_clips(folder, clips, seed, excerpts, workers)
        manifest = {
            "version": VERSION,
            "seed": seed,
            "clips": clips,
            "minutes": round(rows / FPS / 60, 2),
            "rows": rows,
            "excerpts": len(excerpts),
            **{name: dict(sorted(counter.items())) for name, counter in counts.items()},
        }
        write_json(folder / "manifest.json", manifest)
    return manifest


@contextmanager
def _new_folder(out: Path) -> Iterator[Path]:
    """A folder beside `out` that becomes it when all is written and vanishes when something fails."""
    make_folder(out.parent)
    folder = out.parent / f".{out.name}-{os.getpid()}"
    make_folder(folder)
    try:
        yield folder
        if out.exists():
            out.rmdir()
        folder.rename(out)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _write_clips(
    folder: Path, clips: int, seed: int, excerpts: tuple[Excerpt, ...], workers: int
) -> tuple[dict[str, Counter[str]], int]:
    counts: dict[str, Counter[str]] = {"splits": Counter(), "sources": Counter(), "segments": Counter()}
    row = 0
    with (folder / "features.npy").open("wb") as array, (folder / "clips.jsonl").open("w", encoding="utf-8") as lines:
        array.write(_header(0))
        for made in progress(_make_all(clips, seed, excerpts, workers), "composing clips", total=clips):
            lines.write(clip_to_json(replace(made.clip, start=row)) + "\n")
            array.write(np.ascontiguousarray(made.rows).tobytes())
            row += made.clip.length
            counts["splits"][made.clip.split] += 1
            counts["sources"][made.clip.source] += 1
            counts["segments"][str(len(made.clip.segments))] += 1
        _finish(array, row)
    return counts, row


def _header(rows: int) -> bytes:
    """The header of a float16 array of that many rows; numpy pads it, so that its size does not depend on them."""
    buffer = io.BytesIO()
    described = {"descr": "<f2", "fortran_order": False, "shape": (rows, len(CHANNELS))}
    np.lib.format.write_array_header_1_0(buffer, described)
    return buffer.getvalue()


def _finish(array: BinaryIO, rows: int) -> None:
    array.seek(0)
    array.write(_header(rows))


def _make_all(clips: int, seed: int, excerpts: tuple[Excerpt, ...], workers: int) -> Iterator[Made]:
    """All clips in order; each pair depends on the seed and its number only."""
    pairs = range((clips + 1) // 2)
    if workers == 1:
        made = chain.from_iterable(make_mirrored_pair(seed, number, excerpts) for number in pairs)
        yield from islice(made, clips)
        return
    context = multiprocessing.get_context("spawn")
    # Processes share the cores already: threads inside each would only get in each other's way.
    kept = {name: os.environ.get(name) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
    os.environ.update(dict.fromkeys(kept, "1"))
    try:
        with context.Pool(workers, _start_worker, (seed, excerpts)) as pool:
            yield from islice(chain.from_iterable(pool.imap(_work, pairs, chunksize=8)), clips)
    finally:
        for name, value in kept.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


_WORK: dict[str, Any] = {}


def _start_worker(seed: int, excerpts: tuple[Excerpt, ...]) -> None:
    _WORK.update(seed=seed, excerpts=excerpts)


def _work(number: int) -> tuple[Made, Made]:
    return make_mirrored_pair(_WORK["seed"], number, _WORK["excerpts"])


def describe(manifest: dict[str, Any]) -> str:
    """One line about a data set."""
    splits = ", ".join(f"{count} {name}" for name, count in manifest["splits"].items())
    sources = ", ".join(f"{count} {name}" for name, count in manifest["sources"].items())
    return f"{manifest['clips']} clips, {manifest['minutes']} minutes ({splits}; {sources})"
