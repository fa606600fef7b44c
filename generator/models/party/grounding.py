"""Part-aware text grounding (ParTY, section 3.2): a text in several embeddings, of which each part takes its share."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn import functional


@dataclass(frozen=True)
class Grounded:
    """Texts as the parts are told them.

    Attributes:
        embeddings: (B, R, K, W) transformed embeddings of each row.
        shares: of each part (B, R, K), which add up to 1.
        parts: of each part (B, R, W).
    """

    embeddings: Tensor
    shares: dict[str, Tensor]
    parts: dict[str, Tensor]


class TextGrounding(nn.Module):
    """K perceptrons of three layers, and a linear gate for each part.

    Args:
        row_width, text_width: of what is read of a row, and of the embeddings.
        width: of the hidden layers.
        embeddings: K.
    """

    def __init__(self, *, row_width: int, text_width: int, width: int, embeddings: int, parts: Sequence[str]) -> None:
        super().__init__()
        self.views = nn.ModuleList(_perceptron(row_width, width, text_width) for _ in range(embeddings))
        self.gates = nn.ModuleDict({part: nn.Linear(row_width, embeddings) for part in parts})

    def forward(self, rows: Tensor) -> Grounded:
        """Rows (B, R, I) as each part is told them."""
        embeddings = torch.stack([view(rows) for view in self.views], dim=-2)
        gates = cast(dict[str, nn.Linear], self.gates)
        shares = {part: gate(rows).softmax(-1) for part, gate in gates.items()}
        parts = {part: (share[..., None] * embeddings).sum(-2) for part, share in shares.items()}
        return Grounded(embeddings, shares, parts)


def diversity_loss(embeddings: Tensor, text: Tensor, temperature: float) -> Tensor:
    """Equation 3 of embeddings (N, K, W) of texts (N, W): each near its text and away from the others of that text."""
    unit, anchor = functional.normalize(embeddings, dim=-1), functional.normalize(text, dim=-1)
    near = (unit * anchor[:, None]).sum(-1) / temperature  # (N, K)
    others = unit @ unit.transpose(-1, -2) / temperature
    own = torch.eye(unit.shape[1], dtype=torch.bool, device=unit.device)
    all_of_them = torch.cat([near[..., None], others.masked_fill(own, -torch.inf)], dim=-1)
    return (all_of_them.logsumexp(-1) - near).mean()


def _perceptron(inputs: int, width: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, outputs)
    )
