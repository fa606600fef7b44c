"""The viewer in a native MuJoCo window: space plays and pauses, arrows step and change the speed."""

import os
import sys
import threading
from collections.abc import Callable
from time import perf_counter, sleep
from typing import Any

import mujoco
import numpy as np

from ros_free_stack.robot_model import sole_corners
from ros_free_stack.robots import RobotDescription
from sim.draw.appearance import extent
from sim.draw.markers import LimitPaint, add_contacts, add_human, add_zmp
from sim.draw.playback_frames import Film
from sim.view.player import Player

TICK_S = 1 / 60
SPACE, RIGHT, LEFT, DOWN, UP = 32, 262, 263, 264, 265
"""GLFW's key codes."""

HELP = "space: play or pause   left, right: one frame   up, down: speed"
_GHOST = np.array([0.15, 0.39, 0.92, 0.3], np.float32)
_ASIDE_M = 1.0


def has_display() -> bool:
    """Whether this session can open a window."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def press(player: Player, key: int) -> None:
    """What a key does."""
    if key == SPACE:
        player.toggle()
    elif key in (LEFT, RIGHT):
        player.step(1 if key == RIGHT else -1)
    elif key in (UP, DOWN):
        player.faster(1 if key == UP else -1)


def play_in_window(film: Film, model: mujoco.MjModel, robot: RobotDescription, until: Callable[[], bool]) -> None:
    """Play a film until its window is closed, or until `until` says so.

    Raises:
        RuntimeError: the window cannot be opened here.
    """
    import mujoco.viewer

    player, data = Player(len(film), film.fps), mujoco.MjData(model)
    picture = _Picture(film, model, robot)
    others = set(threading.enumerate())
    with mujoco.viewer.launch_passive(
        model, data, key_callback=lambda key: press(player, key), show_left_ui=False, show_right_ui=False
    ) as window:
        with window.lock():
            picture.frame(window.cam)
        before = perf_counter()
        while window.is_running() and not until():
            now = perf_counter()
            player.advance(now - before)
            before = now
            with window.lock():
                picture.draw(player.frame, data, window.user_scn)
            state = f"{player.time_s:.2f} s, {player.speed:g}x"
            words = film.texts[player.frame] or film.title
            window.set_texts((None, mujoco.mjtGridPos.mjGRID_BOTTOMLEFT, f"{words}\n{HELP}", f"{state}\n"))
            window.sync()
            sleep(TICK_S)
    for thread in set(threading.enumerate()) - others:
        thread.join()  # it still draws the model


class _Picture:
    """One frame's pose and markers."""

    def __init__(self, film: Film, model: mujoco.MjModel, robot: RobotDescription) -> None:
        self._film, self._model, self._robot = film, model, robot
        self._paint, self._ghost = LimitPaint(model, robot), mujoco.MjData(model)
        low, high = extent(model, robot)
        self._size = high - low
        self._weight = float(model.body_subtreemass[0] * -model.opt.gravity[2])

    def frame(self, camera: Any) -> None:
        """Put the camera before the robot, and the human beside it, at first; the mouse moves it after that."""
        beside = self._film.human is not None
        camera.lookat[:] = self._film.qpos[0, :3] + ([0, _ASIDE_M / 2, 0] if beside else [0, 0, 0])
        camera.distance = 2 * self._size + (1.5 if beside else 0)
        camera.azimuth, camera.elevation = 180, -14

    def draw(self, frame: int, data: mujoco.MjData, scene: Any) -> None:
        film = self._film
        data.qpos[:] = film.qpos[frame]
        mujoco.mj_forward(self._model, data)
        self._paint.apply(film.at_limit[frame])
        scene.ngeom = 0
        soles = list(sole_corners(self._model, data, self._robot).values())
        force = None if film.force is None else film.force[frame]
        add_contacts(scene, soles, film.standing[frame], force, size=self._size, weight=self._weight)
        add_zmp(scene, film.zmp[frame], soles, film.standing[frame], size=self._size)
        if film.human is not None:
            add_human(scene, film.human[frame] + [0, _ASIDE_M, 0])
        if film.planned is not None:
            self._add_ghost(film.planned[frame], scene)

    def _add_ghost(self, qpos: np.ndarray, scene: Any) -> None:
        self._ghost.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._ghost)
        first = scene.ngeom
        dynamic = mujoco.mjtCatBit.mjCAT_DYNAMIC
        mujoco.mjv_addGeoms(self._model, self._ghost, mujoco.MjvOption(), mujoco.MjvPerturb(), dynamic, scene)
        for geom in scene.geoms[first : scene.ngeom]:
            geom.rgba[:], geom.matid = _GHOST, -1
