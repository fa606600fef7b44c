"""Cycle time of the driver's exchange against the SDK's own group calls, on the same emulated bus.

The bus runs in a process of its own and takes as long for each byte as a wire at 2 Mbps. Each figure is a whole cycle
of 20 servos, goals out and the same 16 bytes of state in from each.

    python benchmarks/bus_cycle.py
"""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter, sleep

import numpy as np
from dynamixel_sdk import COMM_SUCCESS, GroupSyncRead, GroupSyncWrite

from hw.bus import Bus
from hw.cycle import Cycle
from hw.line import METHODS
from hw.pace import realtime_priority
from hw.rig import Rig
from hw.servos import Servos
from ros_free_stack.robots import load_robot

CYCLES = 300
EMULATOR = "import tyro; from hw.virtual.cli import ServosEmulate; tyro.cli(ServosEmulate).run()"


def times_ms(step: Callable[[], bool]) -> list[float]:
    """Duration of each of CYCLES calls that brought an answer, ms."""
    durations: list[float] = []
    for _ in range(CYCLES):
        start = perf_counter()
        if step():
            durations.append(1e3 * (perf_counter() - start))
        else:
            sleep(0.05)  # let a late answer pass: the SDK would take it for the next one
    return durations


def sdk_step(bus: Bus, rig: Rig, length: int, *, fast: bool) -> Callable[[], bool]:
    """One cycle with the SDK's GroupSyncWrite and GroupSyncRead of the first `length` indirect data."""
    table = rig.tables[0]
    goal = table["Goal Position"]
    writer = GroupSyncWrite(bus.handler, bus.packets, goal.address, goal.size)
    reader = GroupSyncRead(bus.handler, bus.packets, table.indirect_blocks[0].data, length)
    for identity in rig.ids:
        writer.addParam(identity, list(goal.pack(table.zero_position)))
        reader.addParam(identity)

    def step() -> bool:
        writer.txPacket()
        return (reader.fastSyncRead if fast else reader.txRxPacket)() == COMM_SUCCESS

    return step


def measure(port: str) -> dict[str, list[float]]:
    """Cycle times of every way, by name."""
    rig = Rig.of_robot(load_robot("op3"))
    found: dict[str, list[float]] = {}
    with Bus(port, rig.baud) as bus:
        cycle = Cycle(Servos.find(rig, (bus,)))
        patience = bus.serial.timeout
        address, mapping = cycle.map_state(0)
        for identity in rig.ids:
            bus.write_bytes(identity, address, mapping)
        bus.serial.timeout = 0  # as the SDK opens it
        found["SDK Sync Read"] = times_ms(sdk_step(bus, rig, len(mapping) // 2, fast=False))
        found["SDK Fast Sync Read"] = times_ms(sdk_step(bus, rig, len(mapping) // 2, fast=True))
        bus.serial.timeout = patience
        goals = rig.zero
        for cycle.method in METHODS[:2]:
            found[f"driver {cycle.method}"] = times_ms(lambda: bool(cycle.exchange(goals).fresh.all()))
    return found


def main() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", EMULATOR, "--json"],
        cwd=Path(__file__).parents[1],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as emulator:
        assert emulator.stdout is not None
        text = ""
        while not text.endswith("}\n"):
            text += emulator.stdout.readline()
        try:
            with realtime_priority():
                found = measure(json.loads(text)["port"])
        finally:
            emulator.terminate()
    reference = median(found["driver fast sync read"])
    print(f"{'cycle of 20 servos':24s} {'median ms':>10s} {'p99 ms':>8s} {'against the driver':>20s} {'answered':>9s}")
    for name, values in found.items():
        ratio = median(values) / reference
        late, answered = np.percentile(values, 99), len(values) / CYCLES
        print(f"{name:24s} {median(values):10.2f} {late:8.2f} {ratio:19.2f}x {answered:9.0%}")


if __name__ == "__main__":
    main()
