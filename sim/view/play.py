"""The `play` subcommand."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from ros_free_stack.console import say
from ros_free_stack.formats.cli import ReadsMotionOrRobot
from ros_free_stack.interrupts import caught_interrupts

if TYPE_CHECKING:
    from ros_free_stack.messages import HumanMotion, RobotTrajectory


@dataclass(frozen=True, kw_only=True)
class Play(ReadsMotionOrRobot):
    """Show a motion: a robot's trajectory or human motion, in a window where there is a display, else in a browser.

    Play, pause, scrub, change the speed; contacts, ZMP and joints at their limits are marked. Ctrl-C ends it.

    Examples:
        python launch.py play out/run/trajectory.npz --motion out/run/human_motion.npz
        python launch.py play out/run/trajectory.npz --physics
        python launch.py play dance1_subject1.csv --robot g1 --quaternion xyzw
        python launch.py play walk1_subject1.bvh --port 9000
    """

    source: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """File to show: .npz, .npy, .bvh, .amc, .txt (DeepMimic), .pkl (GMR, PHC) or .csv."""
    motion: Path | None = None
    """Human motion (.npz) to show beside a robot's trajectory."""
    physics: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Show what the robot does in physics, with what it should do as a ghost."""
    where: Literal["auto", "window", "browser"] = "auto"
    """`window` is MuJoCo's own and shows robots only; `auto` takes it where there is a display."""
    port: int = 8080
    """Port of the browser's page on 127.0.0.1; 0 takes any that is free."""

    def run(self) -> int:
        """Show the file until Ctrl-C."""
        from ros_free_stack.errors import InvalidOption
        from ros_free_stack.formats.registry import load
        from ros_free_stack.messages import HumanMotion

        found = load(self.source, self.source_options(), self.format)
        for note in found.notes:
            say(note)
        if isinstance(found.content, HumanMotion):
            for option, given in (("--physics", self.physics), ("--motion", self.motion)):
                if given:
                    raise InvalidOption(option, f"{self.source} holds human motion, not a robot's trajectory")
            return self._human(found.content)
        return self._robot(found.content)

    def _human(self, motion: "HumanMotion") -> int:
        from ros_free_stack.errors import InvalidOption
        from sim.draw.playback_frames import segment_at
        from sim.view.browser import human_viewer

        if self.where == "window":
            raise InvalidOption("--where", "a window shows robots only; a human motion goes to the browser")
        texts = tuple(segment_at(motion, frame / motion.fps) for frame in range(len(motion.joints)))
        title = motion.prompt or self.source.name
        viewer = human_viewer(motion.joints, motion.fps, texts, title, port=self.port)
        return self._serve(viewer.address, viewer.run)

    def _robot(self, trajectory: "RobotTrajectory") -> int:
        from ros_free_stack.errors import InvalidOption
        from ros_free_stack.files import load_motion
        from ros_free_stack.robots import load_robot
        from sim.draw.appearance import visual_model
        from sim.draw.playback_frames import make_film
        from sim.judge.verdict import judge
        from sim.reference import check_belongs
        from sim.view.browser import check_port, robot_viewer
        from sim.view.window import has_display, play_in_window

        if self.where == "window" and not has_display():
            raise InvalidOption("--where", "there is no display for a window; `browser` needs none")
        if self.where == "browser" or not has_display():
            check_port(self.port)  # before the work, not after it
        robot = load_robot(trajectory.robot)
        check_belongs(trajectory, robot)
        motion = None if self.motion is None else load_motion(self.motion)
        judgement = judge(trajectory, robot) if self.physics else None
        model = visual_model(robot)
        film = make_film(trajectory, robot, model, fps=trajectory.fps, judgement=judgement, motion=motion)
        if self.where != "browser" and has_display():
            try:
                return self._serve("a window", lambda until: play_in_window(film, model, robot, until))
            except RuntimeError as error:
                say(f"no window: {error}")
        viewer = robot_viewer(film, model, robot, port=self.port)
        return self._serve(viewer.address, viewer.run)

    def _serve(self, address: str, run: Callable[[Callable[[], bool]], None]) -> int:
        """Say where to look, and show until Ctrl-C or the window's end."""
        self.report({"address": address}, address)
        sys.stdout.flush()
        say("showing; stop with Ctrl-C")
        # An exception while a lock of the window or of the server is taken would leave it locked: nothing would close.
        with caught_interrupts() as interrupts:
            run(lambda: interrupts.pending)
            if interrupts.pending:
                say("stopped")
        return 0
