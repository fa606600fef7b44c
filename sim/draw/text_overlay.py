"""Words on the frames of a video: what is shown, what is done, the time, and a line that grows with it."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ros_free_stack.messages import Floats
from sim.draw.playback_frames import Film

INK, FAINT, ALARM = (31, 41, 55), (71, 85, 105), (185, 28, 28)
ACCENT = (37, 99, 235)
_MARGIN = 12


class Lettering:
    """Writes onto a film's frames of a width and height in pixels."""

    def __init__(self, film: Film, width: int, height: int) -> None:
        self._film, self._width, self._height = film, width, height

    def write(self, picture: np.ndarray, frame: int) -> None:
        """Write onto a frame's picture (height, width, 3) bytes."""
        film, time = self._film, frame / self._film.fps
        left = 0
        if film.human is not None:
            left = self._width // 2
            picture[:, left - 1 : left + 1] = 255
            self._put(picture, "human", FAINT, 16, x=_MARGIN, y=_MARGIN)
        fell = film.fell_at_s is not None and time >= film.fell_at_s
        title = f"{film.title}: fell" if fell else film.title
        self._put(picture, title, ALARM if fell else FAINT, 16, x=left + _MARGIN, y=_MARGIN)
        low = self._height - _MARGIN - 24
        if film.texts[frame]:
            self._put(picture, film.texts[frame], INK, 19, x=_MARGIN, y=low)
        clock = label(f"{time:.1f} s", FAINT, 16)
        blend(picture, clock, self._width - _MARGIN - clock.shape[1], low + 2)
        picture[-4:, : round(self._width * (frame + 1) / len(film))] = ACCENT

    def _put(self, picture: np.ndarray, text: str, colour: tuple[int, int, int], size: int, *, x: int, y: int) -> None:
        blend(picture, label(text, colour, size), x, y)


@cache
def label(text: str, colour: tuple[int, int, int], size: int) -> Floats:
    """(height, width, 4) a line of text; the last channel is its coverage, 0 to 1."""
    from PIL import Image, ImageDraw

    font = _font(size)
    left, _, right, bottom = font.getbbox(text)
    coverage = Image.new("L", (int(right - left) + 2, int(bottom) + 2), 0)
    ImageDraw.Draw(coverage).text((-left, 0), text, fill=255, font=font)
    alpha = np.asarray(coverage, float)[..., None] / 255
    return np.concatenate([np.broadcast_to(np.array(colour, float), (*alpha.shape[:2], 3)), alpha], axis=2)


def blend(picture: np.ndarray, words: Floats, x: int, y: int) -> None:
    """Lay a label onto a picture with its upper left corner at x, y; what sticks out is cut off."""
    height, width = (
        min(a, b) for a, b in zip(words.shape[:2], (picture.shape[0] - y, picture.shape[1] - x), strict=True)
    )
    words = words[:height, :width]
    part = picture[y : y + height, x : x + width]
    part[:] = (part + words[..., 3:] * (words[..., :3] - part)).astype(np.uint8)


@cache
def _font(size: int) -> Any:
    import matplotlib as mpl
    from PIL import ImageFont

    return ImageFont.truetype(Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", size)
