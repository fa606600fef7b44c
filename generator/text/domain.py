"""Is a segment inside what the model knows: the cosine of its embedding to the nearest training text.

Measured on lists of phrases that the corpus does not contain, the plain sentence embedding of the whole segment
separates known from unknown actions better than whitened or centred ones, which were made to tell left from right.
"""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from generator.text.encoder import TextEncoder
from generator.text.splitter import PERSON
from ros_free_stack.errors import InvalidFile, OutOfDomain
from ros_free_stack.files import atomic_path

THRESHOLD = 0.70  # cosine; in the gap between the development lists of known and unknown actions in the test
MAX_TEXTS = 3000
SAME = 0.97  # cosine of two texts, from which on one of them is enough
ALIKE = 0.85  # cosine of two suggestions, from which on they are the same action for a reader

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Domain:
    """What the model was trained on: `texts`, with `embeddings` (N, 384) of unit length."""

    texts: tuple[str, ...]
    embeddings: Array
    encoder: TextEncoder
    threshold: float = THRESHOLD

    @classmethod
    def fit(cls, texts: Iterable[str], encoder: TextEncoder, *, limit: int = MAX_TEXTS) -> "Domain":
        """The domain of training segment texts, thinned out to at most `limit` that cover them all."""
        unique = sorted(set(texts))
        embeddings = _unit(encoder.encode_sentences(unique))
        kept = _cover(embeddings, limit)
        return cls(tuple(unique[row] for row in kept), embeddings[kept], encoder)

    def similarity(self, segments: Sequence[str]) -> Array:
        """The cosine (N,) of each segment text to the nearest known one; a subject but a human being counts as 0."""
        nearest = (_unit(self.encoder.encode_sentences(segments)) @ self.embeddings.T).max(axis=1)
        human = np.array([segment.startswith(f"{PERSON} ") for segment in segments])
        return np.where(human, nearest, np.float32(0.0))

    def check(self, segments: Sequence[str]) -> None:
        """Raise OutOfDomain for the first segment that is too far from every known text."""
        for segment, similarity in zip(segments, self.similarity(segments), strict=True):
            if similarity < self.threshold:
                raise OutOfDomain(segment, self.nearest(segment))

    def nearest(self, segment: str, count: int = 3) -> tuple[str, ...]:
        """The nearest known texts, of which no two say the same."""
        order = np.argsort(-(_unit(self.encoder.encode_sentences([segment])) @ self.embeddings.T)[0], kind="stable")
        chosen: list[int] = []
        for row in order:
            if len(chosen) < count and (self.embeddings[chosen] @ self.embeddings[row] < ALIKE).all():
                chosen.append(int(row))
        return tuple(self.texts[row] for row in chosen)

    def save(self, path: Path) -> None:
        """Write texts, threshold and embeddings (float16) as one safetensors file."""
        from safetensors.numpy import save_file

        metadata = {"texts": json.dumps(self.texts), "threshold": str(self.threshold)}
        with atomic_path(path) as temporary:
            save_file({"embeddings": self.embeddings.astype(np.float16)}, temporary, metadata)

    @classmethod
    def load(cls, path: Path, encoder: TextEncoder) -> "Domain":
        """Read what `save` wrote.

        Raises:
            InvalidFile: the file is missing or is no such file.
        """
        from safetensors import SafetensorError, safe_open

        if not path.is_file():
            raise InvalidFile(path, "no such file")
        try:
            with safe_open(path, framework="np") as archive:
                metadata: dict[str, Any] = archive.metadata() or {}
                embeddings = archive.get_tensor("embeddings").astype(np.float32)
            texts = tuple(json.loads(metadata["texts"]))
            threshold = float(metadata["threshold"])
        except (SafetensorError, KeyError, ValueError) as error:
            raise InvalidFile(path, f"not the known texts of a model ({error})") from None
        if len(texts) != len(embeddings):
            raise InvalidFile(path, f"{len(texts)} texts but {len(embeddings)} embeddings")
        return cls(texts, embeddings, encoder, threshold)


def _unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _cover(vectors: Array, limit: int) -> list[int]:
    """Greedy k-centre (Gonzalez 1985): take the text farthest from those taken, until all are near one."""
    if not len(vectors):
        return []
    kept = [0]
    nearest = vectors @ vectors[0]
    while len(kept) < limit and nearest.min() < SAME:
        kept.append(int(nearest.argmin()))
        nearest = np.maximum(nearest, vectors @ vectors[kept[-1]])
    return kept
