"""The `robots` and `doctor` subcommands: what is described, and what this machine has."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from ros_free_stack.console import Command, print_table
from ros_free_stack.robots import RobotDescription, load_robot, robot_files

LIMBS = {"legs": "left_knee", "arms": "left_elbow", "head": "head"}
"""What a robot has, by a human joint that shows it."""


@dataclass(frozen=True, kw_only=True)
class RobotsList(Command):
    """List the robots that are described, here and in your own folder (RFS_ROBOTS, or `robots` where one works).

    Example: python launch.py robots list
    """

    menagerie: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """List the robots of MuJoCo Menagerie instead, which `robots add menagerie:NAME` describes."""

    def run(self) -> int:
        if self.menagerie:
            from ros_free_stack.menagerie import menagerie_names

            names = menagerie_names()
            self.report({"menagerie": list(names)}, *names)
            return 0
        rows = [_row(name, path) for name, path in robot_files().items()]
        if self.json:
            self.report({"robots": rows})
        else:
            heads = ("name", "title", "joints", "limbs", "mount", "servos", "described in")
            print_table(heads, [[str(row[key]) for key in row] for row in rows])
        return 0


@dataclass(frozen=True, kw_only=True)
class RobotsShow(Command):
    """Show one robot: joints with their limits and servos, where the limits come from, and what stops the servos.

    Example: python launch.py robots show op3
    """

    robot: Annotated[str, tyro.conf.Positional]
    """Robot by name, or its description (.yaml)."""

    def run(self) -> int:
        robot = load_robot(self.robot)
        result: dict[str, Any] = {
            "name": robot.name,
            "title": robot.title,
            "description": str(robot.path),
            "model": str(robot.model_path),
            "sha256": robot.sha256,
            "mount": robot.mount,
            "limits_source": robot.limits_source.strip(),
            "attachments": {joint: item.body for joint, item in robot.attachments.items()},
            "soles": {foot: sole.body for foot, sole in robot.soles.items()},
            "locked": robot.locked,
            "joints": {name: _joint(robot, name) for name in robot.joints},
        }
        if robot.servos is not None:
            settings, safety = asdict(robot.servos.settings), asdict(robot.servos.safety)
            result |= {"baud": robot.servos.baud, "cycle_s": robot.servos.cycle_s}
            result |= {"servo_settings": settings, "servo_safety": safety}
            result |= {"servo_board": asdict(robot.servos.board) if robot.servos.board else None}
        if self.json:
            self.report(result)
        else:
            self._print(robot)
        return 0

    def _print(self, robot: RobotDescription) -> None:
        print(f"{robot.title}: {robot.model_path.name}, mount {robot.mount}, sha256 {robot.sha256[:12]}")
        print(robot.limits_source.strip())
        servo = robot.servos is not None
        heads = ("joint", "range, rad", "rad/s", "rad/s2", "N m", *(("servo",) if servo else ()))
        print_table(heads, [_cells(robot, name) for name in robot.joints])
        print("human joints: " + ", ".join(f"{joint} {item.body}" for joint, item in robot.attachments.items()))
        print("soles: " + (", ".join(f"{foot} {sole.body}" for foot, sole in robot.soles.items()) or "none"))
        if robot.locked:
            print(f"locked joints: {_items(robot.locked)}")
        if robot.servos is not None:
            print(f"servos at {robot.servos.baud} baud, one cycle in {1e3 * robot.servos.cycle_s:g} ms")
            print(f"servo settings: {_items(asdict(robot.servos.settings))}")
            print(f"servo safety: {_items(asdict(robot.servos.safety))}")
            if robot.servos.board is not None:
                print(f"servo board: {_items(asdict(robot.servos.board))}")


def _row(name: str, path: Path) -> dict[str, Any]:
    robot = load_robot(name)
    return {
        "name": name,
        "title": robot.title,
        "joints": len(robot.joints),
        "limbs": " ".join(limb for limb, joint in LIMBS.items() if joint in robot.attachments),
        "mount": robot.mount,
        "servos": robot.servos.model if robot.servos else "-",
        "described_in": "here" if path.is_relative_to(Path(__file__).parent) else str(path),
    }


def _joint(robot: RobotDescription, name: str) -> dict[str, Any]:
    limits, servos = robot.joints[name], robot.servos
    return {
        "range_rad": [limits.lower, limits.upper],
        "velocity_rad_s": limits.velocity,
        "acceleration_rad_s2": limits.acceleration,
        "effort_n_m": limits.effort,
        "servo_id": servos.ids.get(name) if servos else None,
        "servo_model": servos.model_of(name) if servos and name in servos.ids else None,
    }


def _cells(robot: RobotDescription, name: str) -> list[str]:
    limits, servos = robot.joints[name], robot.servos
    cells = [name, f"{limits.lower:.3f} to {limits.upper:.3f}", f"{limits.velocity:g}", f"{limits.acceleration:g}"]
    cells.append(f"{limits.effort:g}")
    if servos is not None:
        cells.append(f"servo {servos.ids[name]}, {servos.model_of(name)}" if name in servos.ids else "-")
    return cells


def _items(values: dict[str, Any]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items() if value is not None)


@dataclass(frozen=True, kw_only=True)
class Doctor(Command):
    """Say what this machine has for each part of the stack, and how to get what it lacks.

    Example: python launch.py doctor
    """

    def run(self) -> int:
        from ros_free_stack.doctor import print_findings

        return print_findings(as_json=self.json)
