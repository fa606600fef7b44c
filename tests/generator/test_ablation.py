"""The ablation trains its rows once, shares what they share, and leaves folders that the generator loads."""

from dataclasses import replace

import pytest
import torch

from benchmarks import ablation
from benchmarks.ablation import Arguments, run, segmentation_rows, show
from generator import weights
from generator.config import Training
from generator.datasets.authored import AuthoredCorpus
from generator.models.segmo.config import TokenizerConfig, TokenizerLosses
from generator.models.segmo.model import SegMo
from generator.models.segmo.objectives.tokenizer import TokenizerObjective
from generator.nn.durations import DurationModel, DurationsConfig
from generator.performer import Performer
from generator.training.loop import Run, train
from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.files import make_folder
from tests.generator.tiny_dataset import write_tiny_dataset


@pytest.fixture(scope="module")
def arguments(tmp_path_factory: pytest.TempPathFactory) -> Arguments:
    folder = tmp_path_factory.mktemp("ablation")
    dataset = AuthoredCorpus.open(write_tiny_dataset(folder / "data", test_split=True))
    training = Training(8, 3, 1e-3, ema=0.0, weight_decay=0.0)
    torch.manual_seed(0)
    config = TokenizerConfig("patch", 32, 8, 1, 2, codes=32, code_width=8, quantizers=2, parts="limbs")
    objective = TokenizerObjective(dataset, config, training, TokenizerLosses(window=40), seed=0)
    own, shared = folder / "w" / "segmo", folder / "w" / "shared"
    train(objective, training, own / "tokenizer", Run(3))
    durations = DurationsConfig(8)
    weights.save(make_folder(shared / "durations"), durations, DurationModel(durations), {})
    return Arguments(
        dataset=folder / "data",
        weights=folder / "w",
        out=folder / "out",
        iterations=2,
        batch=4,
        rows=("momask", "segmo-clustering", "layout-uniform"),
        width=16,
        layers=1,
    )


def test_rows_are_trained_measured_and_loadable(
    arguments: Arguments, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    results = run(arguments)
    assert list(results) == list(arguments.rows)
    assert results["momask"]["consistency"] == {}
    assert -1 <= results["segmo-clustering"]["consistency"]["exact"]["mean"] <= 1
    for name in arguments.rows:
        loaded = Performer.load(arguments.out / name).model
        assert isinstance(loaded, SegMo)
        assert loaded.mask.config == ablation.Ablation(arguments, None, loaded.tokenizer.config).transformer(  # type: ignore[arg-type]
            ablation.ROWS[name]
        )
    show(results, segmentation_rows(AuthoredCorpus.open(arguments.dataset)))
    printed = capsys.readouterr().out
    assert "| exact | 1.000 | 0.000 | 0.000 |" in printed
    assert all(f"| {name} |" in printed for name in arguments.rows)
    with pytest.raises(InvalidFile, match="exists already; --resume goes on"):
        run(arguments)
    monkeypatch.setattr(ablation, "train", None)  # would fail if anything were trained again
    assert run(replace(arguments, resume=True)) == results


def test_unknown_rows_are_named(arguments: Arguments) -> None:
    with pytest.raises(UnknownName, match="unknown row 'mdm'; valid: layout-exact, "):
        run(replace(arguments, rows=("mdm",)))
