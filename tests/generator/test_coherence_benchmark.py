"""The coherence tables score real motion above its mixtures, and name a source that is not there."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.coherence import BETAS, KAPPAS, LAGS, SIGMAS, WINDOWS, Arguments, main, motions
from ros_free_stack.errors import InvalidOption
from ros_free_stack.skeleton import INDEX
from tests.generator.tiny_dataset import write_tiny_dataset


def test_tables_have_a_row_for_each_hyper_parameter(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = write_tiny_dataset(tmp_path / "data", clips=8)
    main(Arguments(dataset=data, source="authored", clips=3, frames=40))
    rows = [line for line in capsys.readouterr().out.splitlines() if line.endswith("% |")]
    assert len(rows) == len(SIGMAS) * len(KAPPAS) + len(WINDOWS) * len(LAGS) + len(BETAS)


def test_mixtures_have_the_arms_of_another_clip(tmp_path: Path) -> None:
    data = write_tiny_dataset(tmp_path / "data", clips=8)
    real, mixed = motions(Arguments(dataset=data, source="authored", clips=4, frames=40))
    legs, arms = [INDEX["left_knee"], INDEX["right_ankle"]], [INDEX["left_wrist"], INDEX["right_wrist"]]
    assert all(np.allclose(one[:, legs], two[:, legs]) for one, two in zip(real, mixed, strict=True))
    assert any(not np.allclose(one[:, arms], two[:, arms]) for one, two in zip(real, mixed, strict=True))


def test_source_that_is_not_there_is_named(tmp_path: Path) -> None:
    data = write_tiny_dataset(tmp_path / "data", clips=8)
    with pytest.raises(InvalidOption, match="fewer than two clips of cmu have 100 frames; the data set has authored"):
        main(Arguments(dataset=data))
