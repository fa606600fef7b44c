"""Feasible is not faithful, and many prompts are many runs: outcomes and exit codes through the command line."""

import json
from pathlib import Path

import pytest

import launch
from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from generator.registry import DEFAULT, WEIGHTS_FOLDER
from pipeline.pipeline import Pipeline
from ros_free_stack.files import load_motion, save_motion
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS

pytestmark = pytest.mark.skipif(
    not (WEIGHTS_FOLDER / DEFAULT / "mask").is_dir(), reason="the weights folder holds no trained models"
)
QUICK = ("--candidates", "1", "--no-video", "--json")


@pytest.fixture
def always_waves(monkeypatch: pytest.MonkeyPatch) -> None:
    """A generator that waves the right hand, whatever it is asked for."""

    def generate(_: Pipeline, prompt: str, segments: tuple[str, ...], **__: object) -> tuple[HumanMotion, ...]:
        scene = Scene(1)
        perform(scene, "wave", side="right")
        positions = joints(scene.solve(0.5))
        told = (Segment(segments[0], 0.0, len(positions) / FPS),)
        return (HumanMotion(positions, FPS, prompt, told),)

    monkeypatch.setattr(Pipeline, "generate", generate)


@pytest.mark.usefixtures("always_waves")
def test_a_feasible_motion_that_lacks_the_action_is_no_success_and_is_not_streamed(tmp_path: Path, capsys):
    code = launch.main(["run", "a person squats", *QUICK, "--servo", "sim", "--out", str(tmp_path)])
    captured = capsys.readouterr()
    result = json.loads(captured.out)
    assert code == 5 and result["outcome"] == "NOT AS ASKED"
    assert result["verdict"]["passed"] and not result["faithful"]["passed"] and result["servo"] is None
    assert "does not show the action" in result["faithful"]["not_shown"][0]
    assert "feasible: yes; as asked: no, an action is missing" in captured.err
    assert "lacks an action that was asked for (--anyway streams it all the same)" in captured.err
    page = (tmp_path / "report.html").read_text()
    assert "feasible, but not as asked" in page and "does not show the action" in page


@pytest.mark.usefixtures("always_waves")
def test_anyway_streams_what_lacks_the_action(tmp_path: Path, capsys):
    arguments = ["run", "a person squats", *QUICK, "--anyway", "--servo", "sim", "--dry-run", "--out", str(tmp_path)]
    assert launch.main(arguments) == 5
    assert json.loads(capsys.readouterr().out)["servo"]["joints"] == 20


@pytest.mark.usefixtures("always_waves")
def test_a_file_of_prompts_is_a_folder_each_and_goes_on_after_a_bad_line(tmp_path: Path, capsys):
    prompts = tmp_path / "prompts.txt"
    prompts.write_text("wave with the right hand\n\n  photosynthesise \nwave with the right hand!\n", encoding="utf-8")
    code = launch.main(["run", "--prompts", str(prompts), *QUICK, "--out", str(tmp_path / "out")])
    captured = capsys.readouterr()
    runs = json.loads(captured.out)["runs"]
    assert [run["outcome"] for run in runs] == ["PASSED", "ERROR", "PASSED"] and code == 2
    assert "photosynthesise" in runs[1]["error"] and "error: prompt: " in captured.err
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["1-wave-with-the-right-hand", "3-wave-with-the-right-hand"]
    assert all((tmp_path / "out" / name / "verdict.json").exists() for name in names)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "say what the robot should do"),
        (("wave", "--prompts", "p.txt"), "say what the robot should do"),
        (("--prompts", "absent.txt"), "absent.txt: no such file"),
        (("--prompts", "empty.txt"), "has no line with a sentence"),
        (("--prompts", "binary.txt"), "is no text in UTF-8"),
        (("--prompts", "empty.txt", "--then", "bow"), "cannot be combined"),
        (("wave", "--duration", "3", "--then", "bow"), "--duration: cannot be combined"),
        (("wave", "--edit", "m.npz"), "--edit: needs --range"),
        (("wave", "--then", ""), "prompt: it is empty"),
    ],
)
def test_arguments_that_do_not_go_together_end_in_one_line(
    tmp_path: Path, monkeypatch, capsys, arguments: tuple[str, ...], words: str
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.txt").write_text(" \n\n")
    (tmp_path / "binary.txt").write_bytes(b"wave\n\xff\xfe")
    assert launch.main(["run", *arguments]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error:")]
    assert words in line
    assert sorted(path.name for path in tmp_path.iterdir()) == ["binary.txt", "empty.txt"]


def test_run_takes_what_generate_takes(tmp_path: Path, capsys):
    first, second = tmp_path / "first", tmp_path / "second"
    assert launch.main(["run", "a person waves", *QUICK, "--duration", "3", "--out", str(first)]) == 0
    motion = load_motion(first / "human_motion.npz")
    assert motion.duration_s == pytest.approx(3.0)
    save_motion(tmp_path / "start.npz", motion)
    arguments = ["--start", str(tmp_path / "start.npz"), "--then", "a person waves with the left hand"]
    assert launch.main(["run", "a person bows", *QUICK, *arguments, "--out", str(second)]) in (0, 3, 5)
    texts = [segment.text for segment in load_motion(second / "human_motion.npz").segments]
    assert texts == ["a person bows", "a person waves with the left hand"]
    capsys.readouterr()


def test_an_amount_is_followed_in_the_robots_own_seconds_and_told(tmp_path: Path, capsys):
    code = launch.main(["run", "a person waves for 4 seconds", *QUICK, "--out", str(tmp_path)])
    captured = capsys.readouterr()
    (line,) = json.loads(captured.out)["candidates"][0]["amounts"]
    told, asked = line.split(", asked for ")
    assert code == 0 and asked == "4 s" and line in captured.err
    assert float(told.removeprefix("duration: ").removesuffix(" s")) == pytest.approx(4.0, abs=0.2)
