"""ParTY as a `MotionModel`: texts to tokens of parts and of the whole body, to features."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import torch
from torch import Tensor

from generator import weights
from generator.config import from_json
from generator.datasets.layout import layout_of
from generator.model import FeatureSpec, Known, Sample, Sampling, TextCondition
from generator.models.party.condition import Condition
from generator.models.party.config import PartySampling, TokenizerConfig, TransformerConfig
from generator.models.party.generation import Generation
from generator.models.party.network import PartyNetwork
from generator.models.party.tokenizer import PartyTokenizer
from generator.registry import training_command
from ros_free_stack.errors import InvalidOption, NoWeights

STAGES = ("tokenizer", "transformer")


@dataclass(frozen=True)
class Party:
    """The trained tokenizer and network; make one with `Party.load`."""

    tokenizer: PartyTokenizer
    network: PartyNetwork
    name: str
    settings: PartySampling = field(default_factory=PartySampling)

    @property
    def spec(self) -> FeatureSpec:
        """Shortest and longest motion are whole tokens."""
        kind, unit = layout_of(self.tokenizer.config.features), self.tokenizer.config.unit
        least, most = -(-kind.least_frames // unit) * unit, kind.most_frames // unit * unit
        return FeatureSpec(kind.width, kind.fps, least, most, unit)

    @torch.inference_mode()
    def sample(
        self, text: TextCondition, *, known: Known | None, sampling: Sampling, noise: torch.Generator
    ) -> list[Sample]:
        """See `MotionModel.sample`. A motion is generated from its start on: what is known later is kept, but what
        comes before does not lead up to it.

        Raises:
            InvalidOption: a motion's segments do not fill whole tokens.
        """
        totals, unit = text.frames.sum(1), self.spec.token_frames
        if (totals % unit).any():
            raise InvalidOption(
                "frames", f"motions are whole tokens of {unit} frames, found {int(totals[totals % unit > 0][0])} frames"
            )
        condition = Condition.of(text, self.network.config.conditioning)
        given = None if known is None else self._tokens(known, condition)
        tokens, frames = Generation(self.network, condition, self.settings.told(sampling), noise, given).run()
        latent = self._latent(tokens, int(frames.max()))
        # Each at its own length, so that padding cannot reach it.
        return [
            Sample(
                self.tokenizer.decode({body: rows[i : i + 1] for body, rows in tokens.items()}, frames[i : i + 1])[0],
                latent[:, i, : length // self._step],
            )
            for i, length in enumerate(frames.tolist())
        ]

    def reconstruct(self, features: Tensor) -> Tensor:
        """Features (T, F) after a trip through the tokens; frames that fill no token go through one all the same."""
        frames = torch.tensor([len(features)], device=self.tokenizer.mean.device)
        rows = features[None].to(self.tokenizer.mean)
        return self.tokenizer.decode(self.tokenizer.encode(rows, frames), frames)[0]

    @classmethod
    def load(cls, folder: Path, *, device: str) -> Self:
        """Read tokenizer and network.

        Raises:
            NoWeights: a model is not trained, is another generator's, or was trained with another tokenizer; the
                message says what to do.
        """
        saved = {name: weights.load(folder / name, name) for name in STAGES}
        for name, one in saved.items():
            if one.facts.get("generator") != folder.name:
                raise NoWeights(
                    f"{folder / name}: holds weights of another generator than {folder.name}; "
                    f"train it with `{training_command(name, folder / name)}`"
                )
        if saved["transformer"].facts.get("tokenizer") != saved["tokenizer"].digest:
            raise NoWeights(
                f"{folder / 'transformer'}: was trained with another tokenizer than the one in {folder}; "
                f"train it again with `{training_command('transformer', folder / 'transformer')}`"
            )
        config = saved["tokenizer"].config_as(TokenizerConfig)
        tokenizer = PartyTokenizer(config)
        network = PartyNetwork(saved["transformer"].config_as(TransformerConfig), config)
        saved["tokenizer"].fill(tokenizer)
        saved["transformer"].fill(network)
        return cls(
            tokenizer.to(device).eval().requires_grad_(False),
            network.to(device).eval().requires_grad_(False),
            f"{folder.name} {saved['transformer'].digest[:8]}",
            from_json(PartySampling, saved["transformer"].facts.get("sampling", {})),
        )

    @property
    def _step(self) -> int:
        """Frames of the shortest token: the step of a sample's latent."""
        config = self.tokenizer.config
        return min(config.window_of(body) for body in config.bodies)

    def _latent(self, tokens: dict[str, Tensor], frames: int) -> Tensor:
        """(rows, B, n) the codes of every body at each step; see `_step`."""
        places = torch.arange(-(-frames // self._step), device=self.tokenizer.mean.device) * self._step
        windows = {body: self.tokenizer.config.window_of(body) for body in tokens}
        return torch.cat([rows[:, places // windows[body]].permute(2, 0, 1) for body, rows in tokens.items()])

    def _tokens(self, known: Known, condition: Condition) -> dict[str, Tensor]:
        """Of each body (B, n, G) tokens of the known frames, -1 where a frame is not known."""
        config, found = self.tokenizer.config, dict[str, Tensor]()
        if known.latent is None:
            read = self._encoded(known, condition)
        else:
            sizes = [config.groups_of(body) for body in config.bodies]
            rows = dict(zip(config.bodies, known.latent.split(sizes), strict=True))
            read = {body: latent.permute(1, 2, 0) for body, latent in rows.items()}
        for body, tokens in read.items():
            window = config.window_of(body)
            starts = torch.arange(int(condition.counts(window).max()), device=tokens.device) * window
            at = starts // (window if known.latent is None else self._step)
            beyond = torch.arange(known.mask.shape[1], device=tokens.device) >= condition.total[:, None]
            stays = torch.nn.functional.pad(known.mask | beyond, (0, -known.mask.shape[1] % window), value=True)
            whole = stays.unflatten(1, (-1, window)).all(-1)[:, : len(starts)]
            found[body] = torch.where(whole[..., None], tokens[:, at], -1)
        return found

    def _encoded(self, known: Known, condition: Condition) -> dict[str, Tensor]:
        """Of each body (B, n, G) tokens of the known features, read with the frames before them as they are; those of
        unknown frames do not matter."""
        # What lies between is bridged by the nearest known frame, so that no jump is read at its ends.
        places = torch.arange(known.mask.shape[1], device=known.mask.device)
        marked = torch.where(known.mask, places, -1).cummax(1).values
        later = torch.where(known.mask, places, len(places)).flip(1).cummin(1).values.flip(1)
        source = torch.where(marked >= 0, marked, later.clamp_max(len(places) - 1))
        features = known.features.gather(1, source[..., None].expand_as(known.features))
        unit = self.tokenizer.config
        step = math.lcm(*(unit.window_of(body) for body in unit.bodies))
        lead = known.lead[len(known.lead) % step :]
        before = lead.expand(len(features), -1, -1)
        tokens = self.tokenizer.encode(torch.cat([before, features], dim=1), condition.total + len(lead))
        return {body: rows[:, len(lead) // unit.window_of(body) :] for body, rows in tokens.items()}
