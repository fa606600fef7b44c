"""The report, the storyboard and the command line, used as people use them."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from time import sleep

import matplotlib.image
import numpy as np
import pytest

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import load_verdict, save_telemetry, save_trajectory
from ros_free_stack.messages import HumanMotion, Segment, ServoTelemetry
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import JOINT_COUNT
from sim.cli import Validate
from sim.draw.report import write_report
from sim.draw.storyboard import write_storyboard
from sim.draw.worst import culprits
from sim.judge.verdict import judge
from sim.model import judging_model
from sim.reference import make_reference


class Page(HTMLParser):
    """Collects what a page would load and its rows of checks."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.sources: list[str] = []
        self.rows: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.sources += [values[key] or "" for key in ("src", "href") if key in values]
        if tag == "tr":
            self.rows.append(values.get("class") or "")


@pytest.fixture(scope="module")
def motion():
    rng = np.random.default_rng(0)
    joints = np.cumsum(rng.normal(0, 0.002, (30, JOINT_COUNT, 3)), axis=0) + rng.uniform(0, 1, (JOINT_COUNT, 3))
    return HumanMotion(joints, 20.0, "a person <b>waves</b>", (Segment("a person <waves> </script>", 0.2, 1.0),))


def test_report_is_whole_and_offline(op3, standing, motion, tmp_path):
    trajectory = standing(op3, frames=100)
    judgement = judge(trajectory, op3)
    path = write_report(tmp_path / "new", motion, trajectory, judgement, op3, motion.prompt, {"judge": 1.0})
    text = path.read_text(encoding="utf-8")
    page = Page(text)
    assert page.sources and all(source.startswith("data:image/") for source in page.sources)
    assert page.rows.count("pass") == len(judgement.verdict.checks) and "fail" not in page.rows
    assert "{{" not in text and "<b>waves" not in text and "<waves>" not in text
    data = re.search(r'type="application/json">(.*?)</script>', text, re.S)
    assert data is not None
    scene = json.loads(data[1])
    assert len(scene["robot"]) == len(scene["simulated"]) == len(scene["human"]) == 50
    assert len(scene["robot"][0]) == judging_model(op3).nbody


def test_report_of_arms_on_a_stand_has_no_feet(standing, motion, tmp_path):
    robot = load_robot("g1_upper")
    trajectory = standing(robot)
    text = write_report(tmp_path, motion, trajectory, judge(trajectory, robot), robot).read_text(encoding="utf-8")
    assert "checks passed." in text
    assert 'alt="feet"' not in text


def test_report_of_a_failure_names_it(g1, standing, tmp_path):
    trajectory = standing(g1, root_offset=[0, 0, -0.05])
    judgement = judge(trajectory, g1, physics=False)
    text = write_report(tmp_path, None, trajectory, judgement, g1).read_text(encoding="utf-8")
    assert Page(text).rows.count("fail") == 1
    assert f"1 of {len(judgement.verdict.checks)} checks failed: ground penetration" in text


def test_report_needs_a_folder(op3, standing, tmp_path):
    (tmp_path / "file").write_text("")
    trajectory = standing(op3)
    with pytest.raises(InvalidFile):
        write_report(tmp_path / "file", None, trajectory, judge(trajectory, op3, physics=False), op3)


def test_storyboard_shows_human_and_robot(op3, standing, motion, tmp_path):
    reference = make_reference(standing(op3, frames=100), op3, judging_model(op3))
    write_storyboard(tmp_path / "both.png", motion, reference, "title")
    write_storyboard(tmp_path / "robot.png", None, reference)
    both, robot = (matplotlib.image.imread(tmp_path / name) for name in ("both.png", "robot.png"))
    assert both.shape[1] == robot.shape[1] and both.shape[0] > 1.5 * robot.shape[0]
    for picture in (both, robot):
        assert 0.03 < (picture[..., :3].min(axis=-1) < 0.8).mean() < 0.6


def test_validate_passes(op3, standing, tmp_path, capsys):
    save_trajectory(tmp_path / "t.npz", standing(op3))
    assert Validate(trajectory=tmp_path / "t.npz", out=tmp_path / "out", json=True).run() == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["passed"] and len(printed["checks"]) > 10
    assert load_verdict(tmp_path / "out" / "verdict.json").trajectory_digest == standing(op3).digest
    assert (tmp_path / "out" / "report.html").stat().st_size > 100_000


def test_validate_fails(op3, standing, tmp_path, capsys):
    save_trajectory(tmp_path / "t.npz", standing(op3, root_offset=[0, 0, -0.05]))
    assert Validate(trajectory=tmp_path / "t.npz", physics=False).run() == 3
    printed = capsys.readouterr().out
    assert "FAIL  ground_penetration" in printed and printed.rstrip().endswith("infeasible")
    assert Validate(trajectory=tmp_path / "t.npz", physics=False, mount="fixed").run() == 0


def test_validate_refuses_a_truncated_file(op3, standing, tmp_path):
    file = tmp_path / "t.npz"
    save_trajectory(file, standing(op3))
    file.write_bytes(file.read_bytes()[:500])
    with pytest.raises(InvalidFile):
        Validate(trajectory=file).run()


def test_no_verdict_file_without_physics(tmp_path: Path) -> None:
    with pytest.raises(InvalidOption, match="--no-physics"):
        Validate(trajectory=tmp_path / "t.npz", physics=False, out=tmp_path / "out").run()
    assert not (tmp_path / "out").exists()


def test_report_plots_what_the_servos_did(op3, standing, tmp_path):
    times = np.arange(50) / 125
    goal = np.column_stack([np.sin(times), np.cos(times)])
    telemetry = ServoTelemetry(
        robot="op3",
        joint_names=("r_el", "l_el"),
        time_s=times,
        late_s=np.full(50, 1e-4),
        goal=goal,
        fresh=np.arange(100).reshape(50, 2) % 10 > 0,
        position=goal - 0.02,
        velocity=np.zeros((50, 2)),
        current=np.tile([0.1, -0.8], (50, 1)),
        voltage=np.full((50, 2), 12.0),
        temperature=np.tile([30.0, 41.0], (50, 1)),
    )
    save_trajectory(tmp_path / "t.npz", standing(op3))
    save_telemetry(tmp_path / "telemetry.npz", telemetry)
    out = tmp_path / "out"
    Validate(trajectory=tmp_path / "t.npz", telemetry=tmp_path / "telemetry.npz", out=out).run()
    text = (out / "report.html").read_text()
    assert 'alt="servo angles"' in text and 'alt="servo health"' in text
    assert "10.0% of the readings were not fresh" in text
    Validate(trajectory=tmp_path / "t.npz", out=out).run()
    assert "servo angles" not in (out / "report.html").read_text()


def test_cursors_lie_on_the_plots(op3, standing, tmp_path):
    """Every plot over time has a cursor, placed on the picture and scaled in the motion's seconds."""
    trajectory = standing(op3, frames=100)
    text = write_report(tmp_path, None, trajectory, judge(trajectory, op3, physics=False), op3).read_text()
    found = re.findall(r'class="plot" data-start="(\S+)" data-end="(\S+)" style="left:([^%]+)%;width:([^%]+)%', text)
    assert len(found) == len(op3.joints) + len(op3.soles)
    for start, end, left, width in (map(float, row) for row in found):
        assert start < 0.0 and 1.98 < end < 2.2
        assert 0 < left < left + width <= 100


def test_worst_frame_of_every_failed_check(g1, standing, tmp_path):
    trajectory = standing(g1, root_offset=[0, 0, -0.05], joints={"left_elbow_joint": np.full(50, 9.0)})
    judgement = judge(trajectory, g1, physics=False)
    text = write_report(tmp_path, None, trajectory, judgement, g1).read_text(encoding="utf-8")
    failed = [check for check in judgement.verdict.failures if check.worst_frame >= 0]
    assert {"ground_penetration", "joint_range"} <= {check.name for check in failed}
    for check in failed:
        assert f'alt="worst frame: {check.name.replace("_", " ")}"' in text


def test_culprits_are_found_by_any_name(op3, standing):
    reference = make_reference(standing(op3, frames=2), op3, judging_model(op3))
    model = reference.model
    assert culprits(reference, "l_el_link and r_hip_yaw_link") == {
        model.body("l_el_link").id,
        model.body("r_hip_yaw_link").id,
    }
    assert culprits(reference, "l_el") == {model.body("l_el_link").id}
    assert culprits(reference, "left") == {model.body(op3.soles["left"].body).id}
    assert culprits(reference, "") == set()


def test_page_plays_and_its_cursors_follow(op3, standing, chromium, tmp_path):
    """In a browser: a jump to a moment moves the slider and every cursor; nothing is asked of the network."""
    trajectory = standing(op3, frames=100, root_offset=[0, 0, -0.05])
    path = write_report(tmp_path, None, trajectory, judge(trajectory, op3, physics=False), op3)
    chromium.open(path.as_uri())
    for _ in range(100):
        if chromium.evaluate("document.readyState") == "complete" and chromium.evaluate("typeof goTo") == "function":
            break
        sleep(0.2)
    assert chromium.evaluate("performance.getEntriesByType('resource').every(e => e.name.startsWith('data:'))")
    chromium.evaluate("goTo(1.0)")
    assert chromium.evaluate("document.getElementById('time').value") == "25"
    expected = "100 * (1 - plot.start) / (plot.end - plot.start)"
    assert chromium.evaluate(f"plots.every(plot => Math.abs(parseFloat(plot.line.style.left) - {expected}) < 0.01)")
    assert chromium.evaluate("plots.length") > 20
    picture = chromium.screenshot(tmp_path / "report.png")
    assert picture.std() > 0.02
