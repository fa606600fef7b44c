"""What a stretch of a clip may cost: interior-point iterations, which are the same for every run, unlike seconds."""

from dataclasses import dataclass, field

BUDGET = 110
"""Interior-point iterations for a stretch, all its programs together: most need a third of it, and what needs more
gains little by it. A frame of an iteration costs 17 us on a robot of 20 joints, 25 us on one of 29."""


@dataclass
class Effort:
    """What may still be spent on one stretch, and what has been found out on the way.

    Attributes:
        left: interior-point iterations.
        unmended: violation that was left when programs ceased to mend it, m and rad of all frames together.
    """

    left: int = field(default_factory=lambda: BUDGET)
    unmended: float = 0.0

    @property
    def spent(self) -> bool:
        """Whether nothing is left: what was found so far has to do."""
        return self.left <= 0
