"""A scene: the tracks that actions write on, a time cursor, and the person who performs."""

import numpy as np
from numpy.typing import ArrayLike

from generator.corpus import body
from generator.corpus.body import SIDES, SIGN, Floats, aim
from generator.corpus.liveliness import Performer, clipped_normal
from generator.corpus.pose import Pose
from generator.corpus.solver import Solver
from generator.corpus.tracks import LinearTrack, Track


class Scene:
    """One performer's motion in the making. Actions write keys from a start time on; `solve` turns them into a pose.

    Tracks (degrees for pelvis, spine and gaze, rad for the rest, metres):
        heading; pelvis (3); spine (3); gaze (2: left, down); crouch; offset (2: centre of mass forward, left of the
        feet); air (height of the flight); weight (share of the left foot); swing (2: authored arm swing, left arm
        forward positive, and bend of the elbows); shrug (height of the shoulders); and for each side
        arm_* (4), pin_* (4: wrist's place in the world and how far it holds), foot_* (4), roll_*, knee_*.

    Attributes:
        time: the cursor, in s: where the next action starts.
        standing: whether the person stands on both feet at the cursor (False after sitting down).
        performer: the person.
        hanging: arm keys (4,) of the hanging arms, by side.
        rest: where the arms return to: hanging, or in the lap while seated.
    """

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.time = 0.0
        self.standing = True
        self.performer = Performer.draw(self.rng)
        self.hanging: dict[str, Floats] = self._hanging_arms()
        self.rest: dict[str, Floats] = self.hanging
        self._solver_seed = int(self.rng.integers(2**32))
        skew = self.rng
        self.tracks: dict[str, Track] = {
            "heading": Track(0.0),
            "pelvis": Track(np.zeros(3), skew),
            "spine": Track(np.zeros(3), skew),
            "gaze": Track(np.zeros(2), skew),
            "crouch": Track(0.0),
            "offset": Track(np.zeros(2)),
            "air": Track(0.0),
            "weight": LinearTrack(0.5),
            "swing": Track(np.zeros(2)),
            "shrug": Track(0.0),
        }
        for side in SIDES:
            place = (0.04 * self.normal(), SIGN[side] * self.performer.stance, body.BALL_HEIGHT)
            toe_out = np.radians(8 + 4 * self.normal())
            self.tracks |= {
                f"arm_{side}": Track(self.rest[side], skew),
                f"pin_{side}": Track(np.zeros(4)),
                f"foot_{side}": Track([*place, SIGN[side] * toe_out]),
                f"roll_{side}": Track(0.0),
                f"knee_{side}": Track(0.0),
            }

    def _hanging_arms(self) -> dict[str, Floats]:
        forward, outward, swivel = (
            0.09 + 0.06 * self.normal(), 0.10 + 0.05 * self.normal(), -0.75 + 0.2 * self.normal()
        )  # fmt: skip
        return {
            side: aim(
                forward + 0.04 * self.normal(),
                max(outward + 0.03 * self.normal(), 0.03),
                -0.97,
                reach=0.962 + 0.013 * self.normal(),
                swivel=swivel + 0.1 * self.normal(),
            )
            for side in SIDES
        }

    def normal(self) -> float:
        """A standard normal draw, at most two standard deviations."""
        return clipped_normal(self.rng)

    def vary(self, value: float, share: float = 0.12) -> float:
        """`value` with human variation: `share` is the relative standard deviation."""
        return value * (1 + share * self.normal())

    def move(self, track: str, start: float, *keys: tuple[float, ArrayLike]) -> None:
        """`Track.move` on a track by its name: stay until `start`, pass the (time, value) keys, rest at the last."""
        self.tracks[track].move(start, *keys)

    def hold(self, time: float, *tracks: str) -> None:
        """`Track.hold` on several tracks."""
        for name in tracks:
            self.tracks[name].hold(time)

    def relax(self, side: str, time: float) -> None:
        """Bring an arm back to hanging at `time`."""
        self.tracks[f"arm_{side}"].key(time, self.rest[side], 0.0)

    @property
    def heading(self) -> float:
        """The latest heading, in rad."""
        return float(self.tracks["heading"].last[0])

    def foot(self, side: str) -> Floats:
        """(4,) the latest place and yaw of a foot."""
        return self.tracks[f"foot_{side}"].last

    @property
    def centre(self) -> Floats:
        """(2,) middle between the feet."""
        return 0.5 * (self.foot("left") + self.foot("right"))[:2]

    def local(
        self, forward: float, left: float, *, origin: Floats | None = None, heading: float | None = None
    ) -> Floats:
        """(2,) a place on the floor given from the feet's middle (or `origin`) along the heading."""
        angle = self.heading if heading is None else heading
        c, s = np.cos(angle), np.sin(angle)
        start = self.centre if origin is None else origin[:2]
        return start + np.array([c * forward - s * left, s * forward + c * left])

    def swing_foot(
        self,
        side: str,
        start: float,
        end: float,
        place: Floats,
        yaw: float,
        *,
        lift: float = 0.05,
        toe_off: float = 25.0,
        strike: float = -8.0,
        tuck: float = 6.0,
    ) -> None:
        """One footstep to `place` (2,): roll over the ball, clear the floor, land.

        `toe_off`, `tuck` (in mid-swing) and `strike` are the foot's roll in degrees, negative on the heel.
        """
        foot, roll = self.tracks[f"foot_{side}"], self.tracks[f"roll_{side}"]
        foot.hold(start)
        old, span = foot.last, end - start
        way, turn = place - old[:2], yaw - old[3]
        middle = [*(old[:2] + 0.53 * way), body.BALL_HEIGHT + 1.5 * lift, old[3] + 0.5 * turn]
        foot.key(start + 0.60 * span, middle, [*(way / span * 1.62), -0.2 * lift / span, turn / span * 1.5])
        foot.key(end, [*place, body.BALL_HEIGHT, yaw], 0.0)
        roll.hold(start - min(0.34, 0.8 * span))
        roll.key(start + 0.05, np.radians(toe_off))
        roll.key(start + 0.55 * span, np.radians(min(toe_off, tuck)))
        roll.key(end, np.radians(strike))
        roll.key(end + 0.12, 0.0, 0.0)

    def solve(self, tail: float = 0.25) -> Pose:
        """The pose at 20 fps from time 0 to the cursor plus `tail` seconds; the same scene gives the same bytes."""
        rng = np.random.default_rng(self._solver_seed)
        return Solver(self.tracks, self.performer, self.hanging, rng, duration=self.time + tail).solve()
