"""Cycle times of LeRobot's Dynamixel bus, as JSON; run by bus_peers.py with a Python that has LeRobot.

python lerobot_bus.py PORT BAUD ID,ID,... CYCLES
"""

import json
import sys
import time
from typing import Any

from lerobot.motors import Motor, MotorNormMode  # pyright: ignore[reportMissingImports]
from lerobot.motors.dynamixel import DynamixelMotorsBus  # pyright: ignore[reportMissingImports]

REGISTERS = ("Torque_Enable", "Hardware_Error_Status", "Bus_Watchdog", "Present_Current", "Present_Velocity",
             "Present_Position", "Present_Input_Voltage", "Present_Temperature")  # fmt: skip


def times_ms(bus: Any, goals: dict[str, int], registers: tuple[str, ...], count: int) -> list[float]:
    """Duration of each of `count` cycles that brought all answers, ms."""
    durations: list[float] = []
    for _ in range(count):
        start = time.perf_counter()
        try:
            bus.sync_write("Goal_Position", goals, normalize=False)
            for register in registers:
                bus.sync_read(register, normalize=False)
        except (ConnectionError, IndexError):  # the SDK trips over an answer that is not the one it waits for
            continue
        durations.append(1e3 * (time.perf_counter() - start))
    return durations


def main(port: str, baud: str, ids: str, cycles: str) -> None:
    """Measure both and print them."""
    motors = {f"m{i}": Motor(int(i), "xm430-w350", MotorNormMode.DEGREES) for i in ids.split(",")}
    bus = DynamixelMotorsBus(port, motors)
    bus.connect(handshake=False)
    bus.set_baudrate(int(baud))
    time.sleep(0.2)  # let late answers to whoever had the port before pass
    bus.port_handler.ser.reset_input_buffer()
    models = {motor.id: bus.ping(name, num_retry=20) for name, motor in motors.items()}
    assert set(models.values()) == {1020}, models
    goals = dict.fromkeys(motors, 2048)
    found = {
        "LeRobot, position": times_ms(bus, goals, ("Present_Position",), int(cycles)),
        "LeRobot, the same registers": times_ms(bus, goals, REGISTERS, int(cycles)),
    }
    bus.disconnect(disable_torque=False)
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
