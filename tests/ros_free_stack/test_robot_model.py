"""Models as descriptions see them: quick without meshes yet with the same inertias, a free root, locked joints."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml

from ros_free_stack.couplings import joint_couplings
from ros_free_stack.errors import InvalidFile, UnknownName, UnsupportedModel
from ros_free_stack.robot_model import kinematic_model, read_spec, standing_qpos, strip_meshes
from ros_free_stack.robots import load_robot, read_description, robot_names

TETRAHEDRON = 'vertex="0 0 0  .2 0 0  0 .2 0  0 0 .2"'
ARM = """<mujoco><compiler angle="degree"/>
<asset><mesh name="part" {mesh}/><texture name="skin" type="2d" file="none.png"/>
<material name="paint" texture="skin"/></asset>
<worldbody><body name="stand" pos="0 0 1"><geom size=".1" material="paint"/>
  <body name="upper"><joint name="swing" axis="0 1 0" range="-90 45"/><geom type="mesh" mesh="part"/>
    <body name="lower" pos="0 0 -.3"><joint name="bend" axis="0 1 0" range="-90 90" ref="10"/>
      <inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/><geom type="mesh" mesh="part"/>
    </body></body></body></worldbody>
<keyframe><key name="home" qpos="0.1 0.2"/></keyframe></mujoco>"""
LIMITS = {"range": [-1.0, 0.5], "velocity": 5, "acceleration": 50, "effort": 10}


def described(tmp_path: Path, mjcf: str = ARM.format(mesh=TETRAHEDRON), **changes: Any) -> Path:
    """A description of the arm, with changes; None removes a key."""
    (tmp_path / "arm.xml").write_text(mjcf)
    data: dict[str, Any] = {
        "name": "arm", "title": "Arm", "model": {"file": "arm.xml"}, "mount": "fixed", "root_body": "stand",
        "torso_body": "stand", "torso_lean": 0.5, "attachments": {"pelvis": {"body": "stand"}},
        "joints": {"swing": LIMITS}, "locked": {"bend": 0.4}, "limits_source": "chosen",
    }  # fmt: skip
    path = tmp_path / "arm.yaml"
    path.write_text(yaml.safe_dump({k: v for k, v in (data | changes).items() if v is not None}))
    return path


def test_stripping_keeps_inertias_that_meshes_make(tmp_path: Path):
    model = ARM.format(mesh=TETRAHEDRON).replace('file="none.png"', 'builtin="flat" width="8" height="8"')
    (tmp_path / "arm.xml").write_text(model)
    whole = read_spec(tmp_path / "arm.xml").compile()
    spec = read_spec(tmp_path / "arm.xml")
    strip_meshes(spec)
    stripped = spec.compile()
    assert (whole.ngeom, stripped.ngeom, stripped.ntex) == (3, 2, 0)
    for name in ("body_mass", "body_inertia", "body_ipos", "body_iquat"):
        np.testing.assert_allclose(getattr(stripped, name), getattr(whole, name))


def test_a_fixed_root_gets_a_free_joint_and_locked_joints_hold(tmp_path: Path):
    robot = read_description(described(tmp_path))
    model = kinematic_model(robot)
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE and model.nkey == 0
    np.testing.assert_allclose(model.joint("swing").range, [-1.0, 0.5])
    qpos = standing_qpos(model, robot)
    np.testing.assert_allclose(qpos[:7], [0, 0, 1, 1, 0, 0, 0])
    assert qpos[model.joint("bend").qposadr[0]] == pytest.approx(0.4)
    assert [coupling.source for coupling in joint_couplings(model)] == [None]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"attachments": {"pelvis": {"body": "hip"}}}, "attachments names a body 'hip' that arm.xml lacks"),
        ({"torso_body": "chest"}, "torso_body names a body 'chest'"),
        ({"joints": {"elbow": LIMITS}}, "names a joint 'elbow' that arm.xml lacks"),
        ({"locked": {"wrist": 0}}, "names a joint 'wrist'"),
        ({"mount": "free"}, "a robot without soles cannot stand"),
        ({"title": None}, "the entry 'title' is missing"),
        ({"model": {"file": "gone.xml"}}, "gone.xml"),
    ],
)
def test_a_wrong_description_is_one_clear_line(tmp_path: Path, changes: dict[str, Any], words: str):
    path = described(tmp_path, **changes)
    with pytest.raises(InvalidFile, match=words) as caught:
        kinematic_model(read_description(path))
    assert "arm.yaml" in str(caught.value) and "\n" not in str(caught.value)


def test_a_wrong_mount_lists_the_valid_ones(tmp_path: Path):
    with pytest.raises(UnknownName, match="mount 'loose'; valid: fixed, free"):
        read_description(described(tmp_path, mount="loose"))


def test_a_root_with_joints_of_its_own_is_refused(tmp_path: Path):
    path = described(tmp_path, root_body="upper", torso_body="upper", attachments={"pelvis": {"body": "upper"}})
    with pytest.raises(UnsupportedModel, match="'upper' must be a child of the world"):
        kinematic_model(read_description(path))


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ("not xml", "not a MuJoCo model"),
        (ARM.format(mesh='file="gone.stl"'), "cannot compile this model .*gone.stl"),
    ],
)
def test_a_damaged_model_is_one_clear_line(tmp_path: Path, model: str, words: str):
    path = described(tmp_path, model)
    with pytest.raises(InvalidFile, match=words) as caught:
        kinematic_model(read_description(path))
    assert "arm.xml" in str(caught.value) and "\n" not in str(caught.value)


def test_robots_of_the_user_go_by_name_or_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = described(tmp_path)
    monkeypatch.setenv("RFS_ROBOTS", str(tmp_path))
    assert "arm" in robot_names() and load_robot("arm").sha256 == load_robot(str(path)).sha256
    path.rename(tmp_path / "other.yaml")
    with pytest.raises(InvalidFile, match="describes a robot named 'arm'"):
        load_robot("other")
    (tmp_path / "other.yaml").rename(tmp_path / "g1.yaml")
    with pytest.raises(InvalidFile, match="a robot named g1 is described already"):
        robot_names()
