"""Best of N: what does not show its text is sampled again.

A first sample that shows all of its texts stays. Otherwise the segments in which it is wrong are sampled anew, with a
little of either neighbour, while the rest is held. Of several such samples the one with the fewest violations stays,
and what is still wrong in it is sampled again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from generator.model import Known, MotionModel, Sample, Sampling, TextCondition

SEAM_S: Final = 0.2
"""So much of either neighbour is sampled anew too."""

Judge = Callable[[Tensor, Sequence[int]], NDArray[np.int64]]
"""Features (T, F) of a motion and the frames of each segment (A,) to how much is wrong with each (A,)."""


@dataclass(frozen=True)
class Resampler:
    """Samples of a model; `judge` compares them.

    Attributes:
        samples, rounds: how many samples of what is wrong are compared, and how often.
    """

    model: MotionModel
    sampling: Sampling
    judge: Judge
    samples: int = 8
    rounds: int = 3

    def sample(self, text: TextCondition, known: Known | None, noise: torch.Generator) -> Sample:
        """The best sample of a single motion.

        Args:
            text: one row.
            known: frames that stay.
        """
        best, wrong = self._least_wrong(text, known, noise)
        several = text.repeated(self.samples)
        for _ in range(self.rounds):
            if not wrong.any():
                break
            held = self._held(best, self._widened(wrong, text.frames[0]), known).repeated(self.samples)
            found, violations = self._least_wrong(several, held, noise)
            if violations.sum() < wrong.sum():
                best, wrong = found, violations
        return best

    def _least_wrong(
        self, text: TextCondition, known: Known | None, noise: torch.Generator
    ) -> tuple[Sample, NDArray[np.int64]]:
        """The sample with the fewest violations, one for each row, and its violations (A,)."""
        samples = self.model.sample(text, known=known, sampling=self.sampling, noise=noise)
        found = [
            self.judge(sample.features, frames[frames > 0].tolist())
            for sample, frames in zip(samples, text.frames, strict=True)
        ]
        least = int(np.argmin([violations.sum() for violations in found]))
        return samples[least], found[least]

    def _widened(self, wrong: NDArray[np.int64], frames: Tensor) -> Tensor:
        """(T,) true on the frames of the segments that are wrong, and on a seam of either neighbour."""
        spec = self.model.spec
        seam = max(1, round(SEAM_S / spec.token_s)) * spec.token_frames
        lengths = frames[frames > 0]
        chosen = torch.from_numpy(wrong > 0).to(lengths.device).repeat_interleave(lengths)
        return functional.max_pool1d(chosen.float()[None], 2 * seam + 1, stride=1, padding=seam)[0] > 0

    def _held(self, sample: Sample, again: Tensor, known: Known | None) -> Known:
        """The sample as known frames but for those to be sampled `again` (T,); what was given stays given."""
        features = sample.features[None]
        mask = ~again[None]
        latent = None if sample.latent is None else sample.latent[..., None, :]
        if known is None:
            return Known(features, mask, features[0, :0], features[0, :0], latent)
        given = features if latent is not None else torch.where(known.mask[..., None], known.features, features)
        return replace(known, features=given, mask=mask | known.mask, latent=latent)
