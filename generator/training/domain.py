"""The known texts of a corpus, which the domain check compares prompts with."""

from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from generator.datasets.dataset import MotionDataset
from generator.text.domain import Domain, deeds
from generator.text.encoder import TextEncoder
from generator.text.understanding import DOMAIN
from ros_free_stack.files import make_folder

OFTEN: Final = 0.2  # share of its uses in which a text means an action, from which on it may mean it


def fit_domain(dataset: MotionDataset, out: Path) -> dict[str, float]:
    """Write the texts that cover all training segments to the weights folder; how many they are."""
    told = list(_told(dataset))
    texts = {text for text, _ in told}
    domain = Domain.fit(texts, TextEncoder(), actions=_meanings(told))
    domain.save(make_folder(out) / DOMAIN)
    return {"texts": float(len(texts)), "kept": float(len(domain.texts)), "finished": 1.0}


def _told(dataset: MotionDataset) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Each segment text of the training split with the names of the actions that it was told of."""
    for clip in dataset.split("train"):
        for caption in clip.captions:
            for text, segment in zip(caption.segments, clip.segments, strict=True):
                yield text, tuple(name for name, _ in segment.actions)


def _meanings(told: list[tuple[str, tuple[str, ...]]]) -> dict[str, tuple[str, ...]]:
    """Deeds with the actions that they may mean, from the texts that tell a single one."""
    counts: defaultdict[str, Counter[str]] = defaultdict(Counter)
    for text, names in told:
        parts = deeds(text)
        if len(parts) == len(names) == 1:
            counts[parts[0]][names[0]] += 1
    return {
        deed: tuple(name for name, count in found.items() if count >= OFTEN * found.total())
        for deed, found in counts.items()
    }
