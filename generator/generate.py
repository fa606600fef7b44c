"""From a prompt and its segments to human motion, with trained weights."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self, TypeVar

import numpy as np
import torch
from torch import nn

from generator import weights
from generator.config import (
    MAX_FRAMES,
    MIN_FRAMES,
    TOKEN_FRAMES,
    DurationsConfig,
    Sampling,
    TokenizerConfig,
    TransformerConfig,
)
from generator.data.features import decode
from generator.foot_lock import lock_feet
from generator.models.conditioning import Condition, check_segments, stack_lengths, uniform_lengths
from generator.models.durations import DurationModel, whole_tokens
from generator.models.mask_transformer import MaskTransformer
from generator.models.residual_transformer import ResidualTransformer
from generator.models.tokenizer import MotionTokenizer
from generator.text.encoder import TextEncoder
from ros_free_stack.console import say
from ros_free_stack.errors import InvalidOption, NoWeights
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS

WEIGHTS_FOLDER: Final = Path(__file__).parent / "weights"
"""The weights that come with the program."""

MIN_S, MAX_S = MIN_FRAMES / FPS, MAX_FRAMES / FPS

Model = TypeVar("Model", bound=nn.Module)


@dataclass(frozen=True)
class MotionGenerator:
    """The trained models; make one with `MotionGenerator.load`."""

    tokenizer: MotionTokenizer
    mask: MaskTransformer
    residual: ResidualTransformer
    durations: DurationModel
    text_encoder: TextEncoder
    name: str

    @classmethod
    def load(
        cls, folder: Path = WEIGHTS_FOLDER, *, text_encoder: TextEncoder | None = None, device: str = "cpu"
    ) -> Self:
        """Read the four models; `text_encoder` may be given where there already is one.

        Raises:
            NoWeights: a model is not trained, or was trained with another tokenizer; the message says what to do.
        """
        saved = {name: weights.load(folder / name, name) for name in ("tokenizer", "mask", "residual", "durations")}
        for name in ("mask", "residual"):
            if saved[name].facts.get("tokenizer") != saved["tokenizer"].digest:
                raise NoWeights(
                    f"{folder / name}: was trained with another tokenizer than the one in {folder}; "
                    f"train it again with `python launch.py train {name} --dataset DATASET --out {folder}`"
                )

        def fill(name: str, model: Model) -> Model:
            saved[name].fill(model)
            return model.to(device).eval().requires_grad_(False)

        return cls(
            fill("tokenizer", MotionTokenizer(saved["tokenizer"].config_as(TokenizerConfig))),
            fill("mask", MaskTransformer(saved["mask"].config_as(TransformerConfig))),
            fill("residual", ResidualTransformer(saved["residual"].config_as(TransformerConfig))),
            fill("durations", DurationModel(saved["durations"].config_as(DurationsConfig))),
            text_encoder or TextEncoder(),
            f"generator {saved['mask'].digest[:8]}",
        )

    def generate(
        self,
        prompt: str,
        segments: Sequence[str],
        *,
        seed: int,
        candidates: int = 1,
        duration_s: float | None = None,
        durations_s: Sequence[float] | None = None,
        sampling: Sampling | None = None,
    ) -> tuple[HumanMotion, ...]:
        """Generate motions; the same arguments give the same motions.

        Args:
            prompt: the whole sentence.
            segments: its 1 to 5 segment texts in temporal order.
            candidates: how many motions, which differ in noise and a little in timing.
            duration_s: total duration, 2 to 9.8 s; shared among the segments as the model predicts.
            durations_s: duration of each segment instead.

        Raises:
            InvalidOption: a number is out of range.
        """
        check_segments(len(segments), MAX_FRAMES // TOKEN_FRAMES)
        if candidates < 1:
            raise InvalidOption("candidates", f"must be at least 1, found {candidates}")
        sampling = sampling or Sampling()
        device = self.tokenizer.mean.device
        noise = torch.Generator(device).manual_seed(seed)
        embeddings = torch.from_numpy(self.text_encoder.encode_sentences([prompt, *segments])).to(device)
        texts = embeddings[1:]
        if durations_s is None:
            seconds = self._durations(texts, candidates, sampling.duration_spread, duration_s, noise)
        else:
            seconds = np.tile(_checked_durations(durations_s, len(segments)), (candidates, 1))
        lengths = [whole_tokens(row) for row in seconds]
        if self.mask.config.layout == "uniform":
            lengths = [uniform_lengths(len(row), int(row.sum())) for row in lengths]
        condition = Condition(
            embeddings[:1].expand(candidates, -1),
            texts.expand(candidates, -1, -1),
            stack_lengths(lengths).to(device),
        )
        with torch.inference_mode():
            base = self.mask.generate(condition, sampling, noise)
            tokens = self.residual.generate(base, condition, sampling, noise)
            features = self._decode(tokens, condition)
        return tuple(
            self._motion(rows, prompt, segments, row, sampling) for rows, row in zip(features, lengths, strict=True)
        )

    def _durations(
        self, texts: torch.Tensor, candidates: int, spread: float, total_s: float | None, noise: torch.Generator
    ) -> np.ndarray:
        """(candidates, A) predicted durations in s."""
        count = len(texts)
        place = torch.arange(count, device=texts.device)
        with torch.inference_mode():
            mean, log_std = self.durations(texts, place, torch.full_like(place, count))
        draws = torch.randn(candidates, count, generator=noise, device=texts.device)
        seconds = (mean + spread * log_std.exp() * draws).exp().cpu().numpy().astype(np.float64)
        if total_s is not None:
            if not MIN_S <= total_s <= MAX_S:
                raise InvalidOption("duration", f"{total_s:g} s is outside of {MIN_S:g} to {MAX_S:g} s")
            return seconds * (total_s / seconds.sum(axis=1, keepdims=True))
        longest = seconds.sum(axis=1).max()
        if longest > MAX_S:
            say(f"the sentence would take {longest:.1f} s; it is performed faster, within {MAX_S:g} s")
        return seconds

    def _decode(self, tokens: torch.Tensor, condition: Condition) -> list[np.ndarray]:
        """Features (T, 263) of each motion, each decoded at its own length so that padding cannot reach it."""
        lengths = condition.lengths.sum(1).tolist()
        return [
            self.tokenizer.decode(tokens[:, i : i + 1, :length])[0].float().cpu().numpy()
            for i, length in enumerate(lengths)
        ]

    def _motion(
        self, features: np.ndarray, prompt: str, texts: Sequence[str], lengths: np.ndarray, sampling: Sampling
    ) -> HumanMotion:
        joints = decode(features)
        if sampling.foot_lock:
            joints = lock_feet(joints, features[:, -4:])
        joints[..., 2] -= joints[..., 2].min()
        edges = np.concatenate([[0], np.cumsum(lengths)]) * TOKEN_FRAMES / FPS
        segments = tuple(
            Segment(text, float(start), float(end))
            for text, start, end in zip(texts, edges[:-1], edges[1:], strict=True)
        )
        return HumanMotion(joints=joints, fps=FPS, prompt=prompt, segments=segments, source=self.name)


def _checked_durations(durations_s: Sequence[float], count: int) -> np.ndarray:
    seconds = np.asarray(durations_s, dtype=np.float64)
    if seconds.shape != (count,):
        raise InvalidOption("durations", f"{count} segments need as many durations, found {len(durations_s)}")
    if not (np.isfinite(seconds).all() and (seconds > 0).all() and MIN_S <= round(seconds.sum(), 6) <= MAX_S):
        raise InvalidOption(
            "durations", f"must be positive and add up to {MIN_S:g} to {MAX_S:g} s, found {list(durations_s)}"
        )
    return seconds
