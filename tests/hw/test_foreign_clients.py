"""Other people's programs on the emulated bus: the official SDK's flows, its easy layer, and LeRobot's bus.

LeRobot is tried where RFS_LEROBOT_PYTHON names a Python that has it (`pip install lerobot dynamixel-sdk`).
"""

import json
import os
import subprocess
import time
from collections.abc import Callable, Iterator

import pytest
from dynamixel_easy_sdk import Connector, Direction, DxlRuntimeError, OperatingMode, ProfileConfiguration
from dynamixel_sdk import (
    COMM_SUCCESS,
    GroupSyncRead,
    GroupSyncWrite,
    PortHandler,
    Protocol2PacketHandler,
    port_handler,
)

from hw.registers import control_table
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import OVERLOAD, Servo

TABLE = control_table("XM430-W350")
SDK = Protocol2PacketHandler()
IDS = (3, 4, 7)

LEROBOT = """
import json, sys
from lerobot.motors import Motor, MotorNormMode
from lerobot.motors.dynamixel import DynamixelMotorsBus
names = {f"m{i}": Motor(i, "xm430-w350", MotorNormMode.DEGREES) for i in (3, 4, 7)}
bus = DynamixelMotorsBus(sys.argv[1], names)
bus.connect(handshake=False)
result = {"found": bus.broadcast_ping(num_retry=5)}
bus.configure_motors()
bus.enable_torque(num_retry=5)
bus.sync_write("Goal_Position", {"m3": 2300, "m4": 1800, "m7": 2048}, normalize=False, num_retry=5)
for _ in range(4000):
    positions = bus.sync_read("Present_Position", normalize=False, num_retry=5)
    if abs(positions["m3"] - 2300) < 5 and abs(positions["m4"] - 1800) < 5:
        break
result["positions"] = positions
result["temperature"] = bus.read("Present_Temperature", "m7", num_retry=5)
result["calibration"] = {name: [c.range_min, c.range_max] for name, c in bus.read_calibration().items()}
bus.disable_torque(num_retry=5)
bus.disconnect(disable_torque=False)
print(json.dumps(result))
"""


@pytest.fixture(autouse=True)
def patience(patient_sdk: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """The easy layer tries once, and gives up on an answer after twice this many milliseconds."""
    monkeypatch.setattr(port_handler, "LATENCY_TIMER", 600)


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with VirtualBus([Servo.make(i) for i in IDS]) as bus:
        yield bus


@pytest.fixture
def port(bus: VirtualBus) -> Iterator[PortHandler]:
    handler = PortHandler(bus.port)
    handler.openPort()
    yield handler
    handler.closePort()


def wait_until(done: Callable[[], bool]) -> None:
    end = time.monotonic() + 60
    while not done():
        assert time.monotonic() < end, "waited in vain"


def ok(result: tuple[int, int]) -> None:
    assert result == (COMM_SUCCESS, 0)


def test_the_sdks_indirect_address_flow(bus: VirtualBus, port: PortHandler) -> None:
    """LED and goal through indirect data written at once, Moving and position through others read at once."""
    block, goal, position = TABLE.indirect_blocks[0], TABLE["Goal Position"], TABLE["Present Position"]
    written = [TABLE["LED"].address, *range(goal.address, goal.end)]
    read = [TABLE["Moving"].address, *range(position.address, position.end)]
    for identity in IDS:
        ok(SDK.write1ByteTxRx(port, identity, TABLE["Torque Enable"].address, 0))
        for i, address in enumerate(written + read):
            ok(SDK.write2ByteTxRx(port, identity, block.address + 2 * i, address))
        ok(SDK.write1ByteTxRx(port, identity, TABLE["Torque Enable"].address, 1))
    writer = GroupSyncWrite(port, SDK, block.data, len(written))
    reader = GroupSyncRead(port, SDK, block.data + len(written), len(read))
    for identity in IDS:
        writer.addParam(identity, [1, *(2100 + identity).to_bytes(4, "little")])
        reader.addParam(identity)
    assert writer.txPacket() == COMM_SUCCESS

    def arrived() -> bool:
        if reader.txRxPacket() != COMM_SUCCESS:
            return False
        at = [reader.getData(identity, block.data + len(written) + 1, 4) for identity in IDS]
        return all(abs(value - 2100 - identity) < 5 for value, identity in zip(at, IDS, strict=True))

    wait_until(arrived)
    assert [bus.servo(identity).get("LED") for identity in IDS] == [1, 1, 1]


def test_the_sdks_reboot_flow_clears_a_shutdown(bus: VirtualBus, port: PortHandler) -> None:
    with bus.locked:
        bus.servo(3).fail(OVERLOAD)
    assert SDK.write1ByteTxRx(port, 3, TABLE["Torque Enable"].address, 1)[1] & 0x7F == 1
    assert SDK.reboot(port, 3)[0] == COMM_SUCCESS
    wait_until(lambda: SDK.ping(port, 3)[1] == COMM_SUCCESS)
    ok(SDK.write1ByteTxRx(port, 3, TABLE["Torque Enable"].address, 1))


def test_easy_sdk_motor(bus: VirtualBus) -> None:
    connector = Connector(bus.port, 1_000_000)
    motor = connector.createMotor(3)
    motor.setOperatingMode(OperatingMode.EXTENDED_POSITION)
    motor.setProfileConfiguration(ProfileConfiguration.TIME_BASED)
    motor.setDirection(Direction.REVERSE)
    assert bus.servo(3).get("Drive Mode") == 5
    motor.setPositionPGain(700)
    motor.enableTorque()
    with pytest.raises(DxlRuntimeError):
        motor.setOperatingMode(OperatingMode.POSITION)
    motor.setGoalPosition(2222)
    wait_until(lambda: abs(motor.getPresentPosition() - 2222) < 5)
    assert motor.isTorqueOn() == 1
    assert bus.servo(3).motor.position < 0
    motor.disableTorque()
    assert not bus.servo(3).torque_on
    motor.changeID(9)
    assert sorted(connector.broadcastPing()) == [4, 7, 9]
    connector.closePort()


def test_easy_sdk_groups(bus: VirtualBus) -> None:
    connector = Connector(bus.port, 1_000_000)
    motors = connector.createAllMotors()
    group = connector.createGroupExecutor()
    for motor in motors:
        group.addCmd(motor.stageEnableTorque())
    group.executeWrite()
    group.clearStagedWriteCommands()
    group.addCmd(motors[0].stageSetGoalPosition(2100))
    group.addCmd(motors[1].stageLEDOn())
    group.executeWrite()
    group.addCmd(motors[0].stageIsTorqueOn())
    group.addCmd(motors[1].stageGetPresentPosition())
    torque, position = group.executeRead()
    assert torque == 1 and position == pytest.approx(2048, abs=2)
    wait_until(lambda: abs(bus.servo(3).get("Present Position") - 2100) < 5)
    assert bus.servo(4).get("LED") == 1
    connector.closePort()


def test_lerobots_bus(bus: VirtualBus) -> None:
    python = os.environ.get("RFS_LEROBOT_PYTHON")
    if not python:
        pytest.skip("RFS_LEROBOT_PYTHON names no Python with LeRobot")
    done = subprocess.run([python, "-c", LEROBOT, bus.port], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout.splitlines()[-1])
    assert result["found"] == {str(identity): 1020 for identity in IDS}
    assert abs(result["positions"]["m3"] - 2300) < 5 and abs(result["positions"]["m4"] - 1800) < 5
    assert result["temperature"] == pytest.approx(30, abs=3)
    assert result["calibration"]["m3"] == [0, 4095]
    assert not any(bus.servo(identity).torque_on for identity in IDS)
