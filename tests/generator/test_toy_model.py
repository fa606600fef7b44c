"""A generator of this file's own: registered, trained, generating, editing, evaluated, with no change anywhere else."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from generator import weights
from generator.cli import Generate, Train
from generator.datasets.text_cache import text_table
from generator.evaluation.cli import Evaluate
from generator.model import FeatureSpec, Known, Sample, Sampling, TextCondition
from generator.registry import GENERATORS, Generator, Stage
from generator.training.stages import StageJob
from ros_free_stack.errors import UnknownName
from ros_free_stack.files import load_motion
from tests.generator.tiny_dataset import write_tiny_dataset

PRESET = """
title: a toy
published:
  net:
    model: {width: 32}
    training: {batch: 8, iterations: 20, learning_rate: 0.003, warm_up: 1, ema: 0.0}
small:
  net: {}
  durations: {training: {batch: 8, iterations: 20, warm_up: 1}}
  evaluator: {model: {width: 16, layers: 1, embedding: 8}, training: {batch: 8, iterations: 20, warm_up: 1}}
"""


@dataclass(frozen=True)
class NetConfig:
    width: int


class Net(nn.Module):
    """The sentence and the time since the start, to the features of a frame."""

    mean: Tensor
    std: Tensor

    def __init__(self, config: NetConfig, mean: Tensor | None = None, std: Tensor | None = None) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(263) if mean is None else mean)
        self.register_buffer("std", torch.ones(263) if std is None else std)
        self.layers = nn.Sequential(nn.Linear(385, config.width), nn.Tanh(), nn.Linear(config.width, 263))

    def forward(self, sentence: Tensor, frames: int) -> Tensor:
        time = torch.linspace(0, 1, frames)[None, :, None].expand(len(sentence), -1, -1)
        return self.layers(torch.cat([sentence[:, None].expand(-1, frames, -1), time], dim=-1)) * self.std + self.mean


class NetObjective:
    """Squared error of the first 40 frames."""

    name = "net"

    def __init__(self, job: StageJob) -> None:
        data = job.dataset
        clips, self.config = data.split("train"), job.model(NetConfig)
        self.facts: dict[str, Any] = {"clips": len(clips)}
        self.model: Any = Net(self.config, torch.from_numpy(data.mean), torch.from_numpy(data.std).clamp_min(1e-3))
        table = text_table(data.path, (clip.captions[0].text for clip in clips))
        rows = table.rows(clip.captions[0].text for clip in clips)
        self.sentences = torch.from_numpy(table.embeddings[rows].astype(np.float32))
        self.frames = torch.from_numpy(np.stack([data.features(clip)[:40] for clip in clips]))

    def loss(self, iteration: int) -> dict[str, Tensor]:
        error = (self.model(self.sentences, 40) - self.frames) / self.model.std
        return {"loss": error.square().mean()}

    def validate(self, model: nn.Module) -> dict[str, float]:
        return {name: float(value) for name, value in self.loss(0).items()}


@dataclass(frozen=True)
class Toy:
    """No tokens, no representation of its own; noise makes samples differ."""

    net: Net
    name: str
    spec: FeatureSpec

    def sample(
        self, text: TextCondition, *, known: Known | None, sampling: Sampling, noise: torch.Generator
    ) -> list[Sample]:
        found = []
        for row, frames in enumerate(text.frames.sum(1).tolist()):
            features = self.net(text.sentence[row : row + 1], frames)[0]
            features = features + 0.01 * self.net.std * torch.randn(features.shape, generator=noise)
            if known is not None:
                features = torch.where(known.mask[row, :frames, None], known.features[row, :frames], features)
            found.append(Sample(features.detach()))
        return found

    def reconstruct(self, features: Tensor) -> None:
        return None

    @classmethod
    def load(cls, folder: Path, *, device: str) -> Self:
        saved = weights.load(folder / "net", "net")
        net = Net(saved.config_as(NetConfig))
        saved.fill(net)
        return cls(net.eval(), "toy", FeatureSpec(263, 20.0, 40, 196))


@pytest.fixture(autouse=True)
def registered(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path_factory.mktemp("presets")
    (folder / "toy.yaml").write_text(PRESET)
    entry = Generator("toy", "a toy", Toy, (Stage("net", NetObjective),), ("toy",), folder)
    monkeypatch.setitem(GENERATORS, "toy", entry)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_tiny_dataset(tmp_path_factory.mktemp("toy") / "data", clips=48)


@pytest.fixture
def trained(data: Path, tmp_path: Path) -> Iterator[Path]:
    before = torch.get_num_threads()
    command = Train(stage="all", preset="toy", dataset=data, out=tmp_path / "weights", threads=1, device="cpu")
    assert command.run() == 0
    yield tmp_path / "weights"
    torch.set_num_threads(before)


def test_a_new_model_trains_generates_edits_and_is_evaluated(
    data: Path, trained: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    losses = [
        float(line.split(",")[3]) for line in (trained / "toy" / "net" / "curve.csv").read_text().splitlines()[1:]
    ]
    assert len(losses) == 20 and losses[-1] < 0.9 * losses[0]
    first, edited = tmp_path / "first.npz", tmp_path / "edited.npz"
    walk, sway = "a person walks forward", "a person sways"
    assert Generate(prompt=walk, out=first, generator="toy", weights=trained, duration=4.15, anyway=True).run() == 0
    motion = load_motion(first)
    assert motion.source == "toy" and len(motion.joints) == 83, "no tokens: any number of frames"
    command = Generate(prompt=sway, out=edited, generator="toy", weights=trained, edit=first, range=(1.5, 2.55))
    assert command.run() == 0
    changed = load_motion(edited)
    assert len(changed.joints) == 83
    assert changed.joints[:30].tobytes() == motion.joints[:30].tobytes()
    assert not np.allclose(changed.joints[31:50], motion.joints[31:50], atol=1e-3)
    assert [(s.text, round(s.start_s, 2), round(s.end_s, 2)) for s in changed.segments] == [
        (walk, 0.0, 1.5), ("a person sways from side to side", 1.5, 2.55), (walk, 2.55, 4.15),
    ]  # fmt: skip
    capsys.readouterr()
    evaluate = Evaluate(
        generator="toy",
        weights=(trained,),
        evaluator=trained / "shared" / "evaluator",
        dataset=data,
        split="train",
        runs=2,
        json=True,
    )
    assert evaluate.run() == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert list(rows) == ["real", "first", "resampled"], "it has no representation to reconstruct from"
    assert all(np.isfinite(rows[row]["fid"]["mean"]) for row in rows)


def test_stages_of_a_new_model_are_named(data: Path, tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match=r"unknown stage 'mask'; valid: all, domain, durations, evaluator, net"):
        Train(stage="mask", preset="toy", dataset=data, out=tmp_path, device="cpu").run()
