"""Sizes of SegMo's models and how they are sampled from (MoMask, CVPR 2024; SegMo, WACV 2026)."""

from dataclasses import dataclass, replace
from typing import Literal, Self

from generator.config import FEATURES, MAX_FRAMES, MIN_FRAMES, AlignmentKind, SegmentationKind
from generator.model import Sampling
from ros_free_stack.errors import InvalidOption
from ros_free_stack.skeleton import FPS

TOKEN_FRAMES = 4
TOKEN_S = TOKEN_FRAMES / FPS
MIN_TOKENS, MAX_TOKENS = MIN_FRAMES // TOKEN_FRAMES, MAX_FRAMES // TOKEN_FRAMES

ConditioningKind = Literal["sentence", "segments", "layout"]
PartsKind = Literal["whole", "limbs"]


@dataclass(frozen=True)
class TokenizerConfig:
    """Residual VQ-VAE: convolutions over time, down by four, residual quantizers.

    Attributes:
        stem: "strided" halves the rate in two stages (MoMask); "patch" in one step of overlapping windows, several
            times cheaper because no layer then runs at the frame rate.
        width, depth: channels of the decoder, and residual blocks a stage.
        encoder_width: channels of each part's encoder.
        dilation_growth: dilation of block i is this to the power i.
        codes, code_width, quantizers: codebook entries, their width, and residual layers.
        parts: what has codes of its own, the "whole" body (MoMask) or its "limbs": legs, trunk, head, and either arm.
        features: width of the features.
        quantizer_dropout: probability that a training batch uses only the first q < Q quantizers, q uniform.
    """

    stem: Literal["strided", "patch"]
    width: int
    encoder_width: int
    depth: int
    dilation_growth: int
    codes: int
    code_width: int
    quantizers: int
    quantizer_dropout: float = 0.2
    parts: PartsKind = "whole"
    features: int = FEATURES


@dataclass(frozen=True)
class TransformerConfig:
    """Mask or residual transformer.

    Attributes:
        width, layers, heads, feed_forward, dropout: the usual sizes.
        codes, quantizers: those of the tokenizer it speaks the tokens of.
        parts: in how many parts the tokenizer takes the body.
        conditioning: what the model reads: "sentence" the pooled sentence alone (MoMask), "segments" the sentence and
            its ordered segments (SegMo), "layout" at each motion token also its segment's text, number and progress.
        layout: for conditioning "layout", where the segments lie in time: "exact" (labelled boundaries in training,
            predicted durations in generation) or "uniform" (equal shares).
        condition_dropout: probability of training without text, for classifier-free guidance.
        sentence_dropout: probability of training without the sentence but with its segments, so that the model
            relies on what each segment says rather than on whole sentences it has seen.
        clauses: read what a segment says happens at the same time as a sentence of its own; otherwise each segment text
            is read whole (SegMo).
    """

    width: int
    layers: int
    heads: int
    feed_forward: int
    dropout: float
    codes: int
    quantizers: int
    parts: int = 1
    conditioning: ConditioningKind = "layout"
    layout: Literal["exact", "uniform"] = "exact"
    condition_dropout: float = 0.1
    sentence_dropout: float = 0.2
    clauses: bool = True

    def __post_init__(self) -> None:
        if self.width % self.heads:
            raise InvalidOption("model.width", f"must be a multiple of {self.heads} heads, found {self.width}")


@dataclass(frozen=True)
class TokenizerLosses:
    """What the tokenizer is trained for.

    Attributes:
        losses: "published" is MoMask's: smooth L1 of all features, half as much again of the joint positions, and the
            commitment; "weighted" see `generator.training.reconstruction`.
        window: frames of a training window.
    """

    losses: Literal["published", "weighted"] = "weighted"
    window: int = 64


@dataclass(frozen=True)
class MaskLosses:
    """What the mask transformer is trained for beside its masked tokens.

    Attributes:
        alignment: which parts of text and motion the alignment loss pairs, see `generator.models.segmo.alignment`;
            "segment" is SegMo's.
        alignment_weight: weight of that loss (SegMo, equation 9).
        segmentation: where the alignment takes the motion segments from, see `generator.models.segmo.segmentation`;
            "uniform" is SegMo's.
        start: embeddings of codes begin "random" or as projections of the "codes" themselves.
    """

    alignment: AlignmentKind = "none"
    alignment_weight: float = 1.0
    segmentation: SegmentationKind = "exact"
    start: Literal["codes", "random"] = "codes"


@dataclass(frozen=True)
class SegmoSampling:
    """Settings of generation.

    Attributes:
        steps: iterations of the mask transformer's decoding.
        mask_guidance, residual_guidance: scales of classifier-free guidance; 1 is none.
        temperature, residual_temperature: of the token distributions.
        layers: how many layers of tokens are sampled, the base layer included, at most as many as there are.
        top_k: only the best tokens are sampled, the share 1 - `top_k` of the codebook.
    """

    steps: int = 10
    mask_guidance: float = 2.0
    residual_guidance: float = 2.0
    temperature: float = 1.0
    residual_temperature: float = 0.5
    layers: int = 1
    top_k: float = 0.9

    def told(self, wanted: Sampling) -> Self:
        """These settings with what is asked for instead."""
        return replace(
            self,
            steps=self.steps if wanted.steps is None else wanted.steps,
            mask_guidance=self.mask_guidance if wanted.guidance is None else wanted.guidance,
            temperature=self.temperature if wanted.temperature is None else wanted.temperature,
        )
