"""Generation in cycles: some tokens of each part, then those tokens of the whole body that they guide.

Every token is read once: transformers and fusion keep keys and values.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import torch
from torch import Tensor

from generator.bodies import WHOLE
from generator.models.party.condition import Condition
from generator.models.party.config import PartySampling
from generator.models.party.fusion import FusionPast
from generator.models.party.network import PartyNetwork, sum_of
from generator.nn.causal import NEVER, Past


@dataclass
class _Body:
    """One body while it is generated.

    Attributes:
        told: (2B or B, count, W) what its places are told.
        tokens: (B, n, G) tokens so far.
        valid: (B, n) true on tokens before its end.
        open: (B,) true on motions that this body has not ended.
    """

    told: Tensor
    past: tuple[Past, ...]
    open: Tensor
    tokens: list[Tensor] = field(default_factory=list[Tensor])
    valid: list[Tensor] = field(default_factory=list[Tensor])


class Generation:
    """Tokens of one batch of motions.

    Args:
        network: the trained network.
        condition: texts; the frames of the segments set the length unless `most` is given.
        known: of each body tokens (B, n, G) that stay, -1 for those to be generated.
        most: frames of the longest motion; motions then end where their end tokens come.
    """

    def __init__(
        self,
        network: PartyNetwork,
        condition: Condition,
        sampling: PartySampling,
        noise: torch.Generator,
        known: Mapping[str, Tensor] | None = None,
        most: int | None = None,
    ) -> None:
        self._network, self._sampling, self._noise = network, sampling, noise
        self._known, self._own_end = known or {}, most is not None
        self._condition, self._batch = condition, len(condition.frames)
        self._times = 1 if sampling.guidance == 1 else 2
        frames = int(condition.total.max()) if most is None else most
        self._counts = {body: -(-frames // network.tokens.window_of(body)) for body in network.tokens.bodies}
        both = condition.repeated(self._times)
        keep = torch.arange(len(both.frames), device=both.frames.device) < self._batch
        told = network.places(network.read(both), both, keep, self._counts)
        self._bodies = {
            body: _Body(places, network.body(body).transformer.past(), torch.ones_like(keep[: self._batch]))
            for body, places in told.items()
        }
        self._fusion = FusionPast(len(network.tokens.parts))

    def run(self) -> tuple[dict[str, Tensor], Tensor]:
        """Tokens (B, n, G) of each body, and the (B,) frames of each motion."""
        network, cycle = self._network, 0
        lead = WHOLE if network.tokens.holistic else network.tokens.parts[0]
        while len(self._bodies[lead].tokens) < self._counts[lead] and self._any_open(lead):
            guidance = self._part_steps()
            if network.tokens.holistic:
                self._whole_steps(cycle, guidance)
            cycle += 1
        tokens = {name: torch.stack(body.tokens, dim=1) for name, body in self._bodies.items() if body.tokens}
        return tokens, self._frames()

    def _any_open(self, lead: str) -> bool:
        names = (lead,) if self._network.tokens.holistic else self._network.tokens.parts
        return any(bool(self._bodies[name].open.any()) for name in names)

    def _frames(self) -> Tensor:
        if not self._own_end:
            return self._condition.total
        tokens = self._network.tokens
        names = (WHOLE,) if tokens.holistic else tokens.parts
        lasts = [torch.stack(self._bodies[name].valid).sum(0) * tokens.window_of(name) for name in names]
        return torch.stack(lasts).amax(0)

    def _part_steps(self) -> Tensor | None:
        """Generate a cycle's tokens of each part; (2B or B, W) guidance of the cycle (equations 4 to 6)."""
        network = self._network
        total: Tensor | None = None
        for _ in range(network.config.part_cycle):
            parts = network.tokens.parts
            if not parts or len(self._bodies[parts[0]].tokens) >= self._counts[parts[0]]:
                break
            for part in parts:
                earlier = self._embedded(part, len(self._bodies[part].tokens) - 1)
                self._next(part, earlier, self._told(part))
            if network.mix is not None:
                last = len(self._bodies[parts[0]].tokens) - 1
                fused = network.mix(sum_of([self._embedded(part, last) for part in parts]))
                fused = fused * self._valid(parts[0], last)[..., None]
                total = fused if total is None else total + fused
        return total

    def _whole_steps(self, cycle: int, guidance: Tensor | None) -> None:
        """Generate a cycle's tokens of the whole body (equation 7)."""
        body = self._bodies[WHOLE]
        for _ in range(self._network.config.cycle):
            if len(body.tokens) >= self._counts[WHOLE]:
                break
            told = self._told(WHOLE)
            self._next(WHOLE, self._fused(len(body.tokens) - 1), told if guidance is None else told + guidance)

    def _fused(self, step: int) -> Tensor:
        """(2B or B, 1, W) the whole body's token of a step, fused with the parts' tokens of that step."""
        whole, network = self._embedded(WHOLE, step), self._network
        if network.fusion is None or step < 0:
            return whole
        tokens, parts = network.tokens, network.tokens.parts
        rows: list[Tensor] = []
        valid: list[Tensor] = []
        for part in parts:
            own = range(len(self._bodies[part].tokens))
            places = [place for place in own if place * tokens.part_window // tokens.window == step]
            rows.append(torch.cat([whole[:, :0], *(self._embedded(part, place) for place in places)], dim=1))
            valid.append(torch.cat([whole[:, :0, 0].bool(), *(self._valid(part, place) for place in places)], dim=1))
        return network.fusion.step(whole, rows, valid, self._fusion)

    def _embedded(self, name: str, place: int) -> Tensor:
        """(2B or B, 1, W) a token, zero before the first."""
        body = self._bodies[name]
        if place < 0:
            return torch.zeros_like(body.told[:, :1])
        return self._network.body(name).embed(body.tokens[place][:, None]).repeat(self._times, 1, 1)

    def _valid(self, name: str, place: int) -> Tensor:
        """(2B or B, 1) whether a token lies before the motion's end."""
        return self._bodies[name].valid[place][:, None].repeat(self._times, 1)

    def _told(self, name: str) -> Tensor:
        place = len(self._bodies[name].tokens)
        return self._bodies[name].told[:, place : place + 1]

    def _next(self, name: str, earlier: Tensor, told: Tensor) -> None:
        """Draw the next token of a body."""
        body, transformer = self._bodies[name], self._network.body(name)
        hidden, place = transformer.hidden(earlier, told, body.past), len(body.tokens)
        known = self._known.get(name)
        groups: list[Tensor] = []

        def choose(logits: Tensor) -> Tensor:
            drawn = self._drawn(logits[:, 0], end=self._own_end and place > 0 and not groups)
            if known is not None and place < known.shape[1]:
                told_code = known[:, place, len(groups)]
                drawn = torch.where(told_code >= 0, told_code, drawn)
            groups.append(drawn)
            return drawn.repeat(self._times)[:, None]

        transformer.head.draw(hidden, choose)
        body.tokens.append(torch.stack(groups, dim=-1))
        if self._own_end:
            body.open = body.open & (groups[0] < transformer.codes)
            body.valid.append(body.open)
        else:
            body.valid.append(place < self._condition.counts(self._network.tokens.window_of(name)))

    def _drawn(self, logits: Tensor, *, end: bool) -> Tensor:
        """(B,) codes drawn from logits (2B or B, K + 1), of guided and unguided motions."""
        logits = logits.float()
        if not end:
            logits = torch.cat([logits[:, :-1], torch.full_like(logits[:, -1:], NEVER)], dim=-1)
        with_text, without = logits[: self._batch], logits[-self._batch :]
        guided = without + self._sampling.guidance * (with_text - without)
        best, codes = guided.topk(max(1, round(self._sampling.top_k * guided.shape[-1])), dim=-1)
        chance = (best / self._sampling.temperature).softmax(-1)
        return codes.gather(-1, torch.multinomial(chance, 1, generator=self._noise))[:, 0]
