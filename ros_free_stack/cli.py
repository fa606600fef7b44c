"""The `robots` and `doctor` subcommands: what is described, and what this machine has."""

from dataclasses import asdict, dataclass
from typing import Annotated, Any

import tyro

from ros_free_stack.console import Command
from ros_free_stack.robots import ServoMap, load_robot, robot_names


@dataclass(frozen=True, kw_only=True)
class RobotsList(Command):
    """List the robots that are described.

    Example: python launch.py robots list
    """

    def run(self) -> int:
        robots = [load_robot(name) for name in robot_names()]
        result = [
            {"name": r.name, "title": r.title, "joints": len(r.joints), "servos": r.servos.model if r.servos else None}
            for r in robots
        ]
        lines = (f"{r['name']:6s} {r['title']:16s} {r['joints']} joints, servos: {r['servos'] or '-'}" for r in result)
        self.report({"robots": result}, *lines)
        return 0


@dataclass(frozen=True, kw_only=True)
class RobotsShow(Command):
    """Show one robot: joints with their limits and servos, where the limits come from, and what stops the servos.

    Example: python launch.py robots show op3
    """

    robot: Annotated[str, tyro.conf.Positional]
    """Name of the robot."""

    def run(self) -> int:
        robot = load_robot(self.robot)
        joints = {
            name: {
                "range_rad": [limits.lower, limits.upper],
                "velocity_rad_s": limits.velocity,
                "acceleration_rad_s2": limits.acceleration,
                "effort_n_m": limits.effort,
                "servo_id": robot.servos.ids.get(name) if robot.servos else None,
                "servo_model": robot.servos.model_of(name) if robot.servos and name in robot.servos.ids else None,
            }
            for name, limits in robot.joints.items()
        }
        lines = [f"{robot.title}: {robot.model_path.name}, sha256 {robot.sha256[:12]}", robot.limits_source.strip()]
        lines += [
            f"{name:28s} {limits.lower:7.3f} to {limits.upper:6.3f} rad  {limits.velocity:5.2f} rad/s  "
            f"{limits.effort:5.1f} N m{_servo(robot.servos, name)}"
            for name, limits in robot.joints.items()
        ]
        result: dict[str, Any] = {"name": robot.name, "title": robot.title, "sha256": robot.sha256, "joints": joints}
        if robot.servos is not None:
            settings, safety = asdict(robot.servos.settings), asdict(robot.servos.safety)
            result |= {"baud": robot.servos.baud, "cycle_s": robot.servos.cycle_s}
            result |= {"servo_settings": settings, "servo_safety": safety}
            lines += [f"servos at {robot.servos.baud} baud, one cycle in {1e3 * robot.servos.cycle_s:g} ms"]
            lines += [f"servo settings: {_items(settings)}", f"servo safety: {_items(safety)}"]
        self.report(result, *lines)
        return 0


def _servo(servos: ServoMap | None, joint: str) -> str:
    if servos is None or joint not in servos.ids:
        return ""
    return f"  servo {servos.ids[joint]:3d}, {servos.model_of(joint)}"


def _items(values: dict[str, Any]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items() if value is not None)


@dataclass(frozen=True, kw_only=True)
class Doctor(Command):
    """Say what this machine has for each part of the stack, and how to get what it lacks.

    Example: python launch.py doctor
    """

    def run(self) -> int:
        from ros_free_stack.doctor import examine

        findings = examine()
        lines = (f"{'ok  ' if f.ok else 'none'}  {f.name:12s} {f.detail}" for f in findings)
        self.report({f.name: {"ok": f.ok, "detail": f.detail} for f in findings}, *lines)
        return 0 if all(finding.ok or finding.optional for finding in findings) else 2
