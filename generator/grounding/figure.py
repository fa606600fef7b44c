"""The similarity map of motion grounding as a picture (SegMo, figure 5)."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from generator.grounding.search import Found
from generator.models.segmo.config import TOKEN_S
from ros_free_stack.files import atomic_path


def draw_similarity(path: Path, similarity: np.ndarray, texts: Sequence[str], found: Sequence[Found]) -> None:
    """Write a PNG: a row for each text, a column for each start of the sliding window, where each was found as a bar.

    Args:
        similarity: (A, S) cosines; column i is a window that starts at token i.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    count, starts = similarity.shape
    figure = Figure(figsize=(9, 1.6 + 0.5 * count), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    image = axes.imshow(
        similarity,
        aspect="auto",
        cmap="viridis",
        vmin=-1,
        vmax=1,
        extent=(0, starts * TOKEN_S, count - 0.5, -0.5),
    )
    for row, place in enumerate(found):
        axes.plot([place.start_s, place.end_s], [row + 0.36, row + 0.36], color="#dc2626", lw=4, solid_capstyle="butt")
    axes.set_yticks(range(count), [text.removeprefix("a person ") for text in texts])
    axes.set_xlabel("start of the window, s (red: where the text was found)")
    axes.set_xlim(0, max([starts * TOKEN_S, *(place.end_s for place in found)]))
    figure.colorbar(image, ax=axes, label="cosine similarity")
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format="png")
