"""Batches of tokens of every body, with their texts and the texts of their parts."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
from torch import Tensor, nn

from generator import weights
from generator.config import MAX_SEGMENTS
from generator.datasets.dataset import Clip, MotionDataset
from generator.datasets.drawing import drawing_weights
from generator.datasets.text_cache import TextTable, text_table
from generator.models.party.condition import Condition
from generator.models.party.config import ConditioningKind, TokenizerConfig
from generator.models.party.objectives.part_texts import PartTexts, part_texts
from generator.models.party.objectives.tokenizer import batches_of_equal_length, whole_features
from generator.models.party.tokenizer import PartyTokenizer
from generator.text.meanwhile import clauses_at_once
from generator.timing import segment_lengths, uniform_lengths
from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidFile

BUCKET = 12  # batches that are drawn together and then sorted by length, so that little padding is computed


@dataclass(frozen=True)
class CaptionRows:
    """Rows in the table of texts of one caption.

    Attributes:
        texts: (1 + A,) of the sentence and of its segments.
        clauses: (1 + A, 2) of their clauses, -1 for none; the sentence has none.
        parts: of each part (1 + A,) of what it does; the row of the text itself where it does nothing of note, -1
            where nobody said.
        frames: (A,) of each segment.
    """

    texts: np.ndarray
    clauses: np.ndarray
    parts: dict[str, np.ndarray]
    frames: np.ndarray


@dataclass(frozen=True)
class TokenClip:
    """One clip: tokens (n, G) int16 of each body, and its captions."""

    tokens: dict[str, np.ndarray]
    weight: float
    captions: tuple[CaptionRows, ...]


@dataclass(frozen=True)
class TokenBatch:
    """A batch for the network.

    Attributes:
        tokens: of each body (B, n, G), zero on padding.
        condition: texts and lengths.
        parts: of each part (B, R, 384) embeddings of what it does.
        told: of each part (B, R) true where that is known.
    """

    tokens: dict[str, Tensor]
    condition: Condition
    parts: dict[str, Tensor]
    told: dict[str, Tensor]

    def to(self, device: torch.device | str) -> Self:
        def moved(rows: dict[str, Tensor]) -> dict[str, Tensor]:
            return {name: row.to(device) for name, row in rows.items()}

        return type(self)(moved(self.tokens), self.condition.to(device), moved(self.parts), moved(self.told))


@dataclass(frozen=True)
class TokenCorpus:
    """The tokenised data set in memory.

    Attributes:
        texts: embeddings of all texts.
        config, digest: of the tokenizer.
        with_parts: share of the training captions whose parts' texts are known.
    """

    train: tuple[TokenClip, ...]
    held: tuple[TokenClip, ...]
    texts: TextTable
    config: TokenizerConfig
    digest: str
    with_parts: float

    @classmethod
    def build(cls, dataset: MotionDataset, tokenizer_folder: Path, device: str) -> Self:
        """Tokenise the clips of training and validation with a trained tokenizer, and embed all their texts.

        Raises:
            NoWeights: the tokenizer is not trained yet.
            InvalidFile: a clip does not fit the models.
        """
        saved = weights.load(tokenizer_folder, "tokenizer")
        config = saved.config_as(TokenizerConfig)
        tokenizer = PartyTokenizer(config)
        saved.fill(tokenizer)
        tokenizer.to(device).eval()
        chosen = {split: _usable(dataset, split, config.unit) for split in ("train", "val")}
        both = [clip for clips in chosen.values() for clip in clips]
        told = {clip.id: part_texts(clip, config.parts) for clip in both}
        table = text_table(dataset.path, _texts(both, told))

        def clips(split: str) -> tuple[TokenClip, ...]:
            rows = zip(
                chosen[split],
                _tokenise(tokenizer, dataset, chosen[split]),
                drawing_weights(chosen[split]).tolist(),
                strict=True,
            )
            return tuple(
                TokenClip(tokens, chance, _captions(clip, told[clip.id], config.parts, table, config.unit))
                for clip, tokens, chance in rows
            )

        known = [parts is not None for clip in chosen["train"] for parts in told[clip.id]]
        return cls(clips("train"), clips("val"), table, config, saved.digest, float(np.mean(known)))

    def facts(self) -> dict[str, Any]:
        """What is noted beside the weights of the network."""
        return {"tokenizer": self.digest, "clips": len(self.train), "part_texts": round(self.with_parts, 3)}

    def training_texts(self) -> np.ndarray:
        """(N, 384) embeddings of the sentences, once for each clip's use, and of all other texts once."""
        rows = np.concatenate([caption.texts[:1] for clip in self.train for caption in clip.captions])
        return np.concatenate([self.texts.embeddings[rows], self.texts.embeddings]).astype(np.float32)


class TokenBatches:
    """Training batches as a function of the iteration, and fixed validation batches."""

    def __init__(self, corpus: TokenCorpus, *, batch: int, conditioning: ConditioningKind, seed: int) -> None:
        self._corpus, self._batch, self._seed = corpus, batch, seed
        self._rows = MAX_SEGMENTS + 1 if conditioning == "layout" else 1
        chance = np.array([clip.weight for clip in corpus.train])
        self._chance = chance / chance.sum()
        self._lengths = np.array([_frames(clip) for clip in corpus.train])
        self._drawn: tuple[int, np.ndarray] = (-1, np.empty(0))

    def training(self, iteration: int) -> TokenBatch:
        """Clips drawn by weight, each with one of its captions; of similar length within a batch."""
        number, place = divmod(iteration, BUCKET)
        if self._drawn[0] != number:
            rng = np.random.default_rng((self._seed, number))
            rows = rng.choice(len(self._chance), BUCKET * self._batch, p=self._chance)
            rows = rows[np.argsort(self._lengths[rows], kind="stable")].reshape(BUCKET, self._batch)
            self._drawn = number, rng.permutation(rows)
        rng = np.random.default_rng((self._seed, number, place))
        clips = [self._corpus.train[row] for row in self._drawn[1][place]]
        return self.collate(clips, [int(rng.integers(len(clip.captions))) for clip in clips])

    def held(self, count: int) -> list[TokenBatch]:
        """The first clips of the validation split (of training, where there is none), with their first captions."""
        clips = sorted((self._corpus.held or self._corpus.train)[:count], key=_frames)
        chunks = [clips[start : start + self._batch] for start in range(0, len(clips), self._batch)]
        return [self.collate(chunk, [0] * len(chunk)) for chunk in chunks]

    def collate(self, clips: Sequence[TokenClip], captions: Sequence[int]) -> TokenBatch:
        """Pad the clips to one batch, each with the caption of the given number."""
        chosen = [clip.captions[number] for clip, number in zip(clips, captions, strict=True)]
        tokens = {
            body: nn.utils.rnn.pad_sequence(
                [torch.from_numpy(clip.tokens[body]).long() for clip in clips], batch_first=True
            )
            for body in clips[0].tokens
        }
        texts = self._padded([caption.texts for caption in chosen])
        clauses = self._padded([caption.clauses for caption in chosen])
        frames = nn.utils.rnn.pad_sequence([torch.from_numpy(caption.frames) for caption in chosen], batch_first=True)
        parts = {part: self._padded([caption.parts[part] for caption in chosen]) for part in self._corpus.config.parts}
        return TokenBatch(
            tokens,
            Condition(self._embedded(texts), self._embedded(clauses), frames),
            {part: self._embedded(rows) for part, rows in parts.items()},
            {part: torch.from_numpy(rows >= 0) for part, rows in parts.items()},
        )

    def _padded(self, rows: Sequence[np.ndarray]) -> np.ndarray:
        """(B, R, ...) rows of texts, -1 beyond a motion's own; the sentence alone where no more is read."""
        count = min(self._rows, max(map(len, rows)))
        out = np.full((len(rows), count, *rows[0].shape[1:]), -1, np.int64)
        for own, row in zip(out, rows, strict=True):
            own[: len(row)] = row[:count]
        return out

    def _embedded(self, rows: np.ndarray) -> Tensor:
        found = self._corpus.texts.embeddings[rows].astype(np.float32)
        return torch.from_numpy(found * (rows >= 0)[..., None])


def _frames(clip: TokenClip) -> int:
    return int(clip.captions[0].frames.sum())


def _usable(dataset: MotionDataset, split: str, unit: int) -> list[Clip]:
    """The clips of a split, or InvalidFile where one cannot be taken."""
    chosen = list(dataset.split(split))
    for clip in chosen:
        counts, labelled = [len(caption.segments) for caption in clip.captions], len(clip.segments)
        if not counts or (labelled and any(count != labelled for count in counts)):
            raise InvalidFile(dataset.path, f"clip {clip.id} needs captions with {labelled} segment texts each")
        if not 1 <= min(counts) <= max(counts) <= min(MAX_SEGMENTS, clip.length // unit):
            raise InvalidFile(
                dataset.path,
                f"clip {clip.id} has {max(counts)} segments in {clip.length} frames; valid are 1 to {MAX_SEGMENTS}, "
                f"each of at least the {unit} frames of a token",
            )
    return chosen


def _texts(clips: Sequence[Clip], told: dict[str, tuple[PartTexts | None, ...]]) -> list[str]:
    """All texts of the clips."""
    found = set[str]()
    for clip in clips:
        for caption, parts in zip(clip.captions, told[clip.id], strict=True):
            found |= {caption.text, *caption.segments, *(text for own in (parts or {}).values() for text in own)}
            found |= {clause for text in caption.segments for clause in clauses_at_once(text)}
    return sorted(found - {""})


def _captions(
    clip: Clip, told: tuple[PartTexts | None, ...], parts: Sequence[str], table: TextTable, unit: int
) -> tuple[CaptionRows, ...]:
    frames = clip.length // unit * unit
    spans = [(segment.start, segment.end) for segment in clip.segments]
    rows = []
    for caption, said in zip(clip.captions, told, strict=True):
        texts = table.rows((caption.text, *caption.segments))
        clauses = np.stack([np.full(2, -1), *(table.rows(clauses_at_once(text)) for text in caption.segments)])
        nobody = np.full(len(texts), -1)
        own = {part: nobody if said is None else table.rows(said[part]) for part in parts}
        # Where nobody labelled the segments, they share the motion alike.
        lasting = (
            segment_lengths(spans, frames // unit, unit)
            if spans
            else uniform_lengths(len(caption.segments), frames // unit)
        )
        rows.append(CaptionRows(texts, clauses, own, unit * lasting))
    return tuple(rows)


def _tokenise(tokenizer: PartyTokenizer, dataset: MotionDataset, clips: Sequence[Clip]) -> list[dict[str, np.ndarray]]:
    """Tokens (n, G) int16 of every body of each clip."""
    found: list[dict[str, np.ndarray]] = [{} for _ in clips]
    unit, device = tokenizer.config.unit, tokenizer.mean.device
    batches = batches_of_equal_length(clips, unit)
    for rows in progress(batches, "tokenising", total=len(batches)):
        features = whole_features(dataset, [clips[row] for row in rows], unit).to(device)
        frames = torch.full((len(rows),), features.shape[1], device=device)
        for body, tokens in tokenizer.encode(features, frames).items():
            for row, own in zip(rows, tokens.to(torch.int16).cpu().numpy(), strict=True):
                found[row][body] = own
    return found
