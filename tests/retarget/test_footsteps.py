import numpy as np
import pytest

from retarget.plan.footsteps import FootPath, clean_path

FPS, ANKLE, CLEARANCE = 50.0, 0.05, 0.02
CORNERS = np.array([[x, y, -ANKLE] for x in (-0.04, 0.09) for y in (-0.02, 0.02)])


@pytest.fixture(params=[12, 40, 150], ids=lambda frames: f"swing of {frames} frames")
def step(request) -> FootPath:
    """A noisy foot that stands, swings 0.15 m ahead with its toes pointing down, and stands."""
    rng, swing = np.random.default_rng(0), request.param
    phase = np.clip((np.arange(swing + 60) - 30) / swing, 0, 1)
    ankle = np.zeros((len(phase), 3))
    ankle[:, 0] = 0.15 * phase
    ankle[:, 1] = 0.03 * np.sin(np.pi * phase)
    ankle[:, 2] = ANKLE + 0.01 * np.sin(np.pi * phase)
    ankle += rng.normal(0, 0.002, ankle.shape)
    pitch = 0.6 * np.sin(2 * np.pi * phase)
    return clean_path(
        FootPath(ankle, rng.normal(0, 0.01, len(phase)), pitch, (phase <= 0) | (phase >= 1)),
        ankle_height=ANKLE,
        clearance=CLEARANCE,
        corners=CORNERS,
        fps=FPS,
    )


def soles(path: FootPath) -> np.ndarray:
    return path.ankle[:, None] + np.einsum("nij,cj->nci", path.rotation, CORNERS)


def test_a_standing_foot_does_not_move_and_lies_flat(step):
    corners = soles(step)
    both = step.contact[1:] & step.contact[:-1]
    np.testing.assert_allclose(np.diff(corners, axis=0)[both], 0, atol=1e-9)
    np.testing.assert_allclose(corners[step.contact][..., 2], 0, atol=1e-9)


def test_a_swinging_foot_does_not_scrape_the_floor(step):
    corners = soles(step)
    low = (corners[1:, :, 2] < 0.001) & (corners[:-1, :, 2] < 0.001)
    speed = np.linalg.norm(np.diff(corners[..., :2], axis=0), axis=-1) * FPS
    assert corners[..., 2].min() > -1e-9
    assert speed[low].max() < 0.02


def test_a_foot_is_raised_and_put_down_as_gently_as_the_human_does():
    phase = np.clip((np.arange(90) - 30) / 30, 0, 1)
    height = 0.2 * np.sin(np.pi * phase) ** 2
    path = clean_path(
        FootPath(
            np.column_stack([0.1 * height, 0 * height, ANKLE + height]),
            np.zeros(90),
            np.zeros(90),
            (phase <= 0) | (phase >= 1),
        ),
        ankle_height=ANKLE,
        clearance=CLEARANCE,
        corners=CORNERS,
        fps=FPS,
    )
    asked, planned = (np.abs(np.diff(values, n=2)).max() for values in (height, path.ankle[:, 2]))
    assert path.ankle[:, 2].max() > ANKLE + 0.18
    assert planned < 2 * asked


def test_a_swinging_foot_is_lifted(step):
    assert soles(step)[..., 2].min(axis=1).max() > 0.8 * CLEARANCE
