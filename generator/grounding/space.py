"""The space that text segments and motion segments share (SegMo, sections 3.5 and 4.4), with trained weights.

Its model is a mask transformer that was trained to align and never sees a text beside the motion, so that an embedding
says what the motion shows and not what the model was told about it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import torch
from torch import Tensor

from generator import weights
from generator.config import MAX_FRAMES, TEXT_WIDTH
from generator.models.segmo.conditioning import Condition
from generator.models.segmo.config import TOKEN_FRAMES, TokenizerConfig, TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.text.encoder import TextEncoder
from generator.text.meanwhile import encode_segments
from ros_free_stack.errors import InvalidOption, NoWeights
from ros_free_stack.formats.features import encode
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import FPS

SHORTEST_TOKENS = 4
"""Of a motion that can be searched."""


@dataclass(frozen=True)
class AlignedSpace:
    """Embeds texts and motion segments as unit vectors of width W; make one with `AlignedSpace.load`."""

    tokenizer: MotionTokenizer
    model: MaskTransformer

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read the tokenizer and the grounding model of a folder of weights.

        Raises:
            NoWeights: one is not trained, or the grounding model was trained with another tokenizer.
        """
        saved = {name: weights.load(folder / name, name) for name in ("tokenizer", "grounding")}
        if saved["grounding"].facts.get("tokenizer") != saved["tokenizer"].digest:
            raise NoWeights(
                f"{folder / 'grounding'}: was trained with another tokenizer than the one in {folder}; "
                f"train it again with `python launch.py train grounding --dataset DATASET --out {folder.parent}`"
            )
        tokenizer = MotionTokenizer(saved["tokenizer"].config_as(TokenizerConfig))
        model = MaskTransformer(saved["grounding"].config_as(TransformerConfig))
        saved["tokenizer"].fill(tokenizer)
        saved["grounding"].fill(model)
        return cls(tokenizer.eval().requires_grad_(False), model.eval().requires_grad_(False))

    def motion_tokens(self, motion: HumanMotion) -> Tensor:
        """Base tokens (P, n) of a motion, four frames each.

        Raises:
            InvalidOption: the motion is not at 20 fps, too short or too long.
        """
        shortest = SHORTEST_TOKENS * TOKEN_FRAMES
        frames = len(motion.joints)
        if motion.fps != FPS or not shortest < frames <= MAX_FRAMES + 1:
            raise InvalidOption(
                "motion",
                f"must have {shortest + 1} to {MAX_FRAMES + 1} frames at {FPS:g} fps, "
                f"found {frames} at {motion.fps:g} fps",
            )
        features = torch.from_numpy(encode(motion.joints).astype(np.float32))
        return self.tokenizer.encode(features[None])[: self.model.config.parts, 0]

    def hidden(self, tokens: Tensor) -> Tensor:
        """Hidden tokens (n, W) of a motion's base tokens (P, n), none masked, no text seen."""
        none = torch.zeros(1, dtype=torch.bool)
        condition = Condition(
            torch.zeros(1, TEXT_WIDTH),
            torch.zeros(1, 1, 2, TEXT_WIDTH),
            torch.zeros(1, 1, 2, dtype=torch.long),
            torch.tensor([[tokens.shape[1]]]),
        )
        with torch.inference_mode():
            return self.model(tokens[:, None].long(), condition, none, none).hidden[0]

    def segments(self, hidden: Tensor, lengths: Sequence[int]) -> Tensor:
        """(A, W) embeddings of the segments of so many tokens each that make up a motion."""
        with torch.inference_mode():
            return self.model.alignment.motion_embeddings(hidden[None], torch.tensor([list(lengths)]))[0]

    def windows(self, hidden: Tensor, length: int) -> Tensor:
        """(n - length + 1, W) embeddings of all windows of `length` tokens of a motion's hidden tokens (n, W)."""
        windows = hidden.unfold(0, length, 1)
        with torch.inference_mode():
            return self.model.alignment.embed(windows.mean(-1), windows.amax(-1))

    def texts(self, encoder: TextEncoder, texts: Sequence[str]) -> Tensor:
        """(N, W) of segment texts, read as the model reads them: in clauses or whole."""
        if self.model.config.clauses:
            embeddings = encode_segments(encoder, texts)
        else:
            whole = encoder.encode_sentences(texts)
            embeddings = np.stack([whole, np.zeros_like(whole)], axis=1)
        conditioning = self.model.conditioning
        with torch.inference_mode():
            clauses = conditioning.clauses(torch.from_numpy(embeddings))
            return self.model.alignment.text_embeddings(conditioning.segment(clauses))
