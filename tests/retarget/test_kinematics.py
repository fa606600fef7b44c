import casadi as ca
import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.kinematics import Kinematics, rotation_error
from ros_free_stack.errors import UnsupportedModel
from ros_free_stack.robot_model import kinematic_model
from ros_free_stack.robots import load_robot, robot_names

LINKAGE = """
<mujoco><worldbody>
  <body name="cart" pos="0 0 1"><joint name="rail" type="slide" axis="0.6 0.8 0"/><geom size=".1" mass="2"/>
    <body name="arm" pos="0.1 0.2 0.3" euler="20 30 40">
      <joint name="swing" type="hinge" axis="1 2 3" pos="0.05 0 0.1" ref="0.3"/><geom size=".1" mass="1" pos="0 0 .2"/>
      <body name="hand" pos="0 0 0.4"><joint name="turn" type="hinge" axis="0 0 -1"/><geom size=".05" mass=".5"/></body>
    </body>
  </body>
</worldbody></mujoco>
"""


def all_quantities(model: mujoco.MjModel) -> ca.Function:
    """Every body's point, orientation and Jacobians, and the centre of mass."""
    kinematics = Kinematics(model)
    outputs = []
    for body in range(1, model.nbody):
        point = kinematics.position(body, (0.03, -0.02, 0.05))
        outputs += [
            point,
            kinematics.rotation(body),
            kinematics.position_jacobian(body, point),
            kinematics.rotation_jacobian(body),
        ]
    return ca.Function("all", [kinematics.qpos], [*outputs, *kinematics.centre_of_mass()])


MODELS = {name: kinematic_model(load_robot(name)) for name in robot_names()}
MODELS["linkage"] = mujoco.MjModel.from_xml_string(LINKAGE)
FUNCTIONS = {name: all_quantities(model) for name, model in MODELS.items()}


def random_qpos(model: mujoco.MjModel, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    qpos = rng.uniform(-3, 3, model.nq)
    if model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        qpos[3:7] = rng.normal(size=4)
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
    return qpos


@pytest.mark.parametrize("name", MODELS)
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_agrees_with_mujoco(name: str, seed: int):
    model = MODELS[name]
    data = mujoco.MjData(model)
    data.qpos[:] = random_qpos(model, seed)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    values = [np.array(value) for value in FUNCTIONS[name](data.qpos)]
    for body in range(1, model.nbody):
        point, rotation, position_jacobian, rotation_jacobian = values[4 * (body - 1) : 4 * body]
        matrix = data.xmat[body].reshape(3, 3)
        expected = data.xpos[body] + matrix @ [0.03, -0.02, 0.05]
        jacp, jacr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, jacp, jacr, expected, body)
        np.testing.assert_allclose(point[:, 0], expected, atol=1e-9)
        np.testing.assert_allclose(rotation, matrix, atol=1e-9)
        np.testing.assert_allclose(position_jacobian, jacp, atol=1e-9)
        np.testing.assert_allclose(rotation_jacobian, jacr, atol=1e-9)
    com, com_jacobian = values[-2:]
    expected_jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacSubtreeCom(model, data, expected_jacobian, 0)
    np.testing.assert_allclose(com[:, 0], data.subtree_com[0], atol=1e-9)
    np.testing.assert_allclose(com_jacobian, expected_jacobian, atol=1e-9)


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
