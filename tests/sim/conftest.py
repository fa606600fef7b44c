"""Trajectories of known character, made from the robots' standing poses."""

import base64
import json
import shutil
import subprocess
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest

from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robot_model import kinematic_model, standing_qpos
from ros_free_stack.robots import RobotDescription, load_robot

StandingMaker = Callable[..., RobotTrajectory]


@pytest.fixture(scope="session")
def op3() -> RobotDescription:
    return load_robot("op3")


@pytest.fixture(scope="session")
def g1() -> RobotDescription:
    return load_robot("g1")


@pytest.fixture(scope="session")
def standing() -> StandingMaker:
    """A maker of trajectories that stand still except where told: offsets broadcast over (T, ...) frames."""
    poses: dict[str, np.ndarray] = {}

    def make(
        robot: RobotDescription,
        *,
        frames: int = 50,
        fps: float = 50.0,
        root_offset: object = 0.0,
        joints: dict[str, np.ndarray] | None = None,
        contacts: bool = True,
    ) -> RobotTrajectory:
        if robot.name not in poses:
            poses[robot.name] = standing_qpos(kinematic_model(robot), robot)
        root = poses[robot.name]
        joint_pos = np.tile(robot.standing_pos, (frames, 1))
        for name, values in (joints or {}).items():
            joint_pos[:, robot.joint_names.index(name)] = values
        return RobotTrajectory(
            robot=robot.name,
            model_sha256=robot.sha256,
            joint_names=robot.joint_names,
            fps=fps,
            root_pos=np.tile(root[:3], (frames, 1)) + np.asarray(root_offset),
            root_quat=np.tile(root[3:7], (frames, 1)),
            joint_pos=joint_pos,
            contacts=np.full((frames, len(robot.foot_names)), contacts),
            foot_names=robot.foot_names,
        )

    return make


class BrowserError(Exception):
    """The browser's own word on what it could not do."""


class Chromium:
    """One page of a headless Chromium, driven over its DevTools protocol."""

    def __init__(self, connection: Any) -> None:
        self._connection, self._calls = connection, 0

    def open(self, address: str) -> None:
        self._call("Page.navigate", url=address)

    def evaluate(self, script: str) -> Any:
        """The value of a JavaScript expression; a promise is waited for."""
        answer = self._call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        return answer["result"].get("value")

    def screenshot(self, path: Path) -> np.ndarray:
        """Save a PNG and return it as (height, width, 3) floats, 0 to 1."""
        import matplotlib.image

        path.write_bytes(base64.b64decode(self._painted()))
        return matplotlib.image.imread(path)[..., :3]

    def _painted(self) -> str:
        """A PNG in base 64. On a busy machine the browser refuses pictures of a page that it has not painted yet."""
        deadline = monotonic() + 120
        while True:
            try:
                return self._call("Page.captureScreenshot", format="png")["data"]
            except BrowserError:
                if monotonic() > deadline:
                    raise
                sleep(0.5)

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._calls += 1
        self._connection.send(json.dumps({"id": self._calls, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self._connection.recv(timeout=120))
            if answer.get("id") != self._calls:
                continue
            if "error" in answer:
                raise BrowserError(f"{method}: {answer['error']['message']}")
            return answer["result"]


@pytest.fixture
def chromium(tmp_path: Path) -> Iterator[Chromium]:
    """A headless browser; the test is skipped where none is installed."""
    from websockets.sync.client import connect

    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if program is None:
        pytest.skip("needs Chromium (apt-get install chromium)")
    options = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    options += [f"--user-data-dir={tmp_path / 'profile'}", "--remote-debugging-port=0", "--window-size=700,500"]
    with subprocess.Popen([program, *options, "about:blank"], stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            line = next((line for line in process.stderr if "DevTools listening on" in line), None)
            if line is None:
                pytest.skip(f"{program} does not start here")
            host = line.split("ws://")[1].split("/")[0]
            with urllib.request.urlopen(f"http://{host}/json") as answer:
                page = next(item for item in json.load(answer) if item["type"] == "page")
            with connect(page["webSocketDebuggerUrl"], max_size=None) as connection:
                yield Chromium(connection)
        finally:
            process.terminate()
            process.wait()
