"""Which steps of a constrained Gauss-Newton iteration to take: the filter of Fletcher and Leyffer."""

from dataclasses import dataclass, field

LESS = 0.7
"""Share of a former violation that counts as an improvement."""
LARGEST = 1e-3
"""Mean violation of a frame, m or rad, beyond which no step is taken that makes it worse."""


@dataclass
class Filter:
    """Pairs of (cost, violation) met so far; a new one must be better than each of them in one of the two.

    A penalty on the violation would refuse full steps whose second-order error breaks the constraints for a moment (the
    Maratos effect). Fletcher and Leyffer 2002, "Nonlinear programming without a penalty function".
    """

    frames: int
    met: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])

    def accepts(self, cost: float, violation: float) -> bool:
        """Whether a point may be moved to."""
        bound = max([LARGEST * self.frames, *(v for _, v in self.met)])
        return violation <= bound and all(cost < c or violation < LESS * v for c, v in self.met)

    def add(self, cost: float, violation: float) -> None:
        """Remember a point that was moved to."""
        self.met.append((cost, violation))
