"""Other people's drivers on the emulated bus: rustypot in Rust, dxl2, the C++ SDK's examples, GELLO, ToddlerBot.

The last three are no packages: RFS_DYNAMIXEL_SDK, RFS_GELLO and RFS_TODDLERBOT name folders with their source.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hw.virtual.bus import VirtualBus
from hw.virtual.servo import Servo

IDS = (3, 4, 7)
TIMEOUT_S = 120

RUSTYPOT = """
import json, sys, rustypot
robot = rustypot.Xl430PyController(sys.argv[1], int(sys.argv[2]), 2.0)
result = {"found": robot.broadcast_scan(), "ping": robot.ping(3)}
robot.sync_write_torque_enable([3, 4, 7], [True] * 3)
robot.sync_write_goal_position([3, 4], [2300, 1800])
for _ in range(4000):
    positions = robot.sync_read_present_position([3, 4, 7])
    if abs(positions[0] - 2300) < 5 and abs(positions[1] - 1800) < 5:
        break
result["positions"] = positions
robot.write_torque_enable(3, False)
result["torque"] = [robot.read_torque_enable(identity)[0] for identity in (3, 4)]
robot.close()
print(json.dumps(result))
"""
DXL2 = """
import json, sys
from dxl2.connection import Connection
from dxl2.motor import Motor, MotorType
from dxl2.register import Instruction
wire = Connection(sys.argv[1], int(sys.argv[2]))
wire.set_baud_rate(wire.baudrate)
print(json.dumps([Motor(wire, i, MotorType.MX, 2.0).read(Instruction.MODEL_NUMBER) for i in (3, 4, 7)]))
"""
GELLO = """
import importlib.util, json, sys, time
spec = importlib.util.spec_from_file_location("driver", sys.argv[3] + "/gello/dynamixel/driver.py")
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
driver = module.DynamixelDriver([3, 4, 7], port=sys.argv[1], baudrate=int(sys.argv[2]), use_fake_fallback=False)
driver.set_torque_mode(True)
driver.set_joints([3.4, 2.9, 3.14159])
for _ in range(2000):
    positions, _ = driver.get_positions_and_velocities()
    if abs(positions[0] - 3.4) < 0.02 and abs(positions[1] - 2.9) < 0.02:
        break
    time.sleep(0.01)
driver.set_torque_mode(False)
driver.close()
print(json.dumps(list(positions)))
"""
TODDLERBOT = """
import json, sys, numpy
sys.path.insert(0, sys.argv[3])
from toddlerbot.actuation.dynamixel_client import DynamixelClient
client = DynamixelClient([3, 4, 7], port=sys.argv[1], baudrate=int(sys.argv[2]))
client.connect()
client.set_torque_enabled([3, 4, 7], True)
client.write_desired_pos([3, 4, 7], numpy.array([3.4, 2.9, 3.14159]))
for _ in range(2000):
    _, positions = client.read_pos()
    if abs(positions[0] - 3.4) < 0.02 and abs(positions[1] - 2.9) < 0.02:
        break
_, volts = client.read_vin()
client.disconnect()
print(json.dumps({"positions": [float(p) for p in positions], "volts": [float(v) for v in volts]}))
"""


PATIENT = "from dynamixel_sdk import port_handler; port_handler.LATENCY_TIMER = 150\n"
"""The SDK of a busy computer waits longer."""


def outcome(bus: VirtualBus, program: str, baud: int, *arguments: str) -> object:
    """What a program says on the bus of another process than its own."""
    command = [sys.executable, "-c", PATIENT + program, bus.port, str(baud), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def source(variable: str) -> str:
    folder = os.environ.get(variable)
    if not folder or not Path(folder).is_dir():
        pytest.skip(f"{variable} names no folder with its source: it is no package")
    return folder


@pytest.mark.parametrize("baud", [57_600, 1_000_000, 4_000_000])
def test_rustypot(baud: int) -> None:
    pytest.importorskip("rustypot", reason="pip install rustypot")
    with VirtualBus([Servo.make(i, model="XL430-W250", baud=baud) for i in IDS], timed=True) as bus:
        result = outcome(bus, RUSTYPOT, baud)
        assert isinstance(result, dict)
        assert result["found"] == {str(i): 1060 for i in IDS} and result["ping"]
        assert result["positions"] == pytest.approx([2300, 1800, 2048], abs=5)
        assert result["torque"] == [False, True]


def test_dxl2() -> None:
    """Its registers but this one are those of Protocol 1.0."""
    pytest.importorskip("dxl2", reason="pip install dxl2")
    with VirtualBus([Servo.make(i) for i in IDS]) as bus:
        assert outcome(bus, DXL2, 1_000_000) == [[1020, 0, 0]] * 3


def test_gellos_driver() -> None:
    folder = source("RFS_GELLO")
    with VirtualBus([Servo.make(i, model="XL330-M288") for i in IDS]) as bus:
        assert outcome(bus, GELLO, 1_000_000, folder) == pytest.approx([3.4, 2.9, 3.1416], abs=0.02)
        assert not any(servo.torque_on for servo in bus.network.all_servos)


def test_toddlerbots_client() -> None:
    folder = source("RFS_TODDLERBOT")
    for needed in ("colorama", "line_profiler"):
        pytest.importorskip(needed, reason=f"pip install {needed}")
    with VirtualBus([Servo.make(i, baud=2_000_000) for i in IDS]) as bus:
        result = outcome(bus, TODDLERBOT, 2_000_000, folder)
        assert isinstance(result, dict)
        assert result["positions"] == pytest.approx([3.4, 2.9, 3.1416], abs=0.02)
        assert result["volts"] == pytest.approx([12.0] * 3, abs=0.2)
        assert not any(servo.torque_on for servo in bus.network.all_servos)


CPP = ("ping", "broadcast_ping", "reboot")
FAILURES = ("[TxRxResult]", "[RxPacketError]", "Failed", "failed")


@pytest.fixture(scope="module")
def cpp_sdk(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """The examples of the C++ SDK, and how a compiler is called for one of them."""
    root = Path(source("RFS_DYNAMIXEL_SDK")) / "c++"
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("there is no g++")
    folder = tmp_path_factory.mktemp("sdk")
    call = [compiler, "-DLINUX", "-D_GNU_SOURCE", "-std=c++17", f"-I{root / 'include/dynamixel_sdk'}"]
    sources = (root / "src/dynamixel_sdk").glob("*.cpp")
    chosen = [str(file) for file in sources if not file.stem.endswith(("_windows", "_mac", "_arduino"))]
    subprocess.run([*call, "-c", *chosen], cwd=folder, check=True, capture_output=True)
    return root / "example/protocol2.0", [*call, *map(str, folder.glob("*.o"))]


@pytest.mark.parametrize("name", CPP)
def test_the_cpp_sdks_examples(cpp_sdk: tuple[Path, list[str]], tmp_path: Path, name: str) -> None:
    """As they are, but for the port; the others are written for the addresses of a PRO."""
    folder, compile_command = cpp_sdk
    with VirtualBus([Servo.make(i, baud=57_600) for i in (1, 2)], timed=True) as bus:
        text = (folder / name / f"{name}.cpp").read_text()
        (tmp_path / "main.cpp").write_text(text.replace('"/dev/ttyUSB0"', f'"{bus.port}"'))
        program = str(tmp_path / "main")
        subprocess.run([*compile_command, str(tmp_path / "main.cpp"), "-o", program], check=True, capture_output=True)
        keys = "gg\x1b" * 3
        done = subprocess.run([program], input=keys, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert done.returncode == 0
    assert "Succeeded to change the baudrate!" in done.stdout
    assert not [line for line in done.stdout.splitlines() if any(word in line for word in FAILURES)]
    assert bus.heard > 0
