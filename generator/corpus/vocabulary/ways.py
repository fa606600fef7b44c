"""Ways that several actions go."""

from typing import Final

MAX_STRAIGHT_DEG: Final = 25.0


def curved_ways(curve: float) -> tuple[str, ...]:
    """Words for a curve of so many degrees, left positive."""
    side = "left" if curve > 0 else "right"
    return (
        f"forward in a curve to the {side}",
        f"in a curve to the {side}",
        f"forward and to the {side}",
        f"forward curving to the {side}",
        f"in an arc to the {side}",
        f"forward while curving {side}",
    )
