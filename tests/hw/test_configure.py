"""Set-up of servos: shown first, written on request, only where it differs, and never half in silence."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest

from hw.calibration import Calibration, JointCalibration
from hw.configure import apply_changes, planned_changes
from hw.protocol import StatusError
from hw.rig import Rig
from hw.servos import Servos, open_ports
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import Refused, Servo
from ros_free_stack.errors import BusFault, LostServo, ModelMismatch, UnsafeCommand
from ros_free_stack.robots import ServoSettings, load_robot

JOINTS = ("head_pan", "r_el")
RIG = Rig.of_robot(load_robot("op3"), only=JOINTS)


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with VirtualBus([Servo.make(identity, baud=RIG.baud) for identity in RIG.ids]) as bus:
        yield bus


@contextmanager
def servos_on(bus: VirtualBus, rig: Rig = RIG) -> Iterator[Servos]:
    with open_ports(bus.port, rig.baud) as buses:
        yield Servos.find(rig, buses)


def eeprom(bus: VirtualBus) -> list[bytes]:
    """What the servos keep without power."""
    servos = [bus.servo(identity) for identity in RIG.ids]
    with bus.locked:
        return [b"".join(s.table[n].pack(s.get(n)) for n, r in s.table.registers.items() if r.eeprom) for s in servos]


def test_changes_are_shown_and_nothing_is_written(bus: VirtualBus) -> None:
    bus.servo(5).set("Return Delay Time", 250)
    before = eeprom(bus)
    with servos_on(bus) as servos:
        changes = planned_changes(servos)
        assert {(c.servo, c.register, c.now, c.wanted) for c in changes} == {
            ("head_pan (servo 19)", "Min Position Limit", 0, 1024),
            ("head_pan (servo 19)", "Max Position Limit", 4095, 3072),
            ("r_el (servo 5)", "Return Delay Time", 250, 0),
            ("r_el (servo 5)", "Min Position Limit", 0, 482),
            ("r_el (servo 5)", "Max Position Limit", 4095, 3614),
        }
        delay = next(c for c in changes if c.register == "Return Delay Time")
        assert delay.describe(servos.table(delay.index)) == ("0.0005 s", "0 s")
    assert eeprom(bus) == before


@pytest.mark.parametrize(
    ("register", "value", "wanted"),
    [("Homing Offset", 100, 0), ("Drive Mode", 1, 0), ("Operating Mode", 4, 3), ("Return Delay Time", 250, 0)],
)
def test_what_decides_where_a_goal_leads_is_set_right(bus: VirtualBus, register: str, value: int, wanted: int) -> None:
    with servos_on(bus) as servos:
        apply_changes(servos, planned_changes(servos))
        bus.servo(5).set(register, value)
        (change,) = planned_changes(servos)
        assert (change.register, change.now, change.wanted) == (register, value, wanted)
        apply_changes(servos, [change])
    assert bus.servo(5).get(register) == wanted


def test_only_what_differs_is_written_and_then_nothing_differs(bus: VirtualBus) -> None:
    with servos_on(bus) as servos:
        apply_changes(servos, planned_changes(servos))
        assert planned_changes(servos) == ()
        heard = bus.heard
        apply_changes(servos, ())
        assert bus.heard == heard
    assert bus.servo(5).get("Max Position Limit") == 3614


def test_mode_and_current_limit_come_from_the_description(bus: VirtualBus) -> None:
    rig = replace(RIG, settings=ServoSettings(mode="extended position", current_limit=1.5))
    with servos_on(bus, rig) as servos:
        apply_changes(servos, planned_changes(servos))
    assert bus.servo(5).get("Operating Mode") == 4
    assert bus.servo(5).get("Current Limit") == round(1.5 / 2.69e-3)
    assert bus.servo(5).get("Max Position Limit") == 4095, "one turn's limits mean nothing over several turns"


def test_a_reversed_servo_has_reversed_limits(bus: VirtualBus) -> None:
    calibration = Calibration(
        "op3", {"head_pan": JointCalibration(19, -1, 0.5, -1.0, 0.5), "r_el": JointCalibration(5)}
    )
    rig = Rig.of_robot(load_robot("op3"), only=JOINTS, calibration=calibration)
    with servos_on(bus, rig) as servos:
        apply_changes(servos, planned_changes(servos))
    # Joint -1.0 .. 0.5 rad is servo 1.5 .. 0.0 rad.
    assert [bus.servo(19).get(f"{end} Position Limit") for end in ("Min", "Max")] == [2047, 2048 + 978 + 1]


def test_torque_keeps_everything_as_it_is(bus: VirtualBus) -> None:
    bus.servo(19).set("Torque Enable", 1)
    before = eeprom(bus)
    with servos_on(bus) as servos, pytest.raises(UnsafeCommand, match=r"head_pan .* holds torque: .*servos release"):
        apply_changes(servos, planned_changes(servos))
    assert eeprom(bus) == before


def test_a_wrong_model_and_a_missing_servo_are_named_before_anything_is_written(bus: VirtualBus) -> None:
    bus.servo(5).set("Model Number", 1060)
    before = eeprom(bus)
    with pytest.raises(ModelMismatch, match=r"r_el .servo 5. is an XL430-W250, the servo map of op3 says XM430-W350"), \
         servos_on(bus):  # fmt: skip
        pass
    bus.servo(5).dead = True
    with pytest.raises(LostServo, match=r"no answer from r_el .servo 5."), servos_on(bus):
        pass
    assert eeprom(bus) == before


def test_a_refused_write_says_how_far_it_came(bus: VirtualBus, monkeypatch: pytest.MonkeyPatch) -> None:
    servo = bus.servo(5)
    limit = servo.table["Max Position Limit"].address
    write = servo.write

    def refuse(address: int, data: bytes) -> None:
        if address == limit:
            raise Refused(StatusError.DATA_RANGE)
        write(address, data)

    monkeypatch.setattr(servo, "write", refuse)
    with servos_on(bus) as servos:
        with pytest.raises(BusFault, match=r"servo 5 refuses .*Max Position Limit.*data range; 3 of 4 changes were"):
            apply_changes(servos, planned_changes(servos))
        monkeypatch.undo()
        assert [change.register for change in planned_changes(servos)] == ["Max Position Limit"]
        # A write that is answered but does nothing is noticed too.
        monkeypatch.setattr(servo, "write", lambda address, data: None)
        with pytest.raises(BusFault, match="Max Position Limit is 4095 after writing 3614; 0 of 1"):
            apply_changes(servos, planned_changes(servos))
