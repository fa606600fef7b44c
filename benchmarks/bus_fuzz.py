"""Fuzz the packet parsers on both sides of the bus, and the emulated servos behind one of them.

Each case is a burst of bytes: whole packets of any instruction, packets with changed, lost or doubled bytes, headers
with any length, and noise. Both parsers must find the same packets, survive, and find a good packet that follows; no
servo may hold a goal, a limit or any other register outside its range, nor lose its model number.

    python benchmarks/bus_fuzz.py --cases 100000
"""

import random
import time
from dataclasses import dataclass

import tyro

from hw.protocol import HEADER, MAX_LENGTH, Instruction, Packet, PacketReader, encode
from hw.registers import control_table
from hw.virtual.factory import CHOICES, MULTI_TURN, POSITION
from hw.virtual.network import Network
from hw.virtual.receiver import Receiver
from hw.virtual.servo import Servo
from ros_free_stack.console import progress

TABLE = control_table("XM430-W350")
INSTRUCTIONS = tuple(int(item) for item in Instruction)
WRITES = (Instruction.WRITE, Instruction.REG_WRITE, Instruction.SYNC_WRITE, Instruction.BULK_WRITE)
PROBE = Packet(9, Instruction.PING)
FRESH_EVERY = 200
SLOWEST_S = 1.0


def parameters(source: random.Random) -> bytes:
    """Noise, or an address and data that may even make sense."""
    if source.random() < 0.3:
        return source.randbytes(source.randrange(40))
    names = ("Goal Position", "Torque Enable", "Operating Mode") if source.random() < 0.5 else tuple(TABLE.registers)
    register = TABLE[source.choice(names)]
    address = register.address + (source.randrange(-2, 3) if source.random() < 0.2 else 0)
    size = register.size if source.random() < 0.8 else source.randrange(9)
    head = max(0, address).to_bytes(2, "little")
    if source.random() < 0.5:
        plain = source.randrange(6000).to_bytes(8, "little")[:size]
        return head + source.choice((source.randbytes(size), plain, plain, b"\xff" * size, size.to_bytes(2, "little")))
    ids = bytes(source.choices((1, 2, 9, 253), k=3))
    return head + size.to_bytes(2, "little") + b"".join(bytes((i,)) + source.randbytes(size) for i in ids)


def burst(source: random.Random) -> bytes:
    """One case."""
    pieces: list[bytes] = []
    for _ in range(source.randrange(1, 5)):
        kinds = source.choice((WRITES, WRITES, INSTRUCTIONS, range(256)))
        instruction = int(source.choice(kinds))
        piece = bytearray(encode(Packet(source.choice((1, 2, 9, 0xFE, 0xFD)), instruction, parameters(source))))
        damage = source.random()
        at = source.randrange(len(piece))
        if damage < 0.2:
            piece[at] ^= source.randrange(1, 256)
        elif damage < 0.3:
            del piece[at : at + source.randrange(1, 5)]
        elif damage < 0.4:
            piece[at:at] = source.randbytes(source.randrange(1, 5))
        elif damage < 0.5:
            piece = bytearray(HEADER + source.randbytes(source.randrange(12)))
        pieces.append(bytes(piece))
    return b"".join(pieces)


@dataclass
class Witness:
    """One servo, and what it held before the last packet."""

    servo: Servo

    def look(self) -> None:
        """Before a packet."""
        self._mode, self._told = self.servo.get("Operating Mode"), len(self.servo.goals)
        self._refused = len(self.servo.refusals)

    def check(self, case: int) -> None:
        """After it: nothing in the table is out of its range."""
        servo = self.servo
        for name, choices in CHOICES.items():
            assert servo.get(name) in choices, f"case {case}: {name} is {servo.get(name)}"
        assert servo.get("Model Number") == TABLE.number, f"case {case}: model number {servo.get('Model Number')}"
        for goal, limit in (("Goal PWM", 885), ("Goal Current", 0xFFFF), ("Goal Position", MULTI_TURN)):
            assert abs(servo.get(goal)) <= limit, f"case {case}: {goal} {servo.get(goal)}"
        if len(servo.goals) > self._told and len(servo.refusals) == self._refused and self._mode == POSITION:
            low, high = servo.get("Min Position Limit"), servo.get("Max Position Limit")
            assert low <= servo.get("Goal Position") <= high, f"case {case}: goal {servo.get('Goal Position')}"


def main(cases: int = 100_000, seed: int = 0) -> None:
    """Fuzz both parsers and the servos.

    Args:
        cases: bursts of bytes.
        seed: of the randomness.
    """
    source = random.Random(seed)
    found = damaged = refused = accepted = 0
    slowest = 0.0
    servos, network, receiver, reader = [Servo.make(1)], Network([]), Receiver(), PacketReader()
    for case in progress(range(cases), "fuzz"):
        if case % FRESH_EVERY == 0:
            servos = [Servo.make(1), Servo.make(2)]
            network, receiver, reader = Network(servos), Receiver(), PacketReader()
        data = burst(source)
        start = time.perf_counter()
        cut = source.randrange(len(data) + 1)
        heard = receiver.feed(data[:cut]) + receiver.feed(data[cut:])
        packets = [item for item in heard if isinstance(item, Packet)]
        assert list(reader.feed(data[:cut])) + list(reader.feed(data[cut:])) == packets, f"case {case}: parsers differ"
        for packet in packets:
            witnesses = [Witness(servo) for servo in servos]
            for witness in witnesses:
                witness.look()
            network.handle(packet)
            network.advance(0.02)
            for witness in witnesses:
                witness.check(case)
        slowest = max(slowest, time.perf_counter() - start)
        found, damaged = found + len(packets), damaged + len(heard) - len(packets)
        if case % FRESH_EVERY == FRESH_EVERY - 1:
            refused += sum(len(servo.refusals) for servo in servos)
            accepted += sum(len(servo.goals) for servo in servos)
            # However long a packet the noise has announced, a good one is found after as many bytes.
            many = encode(PROBE) * (MAX_LENGTH // len(encode(PROBE)) + 2)
            assert PROBE in receiver.feed(many) and PROBE in list(reader.feed(many)), f"case {case}: deaf"
    assert slowest < SLOWEST_S, f"a burst took {slowest:.1f} s"
    print(
        f"{cases} bursts: {found} packets, {damaged} damaged ones, {refused} writes refused, {accepted} goals told; "
        f"no crash, both parsers agree, slowest burst {1e3 * slowest:.1f} ms"
    )


if __name__ == "__main__":
    tyro.cli(main)
