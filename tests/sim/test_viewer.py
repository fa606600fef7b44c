"""The viewer: its clock, what the server draws, its page in a browser, and how it ends."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import mujoco
import numpy as np
import pytest

from ros_free_stack.errors import InvalidOption
from ros_free_stack.files import save_motion, save_trajectory
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import INDEX, JOINT_COUNT
from sim.draw.appearance import visual_model
from sim.draw.playback_frames import make_film
from sim.judge.verdict import judge
from sim.view.browser import BrowserViewer, human_viewer, robot_viewer
from sim.view.play import Play
from sim.view.player import Player
from sim.view.window import DOWN, LEFT, RIGHT, SPACE, UP, press

ROOT = Path(__file__).parents[2]


@pytest.fixture
def motion():
    joints = np.random.default_rng(0).uniform(0, 1.5, (JOINT_COUNT, 3)) + np.arange(40)[:, None, None] * 0.01
    return HumanMotion(joints, 20.0, "a person walks")


@pytest.fixture
def viewer(op3, standing):
    """OP3 raising an arm in physics, with the plan as a ghost."""
    trajectory = standing(op3, frames=50, joints={"l_sho_pitch": np.linspace(0, 1.0, 50)})
    model = visual_model(op3)
    film = make_film(trajectory, op3, model, fps=50.0, judgement=judge(trajectory, op3))
    viewer = robot_viewer(film, model, op3, port=0)
    yield viewer, film, model
    viewer.close()


def node(viewer: BrowserViewer, name: str) -> Any:
    handle = viewer.server.scene.get_handle_by_name(name)
    assert handle is not None
    return handle


def test_clock():
    player = Player(frames=51, fps=25.0)
    player.advance(0.5)
    assert player.time_s == 0.5 and player.frame == 12
    player.speed = 0.5
    player.advance(0.5)
    assert player.time_s == 0.75
    player.advance(10)
    assert player.time_s == 0 and player.playing
    player.scrub(99)
    assert player.frame == 50 and not player.playing
    player.advance(1)
    assert player.frame == 50


def test_keys():
    player = Player(frames=10, fps=10.0)
    press(player, SPACE)
    assert not player.playing
    press(player, RIGHT)
    press(player, RIGHT)
    press(player, LEFT)
    assert player.frame == 1
    for _ in range(9):
        press(player, UP)
    assert player.speed == 2
    press(player, DOWN)
    assert player.speed == 1


def test_scrubbing_changes_what_is_drawn(viewer):
    shown, film, model = viewer
    data = mujoco.MjData(model)
    arm = model.body("l_el_link").id
    for name, poses in (("robot", film.qpos), ("plan", film.planned)):
        for time in (0.0, 0.6):
            shown.player.scrub(time)
            shown.show()
            data.qpos[:] = poses[round(time * 50)]
            mujoco.mj_kinematics(model, data)
            assert np.allclose(node(shown, f"/{name}/{arm}").position, data.xpos[arm], atol=1e-6)
    assert shown.slider.value == pytest.approx(0.6)


def test_contacts_stand_under_the_feet(viewer):
    shown, film, _ = viewer
    left, right = (node(shown, f"/contacts/{foot}") for foot in ("left", "right"))
    assert left.visible and right.visible
    assert left.position[1] > 0.02 > -0.02 > right.position[1] and left.position[2] == 0
    assert np.allclose(node(shown, "/contacts/zmp").position[:2], film.zmp[0])
    assert min(left.dimensions[:2]) > 0.05


def test_human(motion):
    shown = human_viewer(motion.joints, motion.fps, ("",) * 40, "walk", port=0)
    try:
        shown.player.scrub(1.0)
        shown.show()
        assert np.allclose(node(shown, "/human/head").position, motion.joints[20, INDEX["head"]])
        wrist = node(shown, f"/human/{INDEX['left_wrist']}")
        pair = motion.joints[20, [INDEX["left_elbow"], INDEX["left_wrist"]]]
        assert np.allclose(wrist.position, pair.mean(axis=0))
        axis = np.zeros(3)
        mujoco.mju_rotVecQuat(axis, np.array([0, 0, 1.0]), np.array(wrist.wxyz, float))
        assert np.allclose(axis, (pair[1] - pair[0]) / np.linalg.norm(pair[1] - pair[0]))
    finally:
        shown.close()


def test_only_this_machine(viewer):
    shown, _, _ = viewer
    assert shown.address.startswith("http://127.0.0.1:")
    assert shown.server.get_host() == "127.0.0.1"


def test_port_in_use_is_said(op3, standing, tmp_path):
    save_trajectory(tmp_path / "t.npz", standing(op3))
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(InvalidOption, match=f"{port} is in use"):
            Play(source=tmp_path / "t.npz", where="browser", port=port).run()


def test_options_that_do_not_fit(motion, op3, standing, tmp_path, monkeypatch):
    save_motion(tmp_path / "m.npz", motion)
    save_trajectory(tmp_path / "t.npz", standing(op3))
    with pytest.raises(InvalidOption, match="--physics"):
        Play(source=tmp_path / "m.npz", physics=True).run()
    with pytest.raises(InvalidOption, match="--where"):
        Play(source=tmp_path / "m.npz", where="window").run()
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    if sys.platform == "linux":
        with pytest.raises(InvalidOption, match="no display"):
            Play(source=tmp_path / "t.npz", where="window").run()
    with pytest.raises(InvalidOption, match="--port"):
        Play(source=tmp_path / "t.npz", where="browser", port=70000).run()


def test_command_prints_its_address_and_ends(motion, tmp_path):
    """The command as a user runs it; Ctrl-C ends it with 0 and frees the port."""
    save_motion(tmp_path / "m.npz", motion)
    command = [sys.executable, "launch.py", "play", str(tmp_path / "m.npz"), "--port", "0"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        address = process.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:")
        port = int(address.rpartition(":")[2])
        with urllib.request.urlopen(address, timeout=10) as page:
            assert b"<html" in page.read().lower()
        assert "Ctrl-C" in process.stderr.readline()
        try:
            process.send_signal(signal.SIGINT)
            assert process.wait(30) == 0
            assert process.stderr.read().strip() == "stopped"
        finally:
            process.kill()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port), timeout=10)


def test_window_on_a_display(op3, standing, tmp_path):
    """The command on a virtual display draws the robot into a window and ends with Ctrl-C."""
    if not shutil.which("Xvfb"):
        pytest.skip("needs Xvfb (apt-get install xvfb)")
    import imageio_ffmpeg

    save_trajectory(tmp_path / "t.npz", standing(op3))
    screen = ["Xvfb", "-displayfd", "1", "-screen", "0", "640x480x24"]
    with subprocess.Popen(screen, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        assert server.stdout is not None
        display = ":" + server.stdout.readline().strip()
        command = [sys.executable, "launch.py", "play", str(tmp_path / "t.npz")]
        environment = os.environ | {"DISPLAY": display}
        grab = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-f", "x11grab", "-i", display]
        grab += ["-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "gray", "-"]
        with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None and process.stdout.readline() == "a window\n"
            deadline, bright = monotonic() + 60, 0.0
            while bright < 0.1 and monotonic() < deadline:
                sleep(1)
                pixels = np.frombuffer(subprocess.run(grab, stdout=subprocess.PIPE, check=True).stdout, np.uint8)
                bright = float((pixels > 128).mean())
            try:
                process.send_signal(signal.SIGINT)
                assert process.wait(30) == 0
            finally:
                process.kill()
                server.terminate()
    assert bright > 0.1, "nothing but a black screen"


def test_page_in_a_browser(motion, chromium, tmp_path):
    """The page shows the human, and its button plays."""
    shown = human_viewer(motion.joints, motion.fps, ("walks on",) * 40, "walk", port=0)
    shown.player.scrub(0.0)
    ended = threading.Event()
    thread = threading.Thread(target=lambda: shown.run(until=ended.is_set))
    thread.start()
    try:
        chromium.open(shown.address)
        assert _eventually(lambda: _orange(chromium.screenshot(tmp_path / "page.png"))), "the human's left side"
        words = ("walks on", "speed", "Play")  # the panel may come after the first picture
        assert _eventually(lambda: all(word in chromium.evaluate("document.body.innerText") for word in words))
        chromium.evaluate("[...document.querySelectorAll('button')].find(b => b.innerText == 'Play').click()")
        assert _eventually(lambda: shown.player.playing)
    finally:
        ended.set()
        thread.join()


def _orange(picture):
    """Whether the left side's colour is anywhere on a picture."""
    return ((picture[..., 0] - picture[..., 2]) > 0.3).mean() > 0.001


def _eventually(happened):
    """Whether something happened within the time that a page takes on a machine with much else to do."""
    deadline = monotonic() + 120
    while not (found := happened()) and monotonic() < deadline:
        sleep(0.5)
    return found
