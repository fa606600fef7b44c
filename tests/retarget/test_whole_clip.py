from collections import defaultdict
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.balance.com_plan import LONGEST_SHIFT
from retarget.body.collision import Collision
from retarget.body.geometry import measure
from retarget.clip.human import align
from retarget.pipeline import Retargeter
from retarget.plan.pace import walking_pace
from retarget.plan.stride import leg_speed, stride_share
from retarget.plan.targets import Targets, make_targets
from retarget.plan.timeline import plan_timeline
from retarget.solve import whole_clip
from retarget.solve.effort import Effort
from retarget.solve.frame_solver import FrameSolver
from retarget.solve.limits import JointBounds
from retarget.solve.trajectory_qp import STUCK
from retarget.solve.whole_clip import ClipSolver
from retarget.solve.windows import windows
from ros_free_stack.messages import HumanMotion
from ros_free_stack.robots import load_robot

GEOMETRY = measure(load_robot("op3"))
FRAMES = FrameSolver(GEOMETRY)
SOLVER = ClipSolver(GEOMETRY)
FPS = 50.0


def targets_of(motion: HumanMotion) -> Targets:
    clip = align(motion)
    stride = stride_share(clip, GEOMETRY)
    scale = stride * GEOMETRY.hip_height / clip.leg_length
    pace = walking_pace(clip, GEOMETRY.hip_height, leg_speed=leg_speed(GEOMETRY), scale=scale)
    return make_targets(clip, GEOMETRY, plan_timeline(pace, FPS), stride)


def standing_targets(count: int) -> Targets:
    data = mujoco.MjData(GEOMETRY.model)
    data.qpos[:] = GEOMETRY.standing
    mujoco.mj_kinematics(GEOMETRY.model, data)
    points = [
        data.xpos[body] + data.xmat[body].reshape(3, 3) @ GEOMETRY.offsets[n] for n, body in GEOMETRY.bodies.items()
    ]
    turns = [data.xmat[foot.body].reshape(3, 3) for foot in GEOMETRY.feet]
    soles = [data.xpos[foot.body] + turn @ foot.centre for foot, turn in zip(GEOMETRY.feet, turns, strict=True)]
    return Targets(
        fps=FPS,
        points=np.tile(points, (count, 1, 1)),
        rotations=np.tile(list(GEOMETRY.references.values()), (count, 1, 1, 1)),
        soles=np.tile(soles, (count, 1, 1)),
        sole_rotations=np.tile(turns, (count, 1, 1, 1)),
        contacts=np.ones((count, 2), dtype=bool),
        following=np.ones(count),
        scale=1.0,
    )


def assert_within_limits(qpos: np.ndarray) -> None:
    robot, joints = GEOMETRY.robot, qpos[:, GEOMETRY.qpos_index]
    resting = np.concatenate([joints[:1], joints, joints[-1:]])
    assert (joints >= robot.lower).all() and (joints <= robot.upper).all()
    assert (np.abs(np.diff(joints, axis=0)) * FPS <= robot.velocity + 1e-9).all()
    assert (np.abs(np.diff(resting, n=2, axis=0)) * FPS**2 <= robot.acceleration + 1e-6).all()


def sole_corners(qpos: np.ndarray) -> np.ndarray:
    """(N, F, 4, 3) by MuJoCo."""
    data = mujoco.MjData(GEOMETRY.model)
    found = []
    for data.qpos[:] in qpos:
        mujoco.mj_kinematics(GEOMETRY.model, data)
        found.append([data.xpos[f.body] + f.corners @ data.xmat[f.body].reshape(3, 3).T for f in GEOMETRY.feet])
    return np.array(found)


@pytest.fixture(scope="module")
def steps(motions):
    targets = targets_of(motions["steps"])
    start = FRAMES.solve(targets)
    return targets, start, SOLVER.solve(targets, start.qpos).solution


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 10_000), jump=st.floats(0.0, 0.3), count=st.integers(4, 40))
def test_keeps_every_limit_whatever_the_targets(seed, jump, count):
    rng = np.random.default_rng(seed)
    targets = standing_targets(count)
    targets.points[:] += np.repeat(rng.normal(0, jump, (count // 2 + 1, *targets.points.shape[1:])), 2, axis=0)[:count]
    targets.contacts[:] = np.repeat(rng.random((count // 4 + 1, 2)) < 0.7, 4, axis=0)[:count]
    start = FRAMES.solve(targets).qpos
    # The frame solver rests at the start; a clip must also come to rest.
    start[:] = start[:1]
    assert_within_limits(SOLVER.solve(targets, start).solution.qpos)


def test_standing_feet_stay_where_they_are_and_no_foot_sinks(steps):
    targets, _, solution = steps
    corners = sole_corners(solution.qpos)
    both = targets.contacts[1:] & targets.contacts[:-1]
    speed = np.linalg.norm(np.diff(corners, axis=0), axis=-1).max(axis=-1) * FPS
    assert speed[both].max() < 0.01 and speed[both].mean() < 1e-4
    assert corners[..., 2].min() > -5e-4
    assert not solution.released.any()


def test_soles_near_the_floor_do_not_scrape(steps):
    corners = sole_corners(steps[2].qpos)
    low = (corners[1:, ..., 2] < 0.001) & (corners[:-1, ..., 2] < 0.001)
    speed = np.linalg.norm(np.diff(corners[..., :2], axis=0), axis=-1) * FPS
    assert speed[low].mean() < 1e-3 and speed[low].max() < 0.01


def test_is_smoother_than_the_frame_solver_and_as_near_to_the_targets(steps):
    _, start, solution = steps
    jerk = [
        np.square(np.diff(item.qpos[:, GEOMETRY.qpos_index], n=3, axis=0)).mean() ** 0.5 for item in (start, solution)
    ]
    assert jerk[1] < 0.85 * jerk[0]
    assert solution.point_error.mean() < 1.02 * start.point_error.mean()
    assert_within_limits(solution.qpos)


def test_limbs_stay_apart(motions):
    joints = np.array(motions["wave"].joints)
    joints[..., 20:22, 1] = 0.0
    targets = targets_of(HumanMotion(joints, 20.0))
    qpos = SOLVER.solve(targets, FRAMES.solve(targets).qpos).solution.qpos
    collision = Collision(GEOMETRY)
    assert min(collision.distances(configuration).min() for configuration in qpos) > -0.002


def test_windows_give_what_the_whole_gives(steps):
    targets, start, whole = steps
    parts = windows(len(targets), length=220, overlap=80)
    assert len(parts) > 1
    found = SOLVER.solve(targets, start.qpos, stretches=parts).solution
    np.testing.assert_allclose(found.qpos[:, GEOMETRY.qpos_index], whole.qpos[:, GEOMETRY.qpos_index], atol=0.02)
    assert_within_limits(found.qpos)


def test_same_input_gives_the_same_bytes(steps):
    targets, start, solution = steps
    assert SOLVER.solve(targets, start.qpos).solution.qpos.tobytes() == solution.qpos.tobytes()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_frames(count):
    targets = standing_targets(count)
    found = SOLVER.solve(targets, FRAMES.solve(targets).qpos)
    assert found.solution.qpos.shape == (count, GEOMETRY.model.nq)
    assert found.solution.foot_error.max() < 1e-4
    assert_within_limits(found.solution.qpos)


def test_flight_moves_the_body_without_a_jump():
    targets = standing_targets(60)
    targets.contacts[20:40] = False
    up = 0.05 * np.sin(np.pi * np.clip((np.arange(60) - 20) / 20, 0, 1)) ** 2
    targets.points[..., 2] += up[:, None]
    targets.soles[..., 2] += up[:, None]
    qpos = SOLVER.solve(targets, FRAMES.solve(targets).qpos).solution.qpos
    assert_within_limits(qpos)
    assert qpos[30, 2] - qpos[0, 2] > 0.03
    assert np.abs(np.diff(qpos[:, 2], n=2)).max() < 0.01
    assert np.abs(sole_corners(qpos)[:20, ..., 2]).max() < 1e-4


def test_follows_a_centre_of_mass():
    targets, com = standing_targets(80), np.zeros((80, 2))
    start = FRAMES.solve(targets)
    com[:] = start.centre_of_mass[:, :2]
    com[:, 1] += 0.01 * np.sin(np.pi * np.arange(80) / 79) ** 2
    found = SOLVER.solve(targets, start.qpos, com).solution
    assert found.centre_of_mass[40, 1] - found.centre_of_mass[0, 1] > 0.006


def test_says_where_it_found_nothing_better(steps, motions, monkeypatch):
    targets, start, _ = steps
    monkeypatch.setattr(whole_clip.TrajectoryQP, "solve", lambda *_: None)
    found = SOLVER.solve(targets, start.qpos)
    assert found.unsolved[0][0] == 0 and found.unsolved[-1][1] == len(targets)
    assert all(end >= start for (_, end), (start, _) in pairwise(found.unsolved))
    np.testing.assert_array_equal(found.solution.qpos, start.qpos)
    report = Retargeter(GEOMETRY.robot).retarget(motions["stand"], balance=False).report
    assert report.unsolved_s and report.unsolved_s[0][0] == 0.0


def test_asks_less_of_a_body_that_does_not_follow(motions, monkeypatch):
    shifts = []

    def spy(solver, targets, start, com=None, **options):
        found = solve(solver, targets, start, com, **options)
        if com is not None:
            shifts.append(np.linalg.norm(com - found.solution.centre_of_mass[:, :2], axis=1).max())
        return found

    solve = ClipSolver.solve
    monkeypatch.setattr(whole_clip.TrajectoryQP, "solve", lambda *_: None)
    monkeypatch.setattr(ClipSolver, "solve", spy)
    Retargeter(GEOMETRY.robot).retarget(motions["steps"])
    longest = LONGEST_SHIFT * GEOMETRY.limb_length
    assert shifts[0] > longest
    np.testing.assert_allclose(shifts[1:], [longest, longest / 2])


def test_reports_joints_at_their_limits(steps):
    solution = steps[2]
    bounds = JointBounds.of(GEOMETRY.robot, FPS)
    speed = np.abs(np.diff(solution.qpos[:, GEOMETRY.qpos_index], axis=0)).max(axis=0)
    assert not (solution.limited.any(axis=0) & (speed < 0.1 * bounds.step) & (speed < 0.1 * bounds.change)).any()


def test_a_stretch_costs_no_more_than_its_effort_and_keeps_what_it_has_found(steps):
    targets, start, solution = steps
    (stretch,) = windows(len(targets))
    com = solution.centre_of_mass[:, :2] + [0.02, 0.03]
    spent, errors = [], []
    for budget in (1, 1000):
        efforts = defaultdict(Effort, {stretch: Effort(left=budget)})
        found = SOLVER.solve(targets, start.qpos, com, efforts=efforts)
        assert not found.unsolved
        assert_within_limits(found.solution.qpos)
        spent.append(budget - efforts[stretch].left)
        errors.append(np.linalg.norm(found.solution.centre_of_mass[:, :2] - com, axis=1).mean())
    assert 1 < spent[0] <= STUCK, "a single program"
    assert spent[0] < spent[1] < 300 and errors[1] < errors[0]


def test_a_draft_is_one_iteration(motions, monkeypatch):
    programs = []
    solve = whole_clip.TrajectoryQP.solve
    monkeypatch.setattr(whole_clip.TrajectoryQP, "solve", lambda *given: programs.append(1) or solve(*given))
    targets = targets_of(motions["steps"])
    SOLVER.solve(targets, FRAMES.solve(targets).qpos, draft=True)
    assert len(programs) == 1
