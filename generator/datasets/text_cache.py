"""Embeddings of all texts of a data set, made once and kept in its folder."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from generator.datasets.cache import cache_path
from ros_free_stack.console import say
from ros_free_stack.files import atomic_path


@dataclass(frozen=True)
class TextTable:
    """Distinct texts and their sentence embeddings.

    Attributes:
        row: row of each text.
        embeddings: (N, 384) float16.
    """

    row: dict[str, int]
    embeddings: np.ndarray

    def rows(self, texts: Iterable[str]) -> np.ndarray:
        """Rows of the texts, in their order; -1 for an empty one."""
        return np.array([self.row[text] if text else -1 for text in texts], dtype=np.int64)


def text_table(folder: Path, texts: Iterable[str]) -> TextTable:
    """Embed the texts, or read them from the folder where the very same texts were embedded before."""
    distinct = sorted(set(texts))
    name = hashlib.sha256("\n".join(distinct).encode()).hexdigest()[:16]
    path = cache_path(folder, f"text-{name}.npy")
    if not path.is_file():
        from generator.text.encoder import TextEncoder

        say(f"embedding {len(distinct)} texts, once for this data set")
        embeddings = TextEncoder().encode_sentences(distinct).astype(np.float16)
        with atomic_path(path) as temporary:
            np.save(temporary, embeddings)
    return TextTable({text: row for row, text in enumerate(distinct)}, np.load(path))
