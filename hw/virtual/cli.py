"""Command line of the emulated bus: a port for any Protocol 2.0 program, with faults on demand."""

import sys
import time
from dataclasses import dataclass
from typing import Annotated

import tyro

from hw.virtual.bus import VirtualBus
from hw.virtual.faults import Fault, Faults
from ros_free_stack.console import Command, say
from ros_free_stack.robots import load_robot

_LOOK_S = 0.05


@dataclass(frozen=True, kw_only=True)
class ServosEmulate(Command):
    """Run an emulated bus of a robot's servos on a pseudo terminal until Ctrl-C.

    Examples:
        python launch.py servos emulate --robot op3
        python launch.py servos emulate --fault corrupt:1% --fault lost:1%
        python launch.py servos emulate --fault dead:5s:12 --fault brown-out:400
    """

    robot: str = "op3"
    """Robot whose servos are emulated."""
    powered: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Begin with the board's switch on; else the servos of a robot with one wait for it, as in a robot just started."""
    untimed: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Answer at once instead of after the time that the bytes take on the wire, and at any baud rate."""
    fault: tyro.conf.UseAppendAction[tuple[str, ...]] = ()
    """KIND:WHEN[:ID], may be repeated. KIND is corrupt, lost, noise, latency (of answers), dead, overload, overheating,
    brown-out, reboot or jam (of a servo); WHEN a share of packets (1%), a time since the bus was first heard (2.5s), or
    the number of the goal position (120); ID a servo, all where it is left out."""
    seed: int = 0
    """Seed of the random faults."""

    def run(self) -> int:
        planned = [Fault.parse(text) for text in self.fault]
        robot, faults = load_robot(self.robot), Faults(seed=self.seed)
        with VirtualBus.of_robot(
            robot, timed=not self.untimed, faults=faults, planned=planned, powered=self.powered
        ) as bus:
            self.report({"port": bus.port, "servos": sorted(bus.network.servos)}, bus.port)
            sys.stdout.flush()
            say("emulating; stop with Ctrl-C")
            if bus.network.board is not None and not self.powered:
                name = bus.network.board.settings.name
                say(f"the servos have no power until the {name} gives it: `servos power on`, a stream, or --powered")
            told = 0
            try:
                while True:
                    time.sleep(_LOOK_S)
                    told = _tell(bus, told)
            finally:
                _tell(bus, told)
                servos = bus.network.servos.values()
                goals, outside = sum(len(servo.goals) for servo in servos), sum(servo.goals.outside for servo in servos)
                say(f"{goals} goal positions were written, {outside} of them outside the servos' position limits")


def _tell(bus: VirtualBus, told: int) -> int:
    """Say which faults came true after the first `told`; return how many there are."""
    happened = bus.happened.copy()
    for clock_s, fault in happened[told:]:
        say(f"{clock_s:.2f} s: {fault.kind}" + ("" if fault.id is None else f" of servo {fault.id}"))
    return len(happened)
