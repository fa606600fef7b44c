"""Real-time priority for the loops that a servo cycle depends on."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

_PRIORITY = 10


@contextmanager
def realtime_priority() -> Iterator[bool]:
    """Run this thread ahead of ordinary ones where the system lets us; yields whether it does."""
    try:
        before = os.sched_getscheduler(0), os.sched_getparam(0)
        # In turns: on a single core, driver and emulated bus would otherwise keep each other from running.
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(_PRIORITY))
    except (AttributeError, OSError):
        # Not Linux, or not permitted.
        yield False
        return
    try:
        yield True
    finally:
        os.sched_setscheduler(0, *before)
