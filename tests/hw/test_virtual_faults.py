"""Faults on demand."""

import random

import pytest

from hw.virtual.faults import KINDS, Fault, Faults
from hw.virtual.servo import INPUT_VOLTAGE, OVERHEATING, OVERLOAD, Servo
from ros_free_stack.errors import InvalidOption


def test_the_same_seed_gives_the_same_faults() -> None:
    def bytes_of(seed: int) -> list[bytes]:
        faults = Faults(drop=0.2, corrupt=0.3, noise=0.3, corrupt_instruction=0.3, drop_instruction=0.1, seed=seed)
        source = random.Random(0)
        return [step(source.randbytes(12)) for _ in range(50) for step in (faults.distort, faults.heard)]

    assert bytes_of(1) == bytes_of(1) != bytes_of(2)


def test_shares_are_met() -> None:
    faults = Faults(drop=0.01, corrupt=0.01)
    answers = [faults.distort(b"\0" * 12) for _ in range(20_000)]
    assert 130 < sum(answer == b"" for answer in answers) < 270
    assert 130 < sum(answer not in (b"", b"\0" * 12) for answer in answers) < 270


def test_faults_that_befall_one_answer() -> None:
    faults = Faults(once=["lost", "corrupt", "noise", "latency"], spike_s=0.3)
    data = b"0123456789"
    assert faults.distort(data) == b""
    changed = faults.distort(data)
    assert len(changed) == len(data) and sum(a != b for a, b in zip(changed, data, strict=True)) == 1
    noisy = faults.distort(data)
    assert noisy.endswith(data) and len(noisy) > len(data)
    assert faults.wait_s() == 0.3
    assert faults.wait_s() == 0.0
    assert faults.distort(data) == data


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("corrupt:1%", Fault("corrupt", 0.01, "share")),
        ("dead:2.5s:7", Fault("dead", 2.5, "s", 7)),
        ("brown-out:120", Fault("brown-out", 120, "goals")),
    ],
)
def test_parse(text: str, fault: Fault) -> None:
    assert Fault.parse(text) == fault


@pytest.mark.parametrize("text", ["", "dead", "fire:1s", "dead:1%", "lost:1%:3", "lost:101%", "dead:.s", "dead:1.2.3s"])
def test_parse_says_what_is_valid(text: str) -> None:
    with pytest.raises(InvalidOption, match=r"--fault.*(kinds: corrupt|a share)"):
        Fault.parse(text)


def test_a_fault_waits_for_its_time() -> None:
    servos = {1: Servo.make(1), 2: Servo.make(2)}
    early, late = Fault.parse("dead:2:1"), Fault.parse("dead:1.5s")
    assert not early.due(servos, 9.0)
    for value in (2000, 2001):
        servos[1].write(servos[1].table["Goal Position"].address, value.to_bytes(4, "little"))
    assert early.due(servos, 0.0)
    assert not late.due(servos, 1.4) and late.due(servos, 1.6)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("corrupt", "lost", "noise", "latency")])
def test_what_befalls_a_servo(kind: str) -> None:
    servos = {1: Servo.make(1), 2: Servo.make(2)}
    for servo in servos.values():
        servo.write(servo.table["Torque Enable"].address, b"\1")
    Fault(kind, 0, "s", 1).happen(servos, Faults())
    hit, other = servos[1], servos[2]
    for servo in servos.values():
        servo.advance(0.02)
    error = hit.get("Hardware Error Status")
    assert hit.dead == (kind == "dead")
    assert error == {"overload": OVERLOAD, "overheating": OVERHEATING, "brown-out": INPUT_VOLTAGE}.get(kind, 0)
    assert hit.torque_on == (kind not in ("overload", "overheating", "reboot"))
    assert hit.answering == (kind not in ("dead", "reboot"))
    assert hit.motor.jammed == (kind == "jam")
    assert other.torque_on and not other.alert and other.answering
