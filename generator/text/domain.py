"""Is a segment inside what the model knows: nearer to a training text than to the deeds that no motion was seen of.

Both nearnesses are cosines of plain sentence embeddings. How near the known texts are says little by itself ("does a
handstand" is as near to one as "goes round in circles" is), so the nearness of a written list of contrasting deeds is
held against it, as novelty detection does where examples of the novel can be had (outlier exposure, Hendrycks et al.
2019, arXiv 1812.04606). Texts are compared by what is done: side, count and speed are conditions of the same deed.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from generator.text.encoder import TextEncoder
from generator.text.inflection import GERUNDS, third_person
from generator.text.splitter import PERSON
from ros_free_stack.errors import InvalidFile, OutOfDomain
from ros_free_stack.files import atomic_path

THRESHOLD: Final = 0.264  # this and CONTRAST were chosen on the development halves of the benchmark's lists
CONTRAST: Final = 0.7  # how much the nearness of an unknown deed counts against that of a known one
MAX_TEXTS: Final = 3500
MAX_ENCODED: Final = 15_000  # texts; encoding them takes a minute or two
SAME: Final = 0.97  # cosine of two texts, from which on one of them is enough
ALIKE: Final = 0.85  # cosine of two texts, from which on they are the same deed for a reader
NOT_HUMAN: Final = -1.0  # similarity where the subject is no person, below that of every deed of one

_ARRAYS = ("embeddings", "contrast")
_CONTRAST_TEXTS = Path(__file__).parent / "contrast.txt"
_NUMBERS = r"(?:two|three|four|five|six|seven|eight|nine|ten|eleven|twelve|several|some|multiple|a few|\d+)"
_PLAINER = tuple(
    (re.compile(rf"\b{pattern}(?!\w)"), plain)
    for pattern, plain in (
        ("(?:his|her|their|its|my|your)", "the"),
        ("(?:slowly|quickly|fast|rapidly)", ""),
        (rf"(?:{_NUMBERS} times|repeatedly|once)", "twice"),
        (rf"{_NUMBERS}(?! degrees)", "two"),
    )
)

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Domain:
    """What the model was trained on, `texts`, and what not.

    Attributes:
        texts: known deeds, each "a person " and a verb in the third person.
        embeddings: of the texts, (N, 384), of unit length.
        contrast: embeddings of unknown deeds, (M, 384), of unit length.
        actions: names of the actions that each text may mean, none where that was not noted.
        threshold: the lowest similarity of a known segment.
    """

    texts: tuple[str, ...]
    embeddings: Array
    contrast: Array
    encoder: TextEncoder
    actions: tuple[tuple[str, ...], ...]
    threshold: float = THRESHOLD

    @classmethod
    def fit(
        cls,
        texts: Iterable[str],
        encoder: TextEncoder,
        *,
        actions: Mapping[str, Sequence[str]] | None = None,
        limit: int = MAX_TEXTS,
        seed: int = 0,
    ) -> "Domain":
        """The domain of training segment texts, thinned out to at most `limit` that cover them all.

        A contrasting deed that the training texts tell after all is left out. `actions` has the names of what deeds
        (see `deeds`) mean.
        """
        unique = np.array(sorted({deed for text in texts for deed in deeds(text)}))
        if len(unique) > MAX_ENCODED:
            unique = np.sort(np.random.default_rng(seed).choice(unique, MAX_ENCODED, replace=False))
        embeddings = _unit(encoder.encode_sentences(unique.tolist()))
        kept = _cover(embeddings, limit)
        lines = _CONTRAST_TEXTS.read_text(encoding="utf-8").splitlines()
        unknown = [deed for line in lines if not line.startswith("#") for deed in deeds(f"{PERSON} {line}")]
        contrast = _unit(encoder.encode_sentences(unknown))
        contrast = contrast[(contrast @ embeddings[kept].T).max(axis=1, initial=-1.0) < ALIKE]
        known = tuple(unique[kept].tolist())
        return cls(known, embeddings[kept], contrast, encoder, tuple(tuple((actions or {}).get(t, ())) for t in known))

    def similarity(self, segments: Sequence[str]) -> Array:
        """How well each segment text is known (N,), NOT_HUMAN where its subject is no person.

        The cosine to the nearest known text less CONTRAST times that to the nearest unknown deed; of deeds done at
        the same time, the least known counts.
        """
        parts = [deeds(segment) for segment in segments]
        embeddings = _unit(self.encoder.encode_sentences([part for row in parts for part in row]))
        known = (embeddings @ self.embeddings.T).max(axis=1)
        scores = known - np.float32(CONTRAST) * (embeddings @ self.contrast.T).max(axis=1)
        starts = np.cumsum([0, *map(len, parts)])[:-1]
        human = np.array([segment.startswith(f"{PERSON} ") for segment in segments])
        return np.where(human, np.minimum.reduceat(scores, starts), np.float32(NOT_HUMAN))

    def check(self, segments: Sequence[str]) -> None:
        """Raise OutOfDomain for the first segment that is not known."""
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

    def meant(self, clauses: Sequence[str]) -> list[tuple[str, ...]]:
        """Names of the actions that each clause may mean, those of the nearest known text; none where none is alike."""
        found = _unit(self.encoder.encode_sentences([deeds(clause)[0] for clause in clauses])) @ self.embeddings.T
        return [self.actions[int(row.argmax())] if row.max() >= ALIKE else () for row in found]

    def save(self, path: Path) -> None:
        """Write texts, their actions, threshold and embeddings (float16) as one safetensors file."""
        from safetensors.numpy import save_file

        arrays = {"embeddings": self.embeddings.astype(np.float16), "contrast": self.contrast.astype(np.float16)}
        words = {"texts": json.dumps(self.texts), "actions": json.dumps(self.actions)}
        metadata = {**words, "threshold": str(self.threshold)}
        with atomic_path(path) as temporary:
            save_file(arrays, temporary, metadata)

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
                embeddings, contrast = (archive.get_tensor(name).astype(np.float32) for name in _ARRAYS)
            texts = tuple(json.loads(metadata["texts"]))
            actions = tuple(tuple(names) for names in json.loads(metadata["actions"]))
            threshold = float(metadata["threshold"])
        except (SafetensorError, KeyError, ValueError) as error:
            raise InvalidFile(path, f"not the known texts of a model ({error})") from None
        if not len(texts) == len(actions) == len(embeddings):
            raise InvalidFile(
                path, f"{len(texts)} texts, actions of {len(actions)} of them, {len(embeddings)} embeddings"
            )
        return cls(texts, embeddings, contrast, encoder, actions, threshold)


def deeds(segment: str) -> tuple[str, ...]:
    """What a segment text does, each deed that is done at the same time by itself, without side, count and speed.

    `a person slowly waves twice with her left hand while walking` ->
    `a person waves twice with the right hand`, `a person walks`
    """
    subject, told = (PERSON, segment.removeprefix(f"{PERSON} ")) if segment.startswith(f"{PERSON} ") else ("", segment)
    main, *meanwhile = told.split(" while ")
    return tuple(f"{subject} {part}".strip() for part in (_plainer(main), *(_finite(_plainer(w)) for w in meanwhile)))


def _finite(words: str) -> str:
    verb, *rest = words.split(" ")
    return " ".join([third_person(GERUNDS[verb]) if verb in GERUNDS else verb, *rest])


def _plainer(words: str) -> str:
    for pattern, plain in _PLAINER:
        words = pattern.sub(plain, words)
    names_both = "left" in words and "right" in words
    return " ".join((words if names_both else re.sub(r"\bleft\b", "right", words)).split())


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
