"""The firmware's profiles against the e-Manual's description."""

from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hw.virtual.profile import RECTANGULAR, STEP, TRAPEZOIDAL, TRIANGULAR, Profile

DT = 0.002


def run(profile: Profile) -> tuple[list[float], list[float]]:
    positions, speeds = [profile.position], [profile.velocity]
    while not profile.done and len(positions) < 20_000:
        profile.advance(DT)
        positions.append(profile.position)
        speeds.append(profile.velocity)
    return positions, speeds


def test_without_speed_the_reference_jumps() -> None:
    profile = Profile()
    profile.head_for(2.0, speed=0.0, acceleration=3.0)
    assert profile.kind == STEP
    profile.advance(DT)
    assert profile.position == 2.0


@pytest.mark.parametrize(
    ("goal", "speed", "acceleration", "kind", "duration"),
    [
        (2.0, 1.0, 0.0, RECTANGULAR, 2.0),
        (2.0, 1.0, 4.0, TRAPEZOIDAL, 2.25),
        (-1.0, 10.0, 4.0, TRIANGULAR, 1.0),
    ],
)
def test_shapes(goal: float, speed: float, acceleration: float, kind: int, duration: float) -> None:
    profile = Profile()
    profile.head_for(goal, speed=speed, acceleration=acceleration)
    assert profile.kind == kind
    positions, _ = run(profile)
    assert len(positions) * DT == pytest.approx(duration, abs=0.06)
    assert positions[-1] == goal


@pytest.mark.parametrize("rise_s", [0.0, 0.2, 0.5, 3.0])
def test_time_based(rise_s: float) -> None:
    profile = Profile(position=0.5)
    profile.arrive_in(2.0, total_s=1.0, rise_s=rise_s)
    positions, _ = run(profile)
    assert len(positions) * DT == pytest.approx(1.0, abs=0.06)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.2, 8), st.floats(1, 60))
@example(1.0, 0.0078125, 1.0, 1.0)  # too fast to stop at the second goal
def test_bounds_hold_also_when_the_goal_changes(first: float, second: float, speed: float, acceleration: float) -> None:
    profile = Profile()
    profile.head_for(first, speed=speed, acceleration=acceleration)
    speeds = [0.0]
    for _ in range(60):
        profile.advance(DT)
        speeds.append(profile.velocity)
    profile.head_for(second, speed=speed, acceleration=acceleration)
    positions, more = run(profile)
    speeds += more
    assert max(map(abs, speeds)) <= speed * (1 + 1e-9)
    # On arrival the rest, less than two steps of braking, is taken at once.
    steps = [abs(b - a) for a, b in pairwise(speeds)]
    assert max(steps) <= 3 * acceleration * DT
    assert positions[-1] == second
