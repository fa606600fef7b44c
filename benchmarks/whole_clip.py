"""What solving whole clips and keeping the balance gains: the same motions by both solvers, measured from the output.

python benchmarks/whole_clip.py --dataset data/corpus --cmu cmu_mocap --clips 10 --out out/whole_clip

Jerk is the root mean square of the joints' third differences; error the mean distance of followed points and feet from
their targets; scrape the speed over the floor of sole corners that are lower than 1 mm in two frames; overlap how deep
the description's limbs are in each other; excess by how much joints leave their ranges, speeds and accelerations. The
change is how far points and feet are moved for the balance, on average. Times are of this process alone. Where mink is
installed (the extra `bench`), it follows the same targets frame by frame, with speed limits and standing feet as
equalities (`mink_peer.py`).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from time import process_time

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import tyro
from mink_peer import Mink
from online import quality, targets_of

from retarget.pipeline import Retargeter, SolverName
from ros_free_stack.console import progress, say
from ros_free_stack.errors import MissingDependency
from ros_free_stack.files import atomic_path, make_folder, write_text
from ros_free_stack.messages import Floats, HumanMotion, RobotTrajectory
from ros_free_stack.robots import RobotDescription, load_robot
from ros_free_stack.skeleton import FPS

TAKES = ("walk", "run", "jump", "dance", "box", "climb", "basketball", "sit")
"""Words of the CMU takes: the first take of each."""
TAKE_S = 6.0
LOW_M = 0.001
COLUMNS = ("jerk rad/s3", "error cm", "scrape mm/s", "most cm/s", "depth mm", "overlap mm", "excess", "ms/frame")


@dataclass(frozen=True)
class Arguments:
    """Measure both solvers, with and without balance, and write a table and pictures."""

    dataset: Path | None = None
    """Folder of a motion data set: authored clips of its test split."""
    cmu: Path | None = None
    """Folder of CMU takes."""
    clips: int = 10
    """How many authored clips, none of them the mirror image of another one."""
    solvers: tuple[SolverName, ...] = ("frames", "clip")
    """Solvers."""
    robots: tuple[str, ...] = ("op3", "g1")
    """Robots by name."""
    physics: bool = False
    """Also play the balanced trajectories in physics."""
    out: Path = Path("out/whole_clip")
    """Folder for table.md and a picture of every motion."""


@dataclass(frozen=True)
class Body:
    """What a body does: `corners` (N, F, 4, 3) of soles, `points` (N, P, 3), `depth` (N,) of limbs in each other."""

    corners: Floats
    points: Floats
    depth: Floats


def motions(arguments: Arguments) -> Iterator[tuple[str, HumanMotion]]:
    """Name and motion, authored ones first."""
    if arguments.dataset:
        from generator.datasets.authored import AuthoredCorpus
        from ros_free_stack.formats.features import decode

        dataset = AuthoredCorpus.open(arguments.dataset)
        authored = (clip for clip in dataset.split("test") if clip.source == "authored")
        for clip in islice(authored, 0, 2 * arguments.clips, 2):  # neighbours are a motion and its mirror image
            name = ", then ".join(segment.text for segment in clip.segments)
            yield name, HumanMotion(decode(dataset.features(clip).astype(float)), FPS)
    if arguments.cmu:
        from ros_free_stack.formats import cmu

        takes = cmu.index(arguments.cmu)
        for word in TAKES:
            take = next((take for take in takes if word in take.description), None)
            if take:
                joints = cmu.read_take(arguments.cmu, take.name)[: round(TAKE_S * FPS)]
                yield f"{take.name} {take.description}", HumanMotion(joints, FPS)


def body(robot: RobotDescription, trajectory: RobotTrajectory) -> Body:
    """Kinematics by MuJoCo."""
    from retarget.body.collision import Collision
    from retarget.body.geometry import measure

    geometry = measure(robot)
    model, data, collision = geometry.model, mujoco.MjData(geometry.model), Collision(geometry)
    corners, points, depth = [], [], []
    for k, joints in enumerate(trajectory.joint_pos):
        data.qpos[:3], data.qpos[3:7] = trajectory.root_pos[k], trajectory.root_quat[k]
        data.qpos[geometry.qpos_index] = joints
        mujoco.mj_kinematics(model, data)
        turns = data.xmat.reshape(-1, 3, 3)
        corners.append([data.xpos[foot.body] + foot.corners @ turns[foot.body].T for foot in geometry.feet])
        points.append(
            [data.xpos[body] + turns[body] @ geometry.offsets[name] for name, body in geometry.bodies.items()]
            + [corner.mean(axis=0) for corner in corners[-1]]
        )
        depth.append(-collision.distances(data.qpos).min(initial=np.inf))
    return Body(np.array(corners), np.array(points), np.array(depth))


def excess(robot: RobotDescription, trajectory: RobotTrajectory) -> float:
    """By how much joints exceed a limit, in rad, rad/s and rad/s^2, whichever is most; 0 where none does."""
    joints, fps = trajectory.joint_pos, trajectory.fps
    over = (
        np.maximum(robot.lower - joints, joints - robot.upper),
        np.abs(np.diff(joints, axis=0)) * fps - robot.velocity,
        np.abs(np.diff(joints, n=2, axis=0)) * fps**2 - robot.acceleration,
    )
    return max(0.0, *(float(values.max()) for values in over))


def scrape(corners: Floats, fps: float) -> tuple[float, float]:
    """Mean and largest speed in m/s over the floor of corners that lie on it."""
    low = (corners[1:, ..., 2] < LOW_M) & (corners[:-1, ..., 2] < LOW_M)
    speed = np.linalg.norm(np.diff(corners[..., :2], axis=0), axis=-1)[low] * fps
    return (float(speed.mean()), float(speed.max())) if len(speed) else (0.0, 0.0)


def figures(
    robot: RobotDescription, trajectory: RobotTrajectory, kinematics: Body, error: float, s: float
) -> list[float]:
    """The values of `COLUMNS`; `error` in cm, `s` seconds of solving."""
    joints, fps = trajectory.joint_pos, trajectory.fps
    mean, most = scrape(kinematics.corners, fps)
    return [
        float(np.sqrt((np.diff(joints, n=3, axis=0) ** 2).mean())) * fps**3,
        error,
        1000 * mean,
        100 * most,
        -1000 * float(kinematics.corners[..., 2].min()),
        1000 * float(kinematics.depth.max()),
        excess(robot, trajectory),
        1000 * s / len(joints),
    ]


class Peer:
    """mink on the targets of a robot's clips, or nothing where it is not installed."""

    def __init__(self, robot: RobotDescription) -> None:
        from retarget.body.geometry import measure
        from retarget.solve.frame_solver import FrameSolver

        self._robot, self._geometry = robot, measure(robot)
        self._solver = FrameSolver(self._geometry)
        try:
            self._mink = Mink(self._geometry)
        except MissingDependency as missing:
            say(f"no rows of mink: {missing}")
            self._mink = None

    def row(self, motion: HumanMotion, fps: float) -> list[float] | None:
        """What it makes of a motion."""
        if self._mink is None:
            return None
        targets = targets_of(motion, self._geometry, fps)
        self._solver.start(targets.goal(0))
        qpos, seconds = self._mink.equalities(targets, self._solver.qpos)
        trajectory = RobotTrajectory(
            robot=self._robot.name,
            model_sha256=self._robot.sha256,
            joint_names=self._robot.joint_names,
            fps=fps,
            root_pos=qpos[:, :3],
            root_quat=qpos[:, 3:7] / np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True),
            joint_pos=qpos[:, self._geometry.qpos_index],
            contacts=targets.contacts,
            foot_names=self._robot.foot_names,
        )
        error = quality(self._geometry, targets, qpos).error_cm
        return figures(self._robot, trajectory, body(self._robot, trajectory), error, float(seconds.sum()))


def draw(path: Path, title: str, robot: RobotDescription, found: dict[str, tuple[RobotTrajectory, Body]]) -> None:
    """Jerk, the joint that comes nearest to its limits, and the feet, of the solvers."""
    figure, axes = plt.subplots(4, 1, figsize=(10, 10), sharex=True, layout="constrained")
    for colour, (solver, (trajectory, kinematics)) in zip(("tab:blue", "tab:orange"), found.items(), strict=False):
        joints, fps = trajectory.joint_pos, trajectory.fps
        time = np.arange(len(joints)) / fps
        speed = np.abs(np.diff(joints, axis=0)) * fps / robot.velocity
        acceleration = np.abs(np.diff(joints, n=2, axis=0)) * fps**2 / robot.acceleration
        axes[0].plot(
            time[3:],
            np.sqrt((np.diff(joints, n=3, axis=0) ** 2).mean(axis=1)) * fps**3,
            color=colour,
            lw=1,
            label=solver,
        )
        axes[1].plot(time[1:], speed.max(axis=1), color=colour, lw=1, label=f"{solver}, speed")
        axes[1].plot(time[2:], acceleration.max(axis=1), color=colour, lw=1, ls=":", label=f"{solver}, acceleration")
        corners = kinematics.corners
        axes[2].plot(time, 1000 * corners[:, :, :, 2].min(axis=2), color=colour, lw=1)
        low = (corners[1:, ..., 2] < LOW_M) & (corners[:-1, ..., 2] < LOW_M)
        sliding = np.linalg.norm(np.diff(corners[..., :2], axis=0), axis=-1) * fps * low
        axes[3].plot(time[1:], 100 * sliding.max(axis=(1, 2)), color=colour, lw=1, label=solver)
    axes[0].set(ylabel="jerk, rad/s$^3$", yscale="log", title=title[:90])
    axes[1].set(ylabel="most used joint,\nshare of its limit")
    axes[2].set(ylabel="lowest corner of\neach sole, mm")
    axes[3].set(ylabel="fastest corner\non the floor, cm/s", xlabel="s")
    for axis in (axes[0], axes[1], axes[3]):
        axis.legend(fontsize=8, loc="upper right")
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=80, format="png")
    plt.close(figure)


def main(arguments: Arguments) -> None:
    """Fill the tables motion by motion."""
    from sim.judge.verdict import judge

    make_folder(arguments.out)
    clips = list(motions(arguments))
    lines = [f"| robot | solver | {' | '.join(COLUMNS)} |", "|---|---|" + "---|" * len(COLUMNS)]
    balance = [
        "| robot | solver | clips | ZMP inside before | after | of the time before | after | farthest out before cm |"
        " after | change cm | pass |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name in arguments.robots:
        robot = load_robot(name)
        retargeters = {solver: Retargeter(robot, solver) for solver in arguments.solvers}
        peer = Peer(robot)
        rows: dict[str, list[list[float]]] = {solver: [] for solver in retargeters}
        kept: dict[str, list[tuple[float, ...]]] = {solver: [] for solver in retargeters}
        for number, (words, motion) in enumerate(progress(clips, name)):
            drawn: dict[str, tuple[RobotTrajectory, Body]] = {}
            for solver, retargeter in retargeters.items():
                started = process_time()
                plain = retargeter.retarget(motion, balance=False)
                spent = process_time() - started
                balanced = retargeter.retarget(motion)
                trajectory, kinematics = plain.trajectory, body(robot, plain.trajectory)
                drawn[solver] = trajectory, kinematics
                error = float(np.mean([error.mean for error in plain.report.position_error_cm.values()]))
                rows[solver].append(figures(robot, trajectory, kinematics, error, spent))
                outside, share = balanced.report.zmp_outside_cm, balanced.report.zmp_outside_share
                assert outside is not None and share is not None
                moved = np.linalg.norm(body(robot, balanced.trajectory).points - kinematics.points, axis=-1).mean()
                passed = arguments.physics and judge(balanced.trajectory, robot).passed
                kept[solver].append(
                    (
                        *(float(share[when] == 0) for when in ("before", "after")),
                        *(1 - share[when] for when in ("before", "after")),
                        *(outside[when].max for when in ("before", "after")),
                        100 * float(moved),
                        float(passed),
                    )
                )
                say(f"{name} {solver:6s} {words[:40]:40s} " + " ".join(f"{value:.3g}" for value in rows[solver][-1]))
                say(f"{'':{len(name) + 8}s}{'balanced':40s} " + " ".join(f"{value:.3g}" for value in kept[solver][-1]))
            peers = peer.row(motion, 50.0)
            if peers is not None:
                rows.setdefault("mink", []).append(peers)
                say(f"{name} mink   {words[:40]:40s} " + " ".join(f"{value:.3g}" for value in peers))
            draw(arguments.out / f"{name}-{number:02d}.png", f"{name}: {words}", robot, drawn)
        for solver, found in rows.items():
            typical = np.median(found, axis=0)
            typical[3:7] = np.max(found, axis=0)[3:7]
            lines.append(f"| {name} | {solver} | " + " | ".join(f"{value:.3g}" for value in typical) + " |")
        if rows.keys() >= {"mink", "clip"}:
            theirs, ours = (np.array(rows[solver])[:, [0, -1]] for solver in ("mink", "clip"))
            less, faster = np.median(theirs / ours, axis=0)
            lines.append(f"\n{name}: mink over clip, medians of ratios: jerk {less:.2f}, time {faster:.2f}.\n")
        for solver in retargeters:
            *inside, worst, least, change, passed = np.array(kept[solver]).T
            shares = " | ".join(
                f"{values.mean():.{digits}%}" for values, digits in zip(inside, (0, 0, 1, 2), strict=True)
            )
            played = f"{int(passed.sum())}" if arguments.physics else "not played"
            balance.append(
                f"| {name} | {solver} | {len(clips)} | {shares} | {worst.max():.1f} | {least.max():.1f} |"
                f" {change.mean():.2f} | {played} |"
            )
    table = "\n".join([*lines, "", *balance]) + "\n"
    write_text(arguments.out / "table.md", table)
    print(table)


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
