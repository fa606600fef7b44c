"""The presets: `full` has the published sizes for a GPU; `small` trains on two CPU cores."""

from dataclasses import dataclass, replace

from generator.config import Training
from generator.models.segmo.config import TokenizerConfig, TransformerConfig
from generator.nn.durations import DurationsConfig
from generator.nn.evaluator import EvaluatorConfig
from ros_free_stack.errors import UnknownName


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
