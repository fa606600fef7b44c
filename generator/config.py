"""Sizes and training settings of the generator's models, and the two presets.

`full` has the published sizes (MoMask, CVPR 2024; SegMo, WACV 2026) for a GPU; `small` trains on two CPU cores.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, TypeVar

from ros_free_stack.errors import NoWeights, UnknownName
from ros_free_stack.skeleton import FPS

FEATURES = 263
TEXT_WIDTH = 384
MAX_SEGMENTS = 5
MIN_FRAMES, MAX_FRAMES = 40, 196
TOKEN_FRAMES = 4
TOKEN_S = TOKEN_FRAMES / FPS
MIN_TOKENS, MAX_TOKENS = MIN_FRAMES // TOKEN_FRAMES, MAX_FRAMES // TOKEN_FRAMES

Config = TypeVar("Config")

ConditioningKind = Literal["sentence", "segments", "layout"]
SegmentationKind = Literal["uniform", "change-point", "clustering", "exact"]
PartsKind = Literal["whole", "limbs"]
AlignmentKind = Literal["none", "segment", "batch", "global", "token"]


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


@dataclass(frozen=True)
class DurationsConfig:
    """Multi-layer perceptron from a segment's text to the distribution of its duration."""

    width: int


@dataclass(frozen=True)
class EvaluatorConfig:
    """Motion and text encoders of the evaluator.

    Attributes:
        width, layers, heads: of the transformer of each side.
        embedding: width of the space that both sides share.
        words: longest text that is read, in word pieces.
        dropout: of what the transformers read.
    """

    width: int
    layers: int
    heads: int
    embedding: int
    words: int = 80
    dropout: float = 0.1


@dataclass(frozen=True)
class Training:
    """How a model is trained.

    Attributes:
        batch, iterations, learning_rate, warm_up: the usual; the rate falls as a cosine to `final_rate` of itself.
        ema: decay of the averaged weights that are evaluated and exported; 0 takes the weights themselves.
        alignment: which parts of text and motion the mask transformer's alignment loss pairs, see
            `generator.models.segmo.alignment`; "segment" is SegMo's.
        alignment_weight: weight of that loss (SegMo, equation 9).
        segmentation: where the alignment takes the motion segments from, see `generator.models.segmo.segmentation`;
            "uniform" is SegMo's.
        window: frames of a training window; the tokenizer's only.
    """

    batch: int
    iterations: int
    learning_rate: float
    warm_up: int = 200
    final_rate: float = 0.03
    weight_decay: float = 0.01
    clip: float = 1.0
    ema: float = 0.999
    alignment: AlignmentKind = "none"
    alignment_weight: float = 1.0
    segmentation: SegmentationKind = "exact"
    window: int = 64


@dataclass(frozen=True)
class Preset:
    """All models of one size with their training settings."""

    tokenizer: TokenizerConfig
    tokenizer_training: Training
    mask: TransformerConfig
    mask_training: Training
    residual: TransformerConfig
    residual_training: Training
    durations: DurationsConfig
    durations_training: Training
    evaluator: EvaluatorConfig
    evaluator_training: Training
    grounding: TransformerConfig
    grounding_training: Training


@dataclass(frozen=True)
class Sampling:
    """Settings of generation.

    Attributes:
        steps: iterations of the mask transformer's decoding.
        mask_guidance, residual_guidance: scales of classifier-free guidance; 1 is none.
        temperature, residual_temperature: of the token distributions.
        layers: how many layers of tokens are drawn, the base layer included, at most as many as there are.
        top_k: only the best tokens are drawn, the share 1 - `top_k` of the codebook.
        duration_spread: how much of the predicted spread of durations the seed plays out.
        foot_lock: hold standing feet still, see `generator.postprocess.foot_lock`.
        drafts, rounds: how many drafts of what does not show its text are compared, and how often; with no rounds
            the first draft is taken as it is. See `generator.resampling`.
    """

    steps: int = 10
    mask_guidance: float = 2.0
    residual_guidance: float = 2.0
    temperature: float = 1.0
    residual_temperature: float = 0.5
    layers: int = 1
    top_k: float = 0.9
    duration_spread: float = 0.3
    foot_lock: bool = True
    drafts: int = 8
    rounds: int = 3


_SMALL_MASK = TransformerConfig(192, 4, 4, 384, dropout=0.0, codes=512, quantizers=3, parts=5)
_FULL_MASK = TransformerConfig(384, 8, 6, 1024, dropout=0.2, codes=512, quantizers=6)


def _textless(config: TransformerConfig) -> TransformerConfig:
    """Of a model that is aligned with texts and never sees one."""
    return replace(config, conditioning="segments", condition_dropout=1.0)


PRESETS: dict[str, Preset] = {
    "small": Preset(
        tokenizer=TokenizerConfig(
            "patch", 256, 96, 3, 2, codes=512, code_width=64, quantizers=3, quantizer_dropout=0.8, parts="limbs"
        ),
        tokenizer_training=Training(48, 10_000, 1e-3, ema=0.0, weight_decay=0.0),
        mask=_SMALL_MASK,
        mask_training=Training(64, 20_000, 1e-3, alignment="segment", alignment_weight=0.1),
        residual=replace(_SMALL_MASK, layers=3),
        residual_training=Training(64, 8_000, 1e-3),
        durations=DurationsConfig(128),
        durations_training=Training(256, 3_000, 1e-3, ema=0.99),
        evaluator=EvaluatorConfig(128, 2, 4, 128),
        evaluator_training=Training(128, 2_000, 1e-3, ema=0.99),
        grounding=_textless(replace(_SMALL_MASK, width=128, layers=2, feed_forward=256)),
        grounding_training=Training(64, 4_000, 1e-3, alignment="batch"),
    ),
    "full": Preset(
        tokenizer=TokenizerConfig("strided", 512, 512, 3, 3, codes=512, code_width=512, quantizers=6),
        tokenizer_training=Training(256, 100_000, 2e-4, warm_up=2000, ema=0.0, weight_decay=0.0),
        mask=_FULL_MASK,
        mask_training=Training(64, 300_000, 2e-4, warm_up=2000, alignment="segment"),
        residual=_FULL_MASK,
        residual_training=Training(64, 300_000, 2e-4, warm_up=2000),
        durations=DurationsConfig(256),
        durations_training=Training(256, 10_000, 1e-3, ema=0.99),
        evaluator=EvaluatorConfig(512, 4, 8, 512),
        evaluator_training=Training(256, 20_000, 2e-4, warm_up=500),
        grounding=_textless(replace(_FULL_MASK, layers=4)),
        grounding_training=Training(256, 40_000, 2e-4, warm_up=2000, alignment="batch"),
    ),
}


def preset(name: str) -> Preset:
    """The preset of that name, or UnknownName."""
    if name not in PRESETS:
        raise UnknownName("preset", name, PRESETS)
    return PRESETS[name]


def to_json(config: Any) -> dict[str, Any]:
    """A config dataclass as plain data."""
    return asdict(config)


def from_json(kind: type[Config], data: dict[str, Any]) -> Config:
    """The config dataclass of that kind, or NoWeights where the data describe another version of it."""
    try:
        return kind(**data)
    except TypeError as error:
        raise NoWeights(f"{kind.__name__} was saved by another version of this program ({error})") from None
