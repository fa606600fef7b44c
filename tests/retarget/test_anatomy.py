"""Geometry alone finds the limbs of every robot that is described, whatever its bodies and joints are called."""

import mujoco
import pytest

from retarget.describe.anatomy import find_anatomy
from retarget.describe.proposal import attach, wrist_places
from retarget.describe.tree import Tree, base_bodies
from ros_free_stack.robot_model import read_spec, strip_meshes
from ros_free_stack.robots import load_robot

LIMB_JOINTS = [
    f"{side}_{joint}" for side in ("left", "right") for joint in ("hip", "knee", "ankle", "shoulder", "elbow")
]


def stripped(name: str) -> mujoco.MjSpec:
    spec = read_spec(load_robot(name).model_path)
    strip_meshes(spec)
    for sensor in list(spec.sensors):
        spec.delete(sensor)
    return spec


def rename(spec: mujoco.MjSpec) -> dict[str, str]:
    """Give every body and joint a neutral name; new body name to old one."""
    bodies = {body.name: f"b{k}" for k, body in enumerate(spec.bodies) if body.name != "world"}
    joints = {joint.name: f"j{k}" for k, joint in enumerate(spec.joints)}
    for light in spec.lights:
        light.targetbody = bodies.get(light.targetbody, light.targetbody)
    for exclude in spec.excludes:
        exclude.bodyname1, exclude.bodyname2 = bodies[exclude.bodyname1], bodies[exclude.bodyname2]
    for actuator in spec.actuators:
        actuator.target = joints[actuator.target]
    for body in spec.bodies:
        body.name = bodies.get(body.name, body.name)
    for joint in spec.joints:
        joint.name = joints[joint.name]
    return {new: old for old, new in bodies.items()}


def found(spec: mujoco.MjSpec) -> tuple[dict[str, str], dict[str, str]]:
    """Attached bodies by human joint, and pelvis, torso and head."""
    model = spec.compile()
    tree = Tree(model, base_bodies(model)[0])
    anatomy = find_anatomy(tree)
    assert not anatomy.questions
    attachments = attach(tree, anatomy, wrist_places(tree, anatomy))
    places = {joint: item.body for joint, item in attachments.items()}
    return places, {"torso": tree.name(anatomy.torso), "base": tree.name(tree.base)}


@pytest.mark.parametrize("renamed", [False, True], ids=["named", "renamed"])
@pytest.mark.parametrize("name", ["op3", "g1", "h1", "t1", "apollo", "berkeley"])
def test_agrees_with_the_description(name: str, renamed: bool):
    robot, spec = load_robot(name), stripped(name)
    old = rename(spec) if renamed else {}
    places, trunk = found(spec)
    places = {joint: old.get(body, body) for joint, body in places.items()}
    expected = {joint: item.body for joint, item in robot.attachments.items()}
    assert {joint: places.get(joint) for joint in LIMB_JOINTS} == {joint: expected.get(joint) for joint in LIMB_JOINTS}
    assert places["pelvis"] == expected["pelvis"]
    assert old.get(trunk["torso"], trunk["torso"]) == robot.torso_body
    assert old.get(trunk["base"], trunk["base"]) == robot.root_body


@pytest.mark.parametrize(("name", "head"), [("op3", "head_tilt_link"), ("t1", "H2"), ("apollo", "neck_pitch_link")])
def test_finds_heads(name: str, head: str):
    assert found(stripped(name))[0]["head"] == head


@pytest.mark.parametrize("name", ["g1", "h1", "berkeley"])
def test_invents_no_head(name: str):
    assert "head" not in found(stripped(name))[0]


def test_arms_that_two_pairs_may_be_are_asked_for():
    """Four like arms on a stand, none of them named."""
    arms = "".join(
        f'<body name="s{k}" pos="0 {side * 0.2} {height}"><joint axis="1 0 0"/><geom size=".03"/>'
        f'<body name="u{k}" pos="0 {side * 0.02} 0"><joint axis="0 1 0"/><geom size=".03"/>'
        f'<body name="f{k}" pos="0 0 -.3"><joint axis="0 1 0"/><geom size=".03" pos="0 0 -.25"/></body></body></body>'
        for k, (side, height) in enumerate([(1, 1.4), (-1, 1.4), (1, 1.2), (-1, 1.2), (1, 1.0), (-1, 1.0)])
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body name="stand"><geom size=".1"/>{arms}</body></worldbody></mujoco>'
    )
    anatomy = find_anatomy(Tree(model, base_bodies(model)[0]))
    (question,) = [question for question in anatomy.questions if "arms" in question.problem]
    assert question.key == "attachments.left_shoulder"
    assert set(question.candidates) <= {"s0", "s2", "s4"} and len(question.candidates) > 1


def test_a_robot_that_faces_y_is_asked_to_turn():
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><body name="trunk" pos="0 0 1"><freejoint/><geom size=".1"/>
        <body name="a" pos=".1 0 0"><joint axis="1 0 0"/><geom size=".05" pos="0 0 -.3"/></body>
        <body name="b" pos="-.1 0 0"><joint axis="1 0 0"/><geom size=".05" pos="0 0 -.3"/></body>
        </body></worldbody></mujoco>"""
    )
    (question,) = find_anatomy(Tree(model, base_bodies(model)[0])).questions
    assert question.key == "attachments" and "must face x" in question.problem
