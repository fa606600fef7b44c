"""The `servos simulate` subcommand: the emulated bus of `hw` in front of the physics of `sim`."""

import sys
from dataclasses import dataclass
from pathlib import Path
from time import sleep
from typing import Literal

from ros_free_stack.console import Command, say
from ros_free_stack.robots import load_robot


@dataclass(frozen=True, kw_only=True)
class Simulate(Command):
    """Run an emulated bus whose servos move the whole robot in MuJoCo until Ctrl-C, then write what it did.

    The robot stands, held, until the first servo is switched on.

    Examples:
        python launch.py servos simulate --out simulated.npz
        python launch.py stream out/run/trajectory.npz out/run/verdict.json --servo PORT
        python launch.py render simulated.npz
    """

    robot: str = "op3"
    """Robot by name."""
    mount: Literal["free", "fixed"] = "free"
    """`fixed` for a robot held by its root."""
    out: Path = Path("simulated.npz")
    """Trajectory of the robot, from the moment the first servo was switched on."""

    def run(self) -> int:
        from hw.virtual.bus import VirtualBus
        from ros_free_stack.files import save_trajectory
        from sim.playback.servo_world import ServoWorld

        robot = load_robot(self.robot)
        world = ServoWorld(robot, mount=self.mount)
        bus = VirtualBus.of_robot(robot, timed=True, world=world, powered=False)
        try:
            with bus:
                self.report({"port": bus.port, "out": str(self.out)}, bus.port)
                sys.stdout.flush()
                say("simulating; stop with Ctrl-C")
                while True:
                    sleep(3600)
        finally:
            if world.started:
                done = world.trajectory()
                save_trajectory(self.out, done)
                say(f"{self.out}: {done.duration_s:.1f} s, the root ended {done.root_pos[-1, 2]:.2f} m above the floor")
            else:
                say("no servo was ever switched on: nothing is written")
