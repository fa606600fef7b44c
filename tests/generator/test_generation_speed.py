"""The benchmark of generation: what it compares really runs, and its table tells what was drawn."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from benchmarks.generation_speed import ANOTHER_SEED, Arguments, run, show
from benchmarks.speed_variants import bfloat16, int8, torchscript
from generator.nn.layers import Transformer
from ros_free_stack.errors import UnknownName
from tests.generator.test_performer import folder

__all__ = ["folder"]


@pytest.fixture(scope="module")
def layers() -> Transformer:
    torch.manual_seed(0)
    transformer = Transformer(width=32, layers=2, heads=4, feed_forward=64, dropout=0.0)
    return transformer.eval().requires_grad_(False)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("variant", "tolerance"), [(torchscript, 1e-5), (int8, 0.2), (bfloat16, 0.1)])
@torch.inference_mode()
def test_variants_compute_the_same_layers_at_every_size(layers: Transformer, variant, tolerance: float) -> None:
    other = variant(layers)
    for batch, tokens in ((2, 52), (1, 5), (6, 20)):
        hidden, mask = torch.randn(batch, tokens, 32), torch.ones(batch, tokens, dtype=torch.bool)
        mask[-1, -2:] = False
        torch.testing.assert_close(other(hidden, mask), layers(hidden, mask), atol=tolerance, rtol=0)


@pytest.mark.filterwarnings("ignore")
def test_a_run_times_every_part_and_tells_whether_the_same_is_drawn(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    arguments = Arguments(
        weights=folder, threads=torch.get_num_threads(), repeats=1, candidates=(1,), variants=("eager", "int8")
    )
    found = run(arguments)
    assert {"import torch", "load weights", "generate", "process"} <= set(found["cold_s"][1])
    assert sum(found["cold_s"][1].values()) <= 2 * found["cold_s"][1]["process"]
    assert {"mask steps", "decode tokens", "lock feet"} <= set(found["warm_s"][1])
    rows = {row["variant"]: row for row in found["variants"]}
    assert rows["eager"]["same_tokens"] == 1 and rows["eager"]["joints_apart_m"] == 0
    assert rows[ANOTHER_SEED]["same_tokens"] < 1
    show(found)
    assert "| eager, another seed | 1 |" in capsys.readouterr().out
    with pytest.raises(UnknownName, match="variant"):
        run(replace(arguments, variants=("fast",)))
