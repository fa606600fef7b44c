"""Retargeting of a stream: one human frame in, one robot configuration out, without a look ahead.

What a whole clip tells is found on the way. The first frame gives the person's size, heading and place. Feet that
stand correct the floor, the height of the ankle and the pitch of a flat foot. Contacts have hysteresis in one direction
of time. A foot that lands keeps the foothold above which it was detected, and follows the human again within `FADE_S`
after it has left.
"""

from dataclasses import dataclass, field

import numpy as np

from retarget.body.geometry import RobotGeometry, measure
from retarget.clip import human as hm
from retarget.clip.human import ContactThresholds, HumanClip, joint, yaw_rotation
from retarget.plan.footsteps import CLEARANCE_M, SWING_PITCH
from retarget.plan.held import held_targets
from retarget.plan.targets import TRACKING_ERROR_SHARE, Goal, body_targets, foot_targets, reach_deficit
from retarget.plan.timeline import Timeline, minimum_jerk
from retarget.solve.frame_solver import FrameSolver
from ros_free_stack.errors import InvalidMessage, InvalidOption
from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import JOINT_COUNT

STANCE_S = 0.5
"""Time constant with which standing feet correct the floor and their own rest."""
LOWERING_S = 0.1
"""Time constant with which the body comes down to what the legs can reach."""
FADE_S = 0.15
"""Time from a foot that has left its foothold to one that follows the human."""
LIFTED_M = 0.05
"""Height of the human's ankle above its rest at which a swing has its full clearance and its share of the pitch."""
FIRST_FPS = 20.0
"""Frame rate that is assumed until a second frame tells it."""


@dataclass(frozen=True)
class Configuration:
    """The robot at one moment.

    Attributes:
        time_s: s, as given.
        root_pos: (3,) m; root_quat: (4,) wxyz.
        joint_pos: (J,) rad, in the description's order.
        contacts: (F,) whether each foot stands where it was planted.
        tracking_errors: m to the target of every limb that cannot follow.
        limited: the joints at a limit of range, speed or acceleration.
    """

    time_s: float
    root_pos: Floats
    root_quat: Floats
    joint_pos: Floats
    contacts: Bools
    tracking_errors: dict[str, float]
    limited: tuple[str, ...]


@dataclass
class _Foot:
    """A robot foot on its way: where it stands, and since when and how far from the human it swings."""

    stands: bool = False
    place: Floats = field(default_factory=lambda: np.zeros(3))
    yaw: float = 0.0
    away: Floats = field(default_factory=lambda: np.zeros(4))
    lifted_s: float = 0.0


class OnlineRetargeter:
    """Follows a stream of human joint positions with one robot."""

    def __init__(
        self,
        robot: RobotDescription,
        *,
        stride: float = 1.0,
        thresholds: ContactThresholds | None = None,
        machine_code: bool = True,
    ) -> None:
        """Measure the robot and build its solver.

        Args:
            robot: the robot.
            stride: share of the human's travel over the floor, at the robot's size.
            thresholds: when a foot stands.
            machine_code: compile the solver; False stays in the CasADi virtual machine.

        Raises:
            InvalidOption: `stride` is not a positive number.
            UnsupportedModel: the robot's model lacks something that retargeting needs.
        """
        if not (np.isfinite(stride) and stride > 0):
            raise InvalidOption("stride", f"expected a positive number, found {stride}")
        self.geometry: RobotGeometry = measure(robot)
        self._solver = FrameSolver(self.geometry, machine_code=machine_code)
        self._stride, self._thresholds = stride, thresholds or ContactThresholds()
        self.reset()

    def reset(self) -> None:
        """Begin a new stream: the next frame is a first one."""
        self._time: float | None = None

    def step(self, joints: Floats, time_s: float) -> Configuration:
        """The configuration for the next human frame.

        Args:
            joints: (22, 3) m, z up.
            time_s: of the frame, s; later than the last one.

        Raises:
            InvalidMessage: `joints` has another shape or is not finite.
            InvalidOption: `time_s` is not later than the last frame's.
        """
        joints = _checked(joints)
        if not np.isfinite(time_s) or (self._time is not None and time_s <= self._time):
            raise InvalidOption("time_s", f"expected a number above {self._time}, found {time_s}")
        if self._time is None:
            self._calibrate(joints)
            elapsed = 1 / FIRST_FPS
        else:
            elapsed = time_s - self._time
        clip = self._clip(joints, elapsed)
        goal = self._held_goal(clip) if self.geometry.held else self._goal(clip, elapsed)
        outputs = self._solver.start(goal) if self._time is None else self._solver.step(goal, 1 / elapsed)
        self._time, self._last = time_s, clip.joints[0]
        return self._configuration(time_s, goal, outputs)

    def _calibrate(self, joints: Floats) -> None:
        """Size, heading, place and floor of the person in a first frame (22, 3)."""
        frame = joints[None]
        hips = (joint(frame, "left_hip")[0] + joint(frame, "right_hip")[0]) / 2
        self._turn = yaw_rotation(-hm.heading(frame))[0]
        low = min(hm.SIDES, key=lambda side: float(joint(frame, f"{side}_foot")[0, 2]))
        self._origin = np.array([hips[0], hips[1], joint(frame, f"{low}_foot")[0, 2]])
        aligned = (joints - self._origin) @ self._turn.T
        self._ankle_rest = float(np.clip(joint(aligned[None], f"{low}_ankle")[0, 2], 0.02, 0.15))
        _, pitch = hm.foot_angles(aligned[None], low, 0.0)
        self._pitch_rest = float(pitch[0])
        self._leg = HumanClip(aligned[None], FIRST_FPS, 0.0, 0.0, np.zeros((1, 2), dtype=bool)).leg_length
        self._last, self._lowered = aligned, 0.0
        self._stands = np.zeros(2, dtype=bool)
        self._feet = [_Foot() for _ in self.geometry.feet]

    def _clip(self, joints: Floats, elapsed: float) -> HumanClip:
        """The frame on its own, aligned, with the feet that stand."""
        joints = (joints - self._origin) @ self._turn.T
        moved, frame = np.linalg.norm(joints - self._last, axis=1) / elapsed, joints[None]
        for i, side in enumerate(hm.SIDES):
            toe, ankle = hm.foot_heights(frame, side, self._ankle_rest)
            start, hold = self._thresholds.stands(toe, ankle, joint(moved[None, :, None], f"{side}_foot")[:, 0])
            self._stands[i] = hold[0] and (self._stands[i] or start[0])
            if self._stands[i]:
                share = -np.expm1(-elapsed / STANCE_S)
                _, pitch = hm.foot_angles(frame, side, self._pitch_rest)
                self._origin[2] += share * float(toe[0])
                self._ankle_rest += share * float(ankle[0] - toe[0])
                self._pitch_rest += share * float(pitch[0])
        return HumanClip(frame, 1 / elapsed, self._ankle_rest, self._pitch_rest, self._stands[None].copy())

    def _goal(self, clip: HumanClip, elapsed: float) -> Goal:
        geometry, joints = self.geometry, clip.joints
        scale = geometry.hip_height / self._leg
        travel = np.array([*[self._stride * scale] * 2, scale])
        points, rotations = body_targets(clip, geometry, joints, travel)
        soles, turns, deficit = [], [], 0.0
        for i, (ankle, yaw, pitch) in enumerate(foot_targets(clip, geometry, joints, travel)):
            stands = bool(clip.contacts[0, hm.SIDES.index(geometry.feet[i].side)])
            place, turn = self._place(i, stands, np.array([*ankle[0], yaw[0]]), float(pitch[0]), scale, elapsed)
            foot = geometry.feet[i]
            soles.append(place + turn @ (foot.reference @ (foot.centre - foot.ankle)))
            turns.append(turn @ foot.reference)
            if stands:
                deficit = max(deficit, float(reach_deficit(geometry, points, i, place[None], turn[None])[0]))
        self._lowered += -np.expm1(-elapsed / LOWERING_S) * (deficit - self._lowered)
        return Goal(
            points=points[0] - [0.0, 0.0, self._lowered],
            rotations=np.stack(
                [rotations[0, k] @ reference for k, reference in enumerate(geometry.references.values())]
            ),
            soles=np.array(soles).reshape(-1, 3),
            sole_rotations=np.array(turns).reshape(-1, 3, 3),
            contacts=np.array([foot.stands for foot in self._feet], dtype=bool),
            following=1.0,
        )

    def _place(
        self, i: int, stands: bool, wanted: Floats, pitch: float, scale: float, elapsed: float
    ) -> tuple[Floats, Floats]:
        """Ankle (3,) and orientation (3, 3) of foot `i` for the scaled human's ankle and yaw `wanted` (4,)."""
        foot, floor = self._feet[i], self.geometry.ankle_height
        if stands:
            if not foot.stands:
                foot.stands, foot.place, foot.yaw = True, np.array([wanted[0], wanted[1], floor]), wanted[3]
            return foot.place, yaw_rotation(np.array(foot.yaw))
        if foot.stands:
            turned = np.mod(foot.yaw - wanted[3] + np.pi, 2 * np.pi) - np.pi
            foot.stands, foot.lifted_s = False, 0.0
            foot.away = np.array([*(foot.place[:2] - wanted[:2]), 0.0, turned])
        foot.lifted_s += elapsed
        place = wanted + (1 - minimum_jerk(np.array(foot.lifted_s / FADE_S))) * foot.away
        lifted = np.clip((wanted[2] - floor) / (scale * LIFTED_M), 0.0, 1.0)
        place[2] = floor + max(wanted[2] - floor, lifted * CLEARANCE_M * scale)
        turn = yaw_rotation(place[3]) @ hm.pitch_rotation(np.array(lifted * SWING_PITCH * pitch))
        return place[:3], turn

    def _held_goal(self, clip: HumanClip) -> Goal:
        now = Timeline(clip.fps, np.zeros(1), np.ones(1), np.zeros(1, dtype=bool))
        return held_targets(clip, self.geometry, now).goal(0)

    def _configuration(self, time_s: float, goal: Goal, outputs: dict[str, np.ndarray]) -> Configuration:
        geometry, qpos = self.geometry, self._solver.qpos
        errors = dict(zip(geometry.followed, outputs["point_error"][:, 0].tolist(), strict=True))
        away = np.linalg.norm(outputs["sole"][:3].T - goal.soles, axis=1).tolist()
        errors |= {f"{foot.name}_sole": error for foot, error in zip(geometry.feet, away, strict=True)}
        threshold, names = TRACKING_ERROR_SHARE * geometry.limb_length, geometry.robot.joint_names
        return Configuration(
            time_s=time_s,
            root_pos=qpos[:3],
            root_quat=qpos[3:7],
            joint_pos=qpos[geometry.qpos_index],
            contacts=self._solver.planted,
            tracking_errors={limb: error for limb, error in errors.items() if error > threshold},
            limited=tuple(names[i] for i in np.flatnonzero(self._solver.limited)),
        )


def _checked(joints: Floats) -> Floats:
    joints = np.asarray(joints, dtype=float)
    if joints.shape != (JOINT_COUNT, 3):
        raise InvalidMessage("OnlineRetargeter", "joints", f"expected shape ({JOINT_COUNT}, 3), found {joints.shape}")
    if not np.isfinite(joints).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(joints))[0])
        raise InvalidMessage("OnlineRetargeter", "joints", f"expected finite values, found {joints[where]} at {where}")
    return joints
