"""Limits of the checks, read from `thresholds.yaml`."""

import hashlib
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any, get_args

import yaml

from ros_free_stack.errors import UnknownName
from ros_free_stack.messages import Check, Level

LEVELS: tuple[Level, ...] = get_args(Level)


@dataclass(frozen=True)
class Threshold:
    """One limit: its unit, whether it is a minimum, and where it comes from."""

    limit: float
    unit: str
    minimum: bool
    source: str

    def check(self, name: str, value: float, meaning: str, *, worst_frame: int = -1, worst_item: str = "") -> Check:
        """The measured value against this limit."""
        value = float(value)
        check = Check(name, value, self.unit, self.limit, False, int(worst_frame), worst_item, meaning, self.minimum)
        return replace(check, passed=check.holds)


def load_thresholds(level: Level, *, scale: float) -> dict[str, Threshold]:
    """Every check's limit at one level, for a robot of `scale` times G1's height.

    Raises:
        UnknownName: no such level.
    """
    if level not in LEVELS:
        raise UnknownName("level", level, LEVELS)
    return {
        name: Threshold(
            limit=float(item[level]) * (scale if item.get("scaled") else 1.0),
            unit=str(item["unit"]),
            minimum=item.get("sense") == "minimum",
            source=str(item["source"]),
        )
        for name, item in _table().items()
    }


def limits_sha256(limits: dict[str, Threshold]) -> str:
    """Hash of every limit's name, value, unit and sense; a verdict carries it, so that new limits end old verdicts."""
    rows = sorted((name, repr(item.limit), item.unit, item.minimum) for name, item in limits.items())
    return hashlib.sha256(repr(rows).encode()).hexdigest()


@cache
def _table() -> dict[str, dict[str, Any]]:
    """The file as it is; reading it takes longer than some checks."""
    return yaml.safe_load((resources.files("ros_free_stack") / "thresholds.yaml").read_text(encoding="utf-8"))
