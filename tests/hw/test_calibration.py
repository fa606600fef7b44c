"""Calibration: guided by hand, kept as YAML, checked against the robot when it is read."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml

from hw.calibration import Calibration, JointCalibration, load_calibration
from hw.guide import calibrate
from hw.rig import Rig
from hw.servos import Servos, open_ports
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import Servo
from ros_free_stack.errors import InvalidFile, InvalidOption, LostServo, ModelMismatch, UnsafeCommand
from ros_free_stack.robots import load_robot

JOINTS = ("head_pan", "r_el")
OP3 = load_robot("op3")
RIG = Rig.of_robot(OP3, only=JOINTS)


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with VirtualBus([Servo.make(identity, baud=RIG.baud) for identity in RIG.ids]) as bus:
        yield bus


ZERO = {19: 0.2, 5: -0.1}
SENSE = {19: 1, 5: -1}
ENDS: dict[str, tuple[float, float]] = {"head_pan": (1.2, -1.3), "r_el": (2.0, -1.9)}


class Person:
    """Moves the joints as told: `head_pan` is mounted askew by 0.2 rad, `r_el` turns backwards.

    Attributes:
        asked: the instructions so far.
    """

    def __init__(self, bus: VirtualBus, before: Callable[[int], None] = lambda count: None) -> None:
        self._bus, self._before = bus, before
        self.asked: list[str] = []

    def __call__(self, text: str) -> None:
        self._before(len(self.asked))
        self.asked.append(text)
        joints: dict[str, int] = dict(zip(JOINTS, RIG.ids, strict=True))
        with self._bus.locked:
            if "zero pose" in text:
                for identity, angle in ZERO.items():
                    self._turn(identity, angle)
                return
            joint = text.split()[1]
            angle = ENDS[joint]["negative" in text]
            identity = joints[joint]
            self._turn(identity, ZERO[identity] + SENSE[identity] * angle)

    def _turn(self, identity: int, angle: float) -> None:
        servo = self._bus.servo(identity)
        servo.motor.position, servo.motor.velocity = angle, 0.0
        servo.advance(0.0)


def measured(bus: VirtualBus, person: Callable[[str], None]) -> Calibration:
    with open_ports(bus.port, RIG.baud) as buses:
        return calibrate(Servos.find(RIG, buses), person)


def test_direction_zero_and_range_are_measured(bus: VirtualBus, tmp_path: Path) -> None:
    person = Person(bus)
    calibration = measured(bus, person)
    pan, elbow = calibration.joints["head_pan"], calibration.joints["r_el"]
    assert (pan.direction, elbow.direction) == (1, -1)
    assert [pan.offset, pan.lower, pan.upper] == pytest.approx([0.2, -1.3, 1.2], abs=0.002)
    assert [elbow.offset, elbow.lower, elbow.upper] == pytest.approx([-0.1, -1.9, 2.0], abs=0.002)
    assert len(person.asked) == 5
    calibration.save(tmp_path / "c.yaml")
    assert load_calibration(tmp_path / "c.yaml", OP3) == calibration
    rig = Rig.of_robot(OP3, only=JOINTS, calibration=calibration)
    # The zero pose is where it was shown, and the range is the smaller of the measured and the robot's own.
    assert rig.to_angles(RIG.to_raw(np.array([0.2, -0.1]))) == pytest.approx([0, 0], abs=0.002)
    assert rig.lower == pytest.approx([-1.3, -1.9], abs=0.002)
    with pytest.raises(ModelMismatch, match="the calibration of op3 lacks l_el"):
        Rig.of_robot(OP3, only=("r_el", "l_el"), calibration=calibration)


def test_torque_and_still_joints_are_refused(bus: VirtualBus) -> None:
    bus.servo(5).set("Torque Enable", 1)
    with pytest.raises(UnsafeCommand, match=r"r_el .* holds torque"):
        measured(bus, Person(bus))
    bus.servo(5).set("Torque Enable", 0)
    with pytest.raises(InvalidOption, match=r"head_pan: its ends are 0.00 rad apart"):
        measured(bus, lambda text: None)


def test_a_wrong_model_and_a_missing_servo_are_refused(bus: VirtualBus) -> None:
    bus.servo(5).set("Model Number", 1060)
    with pytest.raises(ModelMismatch, match=r"r_el .* is an XL430-W250"):
        measured(bus, Person(bus))
    bus.servo(5).dead = True
    with pytest.raises(LostServo, match="r_el"):
        measured(bus, Person(bus))


def test_a_servo_lost_in_the_middle_is_named(bus: VirtualBus) -> None:
    def fail(count: int) -> None:
        bus.servo(5).dead = count == 3

    with pytest.raises(LostServo, match="servo 5"):
        measured(bus, Person(bus, fail))


GOOD = Calibration("op3", {joint: JointCalibration(RIG.ids[i], 1, 0.1, -1.0, 1.0) for i, joint in enumerate(JOINTS)})


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (lambda data: data.update(robot="g1"), ModelMismatch, "calibration of g1 does not fit op3"),
        (lambda data: data["joints"]["r_el"].update(id=6), ModelMismatch, "joints that differ in id or range: r_el"),
        (lambda data: data["joints"].update(tail=dict(data["joints"]["r_el"])), ModelMismatch, "tail"),
        (lambda data: data["joints"]["r_el"].update(lower=2.5, upper=2.9), ModelMismatch, "id or range: r_el"),
        (lambda data: data["joints"]["r_el"].update(direction=2), InvalidFile, "expected direction 1 or -1"),
        (lambda data: data["joints"]["r_el"].update(lower=1.5), InvalidFile, "lower < upper"),
        (lambda data: data["joints"]["r_el"].update(offset=float("nan")), InvalidFile, "finite offset"),
        (lambda data: data["joints"]["r_el"].update(id=5.7), InvalidFile, "r_el: expected id 0 to 252, found 5.7"),
        (lambda data: data["joints"]["r_el"].update(id=True), InvalidFile, "expected id 0 to 252, found True"),
        (lambda data: data["joints"]["r_el"].update(id="5"), InvalidFile, "expected id 0 to 252, found '5'"),
        (lambda data: data["joints"]["r_el"].update(direction=1.9), InvalidFile, "direction 1 or -1, found 1.9"),
        (lambda data: data["joints"]["r_el"].update(upper=float("inf")), InvalidFile, "finite upper"),
        (lambda data: data["joints"]["r_el"].update(lower="0"), InvalidFile, "finite lower in rad, found '0'"),
        (lambda data: data["joints"]["r_el"].pop("offset"), InvalidFile, "not a servo calibration .KeyError"),
        (lambda data: data.update(joints=[1]), InvalidFile, "not a servo calibration"),
    ],
)
def test_a_calibration_is_checked_when_it_is_read(
    tmp_path: Path, change: Callable[[dict], object], error: type[Exception], words: str
) -> None:
    path = tmp_path / "c.yaml"
    GOOD.save(path)
    assert load_calibration(path, OP3) == GOOD
    data = yaml.safe_load(path.read_text())
    change(data)
    path.write_text(yaml.safe_dump(data))
    with pytest.raises(error, match=words):
        load_calibration(path, OP3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("robot: op3\njoints:\n  r_el: {id: 5}\n  l_el: {id: 6}\n  r_el: {id: 5}\n", "'r_el' stands there twice"),
        ("robot: op3\nrobot: op3\njoints: {}\n", "'robot' stands there twice"),
        ("robot: op3\njoints: {r_el: {id: 5, id: 6}}\n", "'id' stands there twice"),
        ("a: &a [x]\nrobot: *a\njoints: {}\n", "references"),
        ("[" * 20_000, "RecursionError"),
        ("#" * 1_000_001, "longer than 1000000 bytes"),
    ],
)
def test_what_is_no_calibration_is_refused_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "c.yaml"
    path.write_text(text)
    with pytest.raises(InvalidFile, match=words) as caught:
        load_calibration(path, OP3)
    assert "\n" not in str(caught.value)


def test_a_device_or_a_folder_is_no_calibration(tmp_path: Path) -> None:
    for path in (Path("/dev/zero"), tmp_path):
        with pytest.raises(InvalidFile, match="it is no file"):
            load_calibration(path, OP3)
    with pytest.raises(InvalidFile, match="No such file"):
        load_calibration(tmp_path / "missing.yaml", OP3)
