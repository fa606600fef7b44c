"""The share of one port in a control cycle, byte by byte: answers that are damaged, late or someone else's."""

import os
import tty
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from hw.bus import Bus
from hw.line import BLOCK, SINGLES_PER_CYCLE, Line, Method
from hw.protocol import BROADCAST, HEADER, Instruction, Packet, PacketReader, crc16, encode
from hw.rig import Rig
from ros_free_stack.errors import UnsafeCommand
from ros_free_stack.robots import load_robot

RIG = Rig.of_robot(load_robot("op3"), only=("head_pan", "head_tilt", "r_el"))
ALERT = 0x80
REFUSED = 0x07


@dataclass
class Wire:
    """Both ends of a pseudo serial port: the line on one, bytes that a test chooses on the other."""

    line: Line
    far_end: int

    def exchange(self, method: Method, answer: bytes) -> list[bool]:
        """Ask, let the answer lie there, and take it: who counts as fresh."""
        self.line.send(method, None)
        os.read(self.far_end, 4096)
        os.write(self.far_end, answer)
        return self.line.receive(method, None).tolist()


@pytest.fixture
def wire() -> Iterator[Wire]:
    far_end, near_end = os.openpty()
    tty.setraw(near_end)
    bus = Bus(os.ttyname(near_end), 1_000_000)
    try:
        yield Wire(Line(bus, RIG.ids, RIG.tables), far_end)
    finally:
        bus.serial.close()
        os.close(far_end)
        os.close(near_end)


def block(position: int) -> bytes:
    data = np.zeros(1, dtype=BLOCK)
    data["torque"], data["position"] = 1, position
    return data.tobytes()


def fast(ids: tuple[int, ...], *, status: tuple[int, ...] = (0, 0, 0)) -> bytes:
    """The one packet in which all servos answer a Fast Sync Read."""
    size = len(ids) * (2 + BLOCK.itemsize + 2)
    packet = HEADER + bytes((BROADCAST,)) + (size + 1).to_bytes(2, "little") + b"\x55"
    for i, (identity, error) in enumerate(zip(ids, status, strict=True)):
        packet += bytes((error, identity)) + block(1000 + i)
        packet += crc16(packet).to_bytes(2, "little")
    return packet


def answers(ids: tuple[int, ...], *, status: tuple[int, ...] = (0, 0, 0)) -> bytes:
    """A status packet from each servo."""
    return b"".join(
        encode(Packet(identity, Instruction.STATUS, bytes((error,)) + block(1000 + i)))
        for i, (identity, error) in enumerate(zip(ids, status, strict=True))
    )


def test_fast_read_of_all_servos(wire: Wire) -> None:
    assert wire.exchange("fast sync read", fast(RIG.ids)) == [True] * 3
    assert wire.line.data["position"].tolist() == [1000, 1001, 1002]


@pytest.mark.parametrize("order", [(1, 0, 2), (0, 2, 1), (2, 1, 0), (0, 0, 2)])
def test_fast_read_of_servos_in_another_order_is_taken_from_none(wire: Wire, order: tuple[int, ...]) -> None:
    """Positions that lie under another servo's name would be judged and followed as its own."""
    assert wire.exchange("fast sync read", fast(tuple(RIG.ids[i] for i in order))) == [False] * 3
    assert not wire.line.data["position"].any()


def test_fast_read_that_breaks_off_counts_up_to_the_break(wire: Wire) -> None:
    whole = fast(RIG.ids)
    assert wire.exchange("fast sync read", whole[:-1]) == [True, True, False]
    damaged = bytearray(whole)
    damaged[40] ^= 1
    assert wire.exchange("fast sync read", bytes(damaged)) == [True, False, False]


def test_fast_read_after_noise(wire: Wire) -> None:
    assert wire.exchange("fast sync read", b"\x00\xff\x12" + fast(RIG.ids)) == [True] * 3


@pytest.mark.parametrize(("method", "make"), [("fast sync read", fast), ("sync read", answers)])
def test_a_servo_that_refuses_is_not_fresh_and_one_with_an_alert_is(wire: Wire, method: Method, make) -> None:
    assert wire.exchange(method, make(RIG.ids, status=(ALERT, REFUSED, 0))) == [True, False, True]
    assert wire.line.status.tolist() == [ALERT, REFUSED, 0]
    assert wire.line.data["position"].tolist() == [1000, 0, 1002]


def test_sync_read_takes_answers_by_their_ids(wire: Wire) -> None:
    turned = RIG.ids[::-1]
    assert wire.exchange("sync read", answers(turned)) == [True] * 3
    assert wire.line.data["position"].tolist() == [1002, 1001, 1000]
    strange = answers((99, *RIG.ids[1:]))
    assert wire.exchange("sync read", strange) == [False, True, True]


def test_single_reads_go_round(wire: Wire) -> None:
    asked = [wire.line.send("single reads", None).tolist() for _ in range(4)]
    assert [row.index(True) for row in asked] == [0, 1, 2, 0] and all(sum(row) == 1 for row in asked)
    assert SINGLES_PER_CYCLE >= 1


@pytest.mark.parametrize("goal", [2**31, -(2**31) - 1, 2**40])
def test_a_goal_that_does_not_fit_its_register_is_refused_before_a_byte_is_sent(wire: Wire, goal: int) -> None:
    with pytest.raises(UnsafeCommand, match="does not fit"):
        wire.line.send("sync read", np.array([0, goal, 0]))
    os.set_blocking(wire.far_end, False)
    with pytest.raises(BlockingIOError):
        os.read(wire.far_end, 1)


def test_goals_reach_the_wire_by_id(wire: Wire) -> None:
    wire.line.send("sync read", np.array([100, -200, 300]))
    sent, _ = PacketReader().feed(os.read(wire.far_end, 4096))
    table = RIG.tables[0]["Goal Position"]
    assert (sent.id, sent.instruction) == (BROADCAST, Instruction.SYNC_WRITE)
    head, rows = sent.parameters[:4], sent.parameters[4:]
    assert head == table.address.to_bytes(2, "little") + (4).to_bytes(2, "little")
    goals = {rows[k]: int.from_bytes(rows[k + 1 : k + 5], "little", signed=True) for k in range(0, len(rows), 5)}
    assert goals == dict(zip(RIG.ids, (100, -200, 300), strict=True))
