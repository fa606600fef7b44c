"""The online solver against mink on the same targets: time, error, limits, skate, jerk; cuts and the first frame.

python benchmarks/online.py --cmu cmu_mocap --robots op3 g1    # needs the extra `bench`

Every motion becomes targets once, and the followers (`mink_peer` has mink's) take turns with it, `--rounds` times.
Times are the processor's, so that other programs do not count, and medians over frames; ratios those of one round's
medians, their median over rounds and motions. What a follower gives is measured with MuJoCo and finite differences:
error, the mean distance of followed points and soles to their targets; excess over range (rad), speed (rad/s) and
acceleration (rad/s^2); skate, the mean speed over the floor of soles that should stand; depth, the lowest sole corner;
jerk, the mean of the joints' third differences.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import thread_time
from typing import Final

import mujoco
import numpy as np
import tyro
from corpus import performance
from mink_peer import Mink

from retarget.body.geometry import RobotGeometry, measure
from retarget.clip.human import align
from retarget.plan.pace import walking_pace
from retarget.plan.stride import leg_speed, stride_share
from retarget.plan.targets import Targets, make_targets
from retarget.plan.timeline import plan_timeline
from retarget.solve.frame_solver import FrameSolver
from ros_free_stack.console import progress
from ros_free_stack.formats import cmu
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.robot_model import sole_corners
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import FPS

CMU: Final = {
    "walk": ("07_01", "08_05"),
    "run": ("09_01", "02_03"),
    "jump": ("13_40", "13_19"),
    "dance": ("05_02", "05_13"),
    "box": ("13_18", "02_05"),
    "climb": ("13_35", "14_33"),
    "basketball": ("06_02", "06_14"),
    "sit": ("14_29", "14_31"),
}
AUTHORED: Final = ("wave", "squat", "walk", "turn", "kick", "dance", "reach", "jump")
CUT: Final = 50
COLD: Final = """
from time import process_time
import sys
import numpy as np
from retarget.solve.online import OnlineRetargeter
from ros_free_stack.robots import load_robot
OnlineRetargeter(load_robot(sys.argv[1])).step(np.load(sys.argv[2]), 0.0)
print(process_time())
"""


@dataclass(frozen=True)
class Arguments:
    """Compare on captured takes and on authored motions."""

    cmu: Path | None = None
    """Folder of the captured takes; without it authored motions only."""
    robots: tuple[str, ...] = ("op3", "g1")
    """Robots by name."""
    seconds: float = 8.0
    """Of each motion."""
    rounds: int = 2
    """Turns of every follower with every motion."""
    fps: float = 50.0
    """Frame rate of the robots."""


@dataclass(frozen=True)
class Quality:
    """What a follower made of a motion; see the head of this file for the units."""

    error_cm: float
    over_range: float
    over_speed: float
    over_acceleration: float
    skate_cm_s: float
    depth_cm: float
    jerk: float


Follower = Callable[[Targets, Floats], tuple[Floats, Floats]]
"""Targets and a first configuration (nq,) to configurations (N, nq) and seconds (N,)."""


def motions(arguments: Arguments) -> Iterator[tuple[str, HumanMotion]]:
    """Named human motions."""
    most = round(arguments.seconds * FPS)
    for name in AUTHORED:
        yield f"authored {name}", HumanMotion(performance(name, 0).joints[:most], FPS)
    if arguments.cmu is not None:
        for kind, takes in CMU.items():
            for take in takes:
                joints = cmu.read_take(arguments.cmu, take)
                first, last = max(cmu.sound_spans(joints), key=lambda span: span[1] - span[0])
                yield f"{kind} {take}", HumanMotion(joints[first:last][:most], FPS)


def targets_of(motion: HumanMotion, geometry: RobotGeometry, fps: float) -> Targets:
    """What the robot should do, as the `retarget` command plans it."""
    clip = align(motion)
    stride = stride_share(clip, geometry)
    scale = stride * geometry.hip_height / clip.leg_length
    pace = walking_pace(clip, geometry.hip_height, leg_speed=leg_speed(geometry), scale=scale)
    return make_targets(clip, geometry, plan_timeline(pace, fps), stride)


def own(solver: FrameSolver) -> Follower:
    """This project's frame solver."""

    def follow(targets: Targets, first: Floats) -> tuple[Floats, Floats]:
        qpos, seconds = np.tile(first, (len(targets), 1)), np.zeros(len(targets))
        for k in range(len(targets)):
            started = thread_time()
            if k:
                solver.step(targets.goal(k), targets.fps)
            else:
                solver.start(targets.goal(k))
            seconds[k], qpos[k] = thread_time() - started, solver.qpos
        return qpos, seconds

    return follow


def quality(geometry: RobotGeometry, targets: Targets, qpos: Floats) -> Quality:
    """Judge configurations by MuJoCo's kinematics and finite differences."""
    model, robot, fps = geometry.model, geometry.robot, targets.fps
    data, count = mujoco.MjData(model), len(qpos)
    points = np.zeros((count, len(geometry.followed), 3))
    soles = np.zeros((count, len(geometry.feet), 4, 3))
    for k in range(count):
        data.qpos[:] = qpos[k]
        mujoco.mj_kinematics(model, data)
        for i, name in enumerate(geometry.followed):
            body = geometry.bodies[name]
            points[k, i] = data.xpos[body] + data.xmat[body].reshape(3, 3) @ geometry.offsets[name]
        soles[k] = list(sole_corners(model, data, robot).values())
    centres = soles.mean(axis=2)
    away = [np.linalg.norm(points - targets.points, axis=-1), np.linalg.norm(centres - targets.soles, axis=-1)]
    joints = qpos[:, geometry.qpos_index]
    speed, acceleration, jerk = (np.diff(joints, n=n, axis=0) * fps**n for n in (1, 2, 3))
    slide = np.linalg.norm(np.diff(centres[..., :2], axis=0), axis=-1) * fps
    stand = targets.contacts[1:] & targets.contacts[:-1]
    return Quality(
        error_cm=100 * float(np.concatenate(away, axis=1).mean()),
        over_range=max(float(np.maximum(robot.lower - joints, joints - robot.upper).max()), 0.0),
        over_speed=max(float((np.abs(speed) - robot.velocity).max()), 0.0),
        over_acceleration=max(float((np.abs(acceleration) - robot.acceleration).max()), 0.0),
        skate_cm_s=100 * float(slide[stand].mean()) if stand.any() else 0.0,
        depth_cm=100 * max(-float(soles[..., 2].min()), 0.0),
        jerk=float(np.abs(jerk).mean()),
    )


def cuts(solver: FrameSolver, targets: Targets, whole: Floats) -> Floats:
    """(C, 2) mean distance in cm of the followed points to the uninterrupted run's, for every 50th start frame: there,
    and a second later."""
    geometry = solver.geometry
    data, found = mujoco.MjData(geometry.model), list[list[float]]()

    def places(qpos: Floats) -> Floats:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(geometry.model, data)
        bodies = [geometry.bodies[name] for name in geometry.followed]
        offsets = np.array([geometry.offsets[name] for name in geometry.followed])
        return data.xpos[bodies] + np.einsum("pij,pj->pi", data.xmat[bodies].reshape(-1, 3, 3), offsets)

    later = round(targets.fps)
    for first in range(CUT, len(targets) - later, CUT):
        solver.start(targets.goal(first))
        apart = [places(solver.qpos) - places(whole[first])]
        for k in range(first + 1, first + later + 1):
            solver.step(targets.goal(k), targets.fps)
        apart.append(places(solver.qpos) - places(whole[first + later]))
        found.append([100 * float(np.linalg.norm(item, axis=1).mean()) for item in apart])
    return np.array(found).reshape(-1, 2)


def cold_start(robot: str, joints: Floats, folder: Path) -> float:
    """Processor seconds of a fresh process up to the first configuration, code compiled before."""
    path = folder / "first.npy"
    np.save(path, joints)
    seconds = [
        float(subprocess.run([sys.executable, "-c", COLD, robot, str(path)], capture_output=True, check=True).stdout)
        for _ in range(3)
    ]
    return float(np.median(seconds))


def compare(robot: str, arguments: Arguments) -> None:
    """Print the tables of one robot."""
    geometry = measure(load_robot(robot))
    solver, mink = FrameSolver(geometry), Mink(geometry)
    followers: dict[str, Follower] = {
        "this": own(solver), "mink, limits and equalities": mink.equalities,
        "mink, this solver's limits": mink.bounded, "mink, GMR loop": mink.loop,
    }  # fmt: skip
    found: dict[str, list[Quality]] = {name: [] for name in followers}
    times: dict[str, list[float]] = {name: [] for name in followers}
    apart: list[Floats] = []
    print(f"\n## {geometry.robot.title}\n")
    head("motion", "frames", "follower", "ms a frame", "error cm", "jerk")
    chosen = list(motions(arguments))
    for title, motion in progress(chosen, robot):
        targets = targets_of(motion, geometry, arguments.fps)
        solver.start(targets.goal(0))
        first = solver.qpos.copy()
        medians: dict[str, list[float]] = {name: [] for name in followers}
        qpos: dict[str, Floats] = {}
        for _ in range(arguments.rounds):
            for name, follow in followers.items():
                qpos[name], seconds = follow(targets, first)
                medians[name].append(1e3 * float(np.median(seconds[1:])))
        for name in followers:
            found[name].append(item := quality(geometry, targets, qpos[name]))
            times[name] += medians[name]
            row(
                title, len(targets), name, f"{np.median(medians[name]):.3f}", f"{item.error_cm:.2f}", f"{item.jerk:.0f}"
            )
        apart.append(cuts(solver, targets, qpos["this"]))
    print()
    over = ("over_range", "over_speed", "over_acceleration")
    head("follower", "ms a frame", "ratio", "error cm", "skate cm/s", "jerk", "depth cm", *over)
    for name, items in found.items():
        ratio = float(np.median(np.array(times[name]) / np.array(times["this"])))
        means = [np.mean([getattr(item, key) for item in items]) for key in ("error_cm", "skate_cm_s", "jerk")]
        worst = [max(getattr(item, key) for item in items) for key in ("depth_cm", *over)]
        row(
            name,
            f"{np.median(times[name]):.3f}",
            f"{ratio:.1f}",
            *(f"{v:.2f}" for v in means),
            *(f"{v:.1e}" for v in worst),
        )
    cut = np.concatenate(apart)
    near = (cut < 1.0).mean(axis=0)
    with tempfile.TemporaryDirectory() as folder:
        cold = cold_start(robot, chosen[0][1].joints[0], Path(folder))
    print(
        f"\n{len(cut)} cuts, one at every {CUT}th frame: within 1 cm of the uninterrupted run {near[0]:.0%} at once, "
        f"{near[1]:.0%} after 1 s (median {np.median(cut[:, 0]):.2f} and {np.median(cut[:, 1]):.2f} cm).\n"
        f"Fresh process to the first configuration: {cold:.2f} s of the processor."
    )


def head(*names: str) -> None:
    """The head of a table."""
    row(*names)
    row(*["---"] * len(names))


def row(*values: object) -> None:
    """One row of a table."""
    print(f"| {' | '.join(str(value) for value in values)} |")


def main(arguments: Arguments) -> None:
    """Print the tables of all robots."""
    for robot in arguments.robots:
        compare(robot, arguments)


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
