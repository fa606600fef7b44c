"""Ctrl-C, the quit key, SIGTERM and a lost terminal as a flag, so that no controlled stop and no lock is cut in two."""

import signal
import threading
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGQUIT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


@dataclass
class Interrupts:
    """`pending` is set by a signal; `check` raises it as KeyboardInterrupt where that is safe."""

    pending: bool = False

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal has come."""
        if self.pending:
            raise KeyboardInterrupt


@contextmanager
def caught_interrupts() -> Generator[Interrupts]:
    """Catch SIGINT, SIGQUIT, SIGTERM and SIGHUP for a while; outside the main thread no handler may be set."""
    interrupts = Interrupts()
    if threading.current_thread() is not threading.main_thread():
        yield interrupts
        return

    def remember(number: int, frame: FrameType | None) -> None:
        interrupts.pending = True

    before = {number: signal.signal(number, remember) for number in _SIGNALS}
    try:
        yield interrupts
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
