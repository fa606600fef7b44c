"""What a person sees of a training run: a progress bar on a terminal, a line a minute elsewhere."""

import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from ros_free_stack.console import say

LINE_EVERY_S = 60.0


class Reporter:
    """Context in which `update` shows how far the training is, on stderr."""

    def __init__(self, name: str, iterations: int) -> None:
        self._name, self._iterations = name, iterations
        console = Console(stderr=True)
        self._bar: Progress | None = None
        if console.is_terminal:
            columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
            self._bar = Progress(*columns, console=console, refresh_per_second=2)
            self._task = self._bar.add_task(name, total=1.0)
        self._line = self._clock = time.monotonic()
        self._seen = -1

    def __enter__(self) -> Self:
        if self._bar:
            self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None):
        if self._bar:
            self._bar.stop()

    def update(self, iteration: int, progress: float, row: dict[str, float]) -> None:
        """Show the iteration, the share done (0 to 1), and the newest row of the loss curve."""
        now = time.monotonic()
        due = now - self._line >= LINE_EVERY_S or progress >= 1
        if self._seen < 0:
            self._seen = iteration - 1
        if self._bar is None and not due:
            return
        pace = 1e3 * (now - self._clock) / max(1, iteration - self._seen)
        losses = " ".join(f"{k} {v:.4g}" for k, v in row.items() if k not in ("iteration", "seconds", "learning_rate"))
        text = f"{self._name} {iteration}/{self._iterations} {pace:.0f} ms/it {losses}"
        if self._bar:
            self._bar.update(self._task, completed=progress, description=text)
        else:
            say(f"{text} ({100 * progress:.0f} %)")
            self._line = self._clock = now
            self._seen = iteration
