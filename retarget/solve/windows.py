"""Overlapping stretches of a long clip, each solved while the rest of the clip stays."""

from retarget.solve.differences import Stretch

LENGTH = 640
"""Most frames of a window: memory grows with it, not with the clip."""
OVERLAP = 80
"""Least frames that two windows share: what happens beyond them no longer matters to the frames that are kept."""


def windows(total: int, length: int = LENGTH, overlap: int = OVERLAP) -> list[Stretch]:
    """Stretches of at most `length` frames, equally long, that cover a clip of `total` frames."""
    if total <= length:
        return [Stretch(0, total, total)]
    count = -(-(total - overlap) // (length - overlap))
    share = -(-(total - overlap) // count) + overlap
    starts = [round(k * (total - share) / (count - 1)) for k in range(count)]
    return [Stretch(start, start + share, total) for start in starts]
