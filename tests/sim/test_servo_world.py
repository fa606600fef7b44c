"""The robot in MuJoCo, moved by the torques of emulated servos."""

import pytest

from hw.virtual.bus import VirtualBus
from ros_free_stack.errors import InvalidOption
from ros_free_stack.robots import load_robot
from sim.playback.servo_world import ServoWorld

OP3 = load_robot("op3")


def switch(bus: VirtualBus, on: bool) -> None:
    for servo in bus.network.servos.values():
        servo.write(servo.table["Torque Enable"].address, bytes((on,)))


def run(bus: VirtualBus, seconds: float) -> None:
    for _ in range(round(seconds / 0.008)):
        bus.network.advance(0.008)


def test_servos_hold_the_robot_up_until_they_let_go() -> None:
    world = ServoWorld(OP3)
    bus = VirtualBus.of_robot(OP3, world=world)
    standing = world.data.qpos[2]
    run(bus, 0.5)
    assert world.data.qpos[2] == standing
    switch(bus, True)
    run(bus, 1.0)
    assert world.data.qpos[2] == pytest.approx(standing, abs=0.02)
    assert max(abs(servo.motor.current) for servo in bus.network.servos.values()) > 0.05
    switch(bus, False)
    run(bus, 1.0)
    assert world.data.qpos[2] < standing - 0.05


def test_a_goal_moves_the_robots_joint() -> None:
    world = ServoWorld(OP3, mount="fixed")
    bus = VirtualBus.of_robot(OP3, world=world)
    elbow = bus.servo(5)
    switch(bus, True)
    elbow.write(elbow.table["Goal Position"].address, (1600).to_bytes(4, "little"))
    run(bus, 1.0)
    assert abs(elbow.get("Present Position") - 1600) < 20
    assert world.data.joint("r_el").qpos[0] == elbow.motor.position
    done = world.trajectory()
    assert done.duration_s == pytest.approx(1.0, abs=0.05)
    column = done.joint_names.index("r_el")
    assert done.joint_pos[-1, column] == pytest.approx(elbow.motor.position, abs=0.02)


def test_a_robot_without_servos() -> None:
    with pytest.raises(InvalidOption, match="g1 has no Dynamixel servo"):
        ServoWorld(load_robot("g1"))
