"""SegMo as a `MotionModel`: texts to base tokens, to residual tokens, to features."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Self, TypeVar

import torch
from torch import Tensor, nn

from generator import weights
from generator.config import from_json
from generator.datasets.layout import layout_of
from generator.model import FeatureSpec, Known, Sample, Sampling, TextCondition
from generator.models.segmo.conditioning import Condition
from generator.models.segmo.config import TOKEN_FRAMES, SegmoSampling, TokenizerConfig, TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.residual_transformer import ResidualTransformer
from generator.models.segmo.tokenizer import MotionTokenizer
from ros_free_stack.errors import NoWeights

Model = TypeVar("Model", bound=nn.Module)


@dataclass(frozen=True)
class SegMo:
    """The trained tokenizer and transformers; make one with `SegMo.load`.

    `residual` is None where the base layer alone is sampled.
    """

    tokenizer: MotionTokenizer
    mask: MaskTransformer
    residual: ResidualTransformer | None
    name: str
    settings: SegmoSampling = field(default_factory=SegmoSampling)

    @property
    def spec(self) -> FeatureSpec:
        shares = "uniform" if self.mask.config.layout == "uniform" else "predicted"
        kind = layout_of(self.tokenizer.config.features)
        return FeatureSpec(kind.width, kind.fps, kind.least_frames, kind.most_frames, TOKEN_FRAMES, shares)

    @torch.inference_mode()
    def sample(
        self, text: TextCondition, *, known: Known | None, sampling: Sampling, noise: torch.Generator
    ) -> list[Sample]:
        """See `MotionModel.sample`; a sample's latent is its tokens (Q' P, n) of Q' layers of P parts."""
        condition, settings = Condition.of(text, clauses=self.mask.config.clauses), self.settings.told(sampling)
        given = None if known is None else self._tokens(known, condition)
        base = None if given is None else given[: self.mask.config.parts]
        tokens = self.mask.generate(condition, settings, noise, base)
        if self.residual is not None:
            tokens = self.residual.generate(tokens, condition, settings, noise, given)
        # Each at its own length, so that padding cannot reach it.
        return [
            Sample(self.tokenizer.decode(tokens[:, i : i + 1, :length])[0].float(), tokens[:, i, :length])
            for i, length in enumerate(condition.lengths.sum(1).tolist())
        ]

    def reconstruct(self, features: Tensor) -> Tensor:
        """Features (T, 263) after a trip through the tokens, without a rest of T modulo 4 frames."""
        return self.tokenizer.decode(self.tokenizer.encode(features[None].to(self.tokenizer.mean.device)))[0]

    @classmethod
    def load(cls, folder: Path, *, device: str) -> Self:
        """Read tokenizer, mask transformer and, where its layers are sampled, residual transformer.

        Raises:
            NoWeights: a model is not trained, or was trained with another tokenizer; the message says what to do.
        """
        saved = {name: weights.load(folder / name, name) for name in ("tokenizer", "mask")}
        settings = from_json(SegmoSampling, saved["mask"].facts.get("sampling", {}))
        if settings.layers > 1:
            saved["residual"] = weights.load(folder / "residual", "residual")
        for name in list(saved)[1:]:
            if saved[name].facts.get("tokenizer") != saved["tokenizer"].digest:
                raise NoWeights(
                    f"{folder / name}: was trained with another tokenizer than the one in {folder}; "
                    f"train it again with `python launch.py train {name} --dataset DATASET --out {folder.parent}`"
                )

        def fill(name: str, model: Model) -> Model:
            saved[name].fill(model)
            return model.to(device).eval().requires_grad_(False)

        return cls(
            fill("tokenizer", MotionTokenizer(saved["tokenizer"].config_as(TokenizerConfig))),
            fill("mask", MaskTransformer(saved["mask"].config_as(TransformerConfig))),
            fill("residual", ResidualTransformer(saved["residual"].config_as(TransformerConfig)))
            if "residual" in saved
            else None,
            f"{folder.name} {saved['mask'].digest[:8]}",
            settings,
        )

    def _tokens(self, known: Known, condition: Condition) -> Tensor:
        """(Q' P, B, n) tokens of the known frames, -1 where there are none."""
        stays = known.mask.unflatten(1, (-1, TOKEN_FRAMES)).all(-1)
        if known.latent is not None:
            return torch.where(stays, known.latent, -1)
        rows = self.tokenizer.config.quantizers * len(self.tokenizer.channels)
        tokens = condition.lengths.new_full((rows, *stays.shape), -1)
        for row, length in enumerate(condition.lengths.sum(1).tolist()):
            for first, last in _runs(stays[row, :length]):
                lead = known.lead if first == 0 else known.lead[:0]
                trail = known.trail if last == length else known.trail[:0]
                frames = known.features[row, TOKEN_FRAMES * first : TOKEN_FRAMES * last]
                found = self.tokenizer.encode(torch.cat([lead, frames, trail])[None])[:, 0]
                before = len(lead) // TOKEN_FRAMES
                tokens[:, row, first:last] = found[:, before : before + last - first]
        return tokens


def _runs(flags: Tensor) -> list[tuple[int, int]]:
    """First and last (excluded) place of each run of true flags (n,)."""
    edges = torch.nn.functional.pad(flags.int(), (1, 1)).diff().tolist()
    starts = [place for place, edge in enumerate(edges) if edge > 0]
    return list(zip(starts, (place for place, edge in enumerate(edges) if edge < 0), strict=True))
