"""`servos emulate` as another program meets it."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from dynamixel_sdk import COMM_SUCCESS, PortHandler, Protocol2PacketHandler

from hw.virtual.cli import ServosEmulate
from ros_free_stack.errors import InvalidOption

SDK = Protocol2PacketHandler()
CODE = (
    "import signal, tyro; from hw.virtual.cli import ServosEmulate; "
    # A test run in the background inherits that SIGINT is ignored.
    "signal.signal(signal.SIGINT, signal.default_int_handler); tyro.cli(ServosEmulate).run()"
)


def test_a_port_for_another_program_with_a_fault() -> None:
    command = [sys.executable, "-c", CODE, "--untimed", "--powered", "--fault", "overload:0s:5", "--json"]
    with subprocess.Popen(
        command, cwd=Path(__file__).parents[2], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        text = ""
        while not text.endswith("}\n"):
            text += process.stdout.readline()
        ready = json.loads(text)
        port = PortHandler(ready["port"])
        port.openPort()
        found = SDK.ping(port, 5)
        for _ in range(100):
            if found[1] == COMM_SUCCESS and found[2] == 0x80:
                break
            found = SDK.ping(port, 5)
        assert found == (1020, COMM_SUCCESS, 0x80)
        assert SDK.ping(port, 6)[2] == 0
        port.closePort()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert ready["servos"] == list(range(1, 21))
    assert "overload of servo 5" in errors
    assert "0 goal positions were written, 0 of them outside" in errors


def test_bad_faults_are_refused_before_anything_starts() -> None:
    with pytest.raises(InvalidOption, match="no servo 99"):
        ServosEmulate(fault=("dead:1s:99",)).run()
    with pytest.raises(InvalidOption, match="kinds: corrupt"):
        ServosEmulate(fault=("fire:1s",)).run()
