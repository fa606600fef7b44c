"""The benchmark of ParTY's pieces trains its rows once, scores them, and leaves folders that the generator loads."""

from pathlib import Path

import pytest

from benchmarks.party import ROWS, Arguments, main
from generator.datasets.authored import AuthoredCorpus
from generator.performer import Performer
from ros_free_stack.errors import UnknownName
from tests.generator.tiny_dataset import write_tiny_dataset
from tests.generator.tiny_party import SMALLER, tiny_party_job


@pytest.fixture
def arguments(tmp_path: Path) -> Arguments:
    data = AuthoredCorpus.open(write_tiny_dataset(tmp_path / "data", clips=144, test_split=True))
    for stage in ("tokenizer", "durations", "evaluator"):
        tiny_party_job(stage, data, tmp_path / "w", iterations=1).run()
    arms = tiny_party_job("evaluator", data, tmp_path / "arms", "evaluator.model.body=arms", iterations=1)
    arms.run()
    (tmp_path / "arms" / "shared" / "evaluator").rename(tmp_path / "w" / "shared" / "evaluator-arms")
    return Arguments(
        dataset=data.path, weights=tmp_path / "w", out=tmp_path / "out", iterations=1, seeds=2,
        rows=("no-guidance", "part-wise"), set=SMALLER, runs=2, device="cpu",
    )  # fmt: skip


def test_rows_are_trained_scored_and_loadable(arguments: Arguments, capsys: pytest.CaptureFixture[str]) -> None:
    main(arguments)
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    assert [line.split("|")[1].strip() for line in lines] == ["", "---", "real", "no-guidance", "part-wise"]
    assert "arms_top1" in lines[0] and "legs_top1" not in lines[0], "only parts that have an evaluator"
    assert "±" in lines[-1] and "±" not in lines[2]
    model = Performer.load(arguments.out / "no-guidance" / "1", generator="party").model
    assert model.network.mix is None and model.network.fusion is not None  # type: ignore[attr-defined]
    before = (arguments.out / "part-wise" / "0" / "part-wise" / "transformer" / "config.json").stat().st_mtime_ns
    main(arguments)
    again = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    assert again == lines
    assert (
        arguments.out / "part-wise" / "0" / "part-wise" / "transformer" / "config.json"
    ).stat().st_mtime_ns == before


def test_unknown_row_is_named(arguments: Arguments) -> None:
    with pytest.raises(UnknownName, match=f"unknown row 'magic'; valid: {', '.join(sorted(ROWS))}"):
        main(Arguments(dataset=arguments.dataset, weights=arguments.weights, out=arguments.out, rows=("magic",)))
