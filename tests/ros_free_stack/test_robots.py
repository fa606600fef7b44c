"""Robot descriptions: complete, consistent with their MuJoCo models, and refused when damaged."""

from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.robot_model import (
    add_floor,
    joint_addresses,
    kinematic_model,
    robot_spec,
    sole_corners,
    standing_qpos,
)
from ros_free_stack.robots import ServoSafety, load_robot, read_description, robot_names
from ros_free_stack.skeleton import INDEX

ROBOTS = {name: load_robot(name) for name in robot_names()}
STANDING = [name for name, robot in ROBOTS.items() if robot.mount == "free"]


@pytest.fixture(params=ROBOTS)
def robot(request: pytest.FixtureRequest):
    return ROBOTS[request.param]


@pytest.fixture(params=STANDING)
def standing_robot(request: pytest.FixtureRequest):
    return ROBOTS[request.param]


def test_names_every_actuated_joint_of_the_model(robot):
    model = kinematic_model(robot)
    actuated = {model.joint(model.actuator_trnid[i, 0]).name for i in range(model.nu)}
    assert set(robot.joint_names) | set(robot.locked) == actuated
    assert not set(robot.joint_names) & set(robot.locked)


def test_attachments_and_soles_name_bodies_of_the_model(robot):
    model = kinematic_model(robot)
    bodies = {model.body(i).name for i in range(model.nbody)}
    named = {item.body for item in robot.attachments.values()} | {sole.body for sole in robot.soles.values()}
    assert named | {robot.root_body, robot.torso_body} <= bodies
    assert "pelvis" in robot.attachments
    assert all(joint.replace("left", "right") in robot.attachments for joint in robot.attachments if "left" in joint)
    assert all(sole.ankle in INDEX for sole in robot.soles.values())


def test_capsules_and_collision_pairs_name_bodies_of_the_model(robot):
    model = kinematic_model(robot)
    bodies = {model.body(i).name for i in range(model.nbody)}
    named = {body for pair in robot.collision_pairs for body in pair}
    assert named == set(robot.capsules) <= bodies
    assert len({frozenset(pair) for pair in robot.collision_pairs}) == len(robot.collision_pairs)
    assert all(first != second for first, second in robot.collision_pairs)
    assert all(capsule.radius > 0 for capsules in robot.capsules.values() for capsule in capsules)


def test_left_and_right_capsules_mirror_each_other(robot):
    """In the model's own pose, across the plane y = 0; of bodies that lie on one side."""
    model = kinematic_model(robot)
    data = mujoco.MjData(model)
    data.qpos[model.jnt_qposadr[model.jnt_type != mujoco.mjtJoint.mjJNT_FREE]] = 0
    mujoco.mj_kinematics(model, data)
    placed = []
    for body, capsules in robot.capsules.items():
        at, matrix = data.body(body).xpos, data.body(body).xmat.reshape(3, 3)
        if abs(at[1]) > 0.01:
            placed += [(at + np.array([c.start, c.end]) @ matrix.T, c.radius) for c in capsules]

    def alike(ends, radius):
        mirrored = ends * [1, -1, 1]
        return any(
            radius == other_radius and min(np.abs(mirrored - e).max() for e in (other, other[::-1])) < 2e-3
            for other, other_radius in placed
        )

    assert all(alike(ends, radius) for ends, radius in placed)


def test_limits_reach_the_compiled_model(robot):
    model = kinematic_model(robot)
    for name, limits in robot.joints.items():
        assert model.joint(name).range == pytest.approx([limits.lower, limits.upper])
    assert np.all(robot.lower < robot.upper)
    assert np.all((robot.lower <= robot.standing_pos) & (robot.standing_pos <= robot.upper))
    assert np.all(robot.velocity > 0) and np.all(robot.effort > 0)


def test_standing_pose_has_flat_feet_on_the_floor_under_the_centre_of_mass(standing_robot):
    robot = standing_robot
    model = kinematic_model(robot)
    data = mujoco.MjData(model)
    data.qpos[:] = standing_qpos(model, robot)
    mujoco.mj_forward(model, data)
    corners = np.concatenate(list(sole_corners(model, data, robot).values()))
    assert corners[:, 2] == pytest.approx(0.0, abs=2e-3)
    centre = data.subtree_com[0]
    assert corners[:, 0].min() < centre[0] < corners[:, 0].max()
    assert corners[:, 1].min() < centre[1] < corners[:, 1].max()


def test_left_is_positive_y(robot):
    model = kinematic_model(robot)
    data = mujoco.MjData(model)
    data.qpos[:] = standing_qpos(model, robot)
    mujoco.mj_kinematics(model, data)
    for name, item in robot.attachments.items():
        if name.startswith(("left", "right")):
            assert (data.body(item.body).xpos[1] > 0) == name.startswith("left"), name


def test_floor_and_meshes_are_optional():
    robot = load_robot("g1")
    spec = robot_spec(robot, meshes=False)
    add_floor(spec)
    model = spec.compile()
    assert model.geom("floor").type[0] == mujoco.mjtGeom.mjGEOM_PLANE
    assert model.nmesh == 0


def test_joint_addresses_follow_names():
    robot = load_robot("op3")
    model = kinematic_model(robot)
    positions, speeds = joint_addresses(model, robot)
    assert [model.joint(int(model.dof_jntid[i])).name for i in speeds] == list(robot.joint_names)
    assert [model.jnt_qposadr[model.joint(n).id] for n in robot.joint_names] == positions.tolist()


def test_op3_servo_map():
    servos = load_robot("op3").servos
    assert servos is not None
    assert sorted(servos.ids.values()) == list(range(1, 21))
    assert (servos.ids["r_sho_pitch"], servos.ids["l_knee"], servos.ids["head_tilt"]) == (1, 14, 20)


def test_unknown_robot_lists_the_known():
    with pytest.raises(UnknownName, match=r"g1, g1_upper, .*op3"):
        load_robot("r2d2")


def test_damaged_description_names_the_file(tmp_path: Path):
    path = tmp_path / "broken.yaml"
    path.write_text("name: broken\n")
    with pytest.raises(InvalidFile, match=r"broken\.yaml"):
        read_description(path)


def test_collision_pair_without_capsules_names_the_body(tmp_path: Path):
    source = Path(__file__).parents[2] / "ros_free_stack" / "robots" / "g1.yaml"
    path = tmp_path / "g1.yaml"
    path.write_text(source.read_text().replace("[torso_link]", "[tail]"))
    with pytest.raises(UnknownName, match=r"'tail'; valid: .*torso_link"):
        read_description(path)


def test_hash_changes_with_the_description(tmp_path: Path):
    robot = load_robot("g1")
    source = Path(__file__).parents[2] / "ros_free_stack" / "robots" / "g1.yaml"
    changed = tmp_path / "g1.yaml"
    changed.write_text(source.read_text().replace("title: Unitree G1", "title: another"))
    assert read_description(changed).sha256 != robot.sha256


def written(tmp_path: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """OP3's description with a change."""
    source = resources.files("ros_free_stack") / "robots" / "op3.yaml"
    data = yaml.safe_load(source.read_text(encoding="utf-8"))
    change(data)
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


def test_the_board_of_op3_and_a_robot_without_one(tmp_path: Path):
    servos = load_robot("op3").servos
    assert servos is not None and servos.board is not None
    board = servos.board
    assert (board.name, board.id, board.model_number, board.power) == ("OpenCR", 200, 0x7400, 24)
    assert (board.buttons, board.button_names, board.voltage) == (30, ("mode", "start", "user"), 31)
    without = read_description(written(tmp_path, lambda data: data["servos"].pop("board"))).servos
    assert without is not None and without.board is None


def test_servo_models_can_differ_by_joint(tmp_path: Path):
    servos = read_description(
        written(tmp_path, lambda data: data["servos"].update(models={"l_el": "XL430-W250"}))
    ).servos
    assert servos is not None
    assert (servos.model_of("l_el"), servos.model_of("r_el")) == ("XL430-W250", "XM430-W350")


def test_motor_figures_may_be_unknown(tmp_path: Path):
    known = read_description(written(tmp_path, lambda data: None)).servos
    assert known is not None and known.motor is not None
    assert known.motor.resistance == pytest.approx(12 / 2.3)
    unknown = read_description(written(tmp_path, lambda data: data["servos"].pop("motor"))).servos
    assert unknown is not None and unknown.motor is None


def test_servo_safety_has_defaults(tmp_path: Path):
    servos = read_description(written(tmp_path, lambda data: data.update(servo_safety={"temperature": 60}))).servos
    assert servos is not None
    assert servos.safety == ServoSafety(temperature=60)
    assert read_description(written(tmp_path, lambda data: data.pop("servo_safety"))).servos is not None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda data: data["servo_safety"].update(temprature=60),
            "unknown entry of servo_safety 'temprature'.*temperature",
        ),
        (lambda data: data["servo_safety"].update(temperature=-1), "temperature: expected a positive number, found -1"),
        (lambda data: data["servo_safety"].update(current="much"), "current: expected a positive number, found 'much'"),
        (lambda data: data["servo_safety"].update(watchdog_s=3.0), "watchdog_s: expected at most 2.54 s"),
        (lambda data: data["servo_safety"].update(on_fault="jump"), "on_fault 'jump'; valid: hold, off"),
        (lambda data: data["servos"].update(settings={"mode": "wheel"}), "servo mode 'wheel'; valid: current-based"),
        (
            lambda data: data["servos"].update(settings={"gain": 1}),
            "entry of servos settings 'gain'; did you mean",
        ),
        (lambda data: data["servos"]["motor"].update(voltage=0), "motor voltage: expected a positive number, found 0"),
        (
            lambda data: data["servos"]["motor"].update(volts=12),
            "entry of servos motor 'volts'; did you mean",
        ),
        (lambda data: data["servos"]["motor"].pop("voltage"), "missing 1 required .* 'voltage'"),
        (lambda data: data["servos"].update(models={"tail": "XL430-W250"}), "servo model 'tail'"),
        (lambda data: data["servos"]["ids"].update(head_pan=20), "two joints have the same servo id"),
        (lambda data: data["servos"]["ids"].update(tail=99), "joint with a servo 'tail'"),
        (
            lambda data: data["servos"]["ids"].update(head_pan=19.7),
            "head_pan: expected a servo id 0 to 252, found 19.7",
        ),
        (lambda data: data["servos"]["ids"].update(head_pan=253), "head_pan: expected a servo id 0 to 252, found 253"),
        (lambda data: data["servos"]["board"].update(id=5), "board has the id 5 of a servo"),
        (lambda data: data["servos"]["board"].update(id=200.5), "board id: expected a whole number from 0 to 252"),
        (lambda data: data["servos"]["board"].update(power="on"), "board power: expected a whole number"),
        (lambda data: data["servos"]["board"].update(button_names="start"), "button_names: expected a list of 1 to 8"),
        (lambda data: data["servos"]["board"].update(wait_s=-1), "board wait_s: expected a number of at least 0"),
        (lambda data: data["servos"]["board"].update(watts=1), "entry of servos board 'watts'; did you mean"),
        (lambda data: data["servos"]["board"].pop("voltage"), "missing 1 required .* 'voltage'"),
    ],
)
def test_a_wrong_servo_section_is_refused(tmp_path: Path, change: Callable[[dict[str, Any]], object], words: str):
    with pytest.raises((InvalidFile, UnknownName), match=words):
        read_description(written(tmp_path, change))
