"""Cycle time of the driver's exchange against the SDK's own group calls, on the same emulated bus.

The bus runs in a process of its own and takes as long for each byte as a wire at 2 Mbps. Each figure is a whole cycle
of 20 servos, goals out and state in; the SDK's group calls read 10 bytes a servo, the driver's block 16.

    python benchmarks/bus_cycle.py
"""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
from dynamixel_sdk import GroupSyncRead, GroupSyncWrite

from hw.bus import Bus
from hw.cycle import METHODS, Cycle
from hw.pace import realtime_priority
from hw.rig import Rig
from ros_free_stack.robots import load_robot

CYCLES = 300
EMULATOR = "import tyro; from hw.cli import ServosEmulate; tyro.cli(ServosEmulate).run()"


def times_ms(step: Callable[[], object]) -> list[float]:
    """Duration of each of CYCLES calls, ms."""
    durations: list[float] = []
    for _ in range(CYCLES):
        start = perf_counter()
        step()
        durations.append(1e3 * (perf_counter() - start))
    return durations


def sdk_step(bus: Bus, rig: Rig, *, fast: bool) -> Callable[[], None]:
    """One cycle with the SDK's GroupSyncWrite and GroupSyncRead of current, velocity and position."""
    goal, first = rig.table["Goal Position"], rig.table["Present Current"]
    length = rig.table["Present Position"].end - first.address
    writer = GroupSyncWrite(bus.handler, bus.packets, goal.address, goal.size)
    reader = GroupSyncRead(bus.handler, bus.packets, first.address, length)
    for identity in rig.ids:
        writer.addParam(identity, list(goal.pack(rig.table.zero_position)))
        reader.addParam(identity)

    def step() -> None:
        writer.txPacket()
        (reader.fastSyncRead if fast else reader.txRxPacket)()

    return step


def measure(port: str) -> dict[str, list[float]]:
    """Cycle times of every way, by name."""
    rig = Rig.of_robot(load_robot("op3"))
    found: dict[str, list[float]] = {}
    with Bus(port, rig.baud) as bus:
        bus.serial.timeout = 0  # as the SDK opens it
        found["SDK Sync Read"] = times_ms(sdk_step(bus, rig, fast=False))
        found["SDK Fast Sync Read"] = times_ms(sdk_step(bus, rig, fast=True))
        cycle = Cycle(bus, rig)
        address, mapping = cycle.mapping
        for identity in rig.ids:
            bus.write_bytes(identity, address, mapping)
        goals = np.full(len(rig.ids), rig.table.zero_position)
        for cycle.method in METHODS[:2]:
            found[f"driver {cycle.method}"] = times_ms(lambda: cycle.exchange(goals))
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
    print(f"{'cycle of 20 servos':24s} {'median ms':>10s} {'p99 ms':>8s} {'against the driver':>20s}")
    for name, values in found.items():
        ratio = median(values) / reference
        print(f"{name:24s} {median(values):10.2f} {np.percentile(values, 99):8.2f} {ratio:19.2f}x")


if __name__ == "__main__":
    main()
