"""How long each stage took, by the clock and by the processor."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter, process_time


@dataclass
class Timings:
    """Seconds spent in each stage; `cpu` are those in which this process had a core, all its threads together."""

    seconds: dict[str, float] = field(default_factory=dict[str, float])
    cpu: dict[str, float] = field(default_factory=dict[str, float])

    @contextmanager
    def measure(self, stage: str) -> Iterator[None]:
        start, cpu = perf_counter(), process_time()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + perf_counter() - start
            self.cpu[stage] = self.cpu.get(stage, 0.0) + process_time() - cpu
