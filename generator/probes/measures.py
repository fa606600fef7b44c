"""Numbers about a window of a motion: what its signals do there, for the body, each hand and each foot.

Each is computed when a probe asks for it, and kept. Units are those of `signals.py`; counts are whole numbers.
"""

import numpy as np

from generator.probes.body_measures import BodyMeasures
from generator.probes.foot_measures import FootMeasures
from generator.probes.hand_measures import HandMeasures
from generator.probes.signals import SIDES, Signals


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
