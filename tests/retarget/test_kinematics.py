"""Positions, orientations, Jacobians and centres of mass agree with MuJoCo on random models and on the robots."""

import casadi as ca
import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.body.kinematics import Kinematics, rotation_error
from ros_free_stack.couplings import fold, joint_couplings, settle
from ros_free_stack.errors import UnsupportedModel
from ros_free_stack.robot_model import kinematic_model
from ros_free_stack.robots import load_robot

OFFSET = (0.03, -0.02, 0.05)
TOLERANCE = 1e-9


def all_quantities(model: mujoco.MjModel) -> ca.Function:
    """Every body's point, orientation and Jacobians, and the centre of mass."""
    kinematics = Kinematics(model)
    outputs = []
    for body in range(1, model.nbody):
        point = kinematics.position(body, OFFSET)
        outputs += [
            point,
            kinematics.rotation(body),
            kinematics.position_jacobian(body, point),
            kinematics.rotation_jacobian(body),
        ]
    return ca.Function("all", [kinematics.qpos], [*outputs, *kinematics.centre_of_mass()])


def random_qpos(model: mujoco.MjModel, rng: np.random.Generator) -> np.ndarray:
    qpos = rng.uniform(-3, 3, model.nq)
    for joint in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE):
        at = model.jnt_qposadr[joint] + 3
        qpos[at : at + 4] = rng.normal(size=4)
        qpos[at : at + 4] /= np.linalg.norm(qpos[at : at + 4])
    return qpos


def check_against_mujoco(model: mujoco.MjModel, function: ca.Function, qpos: np.ndarray) -> None:
    """Evaluate at `qpos`, whose followers may be anywhere; MuJoCo gets them where they belong."""
    couplings = joint_couplings(model)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    settle(model, couplings, data.qpos)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    values = [np.array(value) for value in function(qpos)]

    def jacobians(point: np.ndarray, body: int) -> tuple[np.ndarray, np.ndarray]:
        both = np.zeros((6, model.nv))
        mujoco.mj_jac(model, data, both[:3], both[3:], point, body)
        fold(model, couplings, data.qpos, both)
        return both[:3], both[3:]

    for body in range(1, model.nbody):
        point, rotation, position_jacobian, rotation_jacobian = values[4 * (body - 1) : 4 * body]
        matrix = data.xmat[body].reshape(3, 3)
        expected = data.xpos[body] + matrix @ OFFSET
        position, angular = jacobians(expected, body)
        np.testing.assert_allclose(point[:, 0], expected, atol=TOLERANCE)
        np.testing.assert_allclose(rotation, matrix, atol=TOLERANCE)
        np.testing.assert_allclose(position_jacobian, position, atol=TOLERANCE)
        np.testing.assert_allclose(rotation_jacobian, angular, atol=TOLERANCE)
    com, com_jacobian = values[-2:]
    expected = np.zeros((3, model.nv))
    mujoco.mj_jacSubtreeCom(model, data, expected, 0)
    fold(model, couplings, data.qpos, expected)
    np.testing.assert_allclose(com[:, 0], data.subtree_com[0], atol=TOLERANCE)
    np.testing.assert_allclose(com_jacobian, expected, atol=TOLERANCE)


def random_model(rng: np.random.Generator) -> mujoco.MjModel:
    """A tree of 2 to 9 bodies: free or fixed base, bodies no to two hinges and slides each, some coupled."""
    spec = mujoco.MjSpec()
    bodies = [spec.worldbody]
    names: list[str] = []
    for number in range(rng.integers(2, 10)):
        parent = bodies[0] if number == 0 else bodies[rng.integers(1, len(bodies))]
        body = parent.add_body(name=f"b{number}", pos=rng.normal(size=3) / 3, quat=rng.normal(size=4))
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=rng.uniform(0.05, 0.2, 3), pos=rng.normal(size=3) / 5)
        bodies.append(body)
        if number == 0 and rng.random() < 0.5:
            body.add_freejoint()
            continue
        for _ in range(rng.integers(0 if number else 1, 3)):
            slide = rng.random() < 0.3
            joint = body.add_joint(name=f"j{len(names)}", axis=rng.normal(size=3), pos=rng.normal(size=3) / 5)
            joint.type = mujoco.mjtJoint.mjJNT_SLIDE if slide else mujoco.mjtJoint.mjJNT_HINGE
            joint.ref = rng.uniform(-1, 1)
            names.append(joint.name)
    for follower, name in enumerate(names):
        draw = rng.random()
        if draw < 0.3:
            equality = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=name)
            if follower and draw < 0.25:
                equality.name2 = names[rng.integers(follower)]
            # Higher powers count less, lest a chain of followers amplifies rounding errors beyond all bounds.
            equality.data[:5] = rng.uniform(-0.5, 0.5, 5) / 2.0 ** np.arange(5)
    return spec.compile()


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_models_agree_with_mujoco(seed: int):
    rng = np.random.default_rng(seed)
    model = random_model(rng)
    function = all_quantities(model)
    for _ in range(2):
        check_against_mujoco(model, function, random_qpos(model, rng))


@pytest.mark.parametrize("name", ["op3", "g1_upper"])
def test_robots_agree_with_mujoco(name: str):
    model, rng = kinematic_model(load_robot(name)), np.random.default_rng(0)
    function = all_quantities(model)
    for _ in range(10):
        check_against_mujoco(model, function, random_qpos(model, rng))


def test_a_follower_moves_with_its_source_alone():
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><body><joint name="motor" axis="0 1 0"/><geom size=".1"/>
        <body pos="0 0 .2"><joint name="finger" type="slide"/><geom size=".1"/></body></body></worldbody>
        <equality><joint joint1="finger" joint2="motor" polycoef="0.1 0.5 -0.2 0 0"/></equality></mujoco>"""
    )
    kinematics = Kinematics(model)
    tip = kinematics.position(2)
    function = ca.Function("tip", [kinematics.qpos], [tip, kinematics.position_jacobian(2, tip)])
    at, jacobian = (np.array(value) for value in function([0.4, 99.0]))
    step = 1e-6
    moved, _ = (np.array(value) for value in function([0.4 + step, -99.0]))
    np.testing.assert_allclose(jacobian[:, 0], (moved - at)[:, 0] / step, atol=1e-5)
    np.testing.assert_array_equal(jacobian[:, 1], 0)


def equality_model(equality: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="a"><joint name="j"/><geom size=".1"/></body>'
        '<body name="b"><joint name="k"/><geom size=".1"/></body></worldbody>'
        f"<equality>{equality}</equality></mujoco>"
    )


@pytest.mark.parametrize(
    ("equality", "words"),
    [
        ('<connect name="rod" body1="a" body2="b" anchor="0 0 0"/>', "'rod' closes a loop"),
        ('<weld body1="a" body2="b"/>', "'weld' closes a loop"),
        ('<joint joint1="j" joint2="k"/><joint joint1="k" joint2="j"/>', "'j', 'k' follow each other in a circle"),
        ('<joint joint1="j" joint2="k"/><joint joint1="j"/>', "'j' follows two"),
    ],
)
def test_refuses_what_no_joint_can_be_eliminated_by(equality: str, words: str):
    with pytest.raises(UnsupportedModel, match=words):
        Kinematics(equality_model(equality))


def test_an_inactive_equality_couples_nothing():
    assert joint_couplings(equality_model('<joint joint1="j" joint2="k" active="false"/>')) == ()


@settings(max_examples=50, deadline=None)
@given(angle=st.floats(-3.0, 3.0), seed=st.integers(0, 1000))
def test_rotation_error_is_twice_the_sine_of_half_the_angle(angle: float, seed: int):
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    quaternion, target, turn = np.zeros(4), np.zeros(9), np.zeros(9)
    mujoco.mju_axisAngle2Quat(quaternion, np.array([1.0, 0.0, 0.0]), 0.7)
    mujoco.mju_quat2Mat(target, quaternion)
    mujoco.mju_axisAngle2Quat(quaternion, axis, angle)
    mujoco.mju_quat2Mat(turn, quaternion)
    a, b = ca.SX.sym("a", 3, 3), ca.SX.sym("b", 3, 3)
    error = ca.Function("error", [a, b], [rotation_error(a, b)])
    target, turn = target.reshape(3, 3), turn.reshape(3, 3)
    value = np.array(error(turn @ target, target))[:, 0]
    np.testing.assert_allclose(value, 2 * np.sin(angle / 2) * axis, atol=1e-7)


def test_refuses_ball_joints():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><joint name="shoulder" type="ball"/><geom size=".1"/></body></worldbody></mujoco>'
    )
    with pytest.raises(UnsupportedModel, match="shoulder"):
        Kinematics(model)
