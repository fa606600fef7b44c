"""Subcommands of grounding: `ground` and `caption`."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from ros_free_stack.console import Command

if TYPE_CHECKING:
    from generator.grounding.space import AlignedSpace
    from ros_free_stack.messages import HumanMotion


@dataclass(frozen=True, kw_only=True)
class Ground(Command):
    """Find where in a motion each part of a sentence happens."""

    motion: Annotated[Path, tyro.conf.Positional]
    """A human motion, as `generate` writes it."""
    prompt: Annotated[str, tyro.conf.Positional]
    """What to look for, in English, e.g. "a person waves, then bows"."""
    out: Path | None = None
    """Also draw the similarity map to this PNG file."""
    method: Literal["in-order", "most-similar"] = "in-order"
    """`in-order` looks for all texts at once, one after the other, in windows of every length; `most-similar` takes the
    most similar window of --window seconds for each text by itself, as SegMo does."""
    window: float = 1.0
    """Window of the map, and of `most-similar`, in s."""
    weights: Path | None = None
    """Folder of trained models; the ones that come with the program where not given."""

    def run(self) -> int:
        from generator.grounding.search import ground, most_similar, similarity_map
        from generator.grounding.space import AlignedSpace
        from generator.models.segmo.config import TOKEN_S
        from generator.registry import DEFAULT, WEIGHTS_FOLDER
        from generator.text.encoder import TextEncoder
        from generator.text.splitter import Splitter
        from ros_free_stack.errors import InvalidOption
        from ros_free_stack.files import load_motion

        motion = load_motion(self.motion)
        texts = Splitter().split(self.prompt)
        space = AlignedSpace.load((self.weights or WEIGHTS_FOLDER) / DEFAULT)
        hidden = space.hidden(space.motion_tokens(motion))
        length = round(self.window / TOKEN_S)
        if not 1 <= length <= len(hidden):
            longest = len(hidden) * TOKEN_S
            raise InvalidOption("--window", f"must be {TOKEN_S:g} to {longest:g} s here, found {self.window:g}")
        embedded = space.texts(TextEncoder(), texts)
        paper = self.method == "most-similar"
        found = most_similar(space, hidden, embedded, length) if paper else ground(space, hidden, embedded)
        if self.out:
            from generator.grounding.figure import draw_similarity

            draw_similarity(self.out, similarity_map(space, hidden, embedded, length), texts, found)
        result = [{"text": text, **asdict(place)} for text, place in zip(texts, found, strict=True)]
        self.report(
            {"segments": result, "map": self.out and str(self.out)},
            *(f"{r['start_s']:5.1f} to {r['end_s']:4.1f} s  {r['similarity']:5.2f}  {r['text']}" for r in result),
            *([f"wrote {self.out}"] if self.out else []),
        )
        return 0


@dataclass(frozen=True, kw_only=True)
class Caption(Command):
    """Find the known texts that a motion's segments are most like."""

    motion: Annotated[Path, tyro.conf.Positional]
    """A human motion, as `generate` writes it."""
    top: int = 5
    """How many texts for each segment."""
    segments: int | None = None
    """Cut the motion into so many segments at its change points; the segments in the file where not given."""
    weights: Path | None = None
    """Folder of trained models; the ones that come with the program where not given."""

    def run(self) -> int:
        from generator.grounding.space import AlignedSpace
        from generator.grounding.texts import KnownTexts
        from generator.models.segmo.config import TOKEN_S
        from generator.registry import DEFAULT, WEIGHTS_FOLDER
        from ros_free_stack.errors import InvalidOption
        from ros_free_stack.files import load_motion

        if self.top < 1:
            raise InvalidOption("--top", f"must be at least 1, found {self.top}")
        motion, folder = load_motion(self.motion), (self.weights or WEIGHTS_FOLDER) / DEFAULT
        space, known = AlignedSpace.load(folder), KnownTexts.load(folder / "grounding")
        tokens = space.motion_tokens(motion)
        lengths = self._lengths(motion, space, tokens.shape[1])
        nearest = known.nearest(space.segments(space.hidden(tokens), lengths), self.top)
        result, lines, start = [], [], 0
        for length, texts in zip(lengths, nearest, strict=True):
            times = start * TOKEN_S, (start + length) * TOKEN_S
            found = [{"text": text, "similarity": similarity} for text, similarity in texts]
            result.append({"start_s": times[0], "end_s": times[1], "texts": found})
            lines.append(f"{times[0]:5.1f} to {times[1]:4.1f} s")
            lines += [f"    {similarity:5.2f}  {text}" for text, similarity in texts]
            start += length
        self.report({"segments": result}, *lines)
        return 0

    def _lengths(self, motion: "HumanMotion", space: "AlignedSpace", tokens: int) -> list[int]:
        """Tokens of each segment of the motion."""
        import numpy as np
        import torch

        from generator.models.segmo.config import TOKEN_FRAMES
        from generator.models.segmo.segmentation import change_points, pose_signal
        from generator.timing import check_segments, segment_lengths
        from ros_free_stack.formats.features import encode
        from ros_free_stack.skeleton import FPS

        if self.segments is None and motion.segments:
            spans = [(round(s.start_s * FPS), round(s.end_s * FPS)) for s in motion.segments]
            return segment_lengths(spans, tokens, TOKEN_FRAMES).tolist()
        count = 1 if self.segments is None else self.segments
        check_segments(count, tokens, TOKEN_FRAMES)
        if count == 1:
            return [tokens]
        standardised = space.tokenizer.standardise(torch.from_numpy(encode(motion.joints).astype(np.float32)))
        return change_points(pose_signal(standardised.numpy()), count).tolist()
