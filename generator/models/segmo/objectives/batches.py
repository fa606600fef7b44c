"""Batches of motion tokens with their texts and segment boundaries."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
from torch import Tensor, nn

from generator import weights
from generator.config import MAX_SEGMENTS, SegmentationKind
from generator.datasets.dataset import Clip, MotionDataset
from generator.datasets.drawing import drawing_weights
from generator.datasets.text_cache import TextTable, text_table
from generator.models.segmo.conditioning import Condition
from generator.models.segmo.config import MAX_TOKENS, TOKEN_FRAMES, TokenizerConfig
from generator.models.segmo.objectives.segmentation_table import segmentation_table
from generator.models.segmo.objectives.tokenizer import batches_of_equal_length, feature_batch
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.text.counts import MOST, segment_counts
from generator.text.meanwhile import LINK, clauses_at_once
from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidFile

BUCKET = 12  # batches that are drawn together and then sorted by length, so that little padding is computed


@dataclass(frozen=True)
class TokenClip:
    """One clip as the transformers see it.

    Attributes:
        number: its place among all clips of the data set.
        tokens: (Q P, n) int16.
        sentences: (C,) rows of its captions in the table of sentences.
        segments: of each caption (A, 2) rows of both clauses of its segments in the table of clauses, -1 for none.
        told: of each caption (A, 2) repetitions that those clauses name, 0 where they do not.
        counted: the same, with the true number where a text of one clause names none.
    """

    number: int
    tokens: np.ndarray
    weight: float
    sentences: np.ndarray
    segments: tuple[np.ndarray, ...]
    told: tuple[np.ndarray, ...]
    counted: tuple[np.ndarray, ...]


@dataclass(frozen=True)
class TokenBatch:
    """A batch for the transformers.

    Attributes:
        tokens: (Q P, B, T) of Q layers of P parts, zero on padding.
        condition: what they are conditioned on.
        motion_segments: (B, A) tokens of the motion segments that texts are aligned with.
    """

    tokens: Tensor
    condition: Condition
    motion_segments: Tensor


@dataclass(frozen=True)
class TokenCorpus:
    """The tokenised data set in memory.

    Attributes:
        dataset: the data set itself.
        sentences, clauses: embeddings of all captions and of all clauses of segment texts.
        codebooks: (Q, P, K, D) codes of each layer and part.
        tokenizer: digest of the tokenizer's weights.
    """

    dataset: MotionDataset
    train: tuple[TokenClip, ...]
    held: tuple[TokenClip, ...]
    test: tuple[TokenClip, ...]
    sentences: TextTable
    clauses: TextTable
    codebooks: Tensor
    tokenizer: str

    @classmethod
    def build(cls, dataset: MotionDataset, tokenizer_folder: Path, device: str, *, clauses: bool = True) -> Self:
        """Tokenise all clips with a trained tokenizer and embed all their texts.

        Args:
            clauses: take segment texts apart into what they say happens at the same time; otherwise whole.

        Raises:
            NoWeights: the tokenizer is not trained yet.
            InvalidFile: a clip does not fit the models (too many segments, too long).
        """
        saved = weights.load(tokenizer_folder, "tokenizer")
        tokenizer = MotionTokenizer(saved.config_as(TokenizerConfig))
        saved.fill(tokenizer)
        tokenizer.to(device).eval()
        place = {clip.id: number for number, clip in enumerate(dataset.clips)}
        captions = [caption for clip in dataset.clips for caption in clip.captions]
        sentences = text_table(dataset.path, (caption.text for caption in captions))
        pairs = {
            text: clauses_at_once(text) if clauses else (text, "") for caption in captions for text in caption.segments
        }
        table = text_table(dataset.path, (clause for pair in pairs.values() for clause in pair if clause))

        def clips(split: str) -> tuple[TokenClip, ...]:
            chosen = dataset.split(split)
            for clip in chosen:
                _check(dataset, clip)
            tokens, chances = _tokenise(tokenizer, dataset, chosen), drawing_weights(chosen)
            return tuple(
                TokenClip(
                    place[clip.id],
                    codes,
                    chance,
                    sentences.rows(caption.text for caption in clip.captions),
                    tuple(np.stack([table.rows(pairs[text]) for text in own.segments]) for own in clip.captions),
                    *repetitions_of(clip),
                )
                for clip, codes, chance in zip(chosen, tokens, chances.tolist(), strict=True)
            )

        return cls(
            dataset,
            clips("train"),
            clips("val"),
            clips("test"),
            sentences,
            table,
            tokenizer.codebooks.cpu(),
            saved.digest,
        )

    def training_texts(self) -> tuple[np.ndarray, np.ndarray]:
        """Embeddings (N, 384) of the captions, once for each clip's use, and (M, 384) of the distinct clauses."""
        sentence_rows = np.concatenate([clip.sentences for clip in self.train])
        segment_rows = np.concatenate([own.ravel() for clip in self.train for own in clip.segments])
        return (
            self.sentences.embeddings[sentence_rows].astype(np.float32),
            self.clauses.embeddings[np.unique(segment_rows[segment_rows >= 0])].astype(np.float32),
        )

    def facts(self) -> dict[str, Any]:
        """What is noted beside the weights of a transformer."""
        return {"tokenizer": self.tokenizer, "clips": len(self.train)}


class TokenBatches:
    """Training batches as a function of the iteration, and fixed validation batches.

    Args:
        layout: segmentation that the models are told, "exact" or "uniform".
        segmentation: segmentation of the motion that texts are aligned with.
    """

    def __init__(
        self, corpus: TokenCorpus, *, batch: int, layout: SegmentationKind, segmentation: SegmentationKind, seed: int
    ) -> None:
        self._corpus, self._batch, self._seed = corpus, batch, seed
        self._layout = torch.from_numpy(segmentation_table(corpus.dataset, layout))
        self._motion_segments = torch.from_numpy(segmentation_table(corpus.dataset, segmentation))
        chance = np.array([clip.weight for clip in corpus.train])
        self._chance = chance / chance.sum()
        self._lengths = np.array([clip.tokens.shape[1] for clip in corpus.train])
        self._drawn: tuple[int, list[np.ndarray]] = (-1, [])

    def training(self, iteration: int) -> TokenBatch:
        """Clips drawn by weight, each with one of its captions; of similar length within a batch."""
        number, place = divmod(iteration, BUCKET)
        if self._drawn[0] != number:
            rng = np.random.default_rng((self._seed, number))
            rows = rng.choice(len(self._chance), BUCKET * self._batch, p=self._chance)
            rows = rows[np.argsort(self._lengths[rows], kind="stable")].reshape(BUCKET, self._batch)
            self._drawn = number, list(rng.permutation(rows))
        rng = np.random.default_rng((self._seed, number, place))
        clips = [self._corpus.train[row] for row in self._drawn[1][place]]
        captions = [int(rng.integers(len(clip.sentences))) for clip in clips]
        # Most texts name no number: the true one shows what a number means, and half the time the text must do.
        return self.collate(clips, captions, counted=rng.random(len(clips)) < 0.5)

    def held(self, count: int) -> list[TokenBatch]:
        """The first `count` clips of the validation split (of training, where there is none), first captions."""
        return self.batches((self._corpus.held or self._corpus.train)[:count])

    def batches(self, clips: Sequence[TokenClip]) -> list[TokenBatch]:
        """The clips in order of length, each with its first caption."""
        clips = sorted(clips, key=lambda clip: clip.tokens.shape[1])
        chunks = [clips[start : start + self._batch] for start in range(0, len(clips), self._batch)]
        return [self.collate(chunk, [0] * len(chunk)) for chunk in chunks]

    def collate(
        self, clips: Sequence[TokenClip], captions: Sequence[int], counted: np.ndarray | None = None
    ) -> TokenBatch:
        """Pad the clips to one batch, each with the caption of the given number; where `counted`, with true counts."""
        corpus = self._corpus
        tokens = nn.utils.rnn.pad_sequence([torch.from_numpy(clip.tokens.T) for clip in clips], batch_first=True)
        rows = [clip.segments[caption] for clip, caption in zip(clips, captions, strict=True)]
        count = max(map(len, rows))
        segments = np.zeros((len(clips), count, 2, corpus.clauses.embeddings.shape[1]), np.float32)
        for texts, row in zip(segments, rows, strict=True):
            texts[: len(row)] = corpus.clauses.embeddings[row] * (row >= 0)[..., None]
        counts = np.zeros(segments.shape[:3], np.int64)
        for i, (clip, caption) in enumerate(zip(clips, captions, strict=True)):
            true = counted is not None and counted[i]
            counts[i, : len(rows[i])] = (clip.counted if true else clip.told)[caption]
        sentences = [clip.sentences[caption] for clip, caption in zip(clips, captions, strict=True)]
        numbers, counted_as = [clip.number for clip in clips], [len(row) - 1 for row in rows]
        condition = Condition(
            torch.from_numpy(corpus.sentences.embeddings[sentences].astype(np.float32)),
            torch.from_numpy(segments),
            torch.from_numpy(counts),
            self._layout[numbers, counted_as, :count],
        )
        return TokenBatch(tokens.permute(2, 0, 1).long(), condition, self._motion_segments[numbers, counted_as, :count])


def repetitions_of(clip: Clip) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """Of each caption (A, 2) repetitions that its clauses name, and the same with the true ones; see `TokenClip`."""
    told = tuple(segment_counts(caption.segments) for caption in clip.captions)
    counted = tuple(row.copy() for row in told)
    for place, segment in enumerate(clip.segments):
        counts = [parameters["count"] for _, parameters in segment.actions if "count" in parameters]
        for caption, row in zip(clip.captions, counted, strict=True):
            alone = len(segment.actions) == 1 and LINK not in caption.segments[place]
            if len(counts) == 1 and alone and not row[place].any():
                row[place, 0] = min(MOST, counts[0])
    return told, counted


def _check(dataset: MotionDataset, clip: Clip) -> None:
    """InvalidFile unless the models can take the clip."""
    tokens = clip.length // TOKEN_FRAMES
    counts = [len(caption.segments) for caption in clip.captions]
    if not counts or (clip.segments and any(count != len(clip.segments) for count in counts)):
        raise InvalidFile(dataset.path, f"clip {clip.id} needs captions with {len(clip.segments)} segment texts each")
    if not 1 <= min(counts) <= max(counts) <= min(MAX_SEGMENTS, tokens) or tokens > MAX_TOKENS:
        raise InvalidFile(
            dataset.path,
            f"clip {clip.id} has {max(counts)} segments in {clip.length} frames; valid are 1 to "
            f"{MAX_SEGMENTS} segments and at most {MAX_TOKENS * TOKEN_FRAMES} frames",
        )


def _tokenise(tokenizer: MotionTokenizer, dataset: MotionDataset, clips: Sequence[Clip]) -> list[np.ndarray]:
    """Tokens (Q P, n) int16 of each clip."""
    tokens = [np.empty(0)] * len(clips)
    batches = list(batches_of_equal_length(clips))
    for rows in progress(batches, "tokenising", total=len(batches)):
        features = feature_batch(dataset, [clips[row] for row in rows], tokenizer.mean.device)
        codes = tokenizer.encode(features).to(torch.int16).cpu().numpy()
        for place, row in enumerate(rows):
            tokens[row] = codes[:, place]
    return tokens
