"""Every goal position that a servo was ever told, kept for proof that none lay outside its limits."""

from array import array
from dataclasses import dataclass, field


@dataclass
class GoalLog:
    """Goals in the order in which they came, those that the firmware refused included.

    Attributes:
        times: s of the servo's clock.
        values: raw goal positions.
        outside: how many lay outside the position limits that the servo itself held at that time.
        accepted_extremes: lowest and highest that took effect.
    """

    times: "array[float]" = field(default_factory=lambda: array("d"))
    values: "array[int]" = field(default_factory=lambda: array("i"))
    outside: int = 0
    accepted_extremes: tuple[int, int] | None = None

    def add(self, time_s: float, value: int, *, accepted: bool, low: int, high: int) -> None:
        """Record one goal against the servo's own position limits."""
        self.times.append(time_s)
        self.values.append(value)
        self.outside += not low <= value <= high
        if accepted:
            least, most = self.accepted_extremes or (value, value)
            self.accepted_extremes = min(least, value), max(most, value)

    def beyond(self, low: int, high: int) -> int:
        """How many goals lay outside `low` to `high`."""
        return sum(not low <= value <= high for value in self.values)

    def __len__(self) -> int:
        return len(self.values)
