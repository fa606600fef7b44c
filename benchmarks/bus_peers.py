"""The driver's ways of reading against LeRobot's Dynamixel bus, in turns against one emulated bus.

The bus runs in a process of its own and takes as long for each byte as a wire at 2 Mbps. One cycle writes the goals of
20 XM430 and reads them: the driver its full block of 16 bytes a servo (torque, error, watchdog, current, velocity,
position, voltage, temperature), LeRobot its present positions of 4 bytes (`sync_write`, `sync_read`), and once the same
registers one after the other.

    python benchmarks/bus_peers.py --lerobot-python ../lerobot/bin/python

where that Python is one with `pip install lerobot dynamixel-sdk`. Without it, only the driver is measured. With
`--steady SECONDS` the driver also keeps 125 Hz for so long, for its jitter.
"""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import tyro

from hw.cycle import Cycle
from hw.line import BLOCK, METHODS, SINGLES_PER_CYCLE
from hw.pace import realtime_priority
from hw.rig import Rig
from hw.servos import Servos, open_ports
from ros_free_stack.rate import Rate
from ros_free_stack.robots import load_robot

ROOT = Path(__file__).parents[1]
RIG = Rig.of_robot(load_robot("op3"))
EMULATOR = "import tyro; from hw.virtual.cli import ServosEmulate; tyro.cli(ServosEmulate).run()"
PEER = Path(__file__).with_name("lerobot_bus.py")
BYTE_S = 10 / RIG.baud
N = len(RIG.ids)
SYNC_WRITE = 14 + 5 * N
REQUEST, ANSWER = 14 + N, 11
"""Bytes of a Sync Read and of a status packet without data."""

WIRE = {
    "fast sync read": SYNC_WRITE + REQUEST + 8 + N * (BLOCK.itemsize + 4),
    "sync read": SYNC_WRITE + REQUEST + N * (BLOCK.itemsize + ANSWER),
    "single reads": SYNC_WRITE + N * (14 + BLOCK.itemsize + ANSWER),
    "LeRobot, position": SYNC_WRITE + REQUEST + N * (4 + ANSWER),
    "LeRobot, the same registers": SYNC_WRITE + 8 * (REQUEST + N * ANSWER) + N * BLOCK.itemsize,
}
"""Bytes on the wire of one whole cycle."""

HEAD = ("wire ms", "p50 ms", "p99 ms", "max ms", "Hz", "of limit", "answered")


@contextmanager
def emulator() -> Iterator[str]:
    """An emulated bus in a process of its own; its port."""
    with subprocess.Popen(
        [sys.executable, "-c", EMULATOR, "--json"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        assert process.stdout is not None
        text = ""
        while not text.endswith("}\n"):
            text += process.stdout.readline()
        try:
            yield json.loads(text)["port"]
        finally:
            process.terminate()


def times_ms(step: Callable[[], bool], count: int) -> list[float]:
    """Duration of each of `count` calls that brought a whole answer, ms."""
    durations: list[float] = []
    for _ in range(count):
        start = time.perf_counter()
        if step():
            durations.append(1e3 * (time.perf_counter() - start))
    return durations


def driver_times(port: str, count: int) -> dict[str, list[float]]:
    """Cycle times of each way of reading."""
    found: dict[str, list[float]] = {}
    goals = np.full(N, RIG.tables[0].zero_position)
    with open_ports(port, RIG.baud) as buses:
        cycle = prepared(port, Servos.find(RIG, buses))
        for cycle.method in METHODS:
            turns = -(-N // SINGLES_PER_CYCLE) if cycle.method == "single reads" else 1

            def step(turns: int = turns) -> bool:
                fresh = cycle.exchange(goals).fresh
                for _ in range(turns - 1):
                    fresh = fresh | cycle.exchange(None).fresh
                return bool(fresh.all())

            found[cycle.method] = times_ms(step, count)
    return found


def prepared(port: str, servos: Servos) -> Cycle:
    """The cyclic exchange, with the state mapped into one block."""
    cycle = Cycle(servos)
    for i, identity in enumerate(RIG.ids):
        servos.bus(i).write_bytes(identity, *cycle.map_state(i))
    return cycle


def steady(port: str, seconds: float) -> str:
    """Keep the servo cycle for a while; words on its rate and jitter."""
    goals, lost = np.full(N, RIG.tables[0].zero_position), 0
    with open_ports(port, RIG.baud) as buses:
        cycle, rate = prepared(port, Servos.find(RIG, buses)), Rate(1 / RIG.cycle_s)
        rate.resume()
        for _ in range(round(seconds / RIG.cycle_s)):
            lost += int((~cycle.exchange(goals).fresh).sum())
            rate.sleep()
    s = rate.statistics()
    return (
        f"{s.cycles} cycles of {1e3 * RIG.cycle_s:g} ms: {s.rate_hz:.2f} Hz, late p50 {s.jitter_p50_ms:.3f}, p99 "
        f"{s.jitter_p99_ms:.3f}, max {s.jitter_max_ms:.3f} ms, {s.missed} missed, {lost} readings lost"
    )


def lerobot_times(python: Path, port: str, count: int) -> dict[str, list[float]]:
    """Cycle times of LeRobot's bus, measured by a process that has it."""
    ids = ",".join(map(str, RIG.ids))
    arguments = [str(python), str(PEER), port, str(RIG.baud), ids, str(count)]
    result = subprocess.run(arguments, capture_output=True, text=True, check=False)
    if result.returncode:
        raise SystemExit(f"LeRobot's bus failed: {result.stderr.strip().splitlines()[-1]}")
    return json.loads(result.stdout.splitlines()[-1])


def main(lerobot_python: Path | None = None, cycles: int = 200, rounds: int = 3, steady_s: float = 0.0) -> None:
    """Cycle rates of the driver and of LeRobot's bus.

    Args:
        lerobot_python: a Python that has LeRobot.
        cycles: of each way in each round.
        rounds: how often they take turns.
        steady_s: also keep 125 Hz for so long.
    """
    found: dict[str, list[float]] = {name: [] for name in WIRE}
    with emulator() as port, realtime_priority() as realtime:
        for _ in range(rounds):
            turns = driver_times(port, cycles)
            if lerobot_python is not None:
                turns |= lerobot_times(lerobot_python, port, max(1, cycles // 4))
            for name, values in turns.items():
                found[name] += values
        words = steady(port, steady_s) if steady_s else ""
    print(
        f"goals to and state from {N} servos at {RIG.baud:,} bit/s; real-time priority: {'yes' if realtime else 'no'}"
    )
    print(f"{'':28s} " + " ".join(f"{title:>8s}" for title in HEAD))
    for name, values in found.items():
        if not values:
            continue
        wire, (p50, p99) = 1e3 * BYTE_S * WIRE[name], np.percentile(values, [50, 99])
        tried = rounds * (max(1, cycles // 4) if name.startswith("LeRobot") else cycles)
        print(
            f"{name:28s} {wire:8.2f} {p50:8.2f} {p99:8.2f} {max(values):8.2f} {1e3 / p50:8.1f} {wire / p50:8.2f} "
            f"{len(values) / tried:8.0%}"
        )
    if words:
        print(words)


if __name__ == "__main__":
    tyro.cli(main)
