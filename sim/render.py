"""`video.mp4`: the robot drawn by MuJoCo without a display, quick enough for software OpenGL.

Menagerie's meshes have up to a million faces; here vertices are merged on a grid of some millimetres, shadows and
reflections are off, and the result is cached. Frames go to x264 as they are drawn.
"""

import os
from collections.abc import Iterator
from ctypes.util import find_library
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from ros_free_stack.console import say
from ros_free_stack.errors import MissingDependency
from ros_free_stack.files import atomic_path
from ros_free_stack.messages import Floats, RobotTrajectory
from ros_free_stack.robot_model import add_floor, robot_spec
from ros_free_stack.robots import RobotDescription
from sim.model import cached_model, drop_meshes, replace_meshes, size_scale
from sim.reference import in_robot_order, poses
from sim.verdict import Judgement

WIDTH, HEIGHT, FPS = 640, 480, 25
_CELL_M = 0.012
"""Vertices in one cell of this size (on G1) become one."""

_LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}


def render_video(path: Path, trajectory: RobotTrajectory, judgement: Judgement | None, robot: RobotDescription) -> None:
    """Draw a trajectory, as simulated where the judgement has a playback, as planned otherwise.

    Args:
        path: the .mp4 to write.
        trajectory: what the robot should do.
        judgement: its judgement, or None.
        robot: the robot.

    Raises:
        MissingDependency: there is no EGL and no OSMesa.
        InvalidFile: the file cannot be written.
    """
    import imageio_ffmpeg

    backend = gl_backend()
    say(f"drawing with {backend.upper()}")
    model = visual_model(robot)
    qpos = poses(in_robot_order(trajectory, robot), robot, model)
    playback = None if judgement is None else judgement.playback
    if playback is not None and playback.qpos.shape[1] == model.nq:
        qpos = playback.qpos
    step = trajectory.fps / FPS
    frames = np.rint(np.arange(0, len(qpos) - 0.5, step)).astype(int).clip(0, len(qpos) - 1)
    with atomic_path(path) as temporary:
        writer = imageio_ffmpeg.write_frames(
            str(temporary), (WIDTH, HEIGHT), fps=FPS, codec="libx264", macro_block_size=1,
            output_params=["-crf", "20", "-preset", "veryfast", "-movflags", "+faststart", "-f", "mp4"],
        )  # fmt: skip
        writer.send(None)
        for image in draw_frames(model, robot, qpos[frames], backend):
            writer.send(image)
        writer.close()


def gl_backend() -> str:
    """The OpenGL library to draw with: the one that MUJOCO_GL names, else EGL, else OSMesa.

    Raises:
        MissingDependency: none is installed.
    """
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    order = [chosen] if chosen in _LIBRARIES else list(_LIBRARIES)
    for backend in order:
        if find_library(_LIBRARIES[backend]):
            return backend
    raise MissingDependency(
        "an OpenGL library for drawing without a display",
        "install libegl1 or libosmesa6 (apt-get install libegl1); only the video needs it",
    )


def draw_frames(model: mujoco.MjModel, robot: RobotDescription, qpos: Floats, backend: str) -> Iterator[np.ndarray]:
    """(480, 640, 3) bytes for each pose, the camera following the root.

    Raises:
        MissingDependency: the library is there but gives no context.
    """
    context: Any = None
    try:
        context = _context(backend)
        resources = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, resources)
        scene = mujoco.MjvScene(model, maxgeom=1000)
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            scene.flags[flag] = 0
        yield from _draw(model, robot, qpos, scene, resources)
    finally:
        if context is not None:
            context.free()


def _context(backend: str) -> Any:
    """A current OpenGL context of the size of the video."""
    os.environ["PYOPENGL_PLATFORM"] = backend
    try:
        if backend == "egl":
            from mujoco.egl import GLContext
        else:
            from mujoco.osmesa import GLContext
        context = GLContext(WIDTH, HEIGHT)
        context.make_current()
    except (ImportError, AttributeError, RuntimeError) as error:
        raise MissingDependency(f"a working {backend.upper()} driver", str(error)) from None
    return context


def _draw(
    model: mujoco.MjModel,
    robot: RobotDescription,
    qpos: Floats,
    scene: mujoco.MjvScene,
    resources: mujoco.MjrContext,
) -> Iterator[np.ndarray]:
    data = mujoco.MjData(model)
    option, camera = mujoco.MjvOption(), mujoco.MjvCamera()
    view = mujoco.MjrRect(0, 0, WIDTH, HEIGHT)
    height = float(qpos[0, 2])
    camera.distance, camera.azimuth, camera.elevation = 3.0 * height, 145, -12
    image = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    for pose in qpos:
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        camera.lookat[:] = pose[0], pose[1], 0.85 * height
        mujoco.mjv_updateScene(model, data, option, None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
        mujoco.mjr_render(view, scene, resources)
        mujoco.mjr_readPixels(image, None, view, resources)
        yield np.ascontiguousarray(image[::-1])


def visual_model(robot: RobotDescription) -> mujoco.MjModel:
    """The robot's looks on a chequered floor, meshes thinned out, from the cache where it is there."""
    return cached_model(robot, "visual", lambda: _visual_spec(robot))


def _visual_spec(robot: RobotDescription) -> "mujoco.MjSpec":
    from ros_free_stack.robot_model import kinematic_model

    cell = _CELL_M * size_scale(robot, kinematic_model(robot))
    spec = robot_spec(robot)
    for geom in list(spec.geoms):
        if geom.contype or geom.conaffinity:
            spec.delete(geom)
    drop_meshes(spec, keep=lambda geom: True)
    replace_meshes(spec, lambda vertices, faces: merge_vertices(vertices, faces, cell))
    add_floor(spec)
    floor = spec.geom("floor")
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.98], rgb2=[0.75, 0.8, 0.87], width=64, height=384,
    )  # fmt: skip
    spec.add_texture(
        name="tiles", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.83, 0.86, 0.9], rgb2=[0.76, 0.8, 0.85], width=128, height=128,
    )  # fmt: skip
    tiles = spec.add_material(name="tiles", texrepeat=[4, 4], texuniform=True)
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    floor.material = "tiles"
    spec.worldbody.add_light(pos=[1, 1, 3], dir=[-0.3, -0.3, -1], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    spec.visual.headlight.ambient = [0.4, 0.4, 0.4]
    return spec


def merge_vertices(vertices: Floats, faces: np.ndarray, cell: float) -> tuple[Floats, np.ndarray]:
    """Merge the vertices (V, 3) that share a cubic cell of a grid and drop faces (F, 3) that collapse.

    Source: vertex clustering, Rossignac and Borrel 1993.
    """
    _, group, counts = np.unique(np.floor(vertices / cell).astype(int), axis=0, return_inverse=True, return_counts=True)
    group = group.ravel()
    merged = np.stack([np.bincount(group, weights=axis) for axis in vertices.T], axis=1) / counts[:, None]
    kept = group[faces]
    whole = (kept[:, 0] != kept[:, 1]) & (kept[:, 1] != kept[:, 2]) & (kept[:, 2] != kept[:, 0])
    kept = np.unique(_rolled(kept[whole]), axis=0)
    return (merged, kept) if len(kept) >= 4 else (vertices, faces)


def _rolled(faces: np.ndarray) -> np.ndarray:
    """Faces that begin with their smallest index, so that equal ones look equal."""
    start = np.argmin(faces, axis=1)
    return np.take_along_axis(faces, (start[:, None] + np.arange(3)) % 3, axis=1)
