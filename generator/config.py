"""What all generators share: limits, and how a stage is trained."""

from dataclasses import asdict, dataclass
from typing import Any, Literal, TypeVar

from ros_free_stack.errors import NoWeights

FEATURES = 263
TEXT_WIDTH = 384
MAX_SEGMENTS = 5
MIN_FRAMES, MAX_FRAMES = 40, 196
"""Of a motion at 20 fps, as published (T2M)."""

Config = TypeVar("Config")

SegmentationKind = Literal["uniform", "change-point", "clustering", "exact"]
AlignmentKind = Literal["none", "segment", "batch", "global", "token"]


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


def to_json(config: Any) -> dict[str, Any]:
    """A config dataclass as plain data."""
    return asdict(config)


def from_json(kind: type[Config], data: dict[str, Any]) -> Config:
    """The config dataclass of that kind, or NoWeights where the data describe another version of it."""
    try:
        return kind(**data)
    except TypeError as error:
        raise NoWeights(f"{kind.__name__} was saved by another version of this program ({error})") from None
