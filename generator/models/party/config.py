"""Sizes of ParTY's models, what they are trained for, and how they are sampled from (appendix A.1)."""

from dataclasses import dataclass
from typing import Literal

from generator.config import FEATURES
from generator.models.party.bodies import WHOLE, check_bodies
from generator.models.party.temporal import Adjacency
from ros_free_stack.errors import InvalidOption


@dataclass(frozen=True)
class TokenizerConfig:
    """One temporal-aware VQ-VAE for each body.

    Attributes:
        bodies: what has tokens: "whole" and the parts that guide it, or parts that share out the body.
        window, part_window: frames of a token of the whole body, and of a part.
        width, depth: channels of the decoder, and residual blocks of encoder and decoder.
        encoder_width: channels of the frame encoder.
        codes, part_codes, code_width: entries of the codebooks of the whole body and of a part, and their width.
        groups: codebooks of the whole body, each for a share of the code's width; 1 is the paper's.
        local: weigh the frames of a window (LTE); otherwise their mean.
        graph: which windows GTE joins; "none" leaves it out.
        features: width of the features.
    """

    bodies: tuple[str, ...]
    window: int
    part_window: int
    width: int
    encoder_width: int
    depth: int
    codes: int
    part_codes: int
    code_width: int
    groups: int = 1
    local: bool = True
    graph: Adjacency = "banded"
    features: int = FEATURES

    def __post_init__(self) -> None:
        check_bodies(self.bodies)
        for name, frames in (("window", self.window), ("part_window", self.part_window)):
            if frames < 2 or frames % 2:
                raise InvalidOption(f"tokenizer.model.{name}", f"must be even and positive, found {frames}")
        if self.code_width % self.groups:
            raise InvalidOption(
                "tokenizer.model.groups", f"must divide the code width {self.code_width}, found {self.groups}"
            )

    @property
    def parts(self) -> tuple[str, ...]:
        """The bodies that are parts."""
        return tuple(body for body in self.bodies if body != WHOLE)

    @property
    def holistic(self) -> bool:
        """Whether the whole body has tokens."""
        return WHOLE in self.bodies

    @property
    def unit(self) -> int:
        """Frames that come and stay together: a token of the whole body, or of a part where there is none."""
        return self.window if self.holistic else self.part_window

    def window_of(self, body: str) -> int:
        """Frames of a body's token."""
        return self.window if body == WHOLE else self.part_window

    def groups_of(self, body: str) -> int:
        """Codebooks of a body."""
        return self.groups if body == WHOLE else 1

    def codes_of(self, body: str) -> int:
        """Entries of each of a body's codebooks."""
        return self.codes if body == WHOLE else self.part_codes


@dataclass(frozen=True)
class TokenizerLosses:
    """What the tokenizer is trained for.

    Attributes:
        losses: "published" is L1 of the features, joint positions once more, and the approximation loss; "weighted"
            counts the root's path, planted feet and bones as `generator.training.reconstruction` says.
        approximation: weight of the approximation loss, the distance of codes and what they stand for.
        window: frames of a training window, whole tokens of every body.
    """

    losses: Literal["published", "weighted"] = "weighted"
    approximation: float = 1.0
    window: int = 48
