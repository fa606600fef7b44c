"""The emulated board between battery and servos, and servos that share an id."""

from collections.abc import Iterator

import pytest
from dynamixel_sdk import COMM_RX_CORRUPT, COMM_SUCCESS, PortHandler, Protocol2PacketHandler

from hw.protocol import BROADCAST, Instruction, Packet, PacketReader, StatusError, crc16
from hw.registers import control_table
from hw.virtual.bus import VirtualBus
from hw.virtual.network import Network
from hw.virtual.servo import Servo
from ros_free_stack.robots import load_robot

OP3 = load_robot("op3")
TABLE = control_table("XM430-W350")
SDK = Protocol2PacketHandler()
POWER, BUTTONS, VOLTAGE = 24, 30, 31


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with VirtualBus.of_robot(OP3, powered=False) as bus:
        yield bus


@pytest.fixture
def port(bus: VirtualBus) -> Iterator[PortHandler]:
    handler = PortHandler(bus.port)
    handler.openPort()
    yield handler
    handler.closePort()


def test_without_the_switch_no_servo_answers_and_with_it_all_do(bus: VirtualBus, port: PortHandler) -> None:
    assert SDK.ping(port, 200) == (0x7400, COMM_SUCCESS, 0)
    assert SDK.ping(port, 5)[1] != COMM_SUCCESS
    assert SDK.write1ByteTxRx(port, 200, POWER, 1) == (COMM_SUCCESS, 0)
    for _ in range(100):
        if SDK.ping(port, 5)[1] == COMM_SUCCESS:
            break
    assert SDK.write1ByteTxRx(port, 5, TABLE["Torque Enable"].address, 1) == (COMM_SUCCESS, 0)
    assert SDK.write1ByteTxRx(port, 200, POWER, 0) == (COMM_SUCCESS, 0)
    assert not any(servo.torque_on or servo.answering for servo in bus.network.all_servos), "without power all are limp"


def test_buttons_and_voltage_are_read(bus: VirtualBus, port: PortHandler) -> None:
    board = bus.network.board
    assert board is not None
    assert SDK.read1ByteTxRx(port, 200, VOLTAGE)[0] == 120
    board.press("mode", "user")
    assert SDK.read1ByteTxRx(port, 200, BUTTONS) == (0b101, COMM_SUCCESS, 0)
    board.press()
    assert SDK.read1ByteTxRx(port, 200, BUTTONS)[0] == 0


def test_only_the_switch_can_be_written(port: PortHandler) -> None:
    assert SDK.write1ByteTxRx(port, 200, VOLTAGE, 1) == (COMM_SUCCESS, StatusError.ACCESS)
    assert SDK.write1ByteTxRx(port, 200, POWER, 2) == (COMM_SUCCESS, StatusError.DATA_RANGE)


def twins(**second: object) -> Network:
    network = Network([Servo.make(1), Servo.make(2), Servo.make(1, **second)])  # type: ignore[arg-type]
    network.advance(0.01)
    return network


def heard(network: Network, packet: Packet) -> list[Packet]:
    return list(PacketReader().feed(b"".join(reply.data for reply in network.handle(packet))))


def test_two_servos_with_one_id_garble_what_differs() -> None:
    network = twins(position=1.0)
    position = TABLE["Present Position"].address.to_bytes(2, "little") + b"\4\0"
    assert len(heard(network, Packet(1, Instruction.PING))) == 1, "equal answers fall together"
    assert heard(network, Packet(1, Instruction.READ, position)) == []
    assert len(heard(network, Packet(2, Instruction.READ, position))) == 1
    (fast,) = network.handle(Packet(BROADCAST, Instruction.FAST_SYNC_READ, position + b"\1\2"))
    assert crc16(fast.data[:14]) != int.from_bytes(fast.data[14:16], "little"), "the first block's own CRC"
    answers = heard(network, Packet(BROADCAST, Instruction.SYNC_READ, position + b"\1\2"))
    assert [answer.id for answer in answers] == [2]


def test_two_servos_with_one_id_both_obey() -> None:
    network = twins()
    heard(network, Packet(1, Instruction.WRITE, TABLE["LED"].address.to_bytes(2, "little") + b"\1"))
    assert [servo.get("LED") for servo in network.all_servos] == [1, 0, 1]


def test_a_servo_that_takes_the_id_of_another_does_not_vanish() -> None:
    network = Network([Servo.make(1), Servo.make(2, position=1.0)])
    heard(network, Packet(2, Instruction.WRITE, b"\x07\0\1"))
    assert [servo.id for servo in network.all_servos] == [1, 1]
    assert heard(network, Packet(2, Instruction.PING)) == []
    heard(network, Packet(1, Instruction.WRITE, b"\x07\0\3"))
    assert len(heard(network, Packet(3, Instruction.PING))) == 1


def test_the_sdk_meets_twins_as_damaged_packets() -> None:
    with VirtualBus([Servo.make(1), Servo.make(1, position=1.0)]) as bus:
        handler = PortHandler(bus.port)
        handler.openPort()
        assert SDK.read4ByteTxRx(handler, 1, TABLE["Present Position"].address)[1] == COMM_RX_CORRUPT
        handler.closePort()
