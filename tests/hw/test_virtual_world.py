"""Servos that move a mechanism which is simulated elsewhere."""

from collections.abc import Mapping

import pytest

from hw.virtual.network import Network
from hw.virtual.servo import STEP_S, Servo


class Beam:
    """Two servos on one shaft: the second is the first's mirror image, with an inertia of their own."""

    def __init__(self) -> None:
        self.position = self.velocity = 0.0
        self.steps: list[float] = []

    def __call__(self, dt: float, torques: Mapping[int, float]) -> Mapping[int, tuple[float, float]]:
        self.velocity += dt * (torques[1] - torques[2]) / 0.05
        self.position += dt * self.velocity
        self.steps.append(dt)
        return {1: (self.position, self.velocity), 2: (-self.position, -self.velocity)}


def test_servos_move_the_world_and_feel_it() -> None:
    beam, servos = Beam(), [Servo.make(1), Servo.make(2)]
    network = Network(servos, world=beam)
    leader, follower = servos
    leader.write(leader.table["Torque Enable"].address, b"\1")
    leader.write(leader.table["Goal Position"].address, (2500).to_bytes(4, "little"))
    currents = []
    for _ in range(150):
        network.advance(0.008)
        currents.append(leader.motor.current)
    assert beam.position == leader.motor.position == pytest.approx((2500 - 2048) * leader.table.rad_per_tick, abs=0.01)
    assert follower.get("Present Position") == pytest.approx(4096 - leader.get("Present Position"), abs=1)
    assert max(beam.steps) <= STEP_S
    assert max(currents) > 0.3 and abs(currents[-1]) < 0.05
    assert follower.motor.current == 0.0


def test_a_released_servo_gives_way() -> None:
    beam, servos = Beam(), [Servo.make(1), Servo.make(2)]
    network = Network(servos, world=beam)
    beam.velocity = 1.0
    network.advance(0.4)
    assert beam.position > 0.1
