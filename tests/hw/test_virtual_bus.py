"""The emulated bus through the official SDK, over the pseudo terminal."""

import random
import time
from collections.abc import Iterator

import pytest
from dynamixel_easy_sdk import Connector
from dynamixel_sdk import (
    COMM_RX_CORRUPT,
    COMM_RX_TIMEOUT,
    COMM_SUCCESS,
    GroupBulkRead,
    GroupBulkWrite,
    GroupSyncRead,
    GroupSyncWrite,
    PortHandler,
    Protocol2PacketHandler,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from hw.protocol import Instruction, Packet, StatusError, encode
from hw.registers import control_table
from hw.virtual.bus import VirtualBus
from hw.virtual.instructions import Network
from hw.virtual.servo import Servo
from ros_free_stack.errors import InvalidOption
from ros_free_stack.robots import load_robot

TABLE = control_table("XM430-W350")
POSITION, GOAL = TABLE["Present Position"].address, TABLE["Goal Position"].address
TORQUE, LED = TABLE["Torque Enable"].address, TABLE["LED"].address
IDS = (3, 7, 4)
SDK = Protocol2PacketHandler()


class PatientPort(PortHandler):
    """Waits longer than the SDK does: on a busy machine the emulator's thread may not run for tens of milliseconds."""

    def setPacketTimeout(self, packet_length: int) -> None:  # noqa: N802
        super().setPacketTimeout(packet_length)
        self.packet_timeout += 400


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with VirtualBus([Servo.make(i, position=0.1 * i) for i in IDS]) as bus:
        yield bus


@pytest.fixture
def port(bus: VirtualBus) -> Iterator[PortHandler]:
    handler = PatientPort(bus.port)
    handler.openPort()
    yield handler
    handler.closePort()


def test_ping(port: PortHandler) -> None:
    assert SDK.ping(port, 7) == (1020, COMM_SUCCESS, 0)
    assert SDK.ping(port, 8)[1] == COMM_RX_TIMEOUT
    assert SDK.broadcastPing(port) == ({i: [1020, 52] for i in IDS}, COMM_SUCCESS)


def test_read_write_move(bus: VirtualBus, port: PortHandler) -> None:
    assert SDK.read2ByteTxRx(port, 3, 0) == (1020, COMM_SUCCESS, 0)
    assert SDK.write1ByteTxRx(port, 3, TORQUE, 1) == (COMM_SUCCESS, 0)
    assert SDK.write4ByteTxRx(port, 3, GOAL, 2600) == (COMM_SUCCESS, 0)
    assert SDK.write4ByteTxRx(port, 3, GOAL, 9999) == (COMM_SUCCESS, StatusError.DATA_LIMIT)
    assert SDK.write4ByteTxRx(port, 3, POSITION, 0) == (COMM_SUCCESS, StatusError.ACCESS)
    deadline = time.monotonic() + 20
    while abs(SDK.read4ByteTxRx(port, 3, POSITION)[0] - 2600) > 3:
        assert time.monotonic() < deadline
    assert bus.servo(3).goal_extremes == (2600, 2600)


def test_reg_write_waits_for_action(bus: VirtualBus, port: PortHandler) -> None:
    for i in IDS:
        assert SDK.regWriteTxRx(port, i, LED, 1, [1]) == (COMM_SUCCESS, 0)
        assert SDK.read1ByteTxRx(port, i, TABLE["Registered Instruction"].address)[0] == 1
    assert [bus.servo(i).get("LED") for i in IDS] == [0, 0, 0]
    SDK.action(port, 0xFE)
    assert SDK.ping(port, 3)[1] == COMM_SUCCESS
    assert [bus.servo(i).get("LED") for i in IDS] == [1, 1, 1]


def test_reboot_is_silent_for_a_while(port: PortHandler) -> None:
    SDK.write1ByteTxRx(port, 4, LED, 1)
    assert SDK.reboot(port, 4) == (COMM_SUCCESS, 0)
    assert SDK.ping(port, 4)[1] == COMM_RX_TIMEOUT
    deadline = time.monotonic() + 20
    while SDK.ping(port, 4)[1] != COMM_SUCCESS:
        assert time.monotonic() < deadline
    assert SDK.read1ByteTxRx(port, 4, LED)[0] == 0


def test_factory_reset_and_clear(bus: VirtualBus, port: PortHandler) -> None:
    SDK.write1ByteTxRx(port, 4, TABLE["Operating Mode"].address, 4)
    assert SDK.factoryReset(port, 4, 2) == (COMM_SUCCESS, 0)
    assert bus.servo(4).get("Operating Mode") == 3
    assert SDK.factoryReset(port, 4, 9)[1] == StatusError.DATA_RANGE
    with bus.locked:
        bus.servo(4).motor.position = 7.0
    assert SDK.read4ByteTxRx(port, 4, POSITION)[0] > 4096
    assert SDK.clearMultiTurn(port, 4) == (COMM_SUCCESS, 0)
    assert 0 <= SDK.read4ByteTxRx(port, 4, POSITION)[0] < 4096


@pytest.mark.parametrize("fast", [False, True])
def test_sync(bus: VirtualBus, port: PortHandler, fast: bool) -> None:
    writer = GroupSyncWrite(port, SDK, GOAL, 4)
    reader = GroupSyncRead(port, SDK, GOAL, 4)
    for i in IDS:
        writer.addParam(i, list((2000 + i).to_bytes(4, "little")))
        reader.addParam(i)
    assert writer.txPacket() == COMM_SUCCESS
    assert (reader.fastSyncRead if fast else reader.txRxPacket)() == COMM_SUCCESS
    assert [reader.getData(i, GOAL, 4) for i in IDS] == [2000 + i for i in IDS]


@pytest.mark.parametrize("fast", [False, True])
def test_bulk(bus: VirtualBus, port: PortHandler, fast: bool) -> None:
    writer, reader = GroupBulkWrite(port, SDK), GroupBulkRead(port, SDK)
    writer.addParam(3, LED, 1, [1])
    writer.addParam(7, GOAL, 4, [0xD0, 7, 0, 0])
    assert writer.txPacket() == COMM_SUCCESS
    reader.addParam(3, LED, 1)
    reader.addParam(7, GOAL, 4)
    assert (reader.fastBulkRead if fast else reader.txRxPacket)() == COMM_SUCCESS
    assert (reader.getData(3, LED, 1), reader.getData(7, GOAL, 4)) == (1, 2000)


def test_stuffed_data_reaches_the_sdk_whole(bus: VirtualBus, port: PortHandler) -> None:
    data = list(b"\xff\xff\xfd\x00\x01\xff\xff\xfd\x02")
    address = TABLE.indirect_blocks[0].data
    assert SDK.writeTxRx(port, 3, address, len(data), data) == (COMM_SUCCESS, 0)
    assert SDK.readTxRx(port, 3, address, len(data)) == (data, COMM_SUCCESS, 0)


def test_a_silent_servo_ends_a_group_read(bus: VirtualBus, port: PortHandler) -> None:
    bus.servo(7).dead = True
    reader = GroupSyncRead(port, SDK, POSITION, 4)
    for i in IDS:
        reader.addParam(i)
    assert reader.txRxPacket() == COMM_RX_TIMEOUT
    assert reader.fastSyncRead() == COMM_RX_CORRUPT


def test_faults_reach_the_sdk(bus: VirtualBus, port: PortHandler) -> None:
    bus.faults.drop = 1.0
    assert SDK.ping(port, 3)[1] == COMM_RX_TIMEOUT
    bus.faults.drop, bus.faults.corrupt = 0.0, 1.0
    assert {SDK.ping(port, 3)[1] for _ in range(10)} <= {COMM_RX_CORRUPT, COMM_RX_TIMEOUT}
    bus.faults.corrupt, bus.faults.noise = 0.0, 1.0
    assert SDK.ping(port, 3)[1] == COMM_SUCCESS


def test_alert_bit(bus: VirtualBus, port: PortHandler) -> None:
    with bus.locked:
        bus.servo(3).fail(1 << 5)
    assert SDK.ping(port, 3)[2] == 0x80
    assert SDK.ping(port, 4)[2] == 0


def test_easy_sdk(bus: VirtualBus) -> None:
    connector = Connector(bus.port, 1_000_000)
    motor = connector.createMotor(3)
    motor.enableTorque()
    motor.setGoalPosition(2222)
    assert motor.isTorqueOn() == 1
    assert bus.servo(3).get("Goal Position") == 2222
    motor.disableTorque()
    assert not bus.servo(3).torque_on
    connector.closePort()


def test_fast_read_of_the_manual() -> None:
    servos = [Servo.make(i, model="XC330-T288") for i in IDS]
    for servo, position in zip(servos, (166, 2079, 1023), strict=True):
        servo.set("Present Position", position)
    request = Packet(0xFE, Instruction.FAST_SYNC_READ, b"\x84\0\x04\0\x03\x07\x04")
    assert encode(request).hex(" ").upper() == "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"
    (reply,) = Network(servos).handle(request)
    assert reply.data.hex(" ").upper() == (
        "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E"
    )


def test_status_return_level() -> None:
    servo = Servo.make(1)
    network = Network([servo])
    read = Packet(1, Instruction.READ, b"\x84\0\x04\0")
    led = Packet(1, Instruction.WRITE, LED.to_bytes(2, "little") + b"\1")
    for level, answers in ((2, (1, 1, 1)), (1, (1, 1, 0)), (0, (1, 0, 0))):
        servo.set("Status Return Level", level)
        packets = (Packet(1, Instruction.PING), read, led)
        assert tuple(len(network.handle(packet)) for packet in packets) == answers


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
    servos = [Servo.make(1), Servo.make(2)]
    network = Network(servos)
    for identity, instruction, parameters in items:
        network.handle(Packet(identity, instruction, parameters))
        network.advance(0.004)
    for servo in servos:
        low, high = servo.get("Min Position Limit"), servo.get("Max Position Limit")
        assert 0 <= low <= 4095 and 0 <= high <= 4095
        assert servo.get("Model Number") == 1020
        assert len(servo.memory) == TABLE.size


def test_the_port_goes_with_the_bus() -> None:
    bus = VirtualBus([Servo.make(1)])
    bus.start()
    bus.stop()
    bus.stop()
    with pytest.raises(OSError):
        PortHandler(bus.port).openPort()


def test_a_robot_without_servos() -> None:
    with pytest.raises(InvalidOption, match="g1 has no Dynamixel servos"):
        VirtualBus.of_robot(load_robot("g1"))


def test_faults_are_the_same_for_the_same_seed() -> None:
    from hw.virtual.bus import Faults

    def bytes_of(seed: int) -> list[bytes]:
        faults = Faults(drop=0.2, corrupt=0.3, noise=0.3, seed=seed)
        source = random.Random(0)
        return [faults.distort(source.randbytes(12)) for _ in range(50)]

    assert bytes_of(1) == bytes_of(1) != bytes_of(2)
