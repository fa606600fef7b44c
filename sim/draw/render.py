"""`video.mp4`: human and robot side by side, drawn by MuJoCo without a display, quick enough for software OpenGL.

Shadows, reflections, multisampling and the backs of faces cost software OpenGL most of its time and are off. Frames go
to x264 as they are drawn.
"""

from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import atomic_path
from ros_free_stack.messages import HumanMotion, RobotTrajectory
from ros_free_stack.robot_model import sole_corners
from ros_free_stack.robots import RobotDescription
from sim.draw.appearance import extent, visual_model
from sim.draw.gl import gl_context
from sim.draw.markers import LimitPaint, add_contacts, add_human, add_zmp
from sim.draw.playback_frames import Film, make_film
from sim.draw.text_overlay import Lettering
from sim.judge.verdict import Judgement

WIDTH, HEIGHT, FPS = 640, 480, 25
PANE_WIDTH = 400
HUMAN_HEIGHT_M = 1.75
_AZIMUTH, _ELEVATION = 145, -14
_DISTANCE = 1.75
"""Of the camera, in heights of what it looks at."""


def render_video(
    path: Path,
    trajectory: RobotTrajectory,
    judgement: Judgement | None,
    robot: RobotDescription,
    motion: HumanMotion | None = None,
) -> None:
    """Draw a trajectory, as simulated where the judgement has a playback, as planned otherwise.

    Args:
        path: the .mp4 to write.
        trajectory: what the robot should do.
        judgement: its judgement, or None.
        robot: the robot.
        motion: the human motion to show beside it, or None.

    Raises:
        MissingDependency: there is no EGL and no OSMesa.
        InvalidFile: the file cannot be written.
    """
    import imageio_ffmpeg

    model = visual_model(robot)
    film = make_film(trajectory, robot, model, fps=FPS, judgement=judgement, motion=motion)
    with atomic_path(path) as temporary:
        writer = imageio_ffmpeg.write_frames(
            str(temporary), picture_size(film), fps=FPS, codec="libx264", macro_block_size=1,
            output_params=["-crf", "20", "-preset", "veryfast", "-movflags", "+faststart", "-f", "mp4"],
        )  # fmt: skip
        writer.send(None)
        try:
            for image in draw_film(film, model, robot):
                writer.send(image)
        except OSError as error:
            raise InvalidFile(path, f"ffmpeg gave up: {error}") from None
        finally:
            writer.close()


def picture_size(film: Film) -> tuple[int, int]:
    """Width and height of a film's frames: a robot alone, or two panes."""
    return (WIDTH, HEIGHT) if film.human is None else (2 * PANE_WIDTH, HEIGHT)


def draw_film(film: Film, model: mujoco.MjModel, robot: RobotDescription) -> Iterator[np.ndarray]:
    """(height, width, 3) bytes for each frame, cameras following the root and the pelvis.

    Raises:
        MissingDependency: there is no OpenGL, or none that works.
    """
    width, height = picture_size(film)
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    model.vis.quality.offsamples = 0
    with gl_context(width, height):
        resources = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        try:
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, resources)
            yield from _draw(film, model, robot, resources, width, height)
        finally:
            resources.free()


def _draw(
    film: Film, model: mujoco.MjModel, robot: RobotDescription, resources: mujoco.MjrContext, width: int, height: int
) -> Iterator[np.ndarray]:
    robot_pane, human_pane = _RobotPane(film, model, robot), _HumanPane(film, model)
    lettering = Lettering(film, width, height)
    whole = mujoco.MjrRect(0, 0, width, height)
    left, right = mujoco.MjrRect(0, 0, width // 2, height), mujoco.MjrRect(width // 2, 0, width // 2, height)
    image = np.empty((height, width, 3), np.uint8)
    for frame in range(len(film)):
        robot_scene = robot_pane.scene_at(frame)
        if film.human is None:
            mujoco.mjr_render(whole, robot_scene, resources)
        else:
            mujoco.mjr_render(left, human_pane.scene_at(frame), resources)
            mujoco.mjr_render(right, robot_scene, resources)
        mujoco.mjr_readPixels(image, None, whole, resources)
        picture = image[::-1].copy()
        lettering.write(picture, frame)
        yield picture


class _RobotPane:
    """The robot with its contacts, ZMP and joints at their limits."""

    def __init__(self, film: Film, model: mujoco.MjModel, robot: RobotDescription) -> None:
        self._film, self._model, self._robot = film, model, robot
        self._data = mujoco.MjData(model)
        self._paint = LimitPaint(model, robot)
        self._low, high = extent(model, robot)
        self._size = high - self._low
        self._weight = float(model.body_subtreemass[0] * -model.opt.gravity[2])
        self._scene, self._camera = _scene(model), _camera(self._size)

    def scene_at(self, frame: int) -> mujoco.MjvScene:
        film, model, data, scene = self._film, self._model, self._data, self._scene
        data.qpos[:] = film.qpos[frame]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        self._paint.apply(film.at_limit[frame])
        self._camera.lookat[:] = *film.qpos[frame, :2], self._low + 0.48 * self._size
        mujoco.mjv_updateScene(model, data, _OPTION, None, self._camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
        soles = list(sole_corners(model, data, self._robot).values())
        force = None if film.force is None else film.force[frame]
        add_contacts(scene, soles, film.standing[frame], force, size=self._size, weight=self._weight)
        add_zmp(scene, film.zmp[frame], soles, film.standing[frame], size=self._size)
        return scene


class _HumanPane:
    """The human on the same floor."""

    def __init__(self, film: Film, model: mujoco.MjModel) -> None:
        self._film, self._model, self._data = film, model, mujoco.MjData(model)
        mujoco.mj_kinematics(model, self._data)
        mujoco.mj_camlight(model, self._data)
        self._scene, self._camera = _scene(model), _camera(HUMAN_HEIGHT_M)

    def scene_at(self, frame: int) -> mujoco.MjvScene:
        if self._film.human is None:
            return self._scene
        joints = self._film.human[frame]
        self._camera.lookat[:] = *joints[0, :2], 0.48 * HUMAN_HEIGHT_M
        static = mujoco.mjtCatBit.mjCAT_STATIC
        mujoco.mjv_updateScene(self._model, self._data, _OPTION, None, self._camera, static, self._scene)
        add_human(self._scene, joints)
        return self._scene


def _scene(model: mujoco.MjModel) -> mujoco.MjvScene:
    scene = mujoco.MjvScene(model, maxgeom=1000)
    for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
        scene.flags[flag] = 0
    scene.flags[mujoco.mjtRndFlag.mjRND_CULL_FACE] = 1
    return scene


def _camera(height: float) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.distance, camera.azimuth, camera.elevation = _DISTANCE * height, _AZIMUTH, _ELEVATION
    return camera


_OPTION = mujoco.MjvOption()
