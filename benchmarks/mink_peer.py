"""mink (Zakka 2024) on this project's targets, in three ways, for comparison.

Costs, footholds and the first configuration are those of the frame solver. `equalities` takes three steps a frame with
joint ranges, speed limits and standing feet as equalities; `bounded` does so within the frame solver's own bounds of
range, speed and acceleration, which mink lacks. `loop` is that of General Motion Retargeting (Ze et al.
2025, `motion_retarget.py`): two tables of tasks, one after the other, each with one step and up to ten more until the
error falls by less than 1e-3; weights of 100 for the pelvis, damping of 0.5, Levenberg-Marquardt damping of 1, DAQP,
ranges and no speed limits. It has fewer tasks here than there (no orientations of limbs, no hips and shoulders), and so
is quicker than the original.
"""

from importlib import import_module
from time import thread_time
from typing import Any, Final

import casadi as ca
import numpy as np

from retarget.body.compiled import BufferedFunction
from retarget.body.geometry import RobotGeometry
from retarget.plan.targets import Targets
from retarget.solve.frame_problem import DAMPING, POINT_WEIGHTS, ROTATION_WEIGHTS, STANCE_WEIGHTS, SWING_WEIGHTS
from retarget.solve.limits import JointBounds, reach
from ros_free_stack.errors import MissingDependency
from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import robot_spec

STEPS: Final = 3
GMR_STEPS: Final = 10
GMR_STALL: Final = 1e-3
GMR_DAMPING: Final = 0.5
GMR_PELVIS: Final = 100.0
"""Cost of the pelvis' position; the others in the proportions of the frame solver's."""
GMR_LIMBS: Final = 0.1
"""Share of their cost that limbs have in the first table."""


class Reach:
    """A limit for mink: the frame solver's bounds of a frame's step (nv,), for the shorter steps that make it up."""

    def __init__(self, constraint: Any, geometry: RobotGeometry, fps: float) -> None:
        """`constraint` is mink's class of G and h."""
        size = geometry.model.nv
        symbols = [ca.SX.sym(name, size, columns) for name, columns in (("position", 1), ("last", 1), ("table", 4))]
        function = ca.Function("reach", symbols, reach(*symbols), ["position", "last", "table"], ["low", "high"])
        self._function, self._constraint, self._geometry = BufferedFunction(function), constraint, geometry
        self._function.inputs["table"][:] = JointBounds.tangent(geometry, fps).table
        self._rows = np.vstack([np.eye(size), -np.eye(size)])
        self.done = np.zeros(size)

    def begin(self, qpos: Floats) -> None:
        """Begin a frame at (nq,) after the one that is done."""
        inputs, geometry = self._function.inputs, self._geometry
        inputs["last"][:, 0], inputs["position"][geometry.dof_index, 0] = self.done, qpos[geometry.qpos_index]
        self._function()
        self.done = np.zeros_like(self.done)

    def compute_qp_inequalities(self, configuration: Any, dt: float) -> Any:
        """What is left of the frame's bounds."""
        del configuration, dt
        low, high = (self._function.outputs[name][:, 0] for name in ("low", "high"))
        return self._constraint(G=self._rows, h=np.hstack([high - self.done, self.done - low]))


class Mink:
    """mink's tasks for one robot: a site at every followed point, sole and body."""

    def __init__(self, geometry: RobotGeometry) -> None:
        try:
            self.mink: Any = import_module("mink")
        except ImportError:
            raise MissingDependency("mink", "pip install 'ros-free-stack[bench]'") from None
        mink = self.mink
        self.geometry = geometry
        spec = robot_spec(geometry.robot, meshes=False)
        place: dict[str, tuple[int, Floats]] = {
            name: (geometry.bodies[name], geometry.offsets[name]) for name in geometry.followed
        }
        place |= {f"{name}_frame": (body, np.zeros(3)) for name, body in geometry.frames.items()}
        place |= {f"{foot.name}_sole": (foot.body, foot.centre) for foot in geometry.feet}
        for name, (body, offset) in place.items():
            spec.body(geometry.model.body(body).name).add_site(name=f"target_{name}", pos=offset)
        self.model = spec.compile()
        leg = geometry.limb_length
        kinds = {name: name.removeprefix("left_").removeprefix("right_") for name in geometry.followed}
        self.tasks = [self._task(name, POINT_WEIGHTS.get(kind, 1.0) / leg, 0.0) for name, kind in kinds.items()]
        self.tasks += [self._task(f"{name}_frame", 0.0, ROTATION_WEIGHTS.get(name, 1.0)) for name in geometry.frames]
        soles = [
            (f"{foot.name}_sole", weights) for foot in geometry.feet for weights in (SWING_WEIGHTS, STANCE_WEIGHTS)
        ]
        every = [self._task(name, position / leg, rotation) for name, (position, rotation) in soles]
        self.swings, self.stances = every[::2], every[1::2]
        self.holds = [self._task(f"{foot.name}_sole", 1.0, 1.0) for foot in geometry.feet]
        gain = GMR_PELVIS / (POINT_WEIGHTS["pelvis"] / leg)
        self.tables = [self._table(kinds, gain, limbs) for limbs in (GMR_LIMBS, 1.0)]
        self.ranges = mink.ConfigurationLimit(self.model)
        robot = geometry.robot
        self.speeds = mink.VelocityLimit(self.model, dict(zip(robot.joint_names, robot.velocity[:, None], strict=True)))

    def _task(self, name: str, position: float, rotation: float, lm_damping: float = 0.0) -> Any:
        return self.mink.FrameTask(
            f"target_{name}", "site", position_cost=position, orientation_cost=rotation, lm_damping=lm_damping
        )

    def _table(self, kinds: dict[str, str], gain: float, limbs: float) -> list[Any]:
        """Tasks of all points, bodies and soles; those of limbs at a share of their costs."""
        geometry, per_leg = self.geometry, gain / self.geometry.limb_length
        points = [
            self._task(name, POINT_WEIGHTS.get(kind, 1.0) * per_leg * (1.0 if kind == "pelvis" else limbs), 0.0, 1.0)
            for name, kind in kinds.items()
        ]
        bodies = [
            self._task(f"{name}_frame", 0.0, gain * ROTATION_WEIGHTS.get(name, 1.0), 1.0) for name in geometry.frames
        ]
        position, rotation = SWING_WEIGHTS
        soles = [self._task(f"{foot.name}_sole", position * per_leg, gain * rotation, 1.0) for foot in geometry.feet]
        return [*points, *bodies, *soles]

    def aim(self, targets: Targets, k: int) -> None:
        """Set the tasks' targets to those of a frame."""
        self._aim([*self.tasks, *self.swings], targets, k)
        for i, task in enumerate(self.stances):
            self._set(task, targets.soles[k, i], targets.sole_rotations[k, i])

    def _aim(self, tasks: list[Any], targets: Targets, k: int) -> None:
        """The same of tasks of all points, bodies and soles, in this order."""
        points, bodies = targets.points.shape[1], targets.rotations.shape[1]
        for i, task in enumerate(tasks):
            if i < points:
                self._set(task, targets.points[k, i], np.eye(3))
            elif i < points + bodies:
                self._set(task, np.zeros(3), targets.rotations[k, i - points])
            else:
                foot = i - points - bodies
                self._set(task, targets.soles[k, foot], targets.sole_rotations[k, foot])

    def _set(self, task: Any, place: Floats, rotation: Floats) -> None:
        turn = self.mink.SO3.from_matrix(rotation)
        task.set_target(self.mink.SE3.from_rotation_and_translation(turn, place))

    def equalities(self, targets: Targets, first: Floats) -> tuple[Floats, Floats]:
        """Three steps a frame, with speed limits; feet that stand are held where they touched down."""
        return self._held(targets, first, None)

    def bounded(self, targets: Targets, first: Floats) -> tuple[Floats, Floats]:
        """The same within the frame solver's bounds."""
        return self._held(targets, first, Reach(self.mink.Constraint, self.geometry, targets.fps))

    def _held(self, targets: Targets, first: Floats, bounds: Reach | None) -> tuple[Floats, Floats]:
        solve, missing = self.mink.solve_ik, self.mink.NoSolutionFound
        configuration = self.mink.Configuration(self.model, first)
        qpos, seconds = np.zeros((len(targets), self.model.nq)), np.zeros(len(targets))
        pause = 1 / targets.fps / STEPS
        for k in range(len(targets)):
            started = thread_time()
            self.aim(targets, k)
            if bounds is not None:
                bounds.begin(configuration.q)
            held = targets.contacts[k] & targets.contacts[k - 1] if k else np.zeros(len(self.holds), dtype=bool)
            soles = [(self.stances if stands else self.swings)[i] for i, stands in enumerate(targets.contacts[k])]
            constraints = [self.holds[i] for i in np.flatnonzero(held)]
            limits = [self.ranges, self.speeds] if bounds is None else [bounds]
            for _ in range(STEPS):
                options: dict[str, Any] = {"limits": limits, "constraints": constraints}
                try:
                    velocity = solve(configuration, [*self.tasks, *soles], pause, "daqp", DAMPING, **options)
                except missing:
                    options["constraints"] = []
                    velocity = solve(configuration, [*self.tasks, *soles], pause, "daqp", DAMPING, **options)
                configuration.integrate_inplace(velocity, pause)
                if bounds is not None:
                    bounds.done += velocity * pause
            for i in np.flatnonzero(targets.contacts[k] & ~held):
                task = self.holds[i]
                task.set_target(configuration.get_transform_frame_to_world(task.frame_name, "site"))
            seconds[k], qpos[k] = thread_time() - started, configuration.q
        return qpos, seconds

    def loop(self, targets: Targets, first: Floats) -> tuple[Floats, Floats]:
        """Pelvis, trunk and feet before the limbs, then everything, each until the error stalls; ranges alone."""
        configuration = self.mink.Configuration(self.model, first)
        qpos, seconds = np.zeros((len(targets), self.model.nq)), np.zeros(len(targets))
        for k in range(len(targets)):
            started = thread_time()
            for tasks in self.tables:
                self._aim(tasks, targets, k)
                self._until_stalled(configuration, tasks)
            seconds[k], qpos[k] = thread_time() - started, configuration.q
        return qpos, seconds

    def _until_stalled(self, configuration: Any, tasks: list[Any]) -> None:
        pause = self.model.opt.timestep

        def error() -> float:
            return float(np.linalg.norm(np.concatenate([task.compute_error(configuration) for task in tasks])))

        last = error()
        for _ in range(1 + GMR_STEPS):
            velocity = self.mink.solve_ik(configuration, tasks, pause, "daqp", GMR_DAMPING, limits=[self.ranges])
            configuration.integrate_inplace(velocity, pause)
            now = error()
            if last - now <= GMR_STALL:
                break
            last = now
