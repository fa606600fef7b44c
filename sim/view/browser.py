"""The viewer in a browser: a page on this machine alone, with play, pause, scrub, speed, contacts and ghost."""

import errno
import socket
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from time import perf_counter, sleep
from typing import Any

import mujoco
import numpy as np

from ros_free_stack.errors import InvalidOption
from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription
from sim.draw.appearance import extent
from sim.draw.playback_frames import Film
from sim.view.actors import Actor, ContactActor, HumanActor, RobotActor
from sim.view.player import SPEEDS, Player

HOST = "127.0.0.1"
TICK_S = 1 / 30
_ASIDE = 0.6
"""How far to its left the human stands from the robot, in heights of the robot; it is drawn as tall."""

_HUMAN_HEIGHT_M = 1.75


class BrowserViewer:
    """Serves a motion until it is closed.

    Args:
        player: the clock.
        texts: (N) captions.
        title: for the page.
        port: on 127.0.0.1; 0 takes a free one.

    Raises:
        InvalidOption: the port is in use or may not be opened.
    """

    def __init__(self, player: Player, *, texts: tuple[str, ...], title: str, port: int) -> None:
        check_port(port)
        import viser

        self.player, self._texts = player, texts
        with redirect_stdout(StringIO()):  # its banner; stdout is for the address
            self.server = viser.ViserServer(host=HOST, port=port, label=title, verbose=False)
        self.server.scene.set_up_direction("+z")
        self.server.scene.add_grid("/floor", width=12, height=12, cell_size=0.25, section_size=1.0, position=(0, 0, 0))
        self.server.gui.configure_theme(control_layout="collapsible", show_logo=False, show_share_button=False)
        self._caption = self.server.gui.add_markdown("")
        self._button = self.server.gui.add_button("Pause")
        self.slider = self.server.gui.add_slider("time, s", 0.0, max(player.end_s, 1e-3), 1 / player.fps, 0.0)
        names = tuple(f"{speed:g}x" for speed in SPEEDS)
        self._speed = self.server.gui.add_dropdown("speed", names, initial_value=f"{player.speed:g}x")
        self._actors: list[Actor] = []
        self._shown = -1
        self._connect()

    @property
    def address(self) -> str:
        """What to type into a browser."""
        return f"http://{HOST}:{self.server.get_port()}"

    def add(self, actor: Actor, switch: str = "") -> None:
        """Put an actor on the floor, with a switch of that name for people where there is one."""
        self._actors.append(actor)
        actor.show(self.player.frame)
        if switch:
            box = self.server.gui.add_checkbox(switch, True)
            box.on_update(lambda _: actor.set_visible(box.value))

    def look_at(self, target: Floats, distance: float) -> None:
        """Where cameras of new visitors stand: (3,) m before the target and to its left."""
        camera = self.server.initial_camera
        camera.look_at = target
        camera.position = target + distance * np.array([0.8, 0.5, 0.3])

    def show(self) -> None:
        """Draw the player's frame."""
        frame = self.player.frame
        if frame == self._shown:
            return
        self._shown = frame
        with self.server.atomic():
            for actor in self._actors:
                actor.show(frame)
            self.slider.value = frame / self.player.fps
            self._caption.content = f"**{self._texts[frame] or '&nbsp;'}**"

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Play until Ctrl-C, or until `until` says so; the server is closed after it."""
        before = perf_counter()
        try:
            while not until():
                now = perf_counter()
                self.player.advance(now - before)
                before = now
                self._button.label = "Pause" if self.player.playing else "Play"
                self.show()
                sleep(TICK_S)
        finally:
            self.close()

    def close(self) -> None:
        """Free the port."""
        with redirect_stdout(StringIO()):
            self.server.stop()

    def _connect(self) -> None:
        self._button.on_click(lambda _: self.player.toggle())
        self._speed.on_update(lambda _: setattr(self.player, "speed", float(self._speed.value.rstrip("x"))))

        @self.slider.on_update
        def _(event: Any) -> None:
            if event.client is not None:  # a person's hand, not the clock's
                self.player.scrub(self.slider.value)


def robot_viewer(film: Film, model: mujoco.MjModel, robot: RobotDescription, *, port: int) -> BrowserViewer:
    """A viewer of a robot with its contacts, the ghost of its plan where it was simulated, and the human."""
    viewer = BrowserViewer(Player(len(film), film.fps), texts=film.texts, title=film.title, port=port)
    scene = viewer.server.scene
    viewer.add(RobotActor(scene, "robot", model, robot, film.qpos, film.at_limit))
    if robot.soles:
        viewer.add(ContactActor(scene, model, robot, film), "contacts and ZMP")
    if film.planned is not None:
        viewer.add(RobotActor(scene, "plan", model, robot, film.planned, None), "ghost of the plan")
    low, high = extent(model, robot)
    size = high - low
    middle = np.array([*film.qpos[0, :2], (low + high) / 2])
    if film.human is not None:
        scale, aside = size / _HUMAN_HEIGHT_M, np.array([0, _ASIDE * size, 0])
        viewer.add(HumanActor(scene, scale * film.human, aside=aside, scale=scale), "human")
        middle += [0, _ASIDE / 2 * size, 0]
    viewer.look_at(middle, 2.2 * size)
    return viewer


def human_viewer(joints: Floats, fps: float, texts: tuple[str, ...], title: str, *, port: int) -> BrowserViewer:
    """A viewer of a human motion (N, 22, 3) m."""
    viewer = BrowserViewer(Player(len(joints), fps), texts=texts, title=title, port=port)
    viewer.add(HumanActor(viewer.server.scene, joints, aside=np.zeros(3), scale=1.0))
    viewer.look_at(joints[0, 0], 3.0)
    return viewer


def check_port(port: int) -> None:
    """InvalidOption where a port of this machine cannot be opened."""
    if not 0 <= port <= 65535:
        raise InvalidOption("--port", f"expected 0 to 65535, found {port}")
    with socket.socket() as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HOST, port))
        except OSError as error:
            used = error.errno == errno.EADDRINUSE
            problem = "is in use" if used else f"cannot be opened ({error.strerror})"
            raise InvalidOption("--port", f"{port} {problem}; name another, or 0 for any that is free") from None
