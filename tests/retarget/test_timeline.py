import numpy as np
import pytest

from retarget.plan.timeline import HOLD_S, Pace, plan_timeline


def steady(duration: float, slowdown: float = 1.0) -> Pace:
    return Pace(np.array([0.0, duration * slowdown]), np.array([0.0, duration]))


@pytest.mark.parametrize("duration", [0.0, 0.1, 0.7, 3.0, 12.3])
@pytest.mark.parametrize("fps", [30.0, 50.0, 125.0])
@pytest.mark.parametrize("slowdown", [1.0, 1.5])
def test_starts_and_ends_at_rest_and_misses_nothing(duration: float, fps: float, slowdown: float):
    timeline = plan_timeline(steady(duration, slowdown), fps)
    rate = np.diff(timeline.human_s) * fps
    hold = round(HOLD_S * fps)
    assert timeline.human_s[0] == 0 and timeline.human_s[-1] == pytest.approx(duration, abs=1e-9)
    assert (rate >= -1e-9).all() and rate.max(initial=0) < 1.02 / slowdown
    assert timeline.hold[: hold - 1].all() and timeline.hold[-hold + 1 :].all()
    assert (timeline.weight[timeline.hold] == 0).all()
    assert timeline.weight.max() > 0.99
