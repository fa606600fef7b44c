"""Local and global temporal enhancement (ParTY, section 3.1): frames to windows, windows told of each other."""

from typing import Literal

import torch
from torch import Tensor, nn
from torch.nn import functional

Adjacency = Literal["full", "banded", "none"]

NEAR = 2
"""Windows on either side that the banded graph joins."""


def window_mask(frames: Tensor, window: int) -> Tensor:
    """(B, n) true on windows that hold a frame, from frames (B, n * window)."""
    return frames.unflatten(1, (-1, window)).any(-1)


class LocalEnhancement(nn.Module):
    """LTE (equation 1): the frames of a window as their sum, weighted by a 3-layer perceptron with softmax.

    The paper numbers the perceptron by window; motions have any number of windows, so one serves all of them.
    """

    def __init__(self, width: int, window: int) -> None:
        super().__init__()
        self.window = window
        self.score = nn.Sequential(
            nn.Linear(width, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, 1)
        )

    def weights(self, frames: Tensor, mask: Tensor) -> Tensor:
        """(B, n, window) weights of frames (B, n * window, D), which add up to 1 over the frames of `mask`; zeros in a
        window without any."""
        inside = mask.unflatten(1, (-1, self.window))
        scores = self.score(frames)[..., 0].unflatten(1, (-1, self.window)).masked_fill(~inside, -torch.inf)
        return scores.masked_fill(~inside.any(-1, keepdim=True), 0.0).softmax(-1) * inside

    def forward(self, frames: Tensor, mask: Tensor) -> Tensor:
        """Frames (B, n * window, D) with their mask to windows (B, n, D)."""
        weights = self.weights(frames, mask)
        return (weights[..., None] * frames.unflatten(1, (-1, self.window))).sum(2)


class Mean(nn.Module):
    """What is left without LTE: the plain mean of a window's frames."""

    def __init__(self, window: int) -> None:
        super().__init__()
        self.window = window

    def forward(self, frames: Tensor, mask: Tensor) -> Tensor:
        inside = mask.unflatten(1, (-1, self.window))[..., None].to(frames.dtype)
        return (inside * frames.unflatten(1, (-1, self.window))).sum(2) / inside.sum(2).clamp_min(1)


class GlobalEnhancement(nn.Module):
    """GTE (equation 2): three graph convolutions over the windows of a motion, with GELU.

    Each layer adds to its input, which the paper does not say. Without that the fully connected graph, whose normalised
    adjacency is 1 / n everywhere, gives every window of a motion the same vector, and all its tokens are one.
    """

    def __init__(self, width: int, adjacency: Adjacency, layers: int = 3) -> None:
        super().__init__()
        self.adjacency: Adjacency = adjacency
        self.layers = nn.ModuleList(nn.Linear(width, width, bias=False) for _ in range(layers))

    def forward(self, windows: Tensor, mask: Tensor) -> Tensor:
        """Windows (B, n, D) with their mask (B, n), to the same shape."""
        graph = normalised_adjacency(mask, self.adjacency).to(windows.dtype)
        for layer in self.layers:
            windows = windows + functional.gelu(graph @ layer(windows))
        return windows


def normalised_adjacency(mask: Tensor, kind: Adjacency) -> Tensor:
    """(B, n, n) of D^-1/2 A D^-1/2 (Kipf and Welling 2017) with self loops, zero on windows outside of the mask (B, n).

    "full" joins all windows, "banded" those at most two apart.
    """
    joined = mask[:, :, None] & mask[:, None, :]
    if kind == "banded":
        place = torch.arange(mask.shape[1], device=mask.device)
        joined = joined & ((place[:, None] - place).abs() <= NEAR)
    edges = joined.float()
    degree = edges.sum(-1).clamp_min(1).rsqrt()
    return degree[:, :, None] * edges * degree[:, None, :]
