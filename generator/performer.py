"""From a prompt and its segments to human motion, with trained weights."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Self, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from generator import weights
from generator.config import (
    MAX_TOKENS,
    TOKEN_FRAMES,
    TOKEN_S,
    DurationsConfig,
    Sampling,
    TokenizerConfig,
    TransformerConfig,
)
from generator.editing import concatenated, replaced, token_range
from generator.models.segmo.conditioning import Condition, check_segments, stack_lengths, uniform_lengths
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.residual_transformer import ResidualTransformer
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.nn.durations import DurationModel, whole_tokens
from generator.postprocess.context import CONTEXT_TOKENS, Context
from generator.postprocess.stitch import placed
from generator.probes.signals import Signals
from generator.resampling import Drafting
from generator.self_check import SelfCheck
from generator.text.counts import segment_counts
from generator.text.encoder import TextEncoder
from generator.text.meanwhile import encode_segments
from generator.text.understanding import DOMAIN
from generator.timing import checked_durations, fitted, part_sizes
from ros_free_stack.console import say
from ros_free_stack.errors import InvalidOption, NoWeights
from ros_free_stack.formats.features import decode
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS

WEIGHTS_FOLDER: Final = Path(__file__).parent / "weights"
"""The weights that come with the program."""

CONTEXT_S: Final = CONTEXT_TOKENS * TOKEN_S

Model = TypeVar("Model", bound=nn.Module)


@dataclass(frozen=True)
class Performer:
    """The trained models; make one with `Performer.load`. Without `self_check` the first draft is taken."""

    tokenizer: MotionTokenizer
    mask: MaskTransformer
    residual: ResidualTransformer
    durations: DurationModel
    text_encoder: TextEncoder
    name: str
    self_check: SelfCheck | None = None

    @classmethod
    def load(
        cls, folder: Path = WEIGHTS_FOLDER, *, text_encoder: TextEncoder | None = None, device: str = "cpu"
    ) -> Self:
        """Read the four models; `text_encoder` may be given where there already is one.

        Motions are held against their texts where the folder has the known texts.

        Raises:
            NoWeights: a model is not trained, or was trained with another tokenizer; the message says what to do.
            InvalidFile: the known texts are damaged.
        """
        saved = {name: weights.load(folder / name, name) for name in ("tokenizer", "mask", "residual", "durations")}
        for name in ("mask", "residual"):
            if saved[name].facts.get("tokenizer") != saved["tokenizer"].digest:
                raise NoWeights(
                    f"{folder / name}: was trained with another tokenizer than the one in {folder}; "
                    f"train it again with `python launch.py train {name} --dataset DATASET --out {folder}`"
                )

        encoder = text_encoder or TextEncoder()

        def fill(name: str, model: Model) -> Model:
            saved[name].fill(model)
            return model.to(device).eval().requires_grad_(False)

        return cls(
            fill("tokenizer", MotionTokenizer(saved["tokenizer"].config_as(TokenizerConfig))),
            fill("mask", MaskTransformer(saved["mask"].config_as(TransformerConfig))),
            fill("residual", ResidualTransformer(saved["residual"].config_as(TransformerConfig))),
            fill("durations", DurationModel(saved["durations"].config_as(DurationsConfig))),
            encoder,
            f"generator {saved['mask'].digest[:8]}",
            SelfCheck.load(folder, encoder) if (folder / DOMAIN).exists() else None,
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
        start: HumanMotion | None = None,
        sampling: Sampling | None = None,
    ) -> tuple[HumanMotion, ...]:
        """Generate motions; the same arguments give the same motions.

        A sentence that takes longer than the models can see is generated in parts that go on from each other.

        Args:
            prompt: the whole sentence.
            segments: its 1 to 5 segment texts in temporal order; up to 4 with `start`.
            candidates: how many motions, which differ in noise and a little in timing.
            duration_s: total duration, 2 to 9.8 s, with `start` to 8.8 s; shared among the segments as predicted.
            durations_s: duration of each segment instead.
            start: a motion to go on from: the new one begins with the frame after its last one, without a jump.

        Raises:
            InvalidOption: a number is out of range, or `start` is too short or not at 20 frames a second.
        """
        _check(candidates, len(segments) + (start is not None), MAX_TOKENS)
        sampling = sampling or Sampling()
        noise = self._noise(seed)
        most_s = (MAX_TOKENS - CONTEXT_TOKENS * (start is not None)) * TOKEN_S
        if durations_s is not None:
            seconds = np.tile(checked_durations(durations_s, len(segments), most_s), (candidates, 1))
            return self._perform(prompt, segments, seconds, start, sampling, noise)
        seconds = self._durations(segments, candidates, sampling.duration_spread, noise)
        if duration_s is not None:
            return self._perform(prompt, segments, fitted(seconds, duration_s, most_s), start, sampling, noise)
        sizes = part_sizes(seconds.mean(axis=0).tolist(), most_s, MAX_TOKENS * TOKEN_S - CONTEXT_S)
        if len(sizes) > 1:
            return self._in_turn(prompt, segments, seconds, sizes, start, sampling, noise)
        return self._perform(prompt, segments, seconds, start, sampling, noise)

    def _in_turn(
        self,
        prompt: str,
        segments: Sequence[str],
        seconds: np.ndarray,
        sizes: Sequence[int],
        start: HumanMotion | None,
        sampling: Sampling,
        noise: torch.Generator,
    ) -> tuple[HumanMotion, ...]:
        """Motions of parts of a sentence; each part goes on from the one before."""
        grown: list[list[HumanMotion]] = [[] for _ in seconds]
        first = 0
        for size in sizes:
            texts, timing = segments[first : first + size], seconds[:, first : first + size]
            for chunks, row in zip(grown, timing, strict=True):
                last = chunks[-1] if chunks else start
                chunks.extend(self._perform(", then ".join(texts), texts, row[None], last, sampling, noise))
            first += size
        return tuple(replace(concatenated(chunks), prompt=prompt) for chunks in grown)

    def _perform(
        self,
        prompt: str,
        segments: Sequence[str],
        seconds: np.ndarray,
        start: HumanMotion | None,
        sampling: Sampling,
        noise: torch.Generator,
    ) -> tuple[HumanMotion, ...]:
        """Motions of segments of such durations (candidates, A) in s, at once."""
        around = _after(start)
        most, longest = MAX_TOKENS - sum(around.tokens), float(seconds.sum(axis=1).max())
        if longest > (most + 0.5) * TOKEN_S:
            say(f"{prompt}: would take {longest:.1f} s; it is performed faster, within {most * TOKEN_S:g} s")
        lengths = [self._laid_out(whole_tokens(row, most=most)) for row in seconds]
        features = self._features(prompt, segments, lengths, around, sampling, noise)
        return tuple(
            self._motion(around.joined(rows, foot_lock=sampling.foot_lock)[0], prompt, segments, row, start is None)
            for rows, row in zip(features, lengths, strict=True)
        )

    def edit(
        self,
        motion: HumanMotion,
        prompt: str,
        segments: Sequence[str],
        *,
        start_s: float,
        end_s: float,
        seed: int,
        candidates: int = 1,
        sampling: Sampling | None = None,
    ) -> tuple[HumanMotion, ...]:
        """Motions like the given one with the time from `start_s` to `end_s` generated anew from a prompt.

        The range ends after whole tokens of 0.2 s. The frames before it do not change; those after it keep their
        poses, and move over the floor as a whole to where the new range leads.

        Args:
            motion: what to change, at 20 frames a second.
            prompt: what happens in the range instead.
            segments: its 1 to 3 segment texts.
            start_s, end_s: the range, 0.4 to 7.8 s long, not the whole motion.

        Raises:
            InvalidOption: a number is out of range, or the motion is not at 20 frames a second.
        """
        frames = len(motion.joints)
        first, last = token_range(start_s, end_s, frames)
        around = Context.of_range(motion, first, last)
        tokens = -(-(last - first) // TOKEN_FRAMES)
        _check(candidates, len(segments) + sum(count > 0 for count in around.tokens), MAX_TOKENS)
        check_segments(len(segments), tokens)
        sampling = sampling or Sampling()
        noise = self._noise(seed)
        seconds = self._durations(segments, candidates, sampling.duration_spread, noise)
        lengths = [self._laid_out(whole_tokens(row, least=tokens, most=tokens)) for row in seconds]
        features = self._features(prompt, segments, lengths, around, sampling, noise)
        edited: list[HumanMotion] = []
        for rows, row in zip(features, lengths, strict=True):
            middle, follows = around.joined(rows, foot_lock=sampling.foot_lock)
            rest = motion.joints[last:]
            if len(rest):
                rest = placed(rest, rest[: len(follows)], follows)
            new = self._motion(middle[: last - first], prompt, segments, row, first == 0 and last == frames)
            joints = np.concatenate([motion.joints[:first], new.joints, rest])
            edited.append(replace(new, joints=joints, segments=replaced(motion, new, first / FPS, last / FPS)))
        return tuple(edited)

    def missing(self, motion: HumanMotion) -> tuple[str, ...]:
        """What a motion does not show of its segments' texts, a line each; nothing where that cannot be said."""
        return self.self_check.missing(motion) if self.self_check else ()

    def _noise(self, seed: int) -> torch.Generator:
        return torch.Generator(self.tokenizer.mean.device).manual_seed(seed)

    def _texts(self, texts: Sequence[str]) -> torch.Tensor:
        """(N, 384) embeddings."""
        return torch.from_numpy(self.text_encoder.encode_sentences(list(texts))).to(self.tokenizer.mean.device)

    def _durations(self, segments: Sequence[str], candidates: int, spread: float, noise: torch.Generator) -> np.ndarray:
        """(candidates, A) predicted durations in s."""
        count = len(segments)
        place = torch.arange(count, device=self.tokenizer.mean.device)
        with torch.inference_mode():
            mean, log_std = self.durations(
                self._texts(segments),
                torch.from_numpy(segment_counts(segments)).to(place.device),
                place,
                torch.full_like(place, count),
            )
        draws = torch.randn(candidates, count, generator=noise, device=place.device)
        return (mean + spread * log_std.exp() * draws).exp().cpu().numpy().astype(np.float64)

    def _laid_out(self, lengths: np.ndarray) -> np.ndarray:
        if self.mask.config.layout == "uniform":
            return uniform_lengths(len(lengths), int(lengths.sum()))
        return lengths

    def _features(
        self,
        prompt: str,
        segments: Sequence[str],
        lengths: Sequence[np.ndarray],
        around: Context,
        sampling: Sampling,
        noise: torch.Generator,
    ) -> list[np.ndarray]:
        """Features (T, 263) of each candidate with the tokens around it, which the models see and keep."""
        device = self.tokenizer.mean.device
        before, after = around.tokens
        texts = [*[around.before_text][: before > 0], *segments, *[around.after_text][: after > 0]]
        sentence = prompt if len(texts) == len(segments) else ", then ".join(texts)
        clauses = torch.from_numpy(encode_segments(self.text_encoder, texts)).to(device)
        whole = [np.array([*[before][: before > 0], *row, *[after][: after > 0]]) for row in lengths]
        condition = Condition(
            self._texts([sentence]).expand(len(whole), -1),
            clauses.expand(len(whole), -1, -1, -1),
            torch.from_numpy(segment_counts(texts)).to(device).expand(len(whole), -1, -1),
            stack_lengths(whole).to(device),
        )
        with torch.inference_mode():
            known = self._known(around, condition)
            base = self._base(texts, condition, sampling, noise, known[: self.mask.config.parts])
            tokens = self.residual.generate(base, condition, sampling, noise, known)
            # Each at its own length, so that padding cannot reach it.
            return [
                self.tokenizer.decode(tokens[:, i : i + 1, : row.sum()])[0].float().cpu().numpy()
                for i, row in enumerate(whole)
            ]

    def _base(
        self,
        texts: Sequence[str],
        condition: Condition,
        sampling: Sampling,
        noise: torch.Generator,
        known: torch.Tensor,
    ) -> torch.Tensor:
        """Base tokens (P, B, T), of drafts that show their texts where motions are held against them."""
        if self.self_check is None or not sampling.rounds:
            return self.mask.generate(condition, sampling, noise, known)
        check, asked = self.self_check, self.self_check.asked(texts)

        def judge(tokens: torch.Tensor, lengths: Sequence[int]) -> NDArray[np.int64]:
            signals = Signals.of(decode(self.tokenizer.decode(tokens[:, None])[0].float().cpu().numpy()))
            ends = np.cumsum(lengths) * TOKEN_FRAMES
            windows = list(zip((0, *ends[:-1].tolist()), ends.tolist(), strict=True))
            return check.mistakes(signals, windows, asked)

        return Drafting(self.mask, sampling, judge).draw(condition, known, noise)

    def _known(self, around: Context, condition: Condition) -> torch.Tensor:
        """(Q P, B, T) tokens of the surroundings, -1 where there are none."""
        before, after = around.tokens
        rows = self.residual.config.quantizers * self.residual.config.parts
        known = condition.lengths.new_full((rows, *condition.token_mask.shape), -1)
        features = [torch.from_numpy(part).float()[None].to(known.device) for part in around.features()]
        if before:
            known[:, :, :before] = self.tokenizer.encode(features[0])[..., -before:]
        if after:
            given = self.tokenizer.encode(features[1])[:, 0, :after]
            for i, end in enumerate(condition.lengths.sum(1).tolist()):
                known[:, i, end - after : end] = given
        return known

    def _motion(
        self, joints: np.ndarray, prompt: str, texts: Sequence[str], lengths: np.ndarray, on_floor: bool
    ) -> HumanMotion:
        """A motion of such segments; `on_floor` puts its lowest joint on the floor."""
        if on_floor:
            joints = joints - [0.0, 0.0, joints[..., 2].min()]
        edges = np.concatenate([[0], np.cumsum(lengths)]) * TOKEN_FRAMES / FPS
        segments = tuple(
            Segment(text, float(start), float(end))
            for text, start, end in zip(texts, edges[:-1], edges[1:], strict=True)
        )
        return HumanMotion(joints=joints, fps=FPS, prompt=prompt, segments=segments, source=self.name)


def _check(candidates: int, segments: int, tokens: int) -> None:
    check_segments(segments, tokens)
    if candidates < 1:
        raise InvalidOption("candidates", f"must be at least 1, found {candidates}")


def _after(start: HumanMotion | None) -> Context:
    """What comes before a motion that goes on from another."""
    if start is None:
        return Context.none()
    if len(start.joints) < CONTEXT_TOKENS * TOKEN_FRAMES:
        raise InvalidOption("start", f"lasts {start.duration_s:g} s, needs at least {CONTEXT_S:g} s to go on from")
    return Context.of_range(start, len(start.joints), len(start.joints))
