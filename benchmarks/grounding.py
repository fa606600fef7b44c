"""How well text and motion segments find each other: retrieval, captions and grounding on the test split.

python benchmarks/grounding.py --dataset data/corpus --weights generator/weights

Retrieval is in pools of 32 in which no text comes twice. A caption is right if some training segment was told with that
text and did the same, sides included. Grounding searches each text of a clip of two or more segments in the clip.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
import tyro
from torch import Tensor

from generator.datasets.authored import AuthoredCorpus
from generator.datasets.dataset import Clip, LabelledSegment
from generator.grounding.consistency import consistency, recall
from generator.grounding.search import ground
from generator.grounding.space import AlignedSpace
from generator.grounding.texts import KnownTexts
from generator.models.segmo.config import TOKEN_S
from generator.models.segmo.objectives.segmentation_table import first_captions, segmentation_table
from generator.models.segmo.segmentation import boundary_iou
from generator.registry import DEFAULT, WEIGHTS_FOLDER
from generator.text.encoder import TextEncoder
from ros_free_stack.console import progress

POOL = 32
Deed = tuple[tuple[str, str], ...]


@dataclass(frozen=True, kw_only=True)
class Arguments:
    """Print the share of right answers."""

    dataset: Path
    """Folder of the motion data set."""
    weights: Path = WEIGHTS_FOLDER
    """Folder with tokenizer and grounding model."""
    clips: int = 500
    """How many test clips."""
    threads: int = 1


@dataclass(frozen=True)
class Embedded:
    """A test clip: hidden tokens (n, W), texts and motion segments (A, W) in the shared space, true lengths (A,)."""

    clip: Clip
    hidden: Tensor
    texts: Tensor
    segments: Tensor
    lengths: np.ndarray


def embed(dataset: AuthoredCorpus, space: AlignedSpace, count: int) -> list[Embedded]:
    """The first test clips, each with its first caption."""
    lengths, found = first_captions(dataset, segmentation_table(dataset, "exact")), []
    chosen = [i for i, clip in enumerate(dataset.clips) if clip.split == "test"][:count]
    every = [text for number in chosen for text in dataset.clips[number].captions[0].segments]
    embeddings = iter(space.texts(TextEncoder(), every).split(1))
    for number in progress(chosen, "embedding clips", total=len(chosen)):
        clip = dataset.clips[number]
        own = lengths[number][: len(clip.segments)]
        tokens = space.tokenizer.encode(torch.from_numpy(dataset.features(clip))[None])
        hidden = space.hidden(tokens[: space.model.config.parts, 0])
        texts = torch.cat([next(embeddings) for _ in clip.segments])
        found.append(Embedded(clip, hidden, texts, space.segments(hidden, own.tolist()), own))
    return found


def deed(segment: LabelledSegment) -> Deed:
    """Names and sides of a segment's actions."""
    return tuple(sorted((name, str(parameters.get("side", ""))) for name, parameters in segment.actions))


def deeds_of_texts(clips: Iterable[Clip]) -> dict[str, set[Deed]]:
    """What the segments did that were told with each text."""
    found: dict[str, set[Deed]] = defaultdict(set)
    for clip in clips:
        for caption in clip.captions:
            for text, segment in zip(caption.segments, clip.segments, strict=True):
                found[text].add(deed(segment))
    return found


def caption_hits(known: KnownTexts, embedded: list[Embedded], told: dict[str, set[Deed]], rank: int) -> float:
    """Share of segments with a right text among the `rank` nearest."""
    hits = [
        any(deed(segment) in told[text] for text, _ in texts)
        for item in embedded
        for segment, texts in zip(item.clip.segments, known.nearest(item.segments, rank), strict=True)
    ]
    return float(np.mean(hits))


def grounding_iou(space: AlignedSpace, embedded: list[Embedded]) -> tuple[np.ndarray, np.ndarray]:
    """(N,) IoU of the place of each text with the true one, and that of equal shares of the clip."""
    found, shares = [], []
    for item in embedded:
        if len(item.lengths) == 1:
            continue
        ends = item.lengths.cumsum()
        for place, start, end in zip(ground(space, item.hidden, item.texts), ends - item.lengths, ends, strict=True):
            first, last = place.start_s / TOKEN_S, place.end_s / TOKEN_S
            found.append(max(0.0, min(last, end) - max(first, start)) / (max(last, end) - min(first, start)))
        equal = np.diff(np.arange(len(item.lengths) + 1) * ends[-1] // len(item.lengths))
        shares.extend(boundary_iou(equal[None], item.lengths[None])[0])
    return np.array(found), np.array(shares)


def main(arguments: Arguments) -> None:
    """Print the table."""
    torch.set_num_threads(arguments.threads)
    dataset, space = AuthoredCorpus.open(arguments.dataset), AlignedSpace.load(arguments.weights / DEFAULT)
    known = KnownTexts.load(arguments.weights / DEFAULT / "grounding")
    embedded = embed(dataset, space, arguments.clips)
    texts, motions = (torch.cat([getattr(item, name) for item in embedded]) for name in ("texts", "segments"))
    _, rows = np.unique([text for item in embedded for text in item.clip.captions[0].segments], return_inverse=True)
    found = consistency(texts, motions)
    print(f"{len(embedded)} clips, {len(texts)} segments; ISC {found.mean:.3f} (CV {found.variation:.2f})")
    print("\n| retrieval | R@1 | R@5 |\n|---|---|---|")
    for name, queries, targets in (("text to motion", texts, motions), ("motion to text", motions, texts)):
        first, fifth = (recall(queries, targets, rows, rank=rank, pool=POOL, seed=0) for rank in (1, 5))
        print(f"| {name}, pools of {POOL} (chance {1 / POOL:.1%}, {5 / POOL:.1%}) | {first:.1%} | {fifth:.1%} |")
    told = deeds_of_texts(dataset.split("train"))
    first, fifth = (caption_hits(known, embedded, told, rank) for rank in (1, 5))
    print(f"| right deed and side among {len(known.texts)} known texts | {first:.1%} | {fifth:.1%} |")
    iou, shares = grounding_iou(space, embedded)
    above = np.mean(iou > 0.5)
    print(f"\ngrounding: mean IoU {iou.mean():.3f}, above 0.5 in {above:.1%}; equal shares {shares.mean():.3f}")


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
