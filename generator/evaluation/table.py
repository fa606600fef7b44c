"""The table of an evaluation, for people."""

from collections.abc import Mapping
from io import StringIO
from typing import Final

from rich.console import Console
from rich.table import Table

from generator.evaluation.protocol import Score

COLUMNS: Final = {
    "top1": "Top-1",
    "top2": "Top-2",
    "top3": "Top-3",
    "fid": "FID",
    "mm_dist": "MM-Dist",
    "diversity": "Diversity",
    "multimodality": "MModality",
    "tc": "TC",
    "sc": "SC",
    "mpjpe_mm": "MPJPE, mm",
}
WIDTH: Final = 160


def table(rows: Mapping[str, Mapping[str, Score]], title: str) -> str:
    """Rows of scores as text, each score as its mean and half of its 95 % interval; a metric no row has is left out."""
    present = [name for name in COLUMNS if any(name in scores for scores in rows.values())]
    drawing = Table(title=title, title_justify="left")
    drawing.add_column("")
    for name in present:
        drawing.add_column(COLUMNS[name], justify="right")
    for row, scores in rows.items():
        drawing.add_row(row, *(_cell(scores.get(name)) for name in present))
    text = StringIO()
    Console(file=text, width=WIDTH).print(drawing)
    return text.getvalue().rstrip()


def _cell(score: Score | None) -> str:
    if score is None:
        return ""
    digits = 1 if score.mean >= 100 else 3
    return f"{score.mean:.{digits}f} ±{score.interval:.{digits}f}"
