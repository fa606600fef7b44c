"""Three joints of OP3 on an emulated bus, a wave for them, and its stream with a fault on the way."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hw.cycle import Reading
from hw.driver import Driver
from hw.rig import Rig
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import Servo
from ros_free_stack.robots import ServoSafety, load_robot

JOINTS = ("head_pan", "r_el", "l_knee")
OP3 = load_robot("op3")
# A busy test computer may stall for longer than a robot could bear.
SAFETY = ServoSafety(stall_s=60, late_after=10**6, watchdog_s=2.5, hold_s=0.03, lost_after=25)
RIG = replace(Rig.of_robot(OP3, only=JOINTS), safety=SAFETY)
STAND = np.array([OP3.standing.get(joint, 0.0) for joint in JOINTS])
WAVE = STAND + np.outer(0.15 * (1 - np.cos(np.linspace(0, 2 * np.pi, 125))), [1.0, -1.0, 1.0])


def with_safety(**changes: object) -> Rig:
    return replace(RIG, safety=replace(SAFETY, **changes))  # type: ignore[arg-type]


def make_bus(**options: object) -> VirtualBus:
    servos = [
        Servo.make(identity, baud=2_000_000, position=angle) for identity, angle in zip(RIG.ids, STAND, strict=True)
    ]
    return VirtualBus(servos, **options)  # type: ignore[arg-type]


def play(bus: VirtualBus, *, at: int = -1, fault: Callable[[], None] | None = None, rig: Rig = RIG) -> Driver:
    """Stream the wave; let `fault` happen in cycle `at`."""
    count = 0

    def record(time_s: float, late_s: float, goal: np.ndarray, reading: Reading) -> None:
        nonlocal count
        if count == at and fault is not None:
            with bus.locked:
                fault()
        count += 1

    with Driver(rig, bus.port) as driver:
        driver.check_goals(WAVE)
        driver.enable()
        driver.move_to(WAVE[0])
        driver.follow(WAVE, record)
    return driver


def torques(bus: VirtualBus) -> list[bool]:
    return [bus.servo(identity).torque_on for identity in RIG.ids]


def assert_no_goal_outside_limits(bus: VirtualBus) -> None:
    for i, identity in enumerate(RIG.ids):
        servo = bus.servo(identity)
        low, high = RIG.to_raw(np.stack([RIG.lower, RIG.upper]))[:, i]
        assert not servo.refusals
        if servo.goal_extremes is not None:
            assert min(low, high) - 1 <= servo.goal_extremes[0] <= servo.goal_extremes[1] <= max(low, high) + 1
