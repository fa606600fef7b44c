"""Servos of several models, on one port and on two."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from hw.cycle import Cycle, Reading
from hw.driver import Driver
from hw.protocol import Instruction
from hw.registers import all_model_names, control_table, is_driven
from hw.rig import Rig
from hw.servos import Servos, open_ports, split_ports
from hw.units import amperes_per_unit
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import Servo
from ros_free_stack.errors import InvalidOption, LostServo, ModelMismatch, PortError, ServoFault, StackError
from ros_free_stack.robots import RobotDescription, ServoSafety, load_robot

JOINTS = ("head_pan", "r_el", "l_knee", "l_el")
SAFETY = ServoSafety(stall_s=60, late_after=10**6, watchdog_s=2.5, hold_s=0.03, lost_after=25)
OP3 = load_robot("op3")
STAND = np.array([OP3.standing.get(joint, 0.0) for joint in JOINTS])
WAVE = STAND + np.outer(0.15 * (1 - np.cos(np.linspace(0, 2 * np.pi, 100))), [1.0, -1.0, 1.0, -1.0])


def mixed(**models: str) -> RobotDescription:
    """OP3 with other servos in some joints, and the patience that a busy test computer needs."""
    assert OP3.servos is not None
    return replace(OP3, servos=replace(OP3.servos, models=models, safety=SAFETY))


def make_bus(rig: Rig, joints: tuple[str, ...], **options: object) -> VirtualBus:
    servos = [
        Servo.make(rig.ids[i], model=rig.tables[i].model, baud=rig.baud, position=STAND[i])
        for i in map(JOINTS.index, joints)
    ]
    return VirtualBus(servos, **options)  # type: ignore[arg-type]


def play(rig: Rig, port: str) -> list[Reading]:
    seen: list[Reading] = []
    with Driver(rig, port) as driver:
        driver.check_goals(WAVE)
        driver.enable()
        driver.move_to(WAVE[0])
        driver.follow(WAVE, lambda time_s, late_s, goal, reading: seen.append(reading))
    return seen


def swing(bus: VirtualBus, identity: int) -> float:
    servo = bus.servo(identity)
    low, high = servo.goal_extremes or (0, 0)
    return (high - low) * servo.table.rad_per_tick


def test_models_with_and_without_current_on_one_bus() -> None:
    rig = Rig.of_robot(mixed(r_el="XL430-W250", l_el="XH430-V350"), only=JOINTS)
    assert [table.model for table in rig.tables] == ["XM430-W350", "XL430-W250", "XM430-W350", "XH430-V350"]
    assert rig.measures_current.tolist() == [True, False, True, True]
    with make_bus(rig, JOINTS) as bus:
        seen = play(rig, bus.port)
        for identity in rig.ids:
            assert swing(bus, identity) == pytest.approx(0.3, abs=0.02)
            assert not bus.servo(identity).torque_on
            assert not bus.servo(identity).refusals
    positions = np.array([reading.position for reading in seen])
    assert np.ptp(positions, axis=0) == pytest.approx([0.3] * 4, abs=0.06)


@pytest.mark.parametrize("model", [name for name in all_model_names() if is_driven(name)])
def test_every_x_model_can_be_driven(model: str) -> None:
    rig = Rig.of_robot(mixed(r_el=model), only=("head_pan", "r_el"))
    with make_bus(rig, ("head_pan", "r_el")) as bus, Driver(rig, bus.port) as driver:
        reading = driver.enable()
        assert driver.cycle.method == "fast sync read"
        assert reading.position == pytest.approx(STAND[:2], abs=0.01)
        assert reading.voltage == pytest.approx([bus.servo(i).supply_voltage for i in rig.ids], abs=0.1)


def test_current_units_of_the_manual() -> None:
    units = {name: amperes_per_unit(name) for name in ("XM430-W350", "XH430-V350", "XL330-M288", "XH540-V270")}
    assert units == {"XM430-W350": 2.69e-3, "XH430-V350": 1.34e-3, "XL330-M288": 1e-3, "XH540-V270": 2.69e-3}


@pytest.mark.parametrize("model", ["XL320", "PH42-020-S300", "YM070-210-M001-RA", "H54-200-S500-RA", "RH-P12-RN"])
def test_families_with_other_registers_are_refused_by_name(model: str) -> None:
    model = next(name for name in all_model_names() if name.startswith(model[:8]))
    with pytest.raises(ModelMismatch, match=f"r_el has a servo {model}, .* X series .*MX with Protocol 2.0"):
        Rig.of_robot(mixed(r_el=model), only=JOINTS)


def test_firmware_that_cannot_share_a_cycle_is_refused() -> None:
    """Older firmware of the 330 sizes has its indirect data elsewhere."""
    rig = Rig.of_robot(mixed(r_el="XL330-M288", l_el="XL330-M288"), only=JOINTS)
    tables = (rig.tables[0], control_table("XL330-M288", 52), *rig.tables[2:])
    with (
        VirtualBus([]) as bus,
        open_ports(bus.port, rig.baud) as buses,
        pytest.raises(ModelMismatch, match=r"different layouts: give each a port of its own"),
    ):
        Cycle(Servos(rig, buses, (0,) * len(rig.ids), tables=tables))


@pytest.mark.parametrize("firmware", [40, 52, 53])
def test_the_330_series_is_driven_by_the_table_of_its_firmware(firmware: int) -> None:
    rig = Rig.of_robot(mixed(r_el="XL330-M288"), only=("r_el",))
    with VirtualBus([Servo.make(5, model="XL330-M288", baud=rig.baud, position=STAND[1], firmware=firmware)]) as bus:
        bus.servo(5).set("Firmware Version", firmware)
        with Driver(rig, bus.port) as driver:
            reading = driver.enable()
            assert driver.servos.table(0).indirect_blocks[0].data == (208 if firmware <= 52 else 224)
            assert reading.position == pytest.approx(STAND[1:2], abs=0.01)
            assert reading.voltage == pytest.approx([bus.servo(5).supply_voltage], abs=0.1)


RIG = Rig.of_robot(mixed(l_el="XL430-W250"), only=JOINTS)
ARMS, LEGS = ("l_el", "r_el"), ("head_pan", "l_knee")


@pytest.fixture
def ports() -> Iterator[tuple[VirtualBus, VirtualBus]]:
    with make_bus(RIG, ARMS) as arms, make_bus(RIG, LEGS) as legs:
        yield arms, legs


def torques(*buses: VirtualBus) -> list[bool]:
    return [servo.torque_on for bus in buses for servo in bus.network.servos.values()]


def test_two_ports_move_in_one_cycle(ports: tuple[VirtualBus, VirtualBus]) -> None:
    arms, legs = ports
    seen = play(RIG, f"{arms.port},{legs.port}")
    assert torques(arms, legs) == [False] * 4
    for joint, identity in zip(JOINTS, RIG.ids, strict=True):
        assert swing(arms if joint in ARMS else legs, identity) == pytest.approx(0.3, abs=0.02)
    # Each reading holds the servos of both ports.
    assert np.mean([reading.fresh.all() for reading in seen]) > 0.5
    assert all(reading.asked.all() for reading in seen)


@pytest.mark.parametrize(
    ("unsupported", "method"),
    [
        ({Instruction.FAST_SYNC_READ}, "sync read"),
        ({Instruction.FAST_SYNC_READ, Instruction.SYNC_READ}, "single reads"),
    ],
)
def test_the_slower_firmware_decides_for_both_ports(unsupported: set[Instruction], method: str) -> None:
    with make_bus(RIG, ARMS, unsupported=unsupported) as arms, make_bus(RIG, LEGS) as legs:
        with Driver(RIG, f"{arms.port},{legs.port}") as driver:
            driver.enable()
            assert driver.cycle.method == method
            driver.move_to(WAVE[30])
        assert swing(legs, 19) > 0.1 and swing(arms, 5) > 0.1
        assert torques(arms, legs) == [False] * 4


def test_a_fault_on_one_port_stops_both(ports: tuple[VirtualBus, VirtualBus]) -> None:
    arms, legs = ports

    def heat(time_s: float, late_s: float, goal: np.ndarray, reading: Reading) -> None:
        with legs.locked:
            legs.servo(14).motor.temperature = 79.0

    with (
        pytest.raises(ServoFault, match=r"l_knee .servo 14.: 79 deg C"),
        Driver(RIG, f"{arms.port},{legs.port}") as driver,
    ):
        driver.enable()
        driver.follow(np.tile(STAND, (50, 1)), heat)
    assert torques(arms, legs) == [False] * 4


def test_a_port_that_goes_away_does_not_keep_the_other_from_stopping() -> None:
    with make_bus(RIG, ARMS) as arms:
        legs = make_bus(RIG, LEGS)
        legs.start()
        try:
            with (
                pytest.raises(StackError, match=r"NOT confirmed for head_pan .servo 19., l_knee") as caught,
                Driver(RIG, f"{legs.port},{arms.port}") as driver,
            ):
                driver.enable()
                driver.follow(np.tile(STAND, (5, 1)))
                legs.stop()
                driver.follow(np.tile(STAND, (50, 1)))
            assert isinstance(caught.value, PortError | LostServo)
            assert torques(arms) == [False] * 2
        finally:
            legs.stop()


def test_a_servo_on_two_ports_and_a_servo_on_none(ports: tuple[VirtualBus, VirtualBus]) -> None:
    arms, legs = ports
    both = f"{arms.port},{legs.port}"
    with (
        pytest.raises(LostServo, match=r"no answer from head_pan .*, l_knee .* on " + arms.port),
        Driver(RIG, arms.port),
    ):
        pass
    with arms.locked:
        arms.network.add(Servo.make(14, baud=RIG.baud))
    with (
        pytest.raises(ModelMismatch, match=r"l_knee .servo 14. answers on .* and .*: ids must be distinct"),
        Driver(RIG, both),
    ):
        pass
    with pytest.raises(PortError, match="/dev/nothing"), Driver(RIG, f"{arms.port},/dev/nothing"):
        pass


@pytest.mark.parametrize("ports", ["", "a,", "a,a"])
def test_odd_lists_of_ports_are_refused(ports: str) -> None:
    with pytest.raises(InvalidOption, match="distinct ports"):
        split_ports(ports)
