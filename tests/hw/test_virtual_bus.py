"""The emulated bus through the official SDK, over the pseudo terminal."""

import time
from collections.abc import Iterator

import pytest
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

from hw.protocol import Instruction, Packet, StatusError, encode
from hw.registers import control_table
from hw.virtual.bus import VirtualBus
from hw.virtual.faults import Fault
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
        self.packet_timeout += 900


def wait_for(port: PortHandler, identity: int) -> None:
    """Until a servo that restarted answers."""
    deadline = time.monotonic() + 20
    while SDK.ping(port, identity)[1] != COMM_SUCCESS:
        assert time.monotonic() < deadline


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
    wait_for(port, 4)
    assert SDK.read1ByteTxRx(port, 4, LED)[0] == 0


def test_factory_reset_and_clear(bus: VirtualBus, port: PortHandler) -> None:
    SDK.write1ByteTxRx(port, 4, TABLE["Operating Mode"].address, 4)
    assert SDK.factoryReset(port, 4, 9)[1] == StatusError.DATA_RANGE
    assert SDK.factoryReset(port, 4, 2) == (COMM_SUCCESS, 0)
    assert bus.servo(4).get("Operating Mode") == 3
    wait_for(port, 4)
    SDK.write1ByteTxRx(port, 4, TABLE["Operating Mode"].address, 4)
    with bus.locked:
        bus.servo(4).motor.position = 7.0
    deadline = time.monotonic() + 20
    while SDK.read4ByteTxRx(port, 4, POSITION)[0] < 4096:
        assert time.monotonic() < deadline
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
    assert {SDK.ping(port, 3)[1] for _ in range(3)} <= {COMM_RX_CORRUPT, COMM_RX_TIMEOUT}
    bus.faults.corrupt, bus.faults.noise = 0.0, 1.0
    assert SDK.ping(port, 3)[1] == COMM_SUCCESS


def test_alert_bit(bus: VirtualBus, port: PortHandler) -> None:
    with bus.locked:
        bus.servo(3).fail(1 << 5)
    assert SDK.ping(port, 3)[2] == 0x80
    assert SDK.ping(port, 4)[2] == 0


def test_a_damaged_instruction_is_answered_with_a_crc_error(bus: VirtualBus, port: PortHandler) -> None:
    damaged = bytearray(encode(Packet(3, Instruction.PING)))
    damaged[-1] ^= 1
    port.ser.reset_input_buffer()  # pyright: ignore[reportOptionalMemberAccess]
    port.writePort(bytes(damaged))
    port.setPacketTimeout(11)
    data, result = SDK.rxPacket(port, False)
    assert result == COMM_SUCCESS
    assert data[8] == StatusError.CRC


def test_half_a_packet_is_forgotten_when_the_line_goes_quiet(port: PortHandler) -> None:
    port.writePort(encode(Packet(3, Instruction.PING))[:7].replace(b"\x03\x00", b"\xff\x03"))
    time.sleep(0.5)
    assert SDK.ping(port, 3)[1] == COMM_SUCCESS


def test_on_a_timed_wire_a_servo_hears_only_its_own_rate() -> None:
    servos = [Servo.make(1, baud=57_600), Servo.make(2, baud=2_000_000), Servo.make(3, baud=1_000_000)]
    with VirtualBus(servos, timed=True) as bus:
        handler = PatientPort(bus.port)
        for servo in servos:
            handler.setBaudRate(servo.baud)
            assert [SDK.ping(handler, other.id)[1] == COMM_SUCCESS for other in servos] == [
                other is servo for other in servos
            ]
        handler.setBaudRate(57_600)
        baud = TABLE["Baud Rate"].address
        assert SDK.write1ByteTxRx(handler, 1, baud, 4) == (COMM_SUCCESS, 0)
        assert SDK.ping(handler, 1)[1] == COMM_RX_TIMEOUT
        handler.setBaudRate(2_000_000)
        assert SDK.ping(handler, 1)[1] == COMM_SUCCESS
        handler.closePort()


def test_planned_faults_happen_at_their_time(bus: VirtualBus, port: PortHandler) -> None:
    bus.plan(Fault.parse("dead:2:7"))
    bus.plan(Fault.parse("overload:0s:4"))
    for goal in (2000, 2001):
        assert SDK.ping(port, 7)[1] == COMM_SUCCESS
        SDK.write4ByteTxRx(port, 7, GOAL, goal)
    assert SDK.ping(port, 7)[1] == COMM_RX_TIMEOUT
    assert SDK.ping(port, 4)[2] == 0x80
    assert [fault.kind for _, fault in bus.happened] == ["overload", "dead"]
    with pytest.raises(InvalidOption, match="no servo 9; there are 3, 4, 7"):
        bus.plan(Fault.parse("dead:2:9"))


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
