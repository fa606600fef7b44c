"""Numbers about a window of a motion: what its signals do there, for the body, each hand and each foot.

Each is computed when a probe asks for it, and kept. Units are those of `signals.py`; counts are whole numbers.
"""

from functools import cached_property

import numpy as np

from generator.probes.cycles import peaks, rises, runs
from generator.probes.signals import SIDES, SIGN, Floats, Foot, Hand, Signals
from ros_free_stack.skeleton import FPS

_FAR = 0.75  # share of the furthest distance from rest at which a hand is where it acts
_AIR = 0.035  # leg lengths: a toe that high has left the floor
_SWING = 0.045
_TIPTOE = 0.06


def _range(signal: Floats) -> float:
    """Without the outermost frames, so that no single one decides."""
    low, high = np.percentile(signal, [3, 97])
    return float(high - low)


def _longest(mask: np.ndarray) -> tuple[int, int]:
    return max(runs(mask), key=lambda run: run[1] - run[0], default=(0, 0))


class HandMeasures:
    """One hand in a window. It acts where it is furthest from hanging; `mid` are these frames."""

    def __init__(self, hand: Hand, side: str, twist: Floats, window: slice) -> None:
        self._sign, self._twist = SIGN[side], twist[window]
        self._place, self._lift, self._speed = hand.place[window], hand.lift[window], hand.speed[window]
        self._away, self._extension = hand.away[window], hand.extension[window]
        self._hand, self._window = hand, window

    @cached_property
    def _far(self) -> np.ndarray:
        return self._away >= _FAR * self.away

    @cached_property
    def _core(self) -> Floats:
        """Its places from when it gets there to when it leaves."""
        mid = np.flatnonzero(self._far)
        return self._place[mid[0] : mid[-1] + 1]

    @cached_property
    def _still(self) -> int:
        """The frame in which the acting hand is slowest."""
        mid = np.flatnonzero(self._far)
        return int(mid[np.argmin(self._speed[mid])])

    @cached_property
    def away(self) -> float:
        return float(np.percentile(self._away, 97))

    @cached_property
    def active(self) -> float:
        """Seconds."""
        return float(self._far.sum()) / FPS

    @cached_property
    def hold(self) -> float:
        """Seconds near the stillest place."""
        return float((np.linalg.norm(self._place - self._place[self._still], axis=-1) < 0.15).sum()) / FPS

    @cached_property
    def extension(self) -> float:
        return float(np.median(self._extension[self._far]))

    @cached_property
    def longest(self) -> float:
        return float(np.percentile(self._extension, 98))

    @cached_property
    def shortest(self) -> float:
        return float(self._extension[self._far].min())

    @cached_property
    def folded(self) -> float:
        """The least extension of the arm."""
        return float(self._extension.min())

    @cached_property
    def hip_hold(self) -> float:
        """Seconds at the hip with the elbow bent."""
        at_hip = (self._hand.to_hip[self._window] < 0.55) & (self._extension < 0.87)
        start, stop = _longest(at_hip)
        return (stop - start) / FPS

    @cached_property
    def lift(self) -> float:
        return float(np.median(self._lift[self._far]))

    @cached_property
    def top(self) -> float:
        return float(np.percentile(self._lift, 98))

    @cached_property
    def speed(self) -> float:
        return float(np.percentile(self._speed, 98))

    @cached_property
    def thrust(self) -> float:
        """The fastest stretching of the arm, arm lengths a second."""
        return float(np.max(np.gradient(self._extension))) * FPS

    @cached_property
    def front(self) -> float:
        return float(self._place[:, 0].max())

    @cached_property
    def back(self) -> float:
        return float(self._place[:, 0].min())

    @cached_property
    def x(self) -> float:
        return float(np.median(self._place[self._far, 0]))

    @cached_property
    def y(self) -> float:
        return float(np.median(self._place[self._far, 1]))

    @cached_property
    def still_x(self) -> float:
        return float(self._place[self._still, 0])

    @cached_property
    def still_y(self) -> float:
        return float(self._place[self._still, 1])

    @cached_property
    def still_z(self) -> float:
        return float(self._place[self._still, 2])

    @cached_property
    def azimuth(self) -> float:
        """Where the still hand points, deg to the left of where the hips face."""
        return float(np.degrees(np.arctan2(self._sign * self.still_y, self.still_x)) + self._twist[self._still])

    @cached_property
    def range_x(self) -> float:
        return _range(self._core[:, 0])

    @cached_property
    def range_y(self) -> float:
        return _range(self._core[:, 1])

    @cached_property
    def range_z(self) -> float:
        return _range(self._core[:, 2])

    def _swings(self, axis: int, sign: float, least: float, share: float = 0.4) -> float:
        values = self._core[:, axis]
        return float(len(peaks(sign * values, max(least, share * _range(values)))))

    @cached_property
    def ins(self) -> float:
        """Swings inwards between two places further out."""
        return self._swings(1, -1, 0.04)

    @cached_property
    def pulls(self) -> float:
        """Swings back towards the chest between two places further in front."""
        return self._swings(0, -1, 0.04)

    @cached_property
    def downs(self) -> float:
        """Swings down between two higher places."""
        return self._swings(2, -1, 0.045, 0.0)

    @cached_property
    def ups(self) -> float:
        """Swings up between two lower places."""
        return self._swings(2, 1, 0.04, 0.0)

    @cached_property
    def strokes(self) -> float:
        """How often the arm gets straight."""
        return float(rises(self._extension, 0.15, least=0.8))

    @cached_property
    def pushes(self) -> float:
        """How often the hand goes out to the front."""
        return float(rises(self._place[:, 0], 0.15, least=0.75))

    @cached_property
    def fronts(self) -> float:
        """How often the hanging arm swings to the front."""
        return float(rises(self._place[:, 0], 0.45, least=0.25))

    @cached_property
    def tops(self) -> float:
        """How often the hand comes over the shoulder from below."""
        return float(rises(self._lift, 0.5, least=0.2))

    @cached_property
    def flaps(self) -> float:
        return float(rises(self._lift, 0.25, least=0.0))

    @cached_property
    def lift_range(self) -> float:
        return _range(self._lift)

    @cached_property
    def pulses(self) -> float:
        """How often the straight arm goes up."""
        return float(rises(self._lift, 0.45, least=-0.3))

    @cached_property
    def pulses_x(self) -> float:
        """How often the raised hand goes forward and back."""
        return float(len(peaks(self._core[:, 0], 0.08)))

    @cached_property
    def curls(self) -> float:
        """How often the hand goes far up."""
        return float(rises(self._lift, 0.4, least=-0.4))

    @cached_property
    def bites(self) -> float:
        """How often the hand comes to the head."""
        return float(rises(-self._hand.to_head[self._window], 0.2, least=-0.6))

    @cached_property
    def to_head(self) -> float:
        return float(self._hand.to_head[self._window][self._far].min())

    @cached_property
    def head_mid(self) -> float:
        return float(np.median(self._hand.to_head[self._window][self._far]))

    @cached_property
    def hip_mid(self) -> float:
        return float(np.median(self._hand.to_hip[self._window][self._far]))

    @cached_property
    def to_chest(self) -> float:
        return float(np.median(self._hand.to_chest[self._window][self._far]))

    @cached_property
    def floor(self) -> float:
        return float(self._hand.floor[self._window].min())


class FootMeasures:
    """One foot in a window."""

    def __init__(self, foot: Foot, floor: float, window: slice) -> None:
        self._toe, self._heel, self._knee = foot.toe[window] - floor, foot.heel[window], foot.knee[window]
        self._place, self._foot, self._window = foot.place[window], foot, window

    @cached_property
    def _spans(self) -> list[tuple[int, int]]:
        return [(a, b) for a, b in runs(self._toe > _SWING) if b - a >= 2]

    @cached_property
    def _top(self) -> int:
        return int(np.argmax(self._toe))

    @cached_property
    def toe(self) -> float:
        return float(self._toe.max())

    @cached_property
    def heel(self) -> float:
        return float(self._heel.max())

    @cached_property
    def knee_at_top(self) -> float:
        """Bend of the knee when the foot is highest."""
        return float(self._knee[self._top])

    @cached_property
    def straightest(self) -> float:
        """The least bend of the knee while the foot is at least at three quarters of its height."""
        return float(self._knee[self._toe >= 0.75 * self.toe].min())

    @cached_property
    def aside_at_top(self) -> float:
        """The furthest aside while the foot is at least at three quarters of its height."""
        return float(self._place[self._toe >= 0.75 * self.toe, 1].max())

    @cached_property
    def reaches(self) -> float:
        """How often the foot goes far to the front or to the side."""
        return float(rises(self._place[:, :2].max(axis=1), 0.25, least=0.35))

    @cached_property
    def swings(self) -> float:
        """How often the foot goes to the front from behind."""
        return float(rises(self._place[:, 0], 0.25, least=0.15))

    @cached_property
    def knee_low(self) -> float:
        return float(self._foot.knee_height[self._window].min())

    @cached_property
    def knee_high(self) -> float:
        return float(self._foot.knee_height[self._window].max())

    @cached_property
    def thigh(self) -> float:
        return float(self._foot.thigh[self._window].max())

    @cached_property
    def speed(self) -> float:
        return float(self._foot.speed[self._window].max())

    @cached_property
    def drop(self) -> float:
        """The fastest way down, leg lengths a second."""
        return float(np.max(-np.gradient(self._toe))) * FPS

    @cached_property
    def front(self) -> float:
        return float(self._place[:, 0].max())

    @cached_property
    def behind(self) -> float:
        return float(self._place[:, 0].min())

    @cached_property
    def aside(self) -> float:
        return float(self._place[:, 1].max())

    @cached_property
    def lifts(self) -> float:
        return float(len(self._spans))

    @cached_property
    def longest_up(self) -> float:
        """Seconds."""
        return max((b - a for a, b in self._spans), default=0) / FPS

    @cached_property
    def kicks(self) -> float:
        """How often the foot is lifted high."""
        return float(rises(self._toe, max(0.1, 0.5 * self.toe), least=0.6 * self.toe))

    @cached_property
    def lunges(self) -> float:
        """How often the foot is far in front of the hip."""
        return float(rises(self._place[:, 0], 0.25, least=0.3))


class BodyMeasures:
    """The whole body in a window."""

    def __init__(
        self,
        signals: Signals,
        toes: Floats,
        window: slice,
        hands: dict[str, HandMeasures],
        feet: dict[str, FootMeasures],
    ) -> None:
        self._signals, self._window, self._hands, self._feet = signals, window, hands, feet
        self._toes = toes
        self._heading, self._pelvis = signals.heading[window], signals.pelvis[window]
        self._pitch, self._roll, self._twist = signals.pitch[window], signals.roll[window], signals.twist[window]
        self._nod, self._shake = signals.head_pitch[window], signals.head_yaw[window]
        self._look = self._shake + self._twist
        self._level = float(np.mean([*self._nod[:3], *self._nod[-3:]]))
        self._root = signals.root[window]

    @cached_property
    def _steps(self) -> tuple[Floats, Floats]:
        """Velocity of the pelvis forward and to the left, m/s."""
        step, facing = np.gradient(self._root, axis=0) * FPS, np.radians(self._heading)
        ahead = step[:, 0] * np.cos(facing) + step[:, 1] * np.sin(facing)
        return ahead, step[:, 1] * np.cos(facing) - step[:, 0] * np.sin(facing)

    @cached_property
    def _leftward(self) -> Floats:
        """(T,) m to the left of where the window begins."""
        yaw = np.radians(self._heading[:5].mean())
        return (self._root - self._root[0]) @ [-np.sin(yaw), np.cos(yaw)]

    @cached_property
    def _heels(self) -> Floats:
        """(T,) height of the lower heel."""
        feet = self._signals.feet
        return np.minimum(feet["left"].heel[self._window], feet["right"].heel[self._window])

    @cached_property
    def turned(self) -> float:
        return float(self._heading[-3:].mean() - self._heading[:3].mean())

    @cached_property
    def turn_range(self) -> float:
        return _range(self._heading)

    @cached_property
    def ahead(self) -> float:
        """How far the body went forward as it faced, m."""
        return float(self._steps[0].sum()) / FPS

    @cached_property
    def aside(self) -> float:
        """How far it went to its left, m."""
        return float(self._steps[1].sum()) / FPS

    @cached_property
    def slant(self) -> float:
        """Direction of travel, deg to the left of where the body faced."""
        return float(np.degrees(np.arctan2(self.aside, self.ahead)))

    @cached_property
    def path(self) -> float:
        return float(np.hypot(*self._steps).sum()) / FPS

    @cached_property
    def travel(self) -> float:
        return float(np.linalg.norm(self._root[-1] - self._root[0]))

    @cached_property
    def pace(self) -> float:
        """m/s, that four fifths of the frames stay below."""
        return float(np.percentile(np.hypot(*self._steps), 80))

    @cached_property
    def root_back(self) -> float:
        """The furthest that the pelvis gets behind where it began, m."""
        yaw = np.radians(self._heading[:5].mean())
        return float(-((self._root - self._root[0]) @ [np.cos(yaw), np.sin(yaw)]).min())

    @cached_property
    def pelvis_start(self) -> float:
        return float(self._pelvis[:3].mean())

    @cached_property
    def pelvis_end(self) -> float:
        return float(self._pelvis[-3:].mean())

    @cached_property
    def pelvis_low(self) -> float:
        return float(self._pelvis.min())

    @cached_property
    def pelvis_high(self) -> float:
        return float(self._pelvis.max())

    @cached_property
    def pelvis_range(self) -> float:
        return float(np.ptp(self._pelvis))

    @cached_property
    def pelvis_mid(self) -> float:
        return float(np.median(self._pelvis))

    @cached_property
    def dips(self) -> float:
        """How often the pelvis goes down."""
        return float(rises(-self._pelvis, max(0.05, 0.4 * float(np.ptp(self._pelvis)))))

    @cached_property
    def bounces(self) -> float:
        return float(rises(-self._pelvis, 0.015))

    @cached_property
    def pitch_high(self) -> float:
        return float(self._pitch.max())

    @cached_property
    def pitch_low(self) -> float:
        return float(self._pitch.min())

    @cached_property
    def pitch_mid(self) -> float:
        return float(np.median(self._pitch))

    @cached_property
    def pitch_range(self) -> float:
        return float(np.ptp(self._pitch))

    @cached_property
    def roll_high(self) -> float:
        return float(self._roll.max())

    @cached_property
    def roll_low(self) -> float:
        return float(self._roll.min())

    @cached_property
    def roll_range(self) -> float:
        return float(np.ptp(self._roll))

    @cached_property
    def twist_high(self) -> float:
        return float(self._twist.max())

    @cached_property
    def twist_low(self) -> float:
        return float(self._twist.min())

    @cached_property
    def twist_range(self) -> float:
        return float(np.ptp(self._twist))

    @cached_property
    def twists(self) -> float:
        """How often the shoulders turn to the left against the hips."""
        return float(rises(self._twist, 15.0, least=8.0))

    @cached_property
    def nod_high(self) -> float:
        return float(self._nod.max() - self._level)

    @cached_property
    def nod_low(self) -> float:
        return float(self._nod.min() - self._level)

    @cached_property
    def nods(self) -> float:
        return float(rises(self._nod, max(6.0, 0.35 * float(np.ptp(self._nod)))))

    @cached_property
    def nod_range(self) -> float:
        return float(np.ptp(self._nod))

    @cached_property
    def shake_range(self) -> float:
        return float(np.ptp(self._shake))

    @cached_property
    def nod_hold(self) -> float:
        """The longest that the head stays down, s."""
        start, stop = _longest(self._nod - self._level > 0.7 * self.nod_high)
        return (stop - start) / FPS

    @cached_property
    def shake_high(self) -> float:
        return float(self._shake.max() - np.median(self._shake))

    @cached_property
    def shake_low(self) -> float:
        return float(self._shake.min() - np.median(self._shake))

    @cached_property
    def shakes(self) -> float:
        """How often the head turns to the left and to the right."""
        turns = max(3.0, 0.35 * self.shake_range)
        return float((len(peaks(self._shake, turns)) + len(peaks(-self._shake, turns)) + 1) // 2)

    @cached_property
    def look_high(self) -> float:
        return float(self._look.max())

    @cached_property
    def look_low(self) -> float:
        return float(self._look.min())

    @cached_property
    def looks(self) -> float:
        """How often the head turns far to a side."""
        return float(rises(self._look, 20.0, least=15.0) + rises(-self._look, 20.0, least=15.0))

    @cached_property
    def shrug(self) -> float:
        return _range(self._signals.shoulders[self._window])

    @cached_property
    def shrugs(self) -> float:
        return float(rises(self._signals.shoulders[self._window], 0.035))

    @cached_property
    def gap_low(self) -> float:
        return float(self._signals.gap[self._window].min())

    @cached_property
    def gap_mid(self) -> float:
        return float(np.median(self._signals.gap[self._window]))

    @cached_property
    def claps(self) -> float:
        """How often the hands meet."""
        return float(rises(-self._signals.gap[self._window], 0.1, least=-0.35))

    @cached_property
    def _flights(self) -> list[tuple[int, int]]:
        return [(a, b) for a, b in runs(self._toes > _AIR) if b - a >= 2]

    @cached_property
    def flights(self) -> float:
        """How often both feet leave the floor."""
        return float(len(self._flights))

    @cached_property
    def airborne(self) -> float:
        """Share of the frames with both feet off the floor."""
        return float((self._toes > _AIR).mean())

    @cached_property
    def jump(self) -> float:
        """Height of the lower toe."""
        return float(self._toes.max())

    @cached_property
    def tiptoe(self) -> float:
        """Seconds with both heels up and a toe on the floor."""
        start, stop = _longest((self._heels > _TIPTOE) & (self._toes < _AIR))
        return (stop - start) / FPS

    @cached_property
    def heels(self) -> float:
        """How often both heels are raised."""
        return float(rises(self._heels, 0.04, least=0.06))

    @cached_property
    def knee_low(self) -> float:
        """Height of the lower knee at its lowest."""
        return min(self._feet[side].knee_low for side in SIDES)

    @cached_property
    def hand_low(self) -> float:
        """Height of the lower hand over the floor at its lowest."""
        return min(self._hands[side].floor for side in SIDES)

    @cached_property
    def one_leg(self) -> float:
        """The longest that a foot is off the floor, s."""
        return max(self._feet[side].longest_up for side in SIDES)

    @cached_property
    def lifts(self) -> float:
        """How often a foot is lifted."""
        return sum(self._feet[side].lifts for side in SIDES)

    @cached_property
    def punches(self) -> float:
        """How often a hand goes out to the front."""
        return sum(self._hands[side].pushes for side in SIDES)

    @cached_property
    def stance_range(self) -> float:
        return _range(self._signals.stance[self._window])

    @cached_property
    def side_steps(self) -> float:
        """How often the feet part to the side."""
        return float(rises(np.abs(self._signals.stance[self._window]), 0.12))

    @cached_property
    def strides(self) -> float:
        """How often one foot gets in front of the other."""
        feet = [self._signals.feet[side].place[self._window, 0] for side in SIDES]
        return float(rises(np.abs(feet[0] - feet[1]), 0.14))

    @cached_property
    def paces(self) -> float:
        """Single steps of an opening and a closing foot, in whichever direction."""
        return max(self.side_steps, self.strides)

    @cached_property
    def sway(self) -> float:
        return _range(self._leftward)

    @cached_property
    def sways(self) -> float:
        return float((len(peaks(self._leftward, 0.04)) + len(peaks(-self._leftward, 0.04)) + 1) // 2)


class Measures:
    """The measures of frames [start, stop) of a motion: of the body, and of each hand and foot by side.

    A window holds at least three frames.
    """

    def __init__(self, signals: Signals, start: int, stop: int) -> None:
        window = slice(start, stop)
        self.hands = {side: HandMeasures(signals.hands[side], side, signals.twist, window) for side in SIDES}
        toes = np.minimum(signals.feet["left"].toe[window], signals.feet["right"].toe[window])
        floor = float(np.percentile(toes, 5))  # of this window: captured motion may hover
        self.feet = {side: FootMeasures(signals.feet[side], floor, window) for side in SIDES}
        self.body = BodyMeasures(signals, toes - floor, window, self.hands, self.feet)
