"""Storyboards: a picture with both sides' colours, and clear refusals."""

import numpy as np
import pytest

from generator.corpus.draw import draw_motion
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidFile, InvalidMessage, InvalidOption


@pytest.fixture(scope="module")
def standing() -> np.ndarray:
    return joints(Scene(0).solve(0.5))


def test_picture_shows_the_left_side_in_blue_and_on_the_right(standing, tmp_path):
    from matplotlib.image import imread

    path = tmp_path / "motion.png"
    draw_motion(standing, path, "a person stands", frames=1)
    image = imread(path)
    red, blue = (np.argwhere(image[..., a] - image[..., b] > 0.35)[:, 1] for a, b in ((0, 2), (2, 0)))
    assert len(red) > 50
    assert len(blue) > 50
    assert blue.mean() > red.mean()


def test_more_frames_make_a_wider_picture(standing, tmp_path):
    from matplotlib.image import imread

    widths = []
    for frames in (2, 6):
        draw_motion(standing, tmp_path / "motion.png", "", frames=frames)
        widths.append(imread(tmp_path / "motion.png").shape[1])
    assert widths[1] > 2 * widths[0]


def test_refusals(standing, tmp_path):
    with pytest.raises(InvalidMessage, match="expected shape"):
        draw_motion(standing[:, :21], tmp_path / "a.png", "")
    with pytest.raises(InvalidOption, match="at least 1"):
        draw_motion(standing, tmp_path / "a.png", "", frames=0)
    with pytest.raises(InvalidFile, match="cannot be written"):
        draw_motion(standing, tmp_path / "missing" / "a.png", "")
    assert not list(tmp_path.iterdir())
