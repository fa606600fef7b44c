"""The published evaluator of T2M (Guo et al., CVPR 2022), with which papers report their numbers on HumanML3D.

DIR holds what its authors publish, in their layout; each part may lie in DIR itself or in the folder in brackets:

new_joint_vecs/, texts/, test.txt ...        [HumanML3D/, dataset/HumanML3D/]  the data set
our_vab_data.npy, our_vab_words.pkl, our_vab_idx.pkl                  [glove/]  GloVe vectors
t2m/text_mot_match/model/finest.tar                             [checkpoints/]  the networks
t2m/Comp_v6_KLD005/meta/mean.npy, std.npy                       [checkpoints/]  statistics they were trained with
"""

import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.utils.rnn import pack_padded_sequence, pad_sequence

from generator.config import FEATURES, MAX_FRAMES
from generator.evaluation.embedder import in_batches
from generator.evaluation.metrics import Floats
from generator.evaluation.pairs import UNIT, Features, Pair
from generator.evaluation.words import FILES, TAGS, WIDTH, PublishedWords
from generator.nn.evaluator import CONTACTS
from ros_free_stack.errors import InvalidFile

NETWORKS = Path("t2m/text_mot_match/model/finest.tar")
STATISTICS = Path("t2m/Comp_v6_KLD005/meta")


@dataclass(frozen=True)
class OfficialFiles:
    """Where the parts lie; see the module."""

    dataset: Path
    words: Path
    networks: Path
    statistics: Path

    @classmethod
    def find(cls, folder: Path) -> Self:
        """Find the parts, or InvalidFile with the places where the missing one was looked for."""
        return cls(
            _first(folder, ("", "HumanML3D", "dataset/HumanML3D"), Path("new_joint_vecs"), "the data set").parent,
            _first(folder, ("", "glove"), Path(FILES[0]), "the GloVe vectors").parent,
            _first(folder, ("", "checkpoints"), NETWORKS, "the evaluator's networks"),
            _first(folder, ("", "checkpoints"), STATISTICS / "mean.npy", "the evaluator's statistics").parent,
        )


class MovementEncoder(nn.Module):
    """Standardised features (B, T, 259) to movements (B, T / 4, 512); named as in the published weights."""

    def __init__(self, width: int = 512) -> None:
        super().__init__()
        self.main = nn.Sequential(
            nn.Conv1d(FEATURES - CONTACTS, width, 4, 2, 1),
            nn.Dropout(0.2),
            nn.LeakyReLU(0.2),
            nn.Conv1d(width, width, 4, 2, 1),
            nn.Dropout(0.2),
            nn.LeakyReLU(0.2),
        )
        self.out_net = nn.Linear(width, width)

    def forward(self, features: Tensor) -> Tensor:
        return self.out_net(self.main(features.transpose(1, 2)).transpose(1, 2))


class SequenceEncoder(nn.Module):
    """Rows (B, N, I) of so many steps (B,) to (B, 512): BiGRU with a learned first state; named as published."""

    def __init__(self, inputs: int, width: int, outputs: int = 512) -> None:
        super().__init__()
        self.input_emb = nn.Linear(inputs, width)
        self.gru = nn.GRU(width, width, batch_first=True, bidirectional=True)
        self.output_net = nn.Sequential(
            nn.Linear(2 * width, width), nn.LayerNorm(width), nn.LeakyReLU(0.2), nn.Linear(width, outputs)
        )
        self.hidden = nn.Parameter(torch.randn(2, 1, width))

    def forward(self, rows: Tensor, steps: Tensor) -> Tensor:
        packed = pack_padded_sequence(self.input_emb(rows), steps, batch_first=True, enforce_sorted=False)
        _, last = self.gru(packed, self.hidden.expand(-1, len(rows), -1).contiguous())
        return self.output_net(torch.cat([last[0], last[1]], dim=-1))


class TextEncoder(SequenceEncoder):
    """Word vectors (B, N, 300) and one-hot parts of speech (B, N, 15) to (B, 512)."""

    def __init__(self) -> None:
        super().__init__(WIDTH, 512)
        self.pos_emb = nn.Linear(len(TAGS), WIDTH)

    def embed(self, vectors: Tensor, tags: Tensor, steps: Tensor) -> Tensor:
        return self(vectors + self.pos_emb(tags), steps)


class OfficialEmbedder:
    """The published networks as an `Embedder`; its pairs must come from the published data set.

    Raises:
        InvalidFile: a part is missing, or is not what its name says.
    """

    name = "official evaluator"

    def __init__(self, files: OfficialFiles, device: str = "cpu") -> None:
        self._words = PublishedWords(files.words)
        self._mean, self._std = (
            torch.from_numpy(_statistic(files.statistics / name)).to(device) for name in ("mean.npy", "std.npy")
        )
        state = _networks(files.networks)
        self._movement, self._motion, self._text = (
            _filled(network, state, name, files.networks).to(device).eval().requires_grad_(False)
            for name, network in (
                ("movement_encoder", MovementEncoder()),
                ("motion_encoder", SequenceEncoder(512, 1024)),
                ("text_encoder", TextEncoder()),
            )
        )

    def motions(self, features: Sequence[Features]) -> Floats:
        return in_batches(features, self._motions)

    def texts(self, pairs: Sequence[Pair]) -> Floats:
        return in_batches([pair.tokens for pair in pairs], self._texts)

    def _motions(self, features: list[Features]) -> Tensor:
        """All are padded to 196 frames of zeros, which the convolution sees at a motion's end, as published."""
        padded = torch.zeros(len(features), MAX_FRAMES, FEATURES, device=self._mean.device)
        for row, values in zip(padded, features, strict=True):
            row[: len(values)] = (torch.from_numpy(values).to(self._mean) - self._mean) / self._std
        steps = torch.tensor([len(values) // UNIT for values in features])
        return self._motion(self._movement(padded[..., :-CONTACTS]), steps)

    def _texts(self, captions: list[tuple[tuple[str, str], ...]]) -> Tensor:
        vectors, tags = zip(*(self._words(tokens) for tokens in captions), strict=True)
        steps = torch.tensor([len(rows) for rows in vectors])
        padded = (pad_sequence(rows, batch_first=True).to(self._mean) for rows in (list(vectors), list(tags)))
        return self._text.embed(*padded, steps)


def _first(folder: Path, places: Sequence[str], part: Path, what: str) -> Path:
    for place in places:
        if (folder / place / part).exists():
            return folder / place / part
    tried = ", ".join(str(folder / place / part) for place in places)
    raise InvalidFile(folder, f"lacks {what}; looked for {tried}")


def _statistic(path: Path) -> np.ndarray:
    try:
        values = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise InvalidFile(path, f"not a readable .npy ({error})") from None
    if values.shape != (FEATURES,):
        raise InvalidFile(path, f"expected shape ({FEATURES},), found {values.shape}")
    return values.astype(np.float32)


def _networks(path: Path) -> dict[str, Any]:
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
    except (OSError, RuntimeError, EOFError, ValueError, KeyError, pickle.UnpicklingError) as error:
        raise InvalidFile(path, f"not a readable checkpoint ({str(error).splitlines()[0]})") from None
    if not isinstance(state, dict):
        raise InvalidFile(path, f"expected the state of three networks, found {type(state).__name__}")
    return state


def _filled(network: nn.Module, state: dict[str, Any], name: str, path: Path) -> Any:
    try:
        network.load_state_dict(state[name])
    except KeyError:
        raise InvalidFile(path, f"has no {name}; found {', '.join(map(str, state))}") from None
    except (RuntimeError, TypeError, AttributeError) as error:
        raise InvalidFile(path, f"{name} does not fit the published sizes ({str(error).splitlines()[-1]})") from None
    return network
