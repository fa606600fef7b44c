"""What servos answer, byte by byte, without port or clock."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw.protocol import ALERT, BROADCAST, Instruction, Packet, PacketReader, StatusError, encode
from hw.registers import control_table
from hw.virtual.factory import SHOCK
from hw.virtual.network import Network
from hw.virtual.servo import Servo

TABLE = control_table("XM430-W350")
LED, GOAL, MODE = (TABLE[name].address.to_bytes(2, "little") for name in ("LED", "Goal Position", "Operating Mode"))
IDS = (3, 7, 4)


def network(count: int = 2) -> Network:
    return Network([Servo.make(i + 1) for i in range(count)])


def answers(bus: Network, identity: int, instruction: int, parameters: bytes = b"") -> list[Packet]:
    replies = bus.handle(Packet(identity, instruction, parameters))
    return list(PacketReader().feed(b"".join(reply.data for reply in replies)))


def code(bus: Network, identity: int, instruction: int, parameters: bytes = b"") -> int:
    (answer,) = answers(bus, identity, instruction, parameters)
    return answer.parameters[0]


def test_fast_sync_read_of_the_manual() -> None:
    servos = [Servo.make(i, model="XC330-T288") for i in IDS]
    for servo, position in zip(servos, (166, 2079, 1023), strict=True):
        servo.set("Present Position", position)
    request = Packet(0xFE, Instruction.FAST_SYNC_READ, b"\x84\0\x04\0\x03\x07\x04")
    assert encode(request).hex(" ").upper() == "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"
    (reply,) = Network(servos).handle(request)
    assert reply.data.hex(" ").upper() == (
        "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E"
    )


def test_fast_bulk_read_of_the_manual() -> None:
    servos = [Servo.make(i, model="XC330-T288") for i in IDS]
    for servo, (name, value) in zip(
        servos, (("Present Position", 166), ("Present PWM", 421), ("Present Temperature", 31)), strict=True
    ):
        servo.set(name, value)
    request = Packet(0xFE, Instruction.FAST_BULK_READ, bytes.fromhex("03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00"))
    (reply,) = Network(servos).handle(request)
    assert reply.data.hex(" ").upper() == (
        "FF FF FD 00 FE 14 00 55 00 03 A6 00 00 00 67 A4 00 07 A5 01 24 74 00 04 1F D9 C1"
    )


def test_bulk_read_answers_in_the_order_asked() -> None:
    servos = [Servo.make(i) for i in IDS]
    parameters = bytes.fromhex("07 92 00 01 00 03 07 00 01 00")
    found = answers(Network(servos), BROADCAST, Instruction.BULK_READ, parameters)
    assert [(item.id, item.parameters[1:]) for item in found] == [(7, b"\x1e"), (3, b"\x03")]


def test_a_broadcast_ping_is_answered_in_the_order_of_the_ids() -> None:
    found = answers(Network([Servo.make(i) for i in IDS]), BROADCAST, Instruction.PING)
    assert [item.id for item in found] == sorted(IDS)


def test_status_return_level() -> None:
    servo = Servo.make(1)
    bus = Network([servo])
    for level, count in ((2, (1, 1, 1)), (1, (1, 1, 0)), (0, (1, 0, 0))):
        servo.set("Status Return Level", level)
        packets = ((Instruction.PING, b""), (Instruction.READ, b"\x84\0\x04\0"), (Instruction.WRITE, LED + b"\1"))
        assert tuple(len(answers(bus, 1, *packet)) for packet in packets) == count
        assert len(bus.complain(1)) == (level == 2)


@pytest.mark.parametrize(
    ("instruction", "parameters", "expected"),
    [
        (Instruction.WRITE, LED + b"\1", StatusError.NONE),
        (0x77, b"", StatusError.INSTRUCTION),
        (Instruction.ACTION, b"", StatusError.INSTRUCTION),
        (Instruction.CONTROL_TABLE_BACKUP, b"\x02CTRL", StatusError.RESULT_FAIL),
        (Instruction.CONTROL_TABLE_BACKUP, b"\x09CTRL", StatusError.DATA_RANGE),
        (Instruction.WRITE, LED + b"\2", StatusError.DATA_RANGE),
        (Instruction.WRITE, GOAL + b"\1\2", StatusError.DATA_LENGTH),
        (Instruction.WRITE, GOAL + b"\0\x20\0\0", StatusError.DATA_LIMIT),
        (Instruction.WRITE, b"\x84\0\0\0\0\0", StatusError.ACCESS),
        (Instruction.WRITE, b"\x0e\0\0", StatusError.ACCESS),
        (Instruction.READ, b"\x95\x02\x04\0", StatusError.ACCESS),
        (Instruction.READ, b"\x84\0", StatusError.DATA_LENGTH),
        (Instruction.CLEAR, b"\x01\x44\x58\x4c\x23", StatusError.DATA_RANGE),
        (Instruction.FACTORY_RESET, b"\x07", StatusError.DATA_RANGE),
    ],
)
def test_error_codes(instruction: int, parameters: bytes, expected: StatusError) -> None:
    bus = network()
    assert code(bus, 1, instruction, parameters) == expected
    bus.servos[1].fail(SHOCK)
    assert code(bus, 1, instruction, parameters) == expected | ALERT or instruction == Instruction.FACTORY_RESET


def test_under_torque_the_eeprom_and_the_backup_are_locked() -> None:
    bus = network()
    bus.servos[1].write(TABLE["Torque Enable"].address, b"\1")
    assert code(bus, 1, Instruction.WRITE, MODE + b"\4") == StatusError.ACCESS
    assert code(bus, 1, Instruction.CONTROL_TABLE_BACKUP, b"\x01CTRL") == StatusError.RESULT_FAIL


def test_damaged_packets_are_told_of_by_the_servo_they_name() -> None:
    bus = network()
    (reply,) = bus.complain(2)
    assert list(PacketReader().feed(reply.data)) == [Packet(2, Instruction.STATUS, bytes((StatusError.CRC,)))]
    assert bus.complain(BROADCAST) == bus.complain(9) == []


def test_secondary_ids_move_a_group_in_silence() -> None:
    bus = network(4)
    for servo in bus.servos.values():
        servo.set("Secondary(Shadow) ID", 2)
    assert len(answers(bus, 2, Instruction.WRITE, LED + b"\1")) == 1
    assert [servo.get("LED") for servo in bus.servos.values()] == [1] * 4
    assert len(answers(bus, 2, Instruction.PING)) == 1
    answers(bus, 2, Instruction.WRITE, MODE + b"\4")
    assert [servo.get("Operating Mode") for servo in bus.servos.values()] == [3, 4, 3, 3]


def test_backup_brings_eeprom_gains_profile_and_mapping_back() -> None:
    bus = network(1)
    servo, block = bus.servos[1], TABLE.indirect_blocks[0]
    kept = {"Position P Gain": 333, "Profile Velocity": 44, "Homing Offset": 55}
    for name, value in kept.items():
        servo.write(TABLE[name].address, TABLE[name].pack(value))
    servo.write(block.address, b"\x41\0")
    assert code(bus, 1, Instruction.CONTROL_TABLE_BACKUP, b"\x01CTRL") == StatusError.NONE
    servo.factory_reset(("ID",))
    servo.advance(0.5)
    assert code(bus, 1, Instruction.CONTROL_TABLE_BACKUP, b"\x02CTRL") == StatusError.NONE
    assert not servo.answering
    servo.advance(0.5)
    assert {name: servo.get(name) for name in kept} == kept
    assert servo.read(block.address, 2) == b"\x41\0"


def test_a_new_id_answers_at_once_and_the_old_one_no_more() -> None:
    bus = network(1)
    assert code(bus, 1, Instruction.WRITE, b"\x07\0\x09") == StatusError.NONE
    assert answers(bus, 1, Instruction.PING) == []
    assert len(answers(bus, 9, Instruction.PING)) == 1


def test_all_may_be_reset_but_never_all_ids_at_once() -> None:
    bus = network()
    assert answers(bus, BROADCAST, Instruction.FACTORY_RESET, b"\xff") == []
    assert set(bus.servos) == {1, 2}


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from([1, 2, 0xFE]),
            st.one_of(st.sampled_from([int(i) for i in Instruction]), st.integers(0, 255)),
            st.one_of(
                st.binary(max_size=24),
                st.builds(lambda a, d: a.to_bytes(2, "little") + d, st.integers(0, 700), st.binary(max_size=12)),
            ),
        ),
        max_size=12,
    )
)
def test_any_instruction_leaves_the_servos_sane(items: list[tuple[int, int, bytes]]) -> None:
    bus = network()
    servos = list(bus.servos.values())
    for identity, instruction, parameters in items:
        bus.handle(Packet(identity, instruction, parameters))
        bus.advance(0.004)
    for servo in servos:
        assert 0 <= servo.get("Min Position Limit") <= 4095
        assert 0 <= servo.get("Max Position Limit") <= 4095
        assert servo.get("Model Number") == 1020
        assert len(servo.memory) == TABLE.size
