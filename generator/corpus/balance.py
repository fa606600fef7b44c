"""Balance: the centre of mass that a support path asks for, and the pelvis that puts it there."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from generator.corpus import body
from generator.corpus.body import SIDES, Floats, Side
from generator.corpus.pose import Leg, Pose, centre_of_mass, place_legs, trunk_frames, upper_body

_GRAVITY = 9.81
_PENDULUM_HEIGHT = 0.95


def centre_of_mass_path(pressure: Floats, rate: float) -> Floats:
    """(T, 2) the bounded centre of mass of a linear inverted pendulum whose pressure point follows (T, 2).

    The bounded solution of c'' = (g / z) (c - p) is p convolved with exp(-|t| / Tc) / (2 Tc), Tc = sqrt(z / g) (Kajita
    et al., ICRA 2003, solve the same problem by preview control): it leans over before the step, as people do.
    """
    constant = np.sqrt(_PENDULUM_HEIGHT / _GRAVITY)
    reach = int(6 * constant * rate)
    kernel = np.exp(-np.abs(np.arange(-reach, reach + 1)) / (rate * constant))
    kernel /= kernel.sum()
    padded = np.pad(pressure, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, kernel, "valid") for column in padded.T], -1)


def heel_to_toe(pressure: Floats, rate: float) -> Floats:
    """The pressure path with its jumps smoothed along the direction of travel: it rolls from heel to toe."""
    slow = gaussian_filter1d(pressure, 0.5 * rate, axis=0, mode="nearest")
    velocity = np.gradient(slow, axis=0) * rate
    travelling = np.clip(np.linalg.norm(velocity, axis=-1, keepdims=True) / 0.5, 0, 1)
    direction = body.unit(velocity)
    smooth = gaussian_filter1d(pressure, 0.15 * rate, axis=0, mode="nearest")
    return pressure + travelling * np.sum((smooth - pressure) * direction, -1, keepdims=True) * direction


def soft_minimum(values: Floats, sharpness: float = 60.0) -> Floats:
    """Smooth minimum over the first axis."""
    low = values.min(axis=0)
    return low - np.log(np.exp(-sharpness * (values - low)).sum(axis=0)) / sharpness


def place_pelvis(
    pose: Pose, *, centre: Floats, weight: Floats, crouch: Floats, lift: Floats, slack: Floats, rate: float
) -> None:
    """Set `pose["root"]` so that the legs reach both feet and the centre of mass lies over `centre` (T, 2).

    Args:
        weight: (T,) share of the left foot.
        crouch: (T,) metres below the highest reachable pelvis.
        lift: (T,) metres above the upright stance (flight, standing on the toes).
        slack: (T,) share of the leg's length kept bent.
        rate: frames a second.
    """
    frames = trunk_frames(pose)
    legs: dict[Side, Leg] = {side: Leg.of(pose, side, frames[0]) for side in SIDES}
    loaded = {"left": np.clip(3 * weight, 0, 1), "right": np.clip(3 * (1 - weight), 0, 1)}
    length = body.LEG * (0.990 - slack)
    root = np.column_stack([centre, np.full(len(centre), body.STANDING_HEIGHT)])
    pose["root"] = root
    places = upper_body(pose, frames)
    for _ in range(4):
        limits = [body.STANDING_HEIGHT + 0.02 + lift]
        for side, leg in legs.items():
            apart = np.sum((root + leg.hip - leg.ankle)[:, :2] ** 2, -1)
            reachable = leg.ankle[:, 2] + np.sqrt(np.maximum(length**2 - apart, 0.09)) - leg.hip[:, 2]
            free = 0.25 * (1 - loaded[side]) * (leg.ankle[:, 2] > 0.09)  # a lifted foot does not pull the pelvis down
            limits.append(reachable + free)
        height = soft_minimum(np.stack(limits)) - crouch
        root[:, 2] = gaussian_filter1d(height, 0.05 * rate, mode="nearest")
        places += (root - places[:, 0])[:, None]
        place_legs(legs, places)
        root[:, :2] += centre - centre_of_mass(places)[:, :2]
        root[:, :2] = gaussian_filter1d(root[:, :2], 0.03 * rate, axis=0, mode="nearest")
