#!/usr/bin/env python3
"""Command a humanoid by text: the table of commands and how one is called."""

import importlib
import inspect
import os
import signal
import sys
import traceback
from types import FrameType
from typing import NoReturn

import tyro

from ros_free_stack.console import Command, say
from ros_free_stack.errors import StackError, UnknownName

INTERRUPTED = 130

COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("pipeline.run:Run", "a sentence to human motion, robot trajectory, verdict, pictures, servos"),
    "generate": ("generator.cli:Generate", "a sentence to human motion"),
    "retarget": ("retarget.cli:Retarget", "a human motion to a robot's trajectory"),
    "convert": ("ros_free_stack.formats.cli:Convert", "a motion file to another format"),
    "validate": ("pipeline.validate:Validate", "judge a trajectory in MuJoCo, and repair it on request"),
    "render": ("sim.cli:Render", "draw a trajectory as a video"),
    "play": ("sim.view.play:Play", "show a motion in a window or a browser"),
    "stream": ("pipeline.stream:Stream", "play a validated trajectory on servos, real or virtual"),
    "data build": ("generator.corpus.cli:DataBuild", "make the training corpus"),
    "data show": ("generator.corpus.cli:DataShow", "draw one clip of the corpus"),
    "data coverage": ("generator.corpus.cli:DataCoverage", "what of real captions the corpus can say"),
    "ground": ("generator.grounding.cli:Ground", "where in a motion each part of a sentence happens"),
    "caption": ("generator.grounding.cli:Caption", "the texts that a motion's segments are most like"),
    "train": ("generator.cli:Train", "train a model of the generator"),
    "evaluate": ("generator.evaluation.cli:Evaluate", "measure the generator against real motion"),
    "robots list": ("ros_free_stack.cli:RobotsList", "the robots that are described"),
    "robots show": ("ros_free_stack.cli:RobotsShow", "one robot's joints and limits"),
    "robots add": ("retarget.describe.cli:RobotsAdd", "describe a robot from its MuJoCo model"),
    "servos scan": ("hw.commands.look:ServosScan", "which servos answer on a port"),
    "servos info": ("hw.commands.look:ServosInfo", "what each servo is and how it is set"),
    "servos read": ("hw.commands.look:ServosRead", "position, current, temperature, voltage of each servo"),
    "servos configure": ("hw.commands.setup:ServosConfigure", "set servos up for the robot, changes shown first"),
    "servos calibrate": ("hw.commands.setup:ServosCalibrate", "directions and zeros of a real rig"),
    "servos reboot": ("hw.commands.safety:ServosReboot", "clear hardware errors"),
    "servos release": ("hw.commands.safety:ServosRelease", "torque off"),
    "servos power": ("hw.commands.safety:ServosPower", "give the servos their power, or take it"),
    "servos emulate": ("hw.virtual.cli:ServosEmulate", "an emulated bus for other programs"),
    "servos simulate": ("pipeline.simulate:Simulate", "an emulated bus whose servos move the robot in MuJoCo"),
    "doctor": ("ros_free_stack.cli:Doctor", "what this machine has and lacks"),
}
"""Subcommand to the module and class that does it, and one line of help. A stage is imported when it is asked for."""


def usage(prefix: str = "") -> str:
    """The list of subcommands that begin with `prefix`."""
    rows = [f"  {name:17s} {words}" for name, (_, words) in COMMANDS.items() if name.startswith(prefix)]
    lines = [
        "usage: python launch.py COMMAND [options]      (COMMAND --help shows a command's options)",
        "",
        *rows,
        "",
        'example: python launch.py run "a person waves with the right hand" --robot op3 --servo sim --out out/',
    ]
    return "\n".join(lines)


def find_command(arguments: list[str]) -> tuple[str, list[str]]:
    """The subcommand that the arguments begin with, and the arguments that are left for it."""
    for words in (2, 1):
        name = " ".join(arguments[:words])
        if name in COMMANDS:
            return name, arguments[words:]
    raise UnknownName("command", arguments[0], COMMANDS)


def parse(name: str, arguments: list[str]) -> Command:
    """The subcommand's dataclass, filled from its arguments; imports only the stage that it belongs to."""
    module, class_name = COMMANDS[name][0].split(":")
    command_class: type[Command] = getattr(importlib.import_module(module), class_name)
    return tyro.cli(command_class, args=arguments, prog=f"launch.py {name}", description=inspect.getdoc(command_class))


def main(arguments: list[str]) -> int:
    """Run the command line: 0 done, 2 bad input, 3 infeasible, 4 hardware fault, 5 not as asked, 130 interrupted."""
    if not arguments or arguments[0] in ("-h", "--help"):
        print(usage())
        return 0
    group = f"{arguments[0]} "
    if arguments[1:] in ([], ["-h"], ["--help"]) and any(name.startswith(group) for name in COMMANDS):
        print(usage(prefix=group))
        return 0
    # PyTorch's threads spin while they wait, which makes it many times slower where cores are shared.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    previous = signal.signal(signal.SIGTERM, _terminate)
    try:
        return parse(*find_command(arguments)).run()
    except StackError as error:
        if "--debug" in arguments:
            traceback.print_exc()
        say(f"error: {error}")
        return error.exit_code
    except KeyboardInterrupt:
        say("interrupted")
        return INTERRUPTED
    finally:
        signal.signal(signal.SIGTERM, previous)


def _terminate(_number: int, _frame: FrameType | None) -> NoReturn:
    """SIGTERM unwinds like Ctrl-C, so that servos stop and temporary files go."""
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
