"""Best of N over any model: what is wrong is sampled again and nothing else, the best sample stays, what is given is
kept."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np
import torch
from numpy.typing import NDArray

from generator.model import FeatureSpec, Known, Sample, Sampling, TextCondition
from generator.resampling import Judge, Resampler

FRAMES = (24, 28, 20)
SEAM = 4  # frames: 0.2 s


@dataclass
class Noise:
    """A model of random features (T, 2) at 20 fps that keeps what is known; without a latent, as a diffusion model."""

    name: str = "noise"
    spec: FeatureSpec = field(default_factory=lambda: FeatureSpec(2, 20.0, 20, 200))
    asked: list[Known | None] = field(default_factory=list)

    def sample(
        self, text: TextCondition, *, known: Known | None, sampling: Sampling, noise: torch.Generator
    ) -> list[Sample]:
        self.asked.append(known)
        found = []
        for row, total in enumerate(text.frames.sum(1).tolist()):
            features = torch.randn(total, 2, generator=noise)
            if known is not None:
                features = torch.where(known.mask[row, :total, None], known.features[row, :total], features)
            found.append(Sample(features))
        return found

    def reconstruct(self, features: torch.Tensor) -> None:
        return None

    @classmethod
    def load(cls, folder: Path, *, device: str) -> Self:
        return cls()


def text(*frames: int) -> TextCondition:
    count = len(frames)
    return TextCondition(
        torch.zeros(1, 8),
        torch.zeros(1, 3, 8),
        torch.ones(1, 3, dtype=torch.bool),
        torch.zeros(1, count, 8),
        torch.zeros(1, count, 2, 8),
        torch.zeros(1, count, 2, dtype=torch.long),
        torch.tensor([frames]),
    )


def noise() -> torch.Generator:
    return torch.Generator().manual_seed(0)


class Negative:
    """Counts frames whose first feature is below -1 in each segment; keeps what it was shown."""

    def __init__(self) -> None:
        self.seen: list[torch.Tensor] = []
        self.found: list[NDArray[np.int64]] = []

    def __call__(self, features: torch.Tensor, frames: Sequence[int]) -> NDArray[np.int64]:
        self.seen.append(features.clone())
        self.found.append(np.array([int((part[:, 0] < -1).sum()) for part in features.split(list(frames))]))
        return self.found[-1]


def resampler(judge: Judge, *, samples: int = 4, rounds: int = 3) -> Resampler:
    return Resampler(Noise(), Sampling(), judge, samples, rounds)


def test_the_sample_with_the_fewest_violations_stays() -> None:
    judge = Negative()
    found = resampler(judge, rounds=1).sample(text(*FRAMES), None, noise())
    totals = [violations.sum() for violations in judge.found]
    assert len(totals) == 1 + 4 and len(set(totals)) > 1
    assert torch.equal(found.features, judge.seen[int(np.argmin(totals))])


def test_more_rounds_find_what_a_single_one_does_not() -> None:
    def wrong(rounds: int) -> int:
        judge = Negative()
        found = resampler(judge, rounds=rounds).sample(text(*FRAMES), None, noise())
        return int(judge(found.features, FRAMES).sum())

    found = [wrong(rounds) for rounds in (0, 1, 2, 12)]
    assert found == sorted(found, reverse=True)
    assert found[0] > found[-1]


def test_only_what_is_wrong_is_sampled_again() -> None:
    """The middle segment never pleases: it alone changes, with a seam of either neighbour."""
    seen: list[torch.Tensor] = []

    def judge(features: torch.Tensor, frames: Sequence[int]) -> NDArray[np.int64]:
        seen.append(features.clone())
        return np.array([0, 1, 0])

    found = resampler(judge).sample(text(*FRAMES), None, noise())
    assert torch.equal(found.features, seen[0]), "no later sample was better"
    first, stop = FRAMES[0] - SEAM, FRAMES[0] + FRAMES[1] + SEAM
    later = torch.stack(seen[1:])
    assert len(later) == 3 * 4
    assert torch.equal(later[:, :first], seen[0][:first].expand_as(later[:, :first]))
    assert torch.equal(later[:, stop:], seen[0][stop:].expand_as(later[:, stop:]))
    assert (later[:, first:stop] != seen[0][first:stop]).any(-1).all()


def test_a_first_sample_without_violations_stays() -> None:
    calls: list[int] = []

    def judge(features: torch.Tensor, frames: Sequence[int]) -> NDArray[np.int64]:
        calls.append(len(frames))
        return np.zeros(len(frames), dtype=np.int64)

    own = resampler(judge)
    found = own.sample(text(*FRAMES), None, noise())
    assert calls == [3]
    (first,) = own.model.sample(text(*FRAMES), known=None, sampling=Sampling(), noise=noise())
    assert torch.equal(found.features, first.features)


def test_given_frames_stay() -> None:
    total = sum(FRAMES)
    known = Known(torch.full((1, total, 2), 7.0), torch.zeros(1, total, dtype=torch.bool), *[torch.zeros(0, 2)] * 2)
    known.mask[:, 10:30] = True
    found = resampler(lambda _, frames: np.ones(len(frames), dtype=np.int64)).sample(text(*FRAMES), known, noise())
    assert (found.features[10:30] == 7).all()
    assert (found.features[:10] != 7).all() and (found.features[30:] != 7).all()


def test_same_noise_same_sample() -> None:
    one, two = (resampler(Negative()).sample(text(*FRAMES), None, noise()).features for _ in range(2))
    assert torch.equal(one, two)
