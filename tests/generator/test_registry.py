"""The generators: what they name exists, and every stage of every preset can be built."""

from pathlib import Path
from typing import get_args

import pytest
import torch

from generator.config import Training, checked
from generator.datasets.authored import AuthoredCorpus
from generator.models.party.config import PartySampling
from generator.models.segmo.config import SegmoSampling
from generator.performer import Performer
from generator.registry import GENERATORS, WEIGHTS_FOLDER, find_preset, generator, resolved, stages
from generator.settings import FOLDER, SHARED_FILE, Size
from ros_free_stack.errors import NoWeights, UnknownName
from tests.generator.tiny_dataset import write_tiny_dataset
from tests.generator.tiny_models import tiny_job


@pytest.mark.parametrize("name", GENERATORS)
def test_what_a_generator_names_can_be_loaded(name: str) -> None:
    item = generator(name)
    assert callable(resolved(item.model).load)
    for stage in stages(item):
        assert callable(resolved(stage.objective))
        if stage.finish:
            assert callable(resolved(stage.finish))


def test_every_preset_has_the_stages_that_its_generator_samples_from_in_both_sizes() -> None:
    named = {preset for item in GENERATORS.values() for preset in item.presets}
    assert named == {path.stem for path in FOLDER.glob("*.yaml") if path.name != SHARED_FILE}
    for name in named:
        for size in get_args(Size):
            item, preset = find_preset(name, size)
            known, own = {stage.name for stage in stages(item)}, {stage.name for stage in item.stages}
            sampled = {"mask"} if "mask" in own else own
            needed = {"tokenizer", "durations", "evaluator"} | sampled
            assert needed <= set(preset.stages) <= known
            if "residual" in own:
                assert ("residual" in preset.stages) == (preset.sampling["layers"] > 1), "trained where it is sampled"
            for stage in preset.stages:
                checked(Training, preset.stage(stage)["training"], stage)
            checked(SegmoSampling if "mask" in own else PartySampling, preset.sampling, "sampling")


def test_the_generator_that_comes_with_the_program_loads() -> None:
    model = generator("segmo").load(WEIGHTS_FOLDER, "cpu")
    assert model.name.startswith("segmo ")
    assert (model.spec.width, model.spec.fps, model.spec.token_frames) == (263, 20.0, 4)
    through = model.reconstruct(torch.zeros(40, 263))
    assert through is not None and through.shape == (40, 263)


def test_unknown_and_untrained_generators_are_named() -> None:
    with pytest.raises(UnknownName, match="unknown generator 'mdm'; valid: momask, part-wise, party, segmo"):
        generator("mdm")
    presets = "momask, part-wise, party, party-small, segmo-layout, segmo-published"
    with pytest.raises(UnknownName, match=f"unknown preset 'full'; valid: {presets}"):
        find_preset("full")
    with pytest.raises(NoWeights, match="no trained tokenizer; train it with"):
        generator("momask").load(WEIGHTS_FOLDER, "cpu")


def test_momask_trains_and_generates_beside_segmo(tmp_path: Path) -> None:
    data = AuthoredCorpus.open(write_tiny_dataset(tmp_path / "data", clips=8))
    out = tmp_path / "out"
    for stage in ("tokenizer", "mask", "residual", "durations"):
        tiny_job(stage, data, out, preset="momask", iterations=1).run()
    assert {path.name for path in out.iterdir()} == {"momask", "shared"}
    performer = Performer.load(out, generator="momask")
    assert performer.model.spec.layout == "uniform"
    texts = ("a person waves", "a person bows")
    (motion,) = performer.generate(", then ".join(texts), texts, seed=0, durations_s=(1.0, 3.0))
    assert motion.source.startswith("momask ")
    assert [round(s.end_s, 6) for s in motion.segments] == [2.0, 4.0], "nothing tells where a segment begins"
