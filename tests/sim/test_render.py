"""Videos: what is on their frames, and what happens without OpenGL."""

import dataclasses
import os
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from ros_free_stack.errors import InvalidOption, MissingDependency, ModelMismatch
from ros_free_stack.files import save_motion, save_trajectory
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import JOINT_COUNT
from sim.cli import Render
from sim.draw import gl
from sim.draw.appearance import extent, merge_vertices, visual_model
from sim.draw.markers import AT_LIMIT, LimitPaint, add_contacts, add_zmp, contains, support_polygon
from sim.draw.playback_frames import make_film
from sim.draw.render import draw_film, render_video
from sim.draw.text_overlay import Lettering, blend, label
from sim.judge.verdict import judge

SQUARE = np.array([[0, 0, 0], [0.2, 0, 0], [0.2, 0.1, 0], [0, 0.1, 0.0]])


@pytest.fixture(scope="module")
def motion():
    joints = np.random.default_rng(0).uniform(0, 1.5, (JOINT_COUNT, 3))
    return HumanMotion(np.tile(joints, (20, 1, 1)), 20.0, "waves", (Segment("a person waves", 0.0, 0.5),))


def read_video(path):
    import imageio_ffmpeg

    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    width, height = meta["size"]
    return meta, [np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in reader]


def test_refuses_other_names(tmp_path):
    with pytest.raises(InvalidOption, match="mp4"):
        Render(trajectory=tmp_path / "t.npz", out=tmp_path / "video.gif").run()


def test_refuses_another_model(op3, standing, tmp_path):
    save_trajectory(tmp_path / "t.npz", dataclasses.replace(standing(op3), model_sha256="0" * 64))
    with pytest.raises(ModelMismatch):
        Render(trajectory=tmp_path / "t.npz", out=tmp_path / "video.mp4").run()


def test_no_gl_is_said(op3, standing, tmp_path, monkeypatch):
    monkeypatch.setattr(gl, "find_library", lambda name: None)
    with pytest.raises(MissingDependency, match="libegl1"):
        render_video(tmp_path / "video.mp4", standing(op3), None, op3)
    assert list(tmp_path.iterdir()) == []


def test_osmesa_draws_where_egl_does_not_work(tmp_path):
    """A process whose EGL finds no driver passes it over and says what draws."""
    if not gl.find_library("OSMesa"):
        pytest.skip("OSMesa is not installed (libosmesa6)")
    code = "from sim.draw.gl import gl_context\nwith gl_context(64, 48): pass"
    environment = os.environ | {"__EGL_VENDOR_LIBRARY_DIRS": str(tmp_path), "MUJOCO_GL": "", "PYOPENGL_PLATFORM": ""}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("drawing with OSMESA on ")


def test_video_of_robot_and_human(op3, standing, motion, tmp_path):
    save_trajectory(tmp_path / "t.npz", standing(op3, frames=50))
    save_motion(tmp_path / "m.npz", motion)
    sizes = {}
    for name, human in (("alone", None), ("beside", tmp_path / "m.npz")):
        try:
            out = tmp_path / f"{name}.mp4"
            assert Render(trajectory=tmp_path / "t.npz", motion=human, out=out).run() == 0
        except MissingDependency as error:
            pytest.skip(str(error))
        meta, frames = read_video(out)
        assert len(frames) == 25 and frames[0].std() > 15
        sizes[name] = meta["size"]
    assert sizes == {"alone": (640, 480), "beside": (800, 480)}


def test_a_joint_at_its_limit_turns_red(op3, standing):
    """The picture has more pure red where an arm is at the end of its range."""
    low = op3.joints["l_sho_roll"].lower
    still, at_end = standing(op3, frames=1), standing(op3, frames=1, joints={"l_sho_roll": np.array([low])})
    model = visual_model(op3)
    red = []
    for trajectory in (still, at_end):
        try:
            image = next(draw_film(make_film(trajectory, op3, model, fps=25), model, op3)).astype(int)
        except MissingDependency as error:
            pytest.skip(str(error))
        red.append(int(((image[..., 0] > 120) & (image[..., 1] < 60) & (image[..., 2] < 60)).sum()))
    assert red[0] < 5 and red[1] > 100


def test_limit_paint_goes_away_again(op3):
    model = visual_model(op3)
    before = model.geom_rgba.copy()
    paint = LimitPaint(model, op3)
    paint.apply(np.eye(len(op3.joints), dtype=bool)[0])
    changed = (model.geom_rgba != before).any(axis=1)
    assert changed.any() and np.allclose(model.geom_rgba[changed], AT_LIMIT)
    paint.apply(np.zeros(len(op3.joints), bool))
    assert (model.geom_rgba == before).all()


def test_film_says_what_is_on(op3, standing, motion):
    trajectory = standing(op3, frames=100)  # 2 s: the human stands for 0.5 s before and after
    film = make_film(trajectory, op3, visual_model(op3), fps=25, motion=motion)
    assert len(film) == 50 and film.human is not None and film.force is None
    assert [index for index, text in enumerate(film.texts) if text] == list(range(13, 25))
    assert film.title.endswith("planned") and not film.at_limit.any() and film.standing.all()


def test_film_of_a_playback_is_as_simulated(op3, standing):
    trajectory = standing(op3, frames=50)
    judgement = judge(trajectory, op3)
    assert judgement.playback is not None
    film = make_film(trajectory, op3, visual_model(op3), fps=25, judgement=judgement)
    assert np.array_equal(film.qpos, judgement.playback.qpos[::5]) and film.title.endswith("simulated")
    assert film.force is not None and film.force.sum(axis=1).min() > 10
    assert np.array_equal(film.zmp, judgement.playback.pressure[::5]), "where the simulated floor pushes"


def test_words_say_that_it_fell(op3, standing):
    film = dataclasses.replace(make_film(standing(op3), op3, visual_model(op3), fps=25), fell_at_s=0.4)
    red = []
    for frame in (9, 10):
        picture = np.full((480, 640, 3), 255, np.uint8)
        Lettering(film, 640, 480).write(picture, frame)
        red.append(bool(((picture[..., 0] > 150) & (picture[..., 1] < 50)).any()))
    assert red == [False, True]


def test_zmp_ball_is_red_outside_the_support(op3):
    model = visual_model(op3)
    colours = []
    for point in ([0.1, 0.05], [0.3, 0.05]):
        scene = mujoco.MjvScene(model, maxgeom=20)
        add_zmp(scene, np.array(point), [SQUARE], np.array([True]), size=0.5)
        ball = scene.geoms[scene.ngeom - 1]
        assert np.allclose(ball.pos, [*point, 0])
        colours.append(ball.rgba[0] > ball.rgba[2])
    assert colours == [False, True]


def test_a_foot_that_bears_nothing_is_marked(op3):
    scene = mujoco.MjvScene(visual_model(op3), maxgeom=20)
    stands, force = np.array([True, True]), np.array([30.0, 0.0])
    add_contacts(scene, [SQUARE, SQUARE + np.array([0, 0.3, 0])], stands, force, size=0.5, weight=30.0)
    patches = [geom for geom in scene.geoms[: scene.ngeom] if geom.type == mujoco.mjtGeom.mjGEOM_BOX]
    arrows = [geom for geom in scene.geoms[: scene.ngeom] if geom.type == mujoco.mjtGeom.mjGEOM_ARROW]
    assert len(arrows) == 1 and len(patches) == 2
    assert np.allclose(patches[0].pos, [0.1, 0.05, 0]) and patches[0].size[0] > 0.1 > patches[0].size[1]
    assert patches[0].rgba[1] > patches[0].rgba[0] and patches[1].rgba[0] > patches[1].rgba[1]


def test_support_polygon():
    polygon = support_polygon(np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]))
    assert polygon is not None and len(polygon) == 4
    assert contains(polygon, np.array([0.9, 0.9])) and not contains(polygon, np.array([1.1, 0.5]))
    assert support_polygon(np.array([[0, 0], [1, 1], [2, 2.0]])) is None


def test_extent_is_from_sole_to_head(op3):
    low, high = extent(visual_model(op3), op3)
    assert abs(low) < 0.02 and 0.4 < high < 0.65


def test_words_are_cut_at_the_edge():
    picture = np.full((30, 40, 3), 255, np.uint8)
    words = label("a long sentence", (0, 0, 0), 16)
    blend(picture, words, 10, 20)
    assert picture[:20].min() == 255 and picture[20:, 10:].min() < 100


def test_merged_vertices_keep_the_shape():
    """A fine sphere thinned to a grid keeps its radius within a cell and loses most faces."""
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(0).normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    vertices, kept = merge_vertices(points, faces, 0.2)
    assert len(kept) < 0.25 * len(faces)
    assert kept.max() < len(vertices) and len(np.unique(kept, axis=0)) == len(kept)
    assert np.abs(np.linalg.norm(vertices, axis=1) - 1).max() < 0.1


def test_tiny_meshes_stay():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]) * 1e-3
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]])
    vertices, kept = merge_vertices(corners, faces, 0.01)
    assert vertices is corners and kept is faces
