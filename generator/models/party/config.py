"""Sizes of ParTY's models, what they are trained for, and how they are sampled from (appendix A.1)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, Self

from generator.bodies import WHOLE, channels
from generator.config import FEATURES
from generator.model import Sampling
from generator.models.party.temporal import Adjacency
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import CHANNELS

ConditioningKind = Literal["sentence", "layout"]

_MODEL: Final = "transformer.model"


@dataclass(frozen=True)
class TokenizerConfig:
    """One temporal-aware VQ-VAE for each body.

    Attributes:
        bodies: what has tokens: "whole" and the parts that guide it, arms and legs in the paper; or, for a part-wise
            generator, parts that share out the body, as arms, legs and trunk, or either limb, backbone and root.
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
        _check_bodies(self.bodies)
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


@dataclass(frozen=True)
class TransformerConfig:
    """Part transformers, text grounding, part guidance, holistic-part fusion, and the holistic transformer.

    Attributes:
        width, layers, part_layers, heads, feed_forward, dropout: the usual sizes, layers of the whole body's and of
            each part's transformer.
        fusion_heads, fusion_head_width: of the fusion's attention.
        cycle, part_cycle: tokens of the whole body, and of each part, in a cycle.
        embeddings: perceptrons of the text grounding; 0 gives the parts the texts as they are (no PTG).
        guidance: parts guide the whole body (PG).
        fusion: parts are fused into the whole body's earlier tokens (HPF).
        conditioning: "sentence" the sentence before the first token, as in the paper; "layout" each token is also told
            its own segment's text, and how much of the segment and of the motion is over.
        condition_dropout: probability of training without text, for classifier-free guidance.
    """

    width: int
    layers: int
    part_layers: int
    heads: int
    feed_forward: int
    dropout: float
    fusion_heads: int
    fusion_head_width: int
    cycle: int
    part_cycle: int
    embeddings: int = 4
    guidance: bool = True
    fusion: bool = True
    conditioning: ConditioningKind = "sentence"
    condition_dropout: float = 0.0

    def __post_init__(self) -> None:
        if self.width % self.heads:
            raise InvalidOption(f"{_MODEL}.width", f"must be a multiple of {self.heads} heads, found {self.width}")
        if self.cycle < 1 or self.part_cycle < 1:
            raise InvalidOption(f"{_MODEL}.cycle", f"must be positive, found {self.cycle} and {self.part_cycle}")

    def check_windows(self, tokens: TokenizerConfig) -> None:
        """InvalidOption unless the parts of a cycle cover at least the time of what they guide."""
        guided, ahead = self.cycle * tokens.window, self.part_cycle * tokens.part_window
        if tokens.holistic and (self.guidance or self.fusion) and ahead < guided:
            raise InvalidOption(
                f"{_MODEL}.part_cycle",
                f"{self.part_cycle} part tokens of {tokens.part_window} frames cover {ahead} frames, the cycle of "
                f"{self.cycle} tokens of {tokens.window} frames that they guide {guided}",
            )


@dataclass(frozen=True)
class TransformerLosses:
    """What the transformers are trained for beside their tokens.

    Attributes:
        diversity, temperature: weight and temperature of the text diversity loss (equation 3).
        auxiliary: weight of the L1 loss against part texts.
        corruption: share of the tokens that are read as random ones, so that mistakes are met in training.
    """

    diversity: float = 0.1
    temperature: float = 0.05
    auxiliary: float = 0.1
    corruption: float = 0.0


@dataclass(frozen=True)
class PartySampling:
    """Settings of generation.

    Attributes:
        temperature: of the token distributions.
        guidance: scale of classifier-free guidance; 1 is none.
        top_k: only the best tokens are sampled, this share of the codebook.
    """

    temperature: float = 1.0
    guidance: float = 1.0
    top_k: float = 1.0

    def told(self, wanted: Sampling) -> Self:
        """These settings with what is asked for instead; tokens come one after the other, so there are no steps."""
        return replace(
            self,
            guidance=self.guidance if wanted.guidance is None else wanted.guidance,
            temperature=self.temperature if wanted.temperature is None else wanted.temperature,
        )


def _check_bodies(bodies: Sequence[str]) -> None:
    """InvalidOption unless there is the whole body, or parts that share out all features between them."""
    if len(set(bodies)) != len(bodies) or not bodies:
        raise InvalidOption("tokenizer.model.bodies", f"each can be named once, at least one; found {list(bodies)}")
    owned = sorted(index for body in bodies if body != WHOLE for index in channels(body))
    if WHOLE not in bodies and owned != list(range(len(CHANNELS))):
        raise InvalidOption(
            "tokenizer.model.bodies",
            f"without {WHOLE} the parts must share out the body, as arms, legs, trunk do; found {list(bodies)}",
        )
