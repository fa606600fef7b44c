"""The fault matrix: what the driver does about every fault of the emulated bus, at the start, in the middle and at the
end of a stream, in how many milliseconds, and how the servos end.

    python benchmarks/bus_faults.py             print the matrix
    python benchmarks/bus_faults.py --write     and put it into docs/hardware.md, between its markers
    python benchmarks/bus_faults.py --lossy 10  stream for 10 minutes with 1 % of all packets corrupted and 1 % lost
"""

import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from hw.cycle import Reading
from hw.driver import Driver
from hw.gate import DRIVEN
from hw.goals import goals_of
from hw.protocol import BROADCAST, Packet
from hw.rig import Rig
from hw.stream import stream
from hw.virtual.bus import VirtualBus
from hw.virtual.faults import KINDS, WIRE, Fault, Faults
from hw.virtual.memory import WATCHDOG_TRIPPED
from hw.virtual.network import Network, Reply
from hw.virtual.servo import Servo
from ros_free_stack.errors import HardwareFault
from ros_free_stack.files import save_trajectory, save_verdict, write_text
from ros_free_stack.messages import Floats, RobotTrajectory, Verdict
from ros_free_stack.robots import ServoSafety, load_robot
from ros_free_stack.servo_path import servo_path
from sim.judge.verdict import judge

ROOT = Path(__file__).parents[1]
DOCUMENT = ROOT / "docs" / "hardware.md"
BEGIN, END = "<!-- fault matrix: begin -->", "<!-- fault matrix: end -->"

OP3 = load_robot("op3")
assert OP3.servos is not None
ROBOT = replace(OP3, servos=replace(OP3.servos, board=None))
"""On a bench supply: OP3's board would take the power where a servo does not let go, hiding how the others ended."""
RIG = Rig.of_robot(ROBOT)
JOINT, VICTIM = "r_el", 5
PHASES = ("start", "mid-stream", "end")
STREAM = "import sys, tyro; from hw.cli import Stream; sys.exit(tyro.cli(Stream).run())"


def swing(seconds: float) -> RobotTrajectory:
    """The right elbow swings by 0.6 rad, once in 1.25 s."""
    times = np.arange(round(seconds * 50)) / 50
    joints = np.tile(ROBOT.standing_pos, (len(times), 1))
    joints[:, ROBOT.joint_names.index(JOINT)] -= 0.3 * (1 - np.cos(1.6 * np.pi * times))
    return RobotTrajectory(
        robot=ROBOT.name,
        model_sha256=ROBOT.sha256,
        joint_names=ROBOT.joint_names,
        fps=50,
        root_pos=np.zeros((len(times), 3)),
        root_quat=np.tile([1.0, 0, 0, 0], (len(times), 1)),
        joint_pos=joints,
        contacts=np.ones((len(times), 2), dtype=bool),
        foot_names=ROBOT.foot_names,
    )


def judged(trajectory: RobotTrajectory) -> Verdict:
    """The verdict on a robot that hangs from a stand."""
    return judge(trajectory, ROBOT, mount="fixed", controller=DRIVEN).verdict


@dataclass(frozen=True)
class Row:
    """One line of the matrix.

    Attributes:
        fault, phase: what happened, and when.
        reaction: what the driver did, in its own words.
        stopped_ms: from the fault to the last servo's torque off (None where the stream ended as if nothing had been).
        ended: how the servos were left.
        sound: every servo ended as the policy says (off), or by its own watchdog.
        outside: goals beyond the joints' or the servos' own limits, of all that were written.
        goals: how many were written.
    """

    fault: str
    phase: str
    reaction: str
    stopped_ms: float | None
    ended: str
    sound: bool
    outside: int
    goals: int

    def cells(self) -> tuple[str, ...]:
        """For a table."""
        stopped = "-" if self.stopped_ms is None else f"{self.stopped_ms:.0f}"
        return self.fault, self.phase, self.reaction, stopped, self.ended, f"{self.outside} of {self.goals}"


def outside(servos: dict[int, Servo]) -> int:
    """Goals that lay outside the joint's range or the servo's own position limits, of all that were ever written."""
    ends = np.sort(RIG.to_raw(np.stack([RIG.lower, RIG.upper])), axis=0)
    return sum(
        max(servos[identity].goals.outside, servos[identity].goals.beyond(low - 1, high + 1))
        for identity, low, high in zip(RIG.ids, *ends.tolist(), strict=True)
    )


def endings(servos: dict[int, Servo]) -> tuple[str, bool]:
    """How the servos were left, and whether none was left with its torque on and its watchdog waiting."""
    counts = {"torque off": 0, "stopped by the watchdog": 0, "holding": 0}
    for servo in servos.values():
        tripped = servo.get("Bus Watchdog") == WATCHDOG_TRIPPED
        counts["torque off" if not servo.torque_on else "stopped by the watchdog" if tripped else "holding"] += 1
    return ", ".join(f"{count} {words}" for words, count in counts.items() if count), not counts["holding"]


def play(bus: VirtualBus, trajectory: RobotTrajectory, safety: ServoSafety) -> tuple[str, int]:
    """Stream; return what the driver did, and its number of cycles (0 where it stopped early)."""
    try:
        report = stream(trajectory, judged(trajectory), ROBOT, port=bus.port, safety=safety, mount="fixed")
    except HardwareFault as fault:
        return f"{type(fault).__name__}: {fault}", 0
    lost = f", {report.lost_replies} readings lost and asked for again" if report.lost_replies else ""
    return f"streams on{lost}", report.cycles


def run(fault: Fault | None, phase: str, safety: ServoSafety) -> tuple[Row, int]:
    """One stream with one fault; also the number of cycles of a stream without."""
    trajectory = swing(2.5)
    planned = [] if fault is None else [fault]
    # A late answer is later than the driver waits for one.
    with VirtualBus.of_robot(ROBOT, timed=True, faults=Faults(spike_s=0.05), planned=planned) as bus:
        reaction, cycles = play(bus, trajectory, safety)
        servos = bus.network.servos
        if any(servo.dead for servo in servos.values()):
            time.sleep(safety.watchdog_s + 0.1)
        with bus.locked:
            happened = bus.happened[0][0] if bus.happened else None
            last_off = max(
                (t for s in servos.values() for t, on in s.torque_changes if not on and not s.dead), default=0
            )
            name = "none" if fault is None else fault.kind
            stopped = None if cycles or happened is None else 1e3 * (last_off - happened)
            if fault is not None and happened is None:
                reaction = f"it never happened; {reaction}"
            goals = sum(len(servo.goals) for servo in servos.values())
            return Row(name, phase, reaction, stopped, *endings(servos), outside(servos), goals), cycles


def matrix(safety: ServoSafety) -> Iterator[Row]:
    """Every fault in every phase, after a stream without any."""
    row, cycles = run(None, "-", safety)
    if not cycles:
        raise SystemExit(f"a stream without faults does not work here: {row.reaction}")
    yield row
    # The first goal of a servo is where it stands, before its torque is on; while it holds at the end, goals go on.
    at = {"start": 2, "mid-stream": cycles // 2, "end": cycles + 4}
    for kind in KINDS:
        for phase in PHASES:
            fault = Fault(kind, at[phase], "goals", None if kind in WIRE else VICTIM)
            yield run(fault, phase, safety)[0]


@contextmanager
def host(bus: VirtualBus, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A process that streams to the bus for long, and moves it already."""
    trajectory = swing(60)
    save_trajectory(folder / "trajectory.npz", trajectory)
    save_verdict(folder / "verdict.json", judged(trajectory))
    files = [str(folder / "trajectory.npz"), str(folder / "verdict.json"), "--servo", bus.port, "--mount", "fixed"]
    with subprocess.Popen([sys.executable, "-c", STREAM, *files], cwd=ROOT, stderr=subprocess.DEVNULL) as process:
        while len(bus.servo(VICTIM).goals) < 150:
            if process.poll() is not None:
                raise SystemExit("the streaming process ended by itself")
            time.sleep(0.01)
        yield process


def killed(safety: ServoSafety) -> Row:
    """The host process dies by `kill -9` in the middle of a stream."""
    with VirtualBus.of_robot(ROBOT, timed=True) as bus, tempfile.TemporaryDirectory() as folder:
        with host(bus, Path(folder)) as process:
            process.send_signal(signal.SIGKILL)
            process.wait()
        dead_s, servos = bus.clock_s, list(bus.network.servos.values())
        while any(servo.get("Bus Watchdog") != WATCHDOG_TRIPPED for servo in servos):
            if bus.clock_s - dead_s > 10 * safety.watchdog_s:
                break
            time.sleep(1e-3)
        stopped_ms = 1e3 * (bus.clock_s - dead_s)
        time.sleep(0.3)
        with bus.locked:
            still = not any(servo.get("Moving") for servo in servos)
            ended, sound = endings(bus.network.servos)
            period = f"nothing; watchdogs of {1e3 * safety.watchdog_s:.0f} ms"
            ended, sound = f"{ended}, {'none moves' if still else 'still moving'}", sound and still
            goals = sum(len(servo.goals) for servo in servos)
            out = outside(bus.network.servos)
            return Row("kill -9 of the host", "mid-stream", period, stopped_ms, ended, sound, out, goals)


class Truth:
    """Remembers where the servos were at each of the last reads, to tell a damaged reading from a true one."""

    def __init__(self, network: Network) -> None:
        self._servos = [network.servos[identity] for identity in RIG.ids]
        self._handle, network.handle = network.handle, self.handle
        self._told: deque[list[int]] = deque(maxlen=8)
        self.accepted = self.wrong = 0

    def handle(self, packet: Packet) -> list[Reply]:
        """As the network's own."""
        if packet.id == BROADCAST:
            self._told.append([servo.get("Present Position") for servo in self._servos])
        return self._handle(packet)

    def compare(self, time_s: float, late_s: float, goal: Floats, reading: Reading) -> None:
        """Judge a reading: every position in it must be one that the servo really told."""
        raw = RIG.to_raw(np.clip(reading.position, RIG.lower, RIG.upper))
        told = np.array(self._told)
        known = (np.abs(told - raw) <= 1).any(axis=0)
        self.accepted += int(reading.fresh.sum())
        self.wrong += int((reading.fresh & ~known).sum())


def lossy(minutes: float, safety: ServoSafety) -> dict[str, float | int | str]:
    """Stream with 1 % of all packets corrupted and 1 % lost, in both directions."""
    faults = Faults(drop=0.01, corrupt=0.01, drop_instruction=0.01, corrupt_instruction=0.01)
    trajectory = swing(2.5)
    goals = goals_of(servo_path(trajectory, ROBOT), RIG)
    rig = replace(RIG, safety=safety)
    ended, cycles = "torque off", 0
    with VirtualBus.of_robot(ROBOT, timed=True) as bus:
        truth = Truth(bus.network)
        start = time.monotonic()
        try:
            with Driver(rig, bus.port) as driver:
                driver.enable()
                driver.move_to(goals[0])
                bus.faults = faults
                while time.monotonic() - start < 60 * minutes:
                    driver.follow(goals, truth.compare)
                    cycles += len(goals)
                lost = driver.watch.lost_replies
        except HardwareFault as fault:
            ended, lost = f"{type(fault).__name__}: {fault}", -1
        servos = bus.network.servos
        return {
            "minutes": (time.monotonic() - start) / 60,
            "cycles": cycles,
            "readings accepted": truth.accepted,
            "wrong readings accepted": truth.wrong,
            "readings lost and asked for again": lost,
            "goals written": sum(len(servo.goals) for servo in servos.values()),
            "goals outside limits": outside(servos),
            "ended": ended,
            "servos": endings(servos)[0],
        }


def as_table(rows: list[Row]) -> str:
    """Markdown."""
    head = (
        "fault",
        "when",
        "what the driver did",
        "ms until torque off",
        "how the servos ended",
        "goals out of limits",
    )
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row.cells()) + " |" for row in rows])


def write(text: str) -> None:
    """Put the matrix between its markers in the document."""
    document = DOCUMENT.read_text(encoding="utf-8")
    pattern = re.compile(f"{re.escape(BEGIN)}.*?{re.escape(END)}", re.DOTALL)
    if not pattern.search(document):
        raise SystemExit(f"{DOCUMENT} has no line {BEGIN!r}")
    write_text(DOCUMENT, pattern.sub(lambda _: f"{BEGIN}\n{text}\n{END}", document))


def main(
    write_document: Annotated[bool, tyro.conf.arg(name="write"), tyro.conf.FlagCreatePairsOff] = False,
    lossy_minutes: Annotated[float | None, tyro.conf.arg(name="lossy")] = None,
) -> None:
    """The fault matrix of the servo driver.

    Args:
        write_document: put the matrix into docs/hardware.md.
        lossy_minutes: instead, stream for so long on a bus that loses and corrupts packets.
    """
    assert ROBOT.servos is not None
    safety = ROBOT.servos.safety
    if lossy_minutes is not None:
        for name, value in lossy(lossy_minutes, safety).items():
            print(f"{name}: {value:.2f}" if isinstance(value, float) else f"{name}: {value}")
        return
    rows: list[Row] = []
    for row in matrix(safety):
        rows.append(row)
        print(" | ".join(row.cells()), flush=True)
    rows.append(killed(safety))
    print(" | ".join(rows[-1].cells()))
    if write_document:
        write(as_table(rows))
    unsound = [f"{row.fault}, {row.phase}" for row in rows if row.outside or not row.sound]
    if unsound:
        raise SystemExit(f"NOT SOUND: {'; '.join(unsound)}")
    print("every servo ended off or by its watchdog, and no goal was ever out of limits")


if __name__ == "__main__":
    tyro.cli(main)
