import mujoco
import numpy as np
import pytest

from retarget.pipeline import Retargeter, RetargetResult
from retarget.report import limb_chain
from retarget.solve.frame_program import FrameProgram
from ros_free_stack.errors import InvalidOption, SolverFailed
from ros_free_stack.messages import HumanMotion
from ros_free_stack.robot_model import joint_addresses, kinematic_model, sole_corners
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import INDEX

TOLERANCE = 1e-6


@pytest.fixture(scope="module", params=["op3", "g1"])
def retargeter(request) -> Retargeter:
    return Retargeter(load_robot(request.param))


@pytest.fixture(scope="module")
def results(retargeter: Retargeter, motions: dict[str, HumanMotion]) -> dict[str, RetargetResult]:
    return {name: retargeter.retarget(motion) for name, motion in motions.items()}


def each_frame(result: RetargetResult, retargeter: Retargeter):
    """MuJoCo's own kinematics of every frame."""
    trajectory = result.trajectory
    model = kinematic_model(retargeter.robot)
    index, _ = joint_addresses(model, retargeter.robot)
    data = mujoco.MjData(model)
    for k in range(len(trajectory.joint_pos)):
        data.qpos[:3], data.qpos[3:7] = trajectory.root_pos[k], trajectory.root_quat[k]
        data.qpos[index] = trajectory.joint_pos[k]
        mujoco.mj_forward(model, data)
        yield model, data


def soles(result: RetargetResult, retargeter: Retargeter) -> np.ndarray:
    """(N, F, 4, 3) corners of the soles."""
    return np.array(
        [list(sole_corners(model, data, retargeter.robot).values()) for model, data in each_frame(result, retargeter)]
    )


def test_keeps_every_joint_limit(results, retargeter):
    robot = retargeter.robot
    for result in results.values():
        joints, fps = result.trajectory.joint_pos, result.trajectory.fps
        assert (joints >= robot.lower - TOLERANCE).all() and (joints <= robot.upper + TOLERANCE).all()
        speed = np.diff(joints, axis=0) * fps
        assert (np.abs(speed) <= robot.velocity + TOLERANCE).all()
        acceleration = np.diff(joints, n=2, axis=0) * fps**2
        assert (np.abs(acceleration) <= robot.acceleration + 1e-4).all()


def test_starts_and_ends_standing_still(results, retargeter):
    for name in ("wave", "squat", "steps"):
        joints = results[name].trajectory.joint_pos
        frames = int(0.4 * results[name].trajectory.fps)
        for still in (joints[:frames], joints[-frames // 2 :]):
            assert np.abs(np.diff(still, axis=0)).max() < 2e-3
        assert np.abs(joints[0] - joints[-1]).max() < 0.15


def test_standing_feet_do_not_move_and_lie_on_the_floor(results, retargeter):
    for result in results.values():
        corners, contacts = soles(result, retargeter), result.trajectory.contacts
        assert corners[..., 2].min() > -0.004
        both = contacts[1:] & contacts[:-1]
        speed = np.linalg.norm(np.diff(corners, axis=0)[..., :2], axis=-1).max(axis=-1) * result.trajectory.fps
        assert speed[both].max() < 0.02
        assert np.abs(corners[contacts][..., 2]).max() < 0.004


def test_steps_lift_the_feet_and_travel(results, retargeter):
    result = results["steps"]
    scale = retargeter._geometry.hip_height / 0.79
    corners = soles(result, retargeter)
    assert (~result.trajectory.contacts).sum(axis=0).min() > 10
    assert (corners[..., 2].max(axis=(0, 2)) > 0.03 * scale).all()
    assert result.trajectory.root_pos[-1, 0] - result.trajectory.root_pos[0, 0] == pytest.approx(0.45 * scale, rel=0.15)
    assert result.trajectory.contacts.any(axis=1).all()


def test_wave_raises_the_right_hand_alone(results, retargeter):
    attachments = retargeter.robot.attachments
    heights = []
    for _, data in each_frame(results["wave"], retargeter):
        heights.append(
            [
                (
                    data.body(attachments[name].body).xpos
                    + data.body(attachments[name].body).xmat.reshape(3, 3) @ attachments[name].offset
                )[2]
                for name in ("right_wrist", "right_shoulder", "left_wrist", "left_shoulder")
            ]
        )
    right, right_shoulder, left, left_shoulder = np.array(heights).T
    assert (right - right_shoulder).max() > 0.05
    assert (left < left_shoulder).all()


def test_squat_lowers_the_body(results, retargeter):
    height = results["squat"].trajectory.root_pos[:, 2]
    assert height.min() < 0.82 * height[0]


def test_same_input_gives_the_same_bytes(retargeter, motions):
    first, second = (retargeter.retarget(motions["wave"]) for _ in range(2))
    assert first.trajectory.digest == second.trajectory.digest


def test_heading_and_place_of_the_human_do_not_matter(retargeter, motions):
    turned = np.array(motions["steps"].joints) @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    moved = HumanMotion(turned + np.array([3.0, -2.0, 0.4]), motions["steps"].fps)
    a = retargeter.retarget(motions["steps"]).trajectory
    b = retargeter.retarget(moved).trajectory
    np.testing.assert_allclose(a.joint_pos, b.joint_pos, atol=1e-5)


def test_out_of_reach_is_reported_and_stays_within_limits(retargeter, motions):
    joints = np.array(motions["stand"].joints)
    joints[:, INDEX["left_knee"]] += [-0.6, 0, 0.2]
    joints[:, INDEX["left_wrist"]] = joints[:, INDEX["left_elbow"]] + [-0.15, -0.2, 0.1]
    joints[::2, INDEX["right_wrist"]] = joints[::2, INDEX["right_elbow"]] + [0, 0, 0.25]
    result = retargeter.retarget(HumanMotion(joints, 20.0))
    assert result.report.tracking_errors
    assert all(entry.worst_cm > 0 and entry.end_s > entry.start_s for entry in result.report.tracking_errors)
    assert result.report.limited_joints
    kinds = {kind for entry in result.report.tracking_errors for kinds in entry.joints.values() for kind in kinds}
    assert kinds and kinds <= {"range", "speed", "acceleration"}
    assert "at the limit of" in str(max(result.report.tracking_errors, key=lambda entry: len(entry.joints)))
    test_keeps_every_joint_limit({"broken": result}, retargeter)


def test_only_joints_of_the_limb_are_named_as_causes(retargeter, motions):
    joints = np.array(motions["stand"].joints)
    joints[:, INDEX["left_wrist"]] = joints[:, INDEX["left_elbow"]] + [-0.15, -0.2, 0.1]
    joints[:, INDEX["right_knee"]] += [-0.6, 0, 0.2]
    report = retargeter.retarget(HumanMotion(joints, 20.0), balance=False).report
    model = kinematic_model(retargeter.robot)
    sides = {"left": ("left", "l_"), "right": ("right", "r_")}
    assert report.tracking_errors
    for entry in (item for item in report.tracking_errors if item.limb != "pelvis"):
        other = sides["right" if entry.limb.startswith("left") else "left"]
        assert not any(name.startswith(other) for name in entry.joints), entry
        arm = any(part in entry.limb for part in ("wrist", "elbow"))
        legs = {name for name in entry.joints if any(part in name for part in ("hip", "knee", "ank"))}
        assert not (arm and legs), entry
    wrist = limb_chain(retargeter._geometry, "left_wrist")
    assert all(model.joint(name).bodyid[0] for name in wrist) and len(wrist) >= 3
    assert limb_chain(retargeter._geometry, "pelvis") == {
        name for foot in retargeter.robot.foot_names for name in limb_chain(retargeter._geometry, f"{foot}_sole")
    }


def test_the_pace_may_be_kept_and_changes_of_it_are_told(retargeter, motions):
    steps = motions["steps"]
    quick = HumanMotion(steps.joints[::2], steps.fps)
    slowed = retargeter.retarget(quick, balance=False)
    kept = retargeter.retarget(quick, balance=False, keep_timing=True)
    assert kept.report.slowdown == 1.0 < slowed.report.slowdown
    assert kept.trajectory.duration_s < slowed.trajectory.duration_s
    human_s = (len(quick.joints) - 1) / quick.fps
    line = f"pace: {human_s:.1f} s of the person take the robot {slowed.report.slowdown * human_s:.1f} s"
    assert slowed.report.changes()[0].startswith(line) and "--keep-timing" in slowed.report.changes()[0]
    assert not any(line.startswith("pace") for line in kept.report.changes())


def test_progress_rises_to_the_whole(retargeter, motions):
    shares: list[float] = []
    retargeter.retarget(motions["wave"], progress=shares.append)
    assert shares == sorted(shares) and 0 < shares[0] < 1 and shares[-1] == 1


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_very_short_clips(retargeter, motions, frames):
    motion = HumanMotion(motions["wave"].joints[:frames], 20.0)
    trajectory = retargeter.retarget(motion).trajectory
    assert trajectory.duration_s > 1.0


def test_refuses_a_bad_frame_rate(retargeter, motions):
    with pytest.raises(InvalidOption, match="fps"):
        retargeter.retarget(motions["stand"], fps=0.0)


def test_balance_without_a_solution_is_counted_and_told(motions: dict[str, HumanMotion], monkeypatch):
    def fail(*_: object) -> None:
        raise SolverFailed("the balance of the centre of mass", "PIQP -1")

    monkeypatch.setattr("retarget.pipeline.balanced_com", fail)
    report = Retargeter(load_robot("op3"), "frames").retarget(motions["wave"]).report
    assert report.solver_failures == {"balance": 1}
    assert report.failures() == ("solver: 1 plans of balance had no solution: the body leans as the person does",)


def test_frames_without_a_solution_are_counted_or_end_in_an_error(motions: dict[str, HumanMotion], monkeypatch):
    retargeter, count = Retargeter(load_robot("op3"), "frames"), 0
    run = FrameProgram._run

    def failing(program: FrameProgram, accepted: int, *, soften: bool) -> tuple[np.ndarray, int]:
        nonlocal count
        count += 1
        found, status = run(program, accepted, soften=soften)
        return found, -1 if count in broken else status

    monkeypatch.setattr(FrameProgram, "_run", failing)
    broken = range(300, 320)
    result = retargeter.retarget(motions["wave"], balance=False)
    assert 1 <= result.report.solver_failures["frame"] <= 20
    joints = result.trajectory.joint_pos
    assert (joints >= retargeter.robot.lower - TOLERANCE).all() and (joints <= retargeter.robot.upper + TOLERANCE).all()
    assert (np.abs(np.diff(joints, axis=0)) * 50 <= retargeter.robot.velocity + TOLERANCE).all()
    broken = range(count, 10**9)
    with pytest.raises(SolverFailed, match=r"first frame's pose has no solution .solver status: DAQP -1"):
        retargeter.retarget(motions["wave"])
