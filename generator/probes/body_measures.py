"""Numbers about the whole body in a window of a motion: its way over the floor, its height, its limbs together."""

from functools import cached_property

import numpy as np

from generator.probes.cycles import cycles, longest_run, rises, runs, span
from generator.probes.foot_measures import FootMeasures
from generator.probes.hand_measures import HandMeasures
from generator.probes.signals import SIDES, Floats, Signals
from generator.probes.trunk_measures import TrunkMeasures
from ros_free_stack.skeleton import FPS

_AIR = 0.035  # leg lengths: a toe that high has left the floor
_TIPTOE = 0.06


class BodyMeasures(TrunkMeasures):
    """The whole body in a window: the trunk, where the body goes, and what its limbs do together."""

    def __init__(
        self,
        signals: Signals,
        toes: Floats,
        window: slice,
        hands: dict[str, HandMeasures],
        feet: dict[str, FootMeasures],
    ) -> None:
        super().__init__(signals, window)
        self._toes, self._hands, self._feet = toes, hands, feet
        self._heading, self._pelvis = signals.heading[window], signals.pelvis[window]
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
        return span(self._heading)

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
        start, stop = longest_run((self._heels > _TIPTOE) & (self._toes < _AIR))
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
        return span(self._signals.stance[self._window])

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
        return span(self._leftward)

    @cached_property
    def sways(self) -> float:
        return float(cycles(self._leftward, 0.04))
