"""`robots add`, as users run it: a robot of plain shapes becomes a description that retargets, or questions."""

import json
from pathlib import Path

import numpy as np
import pytest

from retarget.describe.bodies import segment_distances
from retarget.describe.checks import check_motion, limit_excess
from retarget.describe.cli import RobotsAdd
from retarget.describe.soles import find_sole
from retarget.pipeline import retarget
from ros_free_stack.errors import InvalidFile, InvalidOption, MissingDependency, UnknownName, UnsupportedModel
from ros_free_stack.robots import load_robot


def leg(side: str, sign: int) -> str:
    return f"""
    <body name="{side}A" pos="0 {0.1 * sign} -.1"><joint name="{side}1" axis="0 0 1" range="-1 1"/>
      <geom type="sphere" size=".04"/>
      <body name="{side}B"><joint name="{side}2" axis="1 0 0" range="-.6 .6"/><geom type="sphere" size=".04"/>
        <body name="{side}C"><joint name="{side}3" axis="0 1 0" range="-1.8 1"/>
          <geom type="capsule" fromto="0 0 -.05 0 0 -.3" size=".05"/>
          <body name="{side}D" pos="0 0 -.35"><joint name="{side}4" axis="0 1 0" range="0 2.4"/>
            <geom type="capsule" fromto="0 0 -.05 0 0 -.3" size=".04"/>
            <body name="{side}E" pos="0 0 -.35"><joint name="{side}5" axis="0 1 0" range="-1 1"/>
              <geom type="sphere" size=".03"/>
              <body name="{side}F"><joint name="{side}6" axis="1 0 0" range="-.5 .5"/>
                <geom type="box" size=".1 .045 .015" pos=".03 0 -.045"/>
              </body></body></body></body></body></body>"""


def arm(side: str, sign: int) -> str:
    return f"""
    <body name="{side}P" pos="0 {0.2 * sign} .35"><joint name="{side}7" axis="0 1 0" range="-3 3"/>
      <geom type="sphere" size=".04"/>
      <body name="{side}Q"><joint name="{side}8" axis="1 0 0" range="-2.5 2.5"/>
        <geom type="capsule" fromto="0 0 -.05 0 0 -.2" size=".035"/>
        <body name="{side}R" pos="0 0 -.25"><joint name="{side}9" axis="0 1 0" range="-2.4 0"/>
          <geom type="capsule" fromto="0 0 -.03 0 0 -.22" size=".03"/>
        </body></body></body>"""


def robot_xml(*, legs: bool = True, arms: bool = True, free: bool = True, compiler: str = "") -> str:
    """A small humanoid whose names say nothing; torques only of its motors."""
    limbs = "".join(
        limb(side, sign)
        for limb, wanted in ((leg, legs), (arm, arms))
        for side, sign in (("x", 1), ("y", -1))
        if wanted
    )
    numbers = [*range(1, 7)] * legs + [7, 8, 9] * arms
    motors = "".join(f'<motor joint="{side}{k}" ctrlrange="-40 40"/>' for side in "xy" for k in numbers)
    return f"""<mujoco><compiler angle="radian" autolimits="true"/>{compiler}<worldbody>
      <body name="trunk" pos="0 0 .86">{"<freejoint/>" if free else ""}
        <geom type="box" size=".07 .12 .18" pos="0 0 .2" mass="8"/>{limbs}
      </body></worldbody><actuator>{motors}</actuator></mujoco>"""


@pytest.fixture(autouse=True)
def robots_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "my_robots"
    monkeypatch.setenv("RFS_ROBOTS", str(folder))
    return folder


def model_file(tmp_path: Path, text: str, name: str = "little.xml") -> str:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def run_json(command: RobotsAdd, capsys: pytest.CaptureFixture[str]) -> tuple[int, dict]:
    code = command.run()
    return code, json.loads(capsys.readouterr().out)


def test_an_unknown_robot_retargets_without_a_hand_edit(
    tmp_path: Path, robots_folder: Path, capsys: pytest.CaptureFixture[str]
):
    code, result = run_json(RobotsAdd(model=model_file(tmp_path, robot_xml()), accept=True, json=True), capsys)
    assert code == 0 and all(check["passed"] for check in result["checks"].values())
    places = result["attachments"]
    assert [places[f"left_{joint}"] for joint in ("hip", "knee", "ankle")] == ["xC", "xD", "xF"]
    assert [places[f"right_{joint}"] for joint in ("shoulder", "elbow", "wrist")] == ["yQ", "yR", "yR"]
    assert sorted(path.name for path in robots_folder.iterdir()) == ["little.png", "little.yaml"]
    robot = load_robot("little")
    corners = np.array(robot.soles["left"].corners)
    np.testing.assert_allclose(corners[0], [-0.07, 0.045, -0.06], atol=1e-3)
    np.testing.assert_allclose(corners[3], [0.13, -0.045, -0.06], atol=1e-3)
    assert robot.joints["x4"].effort == 40 and robot.joints["x4"].upper == 2.4
    assert ("xF", "yF") in robot.collision_pairs and robot.standing["x4"] > 0.2
    text = (robots_folder / "little.yaml").read_text()
    assert "guessed" in robot.limits_source and "# guessed: wrists" in text
    trajectory = retarget(check_motion(), robot).trajectory
    assert trajectory.robot == "little" and max(limit_excess(robot, trajectory).values()) < 1e-6


def test_arms_on_a_stand(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    text = robot_xml(legs=False, free=False)
    code, result = run_json(RobotsAdd(model=model_file(tmp_path, text), name="arms", accept=True, json=True), capsys)
    assert code == 0
    robot = load_robot("arms")
    assert robot.mount == "fixed" and not robot.soles and "left_knee" not in robot.attachments
    trajectory = retarget(check_motion(), robot).trajectory
    assert np.ptp(trajectory.root_pos, axis=0).max() == 0
    assert np.ptp(trajectory.joint_pos, axis=0).max() > 0.5
    assert result["attachments"]["left_elbow"] == "xR"


def test_without_accept_and_terminal_nothing_is_written(
    tmp_path: Path, robots_folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("sys.stdin.isatty", lambda: False, raising=False)
    command = RobotsAdd(model=model_file(tmp_path, robot_xml(legs=False, free=False)), json=True)
    code, result = run_json(command, capsys)
    assert code == 0 and result["description"] is None
    assert [path.name for path in robots_folder.iterdir()] == ["little.png"]


def test_a_free_robot_without_feet_is_asked_whether_it_is_held(
    tmp_path: Path, robots_folder: Path, capsys: pytest.CaptureFixture[str]
):
    model = model_file(tmp_path, robot_xml(legs=False).replace('name="xP"', 'name="left_arm"'))
    code, result = run_json(RobotsAdd(model=model, accept=True, json=True), capsys)
    assert code == 2 and not robots_folder.exists()
    (question,) = result["undecided"]
    assert question["key"] == "mount" and question["candidates"] == ["fixed"]
    given = tmp_path / "given.yaml"
    given.write_text("mount: fixed\n")
    assert RobotsAdd(model=model, given=given, accept=True).run() == 0
    assert load_robot("little").mount == "fixed"


def test_a_limb_that_does_not_bend_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    straight = robot_xml(arms=False).replace('pos="0 0 -.35"', 'pos="0 0 -.001"')
    assert RobotsAdd(model=model_file(tmp_path, straight), accept=True).run() == 2
    text = capsys.readouterr().out
    assert "attachments.left_knee: no joint bends this limb like a knee (candidates: xA, xB" in text
    assert "--given FILE" in text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello", "not a MuJoCo model .*XML"),
        ("<mujoco><a/></mujoco>", "not a MuJoCo model .*unrecognized element"),
        ('<mujoco><worldbody><body><joint name="j"/></body></worldbody></mujoco>', "cannot compile .*mass and inertia"),
        (
            '<mujoco><asset><mesh name="hand" file="gone.stl"/></asset><worldbody><body name="a"><joint name="j"/>'
            '<geom type="mesh" mesh="hand"/></body></worldbody></mujoco>',
            "lacks the mesh file gone.stl",
        ),
    ],
)
def test_a_bad_model_is_one_clear_line(tmp_path: Path, text: str, words: str):
    with pytest.raises(InvalidFile, match=words) as caught:
        RobotsAdd(model=model_file(tmp_path, text)).run()
    assert "\n" not in str(caught.value) and "little.xml" in str(caught.value)


def test_other_bad_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    model = model_file(tmp_path, robot_xml())
    with pytest.raises(InvalidFile, match="no such model file"):
        RobotsAdd(model=str(tmp_path / "none.xml")).run()
    with pytest.raises(InvalidOption, match="described already"):
        RobotsAdd(model=model, name="g1").run()
    with pytest.raises(InvalidOption, match="lower-case letters"):
        RobotsAdd(model=model, name="My Robot").run()
    with pytest.raises(InvalidOption, match=r"ends in \.yaml"):
        RobotsAdd(model=model, out=tmp_path / "a.txt").run()
    given = tmp_path / "given.yaml"
    given.write_text("knees: [a, b]\n")
    with pytest.raises(UnknownName, match="key 'knees'; valid: attachments, mount"):
        RobotsAdd(model=model, given=given).run()
    with pytest.raises(UnsupportedModel, match="no joints"):
        still = "<mujoco><worldbody><body><geom size='.1'/></body></worldbody></mujoco>"
        RobotsAdd(model=model_file(tmp_path, still)).run()
    monkeypatch.setitem(__import__("sys").modules, "mujoco_menagerie", None)
    with pytest.raises(MissingDependency, match=r"mujoco-menagerie is missing: pip install"):
        RobotsAdd(model="menagerie:pal_talos").run()


def test_menagerie_without_network_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    package = pytest.importorskip("mujoco_menagerie")
    with pytest.raises(UnknownName, match=r"Menagerie robot 'r2d2'; valid: .*unitree_g1"):
        RobotsAdd(model="menagerie:r2d2").run()

    def unreachable(*_: object, **__: object) -> None:
        raise package.DownloadError("no route")

    monkeypatch.setattr(package.Robot, "path", unreachable)
    with pytest.raises(InvalidFile, match=r"menagerie:pal_talos: not in the cache .*no route.*give the path"):
        RobotsAdd(model="menagerie:pal_talos").run()


def test_the_sole_is_the_flat_underside_of_a_tilted_foot():
    box = np.array([[x, y, z] for x in (-0.05, 0.15) for y in (-0.04, 0.04) for z in (-0.07, -0.03)])
    top = np.array([[0.0, 0.0, 0.05]])
    tilt = np.array([[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]])
    corners = find_sole(np.concatenate([box, top]) @ tilt.T, np.array([0.0, 0, -1]), np.array([1.0, 0, 0]))
    assert corners is not None
    flat = np.array([[-0.05, 0.04, -0.07], [-0.05, -0.04, -0.07], [0.15, 0.04, -0.07], [0.15, -0.04, -0.07]])
    np.testing.assert_allclose(corners @ tilt, flat, atol=1e-6)


def test_a_ball_has_no_sole():
    directions = np.random.default_rng(0).normal(size=(4000, 3))
    ball = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    corners = find_sole(ball, np.array([0.0, 0, -1]), np.array([1.0, 0, 0]))
    assert corners is None


def test_segment_distances_are_the_least_of_many_points():
    rng = np.random.default_rng(1)
    a, b, c, d = rng.normal(size=(4, 40, 3))
    shares = np.linspace(0, 1, 201)
    first = a[:, None] + shares[:, None] * (b - a)[:, None]
    second = c[:, None] + shares[:, None] * (d - c)[:, None]
    least = np.linalg.norm(first[:, :, None] - second[:, None], axis=-1).min(axis=(1, 2))
    np.testing.assert_allclose(segment_distances(a, b, c, d), least, atol=2e-2)
    assert np.all(segment_distances(a, b, c, d) <= least + 1e-9)
