"""From a sentence and its segments to human motion, with any model: durations, samples, verification, foot lock."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from generator import weights
from generator.config import MAX_ACTIONS, MAX_SEGMENTS
from generator.continuation import concatenated
from generator.datasets.layout import HUMAN
from generator.model import Known, MotionModel, Sampling, TextCondition
from generator.nn.durations import DurationModel, DurationsConfig
from generator.postprocess.context import CONTEXT_FRAMES, CONTEXT_S, Context
from generator.probes.signals import Signals
from generator.registry import DEFAULT, SHARED, WEIGHTS_FOLDER
from generator.registry import generator as registered
from generator.resampling import Resampler
from generator.text.condition import Texts, read_texts
from generator.text.counts import segment_counts
from generator.text.encoder import TextEncoder
from generator.text.understanding import DOMAIN
from generator.timing import check_segments, checked_durations, fitted, part_sizes, whole_frames
from generator.verifier import Mismatch, Verifier
from ros_free_stack.console import say
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import decode
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS

Features = NDArray[np.float32]


@dataclass(frozen=True)
class PerformerSettings:
    """Settings of generation that do not depend on the model.

    Attributes:
        sampling: how the model samples.
        duration_spread: how much of the predicted spread of durations the seed plays out.
        foot_lock: hold standing feet still, see `generator.postprocess.foot_lock`.
        samples, rounds: how many samples of what does not show its text are compared, and how often; with no rounds
            the first sample is taken as it is. See `generator.resampling`.
    """

    sampling: Sampling = field(default_factory=Sampling)
    duration_spread: float = 0.3
    foot_lock: bool = True
    samples: int = 8
    rounds: int = 3


FIRST_SAMPLES: Final = PerformerSettings(rounds=0)
"""Take the first sample as it is."""


@dataclass(frozen=True)
class Performer:
    """A model with what turns sentences into motions; make one with `Performer.load`.

    Attributes:
        verifier: holds motions against their texts; without it the first sample is taken.
    """

    model: MotionModel
    durations: DurationModel
    text_encoder: TextEncoder
    verifier: Verifier | None = None
    device: str = "cpu"

    @classmethod
    def load(
        cls,
        folder: Path = WEIGHTS_FOLDER,
        *,
        generator: str = DEFAULT,
        text_encoder: TextEncoder | None = None,
        device: str = "cpu",
    ) -> Self:
        """Read the models; `text_encoder` may be given where there already is one.

        Motions are held against their texts where the folder has the known texts.

        Raises:
            UnknownName: there is no such generator.
            NoWeights: a model is not trained; the message says what to do.
            InvalidFile: the known texts are damaged.
            InvalidOption: the model was trained on another skeleton than that of human motion.
        """
        model = registered(generator).load(folder, device)
        if (model.spec.width, model.spec.fps) != (HUMAN.width, HUMAN.fps):
            raise InvalidOption(
                "generator",
                f"{model.name} makes {model.spec.width} features at {model.spec.fps:g} frames a second; human motion "
                f"has {HUMAN.width} at {HUMAN.fps:g}",
            )
        shared = folder / SHARED
        saved = weights.load(shared / "durations", "durations")
        durations = DurationModel(saved.config_as(DurationsConfig))
        saved.fill(durations)
        encoder = text_encoder or TextEncoder()
        verifier = Verifier.load(shared, encoder) if (shared / DOMAIN).exists() else None
        return cls(model, durations.to(device).eval().requires_grad_(False), encoder, verifier, device)

    def generate(
        self,
        prompt: str,
        segments: Sequence[str],
        *,
        seed: int,
        candidates: int = 1,
        duration_s: float | None = None,
        durations_s: Sequence[float] | None = None,
        lasting_s: Sequence[float | None] | None = None,
        start: HumanMotion | None = None,
        settings: PerformerSettings | None = None,
    ) -> tuple[HumanMotion, ...]:
        """Generate motions; the same arguments give the same motions.

        A sentence that takes longer than the model can see, or has more actions, is generated in parts that go on from
        each other; one whose durations are given has to fit into one part.

        Args:
            prompt: the whole sentence.
            segments: its 1 to 20 segment texts in temporal order.
            candidates: how many motions, which differ in noise and a little in timing.
            duration_s: total duration, for a model of 196 frames 2 to 9.8 s, with `start` to 8.8 s; shared among the
                segments as predicted.
            durations_s: duration of each segment instead.
            lasting_s: duration of some segments, None where it is predicted.
            start: a motion to go on from: the new one begins with the frame after its last one, without a jump.

        Raises:
            InvalidOption: a number is out of range, or `start` is too short or not at 20 frames a second.
        """
        spec = self.model.spec
        first = MAX_SEGMENTS - (start is not None)
        timed = duration_s is not None or durations_s is not None
        most = first if timed else MAX_ACTIONS
        if not 1 <= len(segments) <= most:
            where = " where durations are given" if timed else ""
            raise InvalidOption("segments", f"expected 1 to {most}{where}, found {len(segments)}")
        self.check(min(len(segments), first), spec.most_frames, candidates)
        settings = settings or PerformerSettings()
        noise = self.noise(seed)
        most_s = spec.most_s - CONTEXT_S * (start is not None)
        if durations_s is not None:
            seconds = checked_durations(durations_s, len(segments), spec.least_s, most_s)
            return self._perform(prompt, segments, np.tile(seconds, (candidates, 1)), start, settings, noise)
        seconds = self.predicted(segments, candidates, settings.duration_spread, noise)
        for i, given in enumerate(lasting_s or ()):
            if given is not None:
                seconds[:, i] = given
        if duration_s is not None:
            seconds = fitted(seconds, duration_s, spec.least_s, most_s)
            return self._perform(prompt, segments, seconds, start, settings, noise)
        sizes = part_sizes(seconds.mean(axis=0).tolist(), most_s, spec.most_s - CONTEXT_S, first=first)
        if len(sizes) > 1:
            return self._in_turn(prompt, segments, seconds, sizes, start, settings, noise)
        return self._perform(prompt, segments, seconds, start, settings, noise)

    def mismatches(self, motion: HumanMotion) -> tuple[Mismatch, ...]:
        """What a motion does not show of its segments' texts; nothing where that cannot be said."""
        return self.verifier.mismatches(motion) if self.verifier else ()

    def check(self, segments: int, frames: int, candidates: int) -> None:
        """InvalidOption unless so many segments fit into the frames and there is a motion to make."""
        unit = self.model.spec.token_frames
        check_segments(segments, frames // unit, unit)
        if candidates < 1:
            raise InvalidOption("candidates", f"must be at least 1, found {candidates}")

    def noise(self, seed: int) -> torch.Generator:
        """The source of all randomness of a motion."""
        return torch.Generator(self.device).manual_seed(seed)

    def predicted(self, segments: Sequence[str], candidates: int, spread: float, noise: torch.Generator) -> np.ndarray:
        """(candidates, A) durations in s, drawn from the predicted distributions."""
        mean, log_std = self._distributions(segments)
        draws = torch.randn(candidates, len(segments), generator=noise, device=self.device)
        return (mean + spread * log_std.exp() * draws).exp().cpu().numpy().astype(np.float64)

    def shares(self, segments: Sequence[str], frames: int) -> NDArray[np.int64]:
        """(A,) frames of each segment of a motion of so many frames, by the predicted durations."""
        mean, _ = self._distributions(segments)
        seconds = mean.double().exp().cpu().numpy()
        return whole_frames(seconds * (frames / self.model.spec.fps / seconds.sum()), self.model.spec)

    def around(
        self,
        prompt: str,
        segments: Sequence[str],
        frames: Sequence[NDArray[np.int64]],
        context: Context,
        settings: PerformerSettings,
        noise: torch.Generator,
    ) -> list[Features]:
        """Features (T, F) of a motion for each row of frames, with the frames of the context that the model sees."""
        texts, _ = context.around(segments, frames[0])
        sentence = prompt if len(texts) == len(segments) else ", then ".join(texts)
        whole = [context.around(segments, row)[1] for row in frames]
        condition = read_texts(self.text_encoder, [(sentence, texts)] * len(whole)).to(self.device)
        condition = condition.lasting(torch.from_numpy(np.stack(whole)))
        known = context.known([int(row.sum()) for row in whole], self.device)
        return self.samples(condition, [texts] * len(whole), known, settings, noise)

    def read(self, texts: Sequence[Texts]) -> TextCondition:
        """Sentences with their segment texts, as the model reads them."""
        return read_texts(self.text_encoder, texts).to(self.device)

    def samples(
        self,
        text: TextCondition,
        segments: Sequence[tuple[str, ...]],
        known: Known | None,
        settings: PerformerSettings,
        noise: torch.Generator,
    ) -> list[Features]:
        """Features (T, F) of each row: first samples, or best of N where these do not show their segment texts."""
        if self.verifier is None or not settings.rounds:
            found = self.model.sample(text, known=known, sampling=settings.sampling, noise=noise)
            return [sample.features.cpu().numpy() for sample in found]
        totals = text.frames.sum(1).tolist()
        return [
            self._resampler(segments[row], settings)
            .sample(text[row : row + 1], known and known.row(row, total), noise)
            .features.cpu()
            .numpy()
            for row, total in enumerate(totals)
        ]

    def motion(
        self, joints: np.ndarray, prompt: str, texts: Sequence[str], frames: np.ndarray, *, on_floor: bool
    ) -> HumanMotion:
        """A motion of segments of so many frames; `on_floor` puts its lowest joint on the floor."""
        if on_floor:
            joints = joints - [0.0, 0.0, joints[..., 2].min()]
        edges = np.concatenate([[0], np.cumsum(frames)]) / FPS
        segments = tuple(
            Segment(text, float(start), float(end))
            for text, start, end in zip(texts, edges[:-1], edges[1:], strict=True)
        )
        return HumanMotion(joints=joints, fps=FPS, prompt=prompt, segments=segments, source=self.model.name)

    def _in_turn(
        self,
        prompt: str,
        segments: Sequence[str],
        seconds: np.ndarray,
        sizes: Sequence[int],
        start: HumanMotion | None,
        settings: PerformerSettings,
        noise: torch.Generator,
    ) -> tuple[HumanMotion, ...]:
        """Motions of parts of a sentence; each part goes on from the one before."""
        grown: list[list[HumanMotion]] = [[] for _ in seconds]
        first = 0
        for size in sizes:
            texts, timing = segments[first : first + size], seconds[:, first : first + size]
            for chunks, row in zip(grown, timing, strict=True):
                last = chunks[-1] if chunks else start
                chunks.extend(self._perform(", then ".join(texts), texts, row[None], last, settings, noise))
            first += size
        return tuple(replace(concatenated(chunks), prompt=prompt) for chunks in grown)

    def _perform(
        self,
        prompt: str,
        segments: Sequence[str],
        seconds: np.ndarray,
        start: HumanMotion | None,
        settings: PerformerSettings,
        noise: torch.Generator,
    ) -> tuple[HumanMotion, ...]:
        """Motions of segments of such durations (candidates, A) in s, at once."""
        spec, context = self.model.spec, self._after(start)
        most, longest = spec.most_frames - sum(context.frames), float(seconds.sum(axis=1).max())
        if longest > most / spec.fps + spec.token_s / 2:
            say(f"{prompt}: would take {longest:.1f} s; it is performed faster, within {most / spec.fps:g} s")
        frames = [whole_frames(row, spec, most=most) for row in seconds]
        features = self.around(prompt, segments, frames, context, settings, noise)
        return tuple(
            self.motion(
                context.stitched(rows, foot_lock=settings.foot_lock)[0], prompt, segments, row, on_floor=start is None
            )
            for rows, row in zip(features, frames, strict=True)
        )

    def _after(self, start: HumanMotion | None) -> Context:
        """What comes before a motion that goes on from another."""
        if start is None:
            return Context.none()
        frames = len(start.joints)
        if frames < CONTEXT_FRAMES:
            raise InvalidOption("start", f"lasts {start.duration_s:g} s, needs at least {CONTEXT_S:g} s to go on from")
        return Context.of_range(start, frames, frames, self.model.spec.token_frames)

    def _distributions(self, segments: Sequence[str]) -> tuple[Tensor, Tensor]:
        """Mean and log of the standard deviation of the log of each segment's duration in s, (A,)."""
        # The predictor knows sentences of so many segments; in a longer one its last place stands for the rest.
        place = torch.arange(len(segments), device=self.device).clamp(max=MAX_SEGMENTS - 1)
        texts = torch.from_numpy(self.text_encoder.encode_sentences(list(segments))).to(self.device)
        counts = torch.from_numpy(segment_counts(segments)).to(self.device)
        with torch.inference_mode():
            return self.durations(texts, counts, place, torch.full_like(place, min(len(segments), MAX_SEGMENTS)))

    def _resampler(self, texts: Sequence[str], settings: PerformerSettings) -> Resampler:
        """What samples motions of such segment texts."""
        assert self.verifier is not None
        verifier, required = self.verifier, self.verifier.requirements(texts)

        def judge(features: Tensor, frames: Sequence[int]) -> NDArray[np.int64]:
            ends = np.cumsum(frames)
            windows = list(zip((0, *ends[:-1].tolist()), ends.tolist(), strict=True))
            return verifier.violations(Signals.of(decode(features.cpu().numpy())), windows, required)

        return Resampler(self.model, settings.sampling, judge, settings.samples, settings.rounds)
