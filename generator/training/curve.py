"""The loss curve of a training run, as csv and as a picture."""

import csv
from collections.abc import Sequence
from pathlib import Path

from ros_free_stack.files import atomic_path

Row = dict[str, float]


def write_curve(path: Path, rows: Sequence[Row]) -> None:
    """Write one line a row; a value that a row does not have is left empty."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    with atomic_path(path) as temporary, temporary.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, columns)
        writer.writeheader()
        writer.writerows({name: f"{value:.6g}" for name, value in row.items()} for row in rows)


def plot_curve(path: Path, rows: Sequence[Row], title: str) -> None:
    """Draw the training and validation loss over the iterations."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for column, label in (("loss", "training"), ("validation_loss", "validation")):
        points = [(row["iteration"], row[column]) for row in rows if column in row]
        if points:
            axes.plot(*zip(*points, strict=True), label=label, marker="o" if label == "validation" else None, ms=3)
    axes.set(title=title, xlabel="iteration", ylabel="loss", yscale="log")
    axes.grid(alpha=0.3)
    axes.legend()
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)
