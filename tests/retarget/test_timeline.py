import numpy as np
import pytest

from retarget.timeline import HOLD_S, plan_timeline


@pytest.mark.parametrize("duration", [0.0, 0.1, 0.7, 3.0, 12.3])
@pytest.mark.parametrize("fps", [30.0, 50.0, 125.0])
def test_starts_and_ends_at_rest_and_misses_nothing(duration: float, fps: float):
    timeline = plan_timeline(duration, fps)
    rate = np.diff(timeline.human_s) * fps
    hold = round(HOLD_S * fps)
    assert timeline.human_s[0] == 0 and timeline.human_s[-1] == pytest.approx(duration, abs=1e-9)
    assert (rate >= -1e-9).all() and rate.max(initial=0) < 1.02
    assert timeline.hold[: hold - 1].all() and timeline.hold[-hold + 1 :].all()
    assert (timeline.weight[timeline.hold] == 0).all()
    assert timeline.weight.max() > 0.99
