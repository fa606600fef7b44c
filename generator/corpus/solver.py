"""Turns keyed tracks into a pose: everything that no action should have to author.

Centre of mass from the support path, pelvis from the centre of mass and the legs' reach, arm swing and counter-rotation
from the feet, the trunk's answer to the arms, breathing, sway, tremor and the arms' looseness.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from generator.corpus import balance, body
from generator.corpus.body import ARM, SIDES, SIGN, Floats, rotate, rotation_matrix
from generator.corpus.liveliness import Noise, Performer, pendulum
from generator.corpus.pose import CHANNELS, Pose, arm_frame, trunk_frames, upper_body
from generator.corpus.tracks import Track
from ros_free_stack.skeleton import FPS, INDEX

_SUBSTEPS = 3
_RATE = FPS * _SUBSTEPS
_PAD = int(_RATE)  # a second of rest on either side, so that the filters see standing
_ARM_LAG_S = (0.03, 0.03, 0.07, 0.05)  # direction first, then reach and swivel: the hand trails the elbow


def _smooth(values: Floats, seconds: float) -> Floats:
    return gaussian_filter1d(values, seconds * _RATE, axis=0, mode="nearest")


class Solver:
    """The solution of one scene on a grid of 60 Hz; `solve` gives it at 20 fps."""

    def __init__(
        self,
        tracks: dict[str, Track],
        performer: Performer,
        hanging: dict[str, Floats],
        rng: np.random.Generator,
        *,
        duration: float,
    ) -> None:
        count = int(np.ceil(duration * _RATE)) + 2 * _PAD
        self.times = (np.arange(count) - _PAD) / _RATE
        self.tracks, self.performer, self.hanging = tracks, performer, hanging
        self.noise = Noise(rng, count, _RATE, performer.sway)
        self.breath = np.sin(2 * np.pi * 0.27 * self.times)
        self.pose: Pose = {}

    def solve(self) -> Pose:
        """The pose at 20 fps; its first frame is time 0."""
        self._feet()
        self._support()
        self._gait()
        self._trunk()
        for side in SIDES:
            self._arm(side)
        self._answer_to_arms()
        self._neck()
        self._pelvis()
        self._loose_arms()
        for side in SIDES:
            self._pin(side)
        return {name: self.pose[name][_PAD : len(self.times) - _PAD : _SUBSTEPS] for name in CHANNELS}

    def _sample(self, track: str, lag: float = 0.0) -> Floats:
        return self.tracks[track].sample(self.times - lag)

    def _feet(self) -> None:
        heading = _smooth(self._sample("heading")[:, 0], 0.10)
        self.pose["heading"] = heading
        self.forward = np.stack([np.cos(heading), np.sin(heading)], -1)
        self.left = np.stack([-np.sin(heading), np.cos(heading)], -1)
        for side in SIDES:
            self.pose[f"foot_{side}"] = self._sample(f"foot_{side}")
            self.pose[f"roll_{side}"] = self._sample(f"roll_{side}")[:, 0]
            self.pose[f"knee_{side}"] = self._sample(f"knee_{side}")[:, 0] + 0.06

    def _support(self) -> None:
        """Weight, pressure point and centre of mass."""
        self.air = self._sample("air")[:, 0]
        weight = self._sample("weight")[:, 0]
        self.both = 1 - np.abs(2 * gaussian_filter1d(weight, 0.3 * _RATE) - 1)
        wander = self.noise.draw(0.09, band=(0.05, 0.45))[:, 0]  # nobody stands quite still
        self.weight = np.clip(weight + wander * self.both**2, 0, 1)
        middle = {}
        for side in SIDES:
            foot = self.pose[f"foot_{side}"]
            middle[side] = foot[:, :2] - 0.065 * np.stack([np.cos(foot[:, 3]), np.sin(foot[:, 3])], -1)
        pressure = self.weight[:, None] * middle["left"] + (1 - self.weight[:, None]) * middle["right"]
        offset = self._sample("offset")
        pressure = pressure + offset[:, :1] * self.forward + offset[:, 1:] * self.left
        pressure = balance.heel_to_toe(pressure, _RATE)
        grounded = self.air < 0.005
        quiet = self.both * grounded * (self._sample("crouch")[:, 0] < 0.12)
        speed = [np.linalg.norm(np.gradient(self._sample(f"arm_{s}")[:, :2], axis=0), axis=-1) for s in SIDES]
        busy = np.clip(_smooth(np.sum(speed, axis=0) * _RATE, 0.3), 0, 1.5) * quiet  # busy arms move the body
        pressure = pressure + self.noise.draw(0.012, 0.014, band=(0.3, 1.5)) * busy[:, None]
        centre = balance.centre_of_mass_path(pressure, _RATE)
        self.centre = centre + self.noise.draw(0.007, 0.006, band=(0.05, 0.5)) * grounded[:, None]

    def _gait(self) -> None:
        apart = (self.pose["foot_left"] - self.pose["foot_right"])[:, :2]
        self.split = _smooth(np.sum(apart * self.forward, -1), 0.05)
        speed = np.linalg.norm(np.gradient(self.centre, axis=0), axis=-1) * _RATE
        self.moving = np.clip(_smooth(speed, 0.2) / 0.6, 0, 1.5)

    def _trunk(self) -> None:
        person, none = self.performer, np.zeros(len(self.times))
        load = _smooth(2 * self.weight - 1, 0.09)
        walking, shift = np.clip(self.moving, 0, 1), load * self.both
        pelvis = self.noise.tremor(np.radians(self._sample("pelvis")), gain=0.012, base=0.0015)
        spine = self.noise.tremor(np.radians(self._sample("spine")), gain=0.016, base=0.0025)
        pelvis += np.stack([0.05 * shift, none, 0.03 * shift], -1)
        spine += np.stack([-0.06 * shift, none, -0.05 * shift], -1)
        counter = self.split * walking
        pelvis += np.stack([0.085 * load * walking, 0.03 * self.moving, -person.pelvis_yaw * counter], -1)
        spine += np.stack([-0.10 * load * walking, 0.02 * self.moving, person.chest_yaw * counter], -1)
        spine += self.noise.draw(0.016, 0.018, 0.026)
        spine[:, 1] += 0.008 * self.breath
        pelvis += self.noise.draw(0.008, 0.012, 0.016)
        self.pose["pelvis"], self.pose["spine"] = pelvis + person.pelvis, spine + person.spine

    def _arm(self, side: str) -> None:
        raw = {lag: self._sample(f"arm_{side}", lag) for lag in set(_ARM_LAG_S)}
        arm = np.stack([raw[lag][:, i] for i, lag in enumerate(_ARM_LAG_S)], -1)
        gain, base = np.array([0.013, 0.013, 0.012, 0.012]), np.array([0.010, 0.010, 0.003, 0.012])
        arm = self.noise.tremor(arm, gain=gain, base=base)
        free = np.exp(-np.sum((arm[:, :2] - self.hanging[side][:2]) ** 2, -1) / 0.35**2)
        authored = self._sample("swing", 0.03)
        gait = -SIGN[side] * _smooth(self.split, 0.03) * self.performer.swing * np.clip(1.1 * self.moving, 0, 1.2)
        swing = (gait + SIGN[side] * authored[:, 0] + 1.6 * authored[:, 1]) * free  # bent elbows come forward
        direction = body.chart_to_direction(arm[:, :2], side)
        about = np.multiply.outer(-swing - 0.04, [0.0, 1.0, 0.0])
        direction = rotate(rotation_matrix(about), direction)
        arm[:, :2] = body.direction_to_chart(direction, side)
        arm[:, 2] -= 0.035 * np.clip(swing, -0.2, 1) + 0.01 * self.moving + authored[:, 1] * free
        arm += self.noise.draw(0.034, 0.034, 0.006, 0.05)
        elevation = np.arcsin(np.clip(direction[:, 2], -1, 1))
        raised = 0.32 * np.clip((elevation + 0.5) / 1.8, 0, 1) ** 1.5 + 0.014 * self.breath
        raised += self._sample("shrug")[:, 0]
        drawn = 0.22 * np.clip(direction[:, 0] * arm[:, 2] - 0.35, -0.3, 0.65)
        self.pose[f"arm_{side}"], self.pose[f"collar_{side}"] = arm, np.stack([raised, drawn], -1)

    def _answer_to_arms(self) -> None:
        """The trunk leans back behind raised or stretched arms and turns after a reaching one."""
        ahead, above = {}, {}
        for side in SIDES:
            arm = self.pose[f"arm_{side}"]
            direction = body.chart_to_direction(arm[:, :2], side)
            ahead[side], above[side] = direction[:, 0] * arm[:, 2], direction[:, 2] * arm[:, 2]
        both = np.clip(_smooth(ahead["left"] + ahead["right"] - 0.25, 0.08), -0.5, 2)
        turn = _smooth(ahead["right"] - ahead["left"], 0.06)
        tilt = _smooth(above["right"] - above["left"], 0.08)
        still = (1 - np.clip(self.moving, 0, 0.8))[:, None]
        self.pose["spine"] += still * np.stack([-0.07 * tilt, -0.055 * both, 0.20 * turn], -1)
        self.pose["pelvis"] += still * np.stack([0.02 * tilt, 0 * both, 0.09 * turn], -1)

    def _neck(self) -> None:
        gaze = self.noise.tremor(np.radians(self._sample("gaze", -0.12)), gain=0.02, base=0.008)
        gaze += self.noise.draw(0.05, 0.03)
        heading = self.pose["heading"]
        ahead = np.interp(self.times + 0.30, self.times, heading) - heading  # the eyes lead a turn
        trunk = self.pose["spine"] + self.pose["pelvis"]
        neck = np.stack(
            [
                -0.5 * trunk[:, 0],
                0.75 * gaze[:, 1] - 0.55 * np.clip(trunk[:, 1], -0.6, 0.6),
                0.75 * np.clip(gaze[:, 0] + ahead - 0.7 * trunk[:, 2], -1.2, 1.2),
            ],
            -1,
        )
        self.pose["neck"] = neck + self.performer.neck

    def _pelvis(self) -> None:
        crouch = self.noise.tremor(self._sample("crouch"), gain=0.008, base=0.0004)[:, 0]
        toes = 0.12 * np.sin(np.clip(np.minimum(self.pose["roll_left"], self.pose["roll_right"]), 0, 1.2))
        balance.place_pelvis(
            self.pose,
            centre=self.centre,
            weight=self.weight,
            crouch=crouch,
            lift=np.maximum(self.air, 0) + toes,
            slack=0.012 * np.clip(self.moving, 0, 1),
            rate=_RATE,
        )

    def _loose_arms(self) -> None:
        """Free arms are damped pendulums under the accelerated shoulders."""
        places = upper_body(self.pose, trunk_frames(self.pose))
        shoulders = 0.5 * (places[:, INDEX["left_shoulder"]] + places[:, INDEX["right_shoulder"]])
        acceleration = np.gradient(np.gradient(_smooth(shoulders, 0.04), axis=0), axis=0)[:, :2] * _RATE**2
        yaw = _smooth(self.pose["heading"] + self.pose["spine"][:, 2] + self.pose["pelvis"][:, 2], 0.04)
        turning = np.gradient(np.gradient(yaw)) * _RATE**2
        sideways = self._hang(np.sum(acceleration * self.left, -1))
        for side in SIDES:
            fore = self._hang(np.sum(acceleration * self.forward, -1) - SIGN[side] * 0.17 * turning)
            arm = self.pose[f"arm_{side}"]
            free = np.exp(-np.sum((arm[:, :2] - self.hanging[side][:2]) ** 2, -1) / 0.5**2)
            free *= 1 - 0.7 * np.clip(self.moving, 0, 1)
            about = np.stack([0.6 * sideways * free, -fore * free, 0 * free], -1)
            direction = rotate(rotation_matrix(about), body.chart_to_direction(arm[:, :2], side))
            outward = direction[:, 1] * SIGN[side]
            direction[:, 1] = np.where(free > 0.2, np.maximum(outward, 0.02), outward) * SIGN[side]
            arm[:, :2] = body.direction_to_chart(direction, side)

    def _hang(self, acceleration: Floats) -> Floats:
        return np.clip(pendulum(acceleration, _RATE) * self.performer.looseness * 0.8, -0.45, 0.45)

    def _pin(self, side: str) -> None:
        """Draw the wrist to a place in the world where a pin holds it."""
        pin = self._sample(f"pin_{side}")
        if pin[:, 3].max() <= 0:
            return
        frames = trunk_frames(self.pose)
        places, frame = upper_body(self.pose, frames), arm_frame(frames[3])
        shoulder, wrist = places[:, INDEX[f"{side}_shoulder"]], places[:, INDEX[f"{side}_wrist"]]
        offset = wrist + np.clip(pin[:, 3:], 0, 1) * (pin[:, :3] - wrist) - shoulder
        arm = self.pose[f"arm_{side}"]
        arm[:, :2] = body.direction_to_chart(rotate(np.swapaxes(frame, 1, 2), offset), side)
        arm[:, 2] = np.linalg.norm(offset, axis=-1) / ARM
