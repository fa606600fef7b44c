"""A Dynamixel bus on a pseudo terminal: any Protocol 2.0 program can open its port.

with VirtualBus.of_robot(load_robot("op3")) as bus:
    driver.open(bus.port)
"""

import threading
import time
from collections.abc import Iterable
from types import TracebackType
from typing import Self

from hw.pace import realtime_priority
from hw.protocol import Instruction, Packet, encode
from hw.virtual.board import Board
from hw.virtual.faults import WIRE, Fault, Faults
from hw.virtual.motor import MotorModel
from hw.virtual.network import Network, Reply
from hw.virtual.receiver import Damaged, Receiver
from hw.virtual.servo import Servo
from hw.virtual.terminal import Terminal
from hw.virtual.world import World
from ros_free_stack.errors import InvalidOption
from ros_free_stack.robots import RobotDescription

_TICK_S = 4e-3
_QUIET_S = 0.1
_SPARE_S = 1e-3
"""Wire time in which the servos' own step, some 0.3 ms of computation, surely fits."""
_BITS_PER_BYTE = 10


class VirtualBus:
    """Servos on a pseudo terminal, served by a thread.

    Attributes:
        network: the servos and their answers.
        faults: what goes wrong on the wire.
        happened: faults that came true, each with the time, s of the servos' clocks.
        port: path to open, once started.
        heard: instruction packets so far.
    """

    def __init__(
        self, servos: Iterable[Servo], *, timed: bool = False, unsupported: Iterable[Instruction] = (),
        faults: Faults | None = None, planned: Iterable[Fault] = (), world: World | None = None,
        board: Board | None = None,
    ) -> None:  # fmt: skip
        """A bus; with `timed` the baud rate counts as on a wire.

        Args:
            servos: two with one id speak at once, as on a wire.
            timed: answers take as long as their bytes take at the rate at which the port was opened, and servos that
                are set to another rate do not hear; else they come at once, whatever the rates.
            unsupported: instructions that the firmware does not know.
            faults: what goes wrong on the wire at random.
            planned: faults that are to come.
            world: what the servos move; None lets each turn its own inertia.
            board: what gives the servos their power; None leaves it on.

        Raises:
            InvalidOption: a planned fault is of a servo that there is not.
        """
        self.network = Network(servos, unsupported=unsupported, world=world, board=board)
        self.faults = faults or Faults()
        self.happened: list[tuple[float, Fault]] = []
        self.port = ""
        self.heard = 0
        self._timed = timed
        self._planned: list[Fault] = []
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._now = self._free = self._first_heard = 0.0
        for fault in planned:
            self.plan(fault)

    @classmethod
    def of_robot(
        cls, robot: RobotDescription, *, timed: bool = False, unsupported: Iterable[Instruction] = (),
        faults: Faults | None = None, planned: Iterable[Fault] = (), world: World | None = None, powered: bool = True,
    ) -> "VirtualBus":  # fmt: skip
        """The bus of a robot's servo map, every joint at its standing pose; the rest is as in a new VirtualBus.

        A board that the description names is on it; unless `powered`, its switch is off, as in a robot just started.

        Raises:
            InvalidOption: the robot has no servo map, or a planned fault is of a servo that there is not.
        """
        servo_map = robot.servos
        if servo_map is None:
            raise InvalidOption("--robot", f"{robot.name} has no Dynamixel servos in its description")
        servos = [
            Servo.make(
                servo_map.ids[joint],
                model=servo_map.model_of(joint),
                baud=servo_map.baud,
                motor=MotorModel(stall_torque=limits.effort, no_load_speed=limits.velocity),
                position=robot.standing.get(joint, 0.0),
            )
            for joint, limits in robot.joints.items()
            if joint in servo_map.ids
        ]
        board = None if servo_map.board is None else Board(servo_map.board, servo_map.baud, powered=powered)
        return cls(
            servos,
            timed=timed,
            unsupported=unsupported,
            faults=faults,
            planned=planned,
            world=world,
            board=board,
        )

    def servo(self, identity: int) -> Servo:
        """The servo with an id (its table changes while the bus runs: use `locked` for more than one look)."""
        return self.network.servos[identity]

    def plan(self, fault: Fault) -> None:
        """Let a fault happen when its time comes (one of a share: from now on).

        Raises:
            InvalidOption: there is no servo of its id.
        """
        if fault.id is not None and fault.id not in self.network.servos:
            known = ", ".join(map(str, sorted(self.network.servos)))
            raise InvalidOption("--fault", f"no servo {fault.id}; there are {known}")
        if fault.unit == "share":
            setattr(self.faults, WIRE[fault.kind], fault.when)
        else:
            self._planned.append(fault)

    @property
    def clock_s(self) -> float:
        """The servos' clock, s."""
        return next((servo.clock_s for servo in self.network.servos.values()), 0.0)

    @property
    def locked(self) -> threading.Lock:
        """Holds the bus still while its servos are looked at or changed."""
        return self._lock

    def start(self) -> str:
        """Open the pseudo terminal, serve it, and return the path of its port."""
        self._terminal = Terminal()
        self.port = self._terminal.port
        if self.network.board is not None:
            self.network.board.switch(self.network.all_servos)
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
        self._terminal.close()

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
        receiver, arrived = Receiver(), self._now
        while not self._stop.is_set():
            data = self._terminal.read(max(0.0, self._now + _TICK_S - time.perf_counter()))
            if data:
                arrived = time.perf_counter()
                self._first_heard = self._first_heard or arrived
                for item in receiver.feed(data):
                    self._take(item, arrived)
            elif time.perf_counter() - arrived > _QUIET_S:
                receiver.rest()
            if time.perf_counter() - self._now >= _TICK_S:
                self._advance()

    def _advance(self) -> None:
        """Let the time pass that has passed. Not before each answer: the sensors of a servo too have their own pace."""
        now = time.perf_counter()
        with self._lock:
            self.network.advance(now - self._now)
            self._happen(now)
        self._now = now

    def _happen(self, now: float) -> None:
        """Let the faults happen that are due."""
        heard_s = now - self._first_heard if self._first_heard else -1.0
        servos = self.network.servos
        for fault in [fault for fault in self._planned if fault.due(servos, heard_s)]:
            self._planned.remove(fault)
            fault.happen(servos, self.faults)
            self.happened.append((self.clock_s, fault))

    def _take(self, item: Packet | Damaged, arrived: float) -> None:
        """Answer one packet, after the time that a wire takes: one byte after the other."""
        byte_s = self._byte_s()
        self._free = max(self._free, arrived) + byte_s * (len(encode(item)) if isinstance(item, Packet) else 0)
        for heard in self._distorted(item):
            with self._lock:
                self.heard += 1
                answer = self.network.complain(heard.id) if isinstance(heard, Damaged) else self.network.handle(heard)
                self._happen(arrived)
            self._send(answer, byte_s)

    def _distorted(self, item: Packet | Damaged) -> list[Packet | Damaged]:
        """What the servos hear of a packet."""
        if isinstance(item, Damaged) or not (self.faults.drop_instruction or self.faults.corrupt_instruction):
            return [item]
        return Receiver().feed(self.faults.heard(encode(item)))

    def _send(self, replies: list[Reply], byte_s: float) -> None:
        if not replies:
            return
        due = self._free + self.faults.wait_s()
        if self._timed:
            due += sum(reply.delay_s + byte_s * len(reply.data) for reply in replies)
        self._free = due
        data = b"".join(self.faults.distort(reply.data) for reply in replies)
        now = time.perf_counter()
        if due - now > _SPARE_S and now - self._now > _TICK_S / 2:
            self._advance()  # while the wire is busy: after the answer it would keep the next instruction waiting
        _sleep_until(due)
        if data:
            self._terminal.write(data)

    def _byte_s(self) -> float:
        """Time of one byte, s; also tells the servos at which rate the host speaks."""
        if not self._timed:
            return 0.0
        self.network.rate = rate = self._terminal.rate
        return _BITS_PER_BYTE / max(rate, 1)


def _sleep_until(due: float) -> None:
    """Sleep, then spin for the last stretch: a scheduler's wake-up is coarser than a servo's answer."""
    while (remaining := due - time.perf_counter()) > 0:
        if remaining > 2e-4:
            time.sleep(remaining - 2e-4)
