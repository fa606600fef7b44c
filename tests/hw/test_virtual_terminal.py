"""The emulated port as clients of every kind treat it."""

import array
import fcntl
from pathlib import Path

import pytest
import serial

from hw.protocol import BROADCAST, HEADER, Instruction, Packet, encode
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import Servo


def test_a_client_that_never_reads_keeps_nobody_waiting() -> None:
    with VirtualBus([Servo.make(1)]) as bus:
        client = serial.Serial(bus.port, 57_600)
        ping = encode(Packet(BROADCAST, Instruction.PING))
        for _ in range(2_000):  # their answers are more than the terminal holds
            client.write(ping)
        while bus.heard < 2_000:
            client.write(ping)
        client.close()
    assert bus.heard >= 2_000


def test_only_the_client_has_its_end_open() -> None:
    with VirtualBus([Servo.make(1)]) as bus:
        mine = [str(file.readlink()) for file in Path("/proc/self/fd").iterdir() if file.is_symlink()]
        assert bus.port not in mine
        for _ in range(2):  # one client comes, leaves, and the next is served
            with serial.Serial(bus.port, 57_600, timeout=30) as client:
                client.write(encode(Packet(1, Instruction.PING)))
                assert client.read(14)[:4] == HEADER


@pytest.mark.parametrize("rate", [9_600, 1_000_000, 4_500_000])
def test_rates_without_a_name_are_heard_too(rate: int) -> None:
    """As C++ and Rust programs set them, by termios2."""
    with VirtualBus([Servo.make(1, baud=rate)], timed=True) as bus, serial.Serial(bus.port, 57_600, timeout=30) as port:
        words = array.array("I", bytes(44))
        fcntl.ioctl(port.fileno(), 0x802C542A, words)
        words[2] = (words[2] & ~0o10017) | 0o10000  # CBAUD out, BOTHER in
        words[9] = words[10] = rate
        fcntl.ioctl(port.fileno(), 0x402C542B, words)
        port.write(encode(Packet(1, Instruction.PING)))
        assert port.read(14)[:4] == HEADER
