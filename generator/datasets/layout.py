"""The published layouts of motion features: which skeleton, at which rate, how long motions are."""

from dataclasses import dataclass
from typing import Final

from ros_free_stack.errors import UnknownName
from ros_free_stack.formats.features import HUMANML3D, KIT, Skeleton


@dataclass(frozen=True)
class Layout:
    """Features of one data set's kind.

    Attributes:
        fps: frames a second.
        least_frames, most_frames: shortest and longest motion that is used (T2M).
        unit_m: what its lengths are in, m.
    """

    name: str
    skeleton: Skeleton
    fps: float
    least_frames: int
    most_frames: int
    unit_m: float

    @property
    def width(self) -> int:
        """Features of a frame."""
        return self.skeleton.width


LAYOUTS: Final = {
    layout.width: layout
    for layout in (Layout("humanml3d", HUMANML3D, 20.0, 40, 196, 1.0), Layout("kit-ml", KIT, 12.5, 24, 196, 0.001))
}
"""By feature width."""

HUMAN: Final = LAYOUTS[HUMANML3D.width]
"""What this project's human motion has: 22 joints, 263 features, 20 fps."""


def layout_of(width: int) -> Layout:
    """The layout of so many features a frame, or UnknownName."""
    if width not in LAYOUTS:
        raise UnknownName("feature width", str(width), map(str, LAYOUTS))
    return LAYOUTS[width]
