"""A CasADi function of one frame, evaluated on all frames of a clip in few calls."""

import casadi as ca
import numpy as np

from retarget.body.compiled import BufferedFunction
from ros_free_stack.messages import Floats

CHUNK = 64
"""Frames a call."""


class BatchFunction:
    """Evaluates a function on N frames: arrays of it (rows, columns) are (N, columns, rows) here."""

    def __init__(self, function: ca.Function) -> None:
        self._function = BufferedFunction(function.map(CHUNK))
        self._columns = {name: function.size2_in(name) for name in function.name_in()}
        self._columns |= {name: function.size2_out(name) for name in function.name_out()}

    def __call__(self, inputs: dict[str, Floats]) -> dict[str, Floats]:
        """All outputs; `inputs` needs every input."""
        count = len(next(iter(inputs.values())))
        outputs: dict[str, list[Floats]] = {name: [] for name in self._function.outputs}
        for start in range(0, count, CHUNK):
            here = min(CHUNK, count - start)
            for name, values in inputs.items():
                self._frames(name, self._function.inputs[name])[:here] = values[start : start + here]
            for name, values in self._function().items():
                outputs[name].append(self._frames(name, values)[:here].copy())
        return {name: np.concatenate(values) for name, values in outputs.items()}

    def _frames(self, name: str, memory: np.ndarray) -> np.ndarray:
        """A view (CHUNK, columns, rows) of the arrays of all frames side by side, (rows, columns * CHUNK)."""
        return memory.T.reshape(CHUNK, self._columns[name], memory.shape[0])
