"""A Dynamixel bus on a pseudo terminal: any Protocol 2.0 program can open its port.

with VirtualBus.of_robot(load_robot("op3")) as bus:
    driver.open(bus.port)
"""

import os
import select
import threading
import time
import tty
from collections.abc import Iterable
from dataclasses import dataclass, field
from types import TracebackType
from typing import Self

import numpy as np

from hw.pace import realtime_priority
from hw.protocol import Instruction, Packet, PacketReader, encode
from hw.virtual.instructions import Network
from hw.virtual.motor import MotorModel
from hw.virtual.servo import Servo
from ros_free_stack.errors import InvalidOption
from ros_free_stack.robots import RobotDescription

_IDLE_S = 0.01
_BITS_PER_BYTE = 10


@dataclass
class Faults:
    """What goes wrong on the wire; may be changed while the bus runs.

    Attributes:
        drop: probability that an answer is lost.
        corrupt: probability that one byte of an answer is changed.
        drop_instruction: probability that an instruction is not heard.
        noise: probability of up to 8 random bytes before an answer.
        delay_s: extra time before each answer.
        spike_s: extra time before an answer, with probability `spike`.
        spike: see `spike_s`.
        seed: of the randomness.
    """

    drop: float = 0.0
    corrupt: float = 0.0
    drop_instruction: float = 0.0
    noise: float = 0.0
    delay_s: float = 0.0
    spike: float = 0.0
    spike_s: float = 0.0
    seed: int = 0
    _random: np.random.Generator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(self.seed)

    def hears(self) -> bool:
        """Whether an instruction gets through."""
        return self._random.random() >= self.drop_instruction

    def distort(self, data: bytes) -> bytes:
        """What arrives of an answer."""
        if self._random.random() < self.drop:
            return b""
        if self._random.random() < self.corrupt:
            changed = bytearray(data)
            changed[self._random.integers(len(data))] ^= int(self._random.integers(1, 256))
            data = bytes(changed)
        if self._random.random() < self.noise:
            data = self._random.bytes(int(self._random.integers(1, 9))) + data
        return data

    def wait_s(self) -> float:
        """Extra time before an answer."""
        return self.delay_s + (self.spike_s if self._random.random() < self.spike else 0.0)


class VirtualBus:
    """Servos on a pseudo terminal, served by a thread.

    Attributes:
        network: the servos and their answers.
        faults: what goes wrong on the wire.
        port: path to open, once started.
        heard: instruction packets so far.
    """

    def __init__(
        self, servos: Iterable[Servo], *, baud: int | None = None, unsupported: Iterable[Instruction] = (),
        faults: Faults | None = None,
    ) -> None:  # fmt: skip
        """With `baud`, answers take as long as their bytes take on a wire at that rate; else they come at once."""
        self.network = Network(servos, unsupported=unsupported)
        self.faults = faults or Faults()
        self.port = ""
        self.heard = 0
        self._byte_s = _BITS_PER_BYTE / baud if baud else 0.0
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._now = self._free = 0.0

    @classmethod
    def of_robot(
        cls, robot: RobotDescription, *, timed: bool = False, unsupported: Iterable[Instruction] = (),
        faults: Faults | None = None,
    ) -> "VirtualBus":  # fmt: skip
        """The bus of a robot's servo map, every joint at its standing pose; `timed` models the wire at its baud rate.

        Raises:
            InvalidOption: the robot has no servo map.
        """
        servo_map = robot.servos
        if servo_map is None:
            raise InvalidOption("--robot", f"{robot.name} has no Dynamixel servos in its description")
        servos = [
            Servo.make(
                servo_map.ids[joint],
                model=servo_map.model,
                baud=servo_map.baud,
                motor=MotorModel(stall_torque=limits.effort, no_load_speed=limits.velocity),
                position=robot.standing.get(joint, 0.0),
            )
            for joint, limits in robot.joints.items()
            if joint in servo_map.ids
        ]
        return cls(servos, baud=servo_map.baud if timed else None, unsupported=unsupported, faults=faults)

    def servo(self, identity: int) -> Servo:
        """The servo with an id (its table changes while the bus runs: use `locked` for more than one look)."""
        return self.network.servos[identity]

    @property
    def locked(self) -> threading.Lock:
        """Holds the bus still while its servos are looked at or changed."""
        return self._lock

    def start(self) -> str:
        """Open the pseudo terminal, serve it, and return the path of its port."""
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self._now = time.perf_counter()
        self._thread = threading.Thread(target=self._serve, name="virtual-bus", daemon=True)
        self._thread.start()
        return self.port

    def stop(self) -> None:
        """Stop serving and close the terminal; harmless when done twice."""
        if self._thread is None:
            return
        self._stop.set()
        self._thread.join()
        self._thread = None
        os.close(self._master)
        os.close(self._slave)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()

    def _serve(self) -> None:
        with realtime_priority():
            self._serve_packets()

    def _serve_packets(self) -> None:
        reader = PacketReader()
        while not self._stop.is_set():
            readable, _, _ = select.select([self._master], [], [], _IDLE_S)
            data = os.read(self._master, 4096) if readable else b""
            arrived = time.perf_counter()
            with self._lock:
                self._advance()
            for packet in reader.feed(data):
                self._answer(packet, arrived)

    def _advance(self) -> None:
        now = time.perf_counter()
        self.network.advance(now - self._now)
        self._now = now

    def _answer(self, packet: Packet, arrived: float) -> None:
        # The wire carries one byte after the other, whatever the terminal takes at once.
        self._free = max(self._free, arrived) + self._byte_s * len(encode(packet))
        with self._lock:
            if not self.faults.hears():
                return
            self.heard += 1
            replies = self.network.handle(packet)
        if not replies:
            return
        due = self._free + self.faults.wait_s()
        if self._byte_s:
            due += sum(reply.delay_s + self._byte_s * len(reply.data) for reply in replies)
        self._free = due
        data = b"".join(self.faults.distort(reply.data) for reply in replies)
        _sleep_until(due)
        if data:
            os.write(self._master, data)


def _sleep_until(due: float) -> None:
    """Sleep, then spin for the last stretch: a scheduler's wake-up is coarser than a servo's answer."""
    while (remaining := due - time.perf_counter()) > 0:
        if remaining > 2e-4:
            time.sleep(remaining - 2e-4)
