"""HumanML3D and KIT-ML folders: read by the published rules, and every stage trains on them."""

from pathlib import Path

import numpy as np
import pytest

from generator import weights
from generator.cli import Train
from generator.datasets.open_dataset import open_dataset
from generator.datasets.published import PublishedMotions
from generator.models.segmo.objectives.segmentation_table import segmentation_table
from generator.performer import Performer
from generator.registry import find_preset
from generator.training.stages import StageJob
from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats.features import HUMANML3D, KIT, Skeleton
from tests.generator.tiny_models import tiny_job
from tests.generator.tiny_published import write_published

SMALLER = tuple(
    f"{stage}.{setting}"
    for stage, settings in {
        "tokenizer": ("model.width=16", "model.encoder_width=8", "model.depth=1", "model.code_width=8"),
        "mask": ("model.width=32", "model.layers=1", "model.feed_forward=64"),
        "residual": ("model.width=32", "model.layers=1", "model.feed_forward=64"),
    }.items()
    for setting in (*settings, "model.codes=32", "training.batch=4", "training.warm_up=2")
)


@pytest.fixture(scope="module")
def humanml3d(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_published(tmp_path_factory.mktemp("humanml3d") / "HumanML3D", HUMANML3D)


@pytest.fixture(scope="module")
def kit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_published(tmp_path_factory.mktemp("kit") / "KIT-ML", KIT)


def test_clips_are_whole_motions_and_excerpts_with_split_captions(humanml3d: Path) -> None:
    data = open_dataset(humanml3d)
    assert isinstance(data, PublishedMotions)
    assert (data.layout.width, data.layout.fps, data.layout.least_frames) == (263, 20.0, 40)
    assert len(data.split("train")) == 12 + 1 and len(data.split("val")) == 4 and not data.split("test")
    excerpt, whole = data.split("train")[:2]
    assert (excerpt.start, excerpt.captions[0].text, excerpt.captions[0].segments[0]) == (
        20,
        "he waves",
        "a person waves",
    )
    assert excerpt.length == min(80, whole.length - 20)
    assert [caption.segments for caption in whole.captions] == [
        ("a person walks forward",),
        ("a person walks forward", "a person waves"),
    ]
    assert whole.captions[0].tokens[2] == ("walk", "VERB")
    stored = np.load(humanml3d / "new_joint_vecs" / "000000.npy")
    np.testing.assert_array_equal(data.features(excerpt), stored[20 : 20 + excerpt.length])


def test_kit_is_told_by_its_width_and_statistics_are_measured(kit: Path) -> None:
    data = open_dataset(kit)
    assert (data.layout.name, data.layout.width, data.layout.fps, data.layout.least_frames) == ("kit-ml", 251, 12.5, 24)
    rows = np.concatenate([data.features(clip) for clip in data.split("train")]).astype(np.float64)
    np.testing.assert_allclose(data.mean, rows.mean(0), atol=1e-4)
    np.testing.assert_allclose(data.std, rows.std(0), atol=1e-4)


def test_published_statistics_are_taken_where_they_are_there(tmp_path: Path) -> None:
    folder = write_published(tmp_path / "data", HUMANML3D, motions=4)
    np.save(folder / "Mean.npy", np.full(263, 2.0))
    np.save(folder / "Std.npy", np.full(263, 3.0))
    data = open_dataset(folder)
    assert data.mean.tolist() == [2.0] * 263 and data.std.tolist() == [3.0] * 263


def test_captions_are_split_once(humanml3d: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = open_dataset(humanml3d)
    monkeypatch.setattr("generator.datasets.published.sentence_splitter", None)  # would fail if asked again
    assert open_dataset(humanml3d).clips == first.clips


def test_captions_of_one_clip_are_cut_into_as_many_segments_as_each_has(humanml3d: Path) -> None:
    data = open_dataset(humanml3d)
    whole = data.clips.index(data.split("train")[1])
    for kind in ("uniform", "change-point"):
        table = segmentation_table(data, kind)
        tokens = data.clips[whole].length // 4
        assert table[whole, 0].tolist() == [tokens, 0, 0, 0, 0]
        assert table[whole, 1].sum() == tokens and (table[whole, 1] > 0).sum() == 2
        assert not table[whole, 2:].any()


@pytest.mark.parametrize("skeleton", [HUMANML3D, KIT], ids=["humanml3d", "kit-ml"])
def test_train_command_trains_segmo_as_published_on_a_published_folder(
    skeleton: Skeleton, humanml3d: Path, kit: Path, tmp_path: Path
) -> None:
    folder = humanml3d if skeleton is HUMANML3D else kit
    for stage in ("tokenizer", "mask", "residual"):
        command = Train(
            stage=stage,
            preset="segmo-published",
            dataset=folder,
            out=tmp_path,
            set=SMALLER,
            iterations=2,
            threads=1,
            device="cpu",
        )
        assert command.run() == 0
    tokenizer, mask = (weights.load(tmp_path / "segmo" / stage, stage) for stage in ("tokenizer", "mask"))
    assert tokenizer.config["features"] == skeleton.width
    assert mask.config["conditioning"] == "segments" and mask.facts["objective"]["segmentation"] == "uniform"
    assert mask.facts["clips"] == 13
    assert mask.facts["sampling"]["mask_guidance"] == 4.0


@pytest.mark.parametrize("stage", ["durations", "evaluator"])
def test_shared_stages_train_on_kit(kit: Path, tmp_path: Path, stage: str) -> None:
    result = tiny_job(stage, open_dataset(kit), tmp_path, iterations=2).run()
    assert result["finished"] == 1 and np.isfinite(result["validation_loss"])


def test_models_of_humanml3d_generate_and_those_of_kit_are_refused(humanml3d: Path, kit: Path, tmp_path: Path) -> None:
    for name, folder in (("h", humanml3d), ("k", kit)):
        data = open_dataset(folder)
        generator, preset = find_preset("segmo-published")
        for stage in ("tokenizer", "mask", "residual", "durations"):
            changed = preset.changed((*SMALLER, "durations.training.batch=4"))
            StageJob(
                stage=stage, generator=generator, preset=changed, dataset=data, out=tmp_path / name, iterations=1
            ).run()
    (motion,) = Performer.load(tmp_path / "h").generate("a person walks", ("a person walks",), seed=0, duration_s=3.0)
    assert motion.joints.shape == (60, 22, 3)
    with pytest.raises(InvalidOption, match=r"makes 251 features at 12\.5 frames a second; human motion has 263 at 20"):
        Performer.load(tmp_path / "k")


def test_exact_boundaries_of_a_folder_without_labels_are_refused(humanml3d: Path, tmp_path: Path) -> None:
    data = open_dataset(humanml3d)
    tiny_job("tokenizer", data, tmp_path, iterations=1).run()
    with pytest.raises(InvalidOption, match=r"exact boundaries are not labelled in .*; take uniform, for example with"):
        tiny_job("mask", data, tmp_path, iterations=1).run()


def test_limbs_of_another_skeleton_are_refused(kit: Path, tmp_path: Path) -> None:
    with pytest.raises(InvalidOption, match="limbs are known of 263 features, found 251; take whole"):
        tiny_job("tokenizer", open_dataset(kit), tmp_path, iterations=1).run()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("texts/000000.txt", "walks\n", r"line 1: expected caption#tokens#start#end"),
        ("new_joint_vecs/000000.npy", "x", "not a readable .npy"),
        ("train.txt", None, r"train.txt: missing"),
    ],
)
def test_damaged_folders_are_named(tmp_path: Path, name: str, content: str | None, words: str) -> None:
    folder = write_published(tmp_path / "data", HUMANML3D, motions=4)
    (folder / name).unlink()
    if content is not None:
        (folder / name).write_text(content)
    with pytest.raises(InvalidFile, match=words):
        open_dataset(folder)


def test_folders_that_hold_no_data_set_and_other_widths_are_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match=r"holds no motion data set; expected what `launch\.py data build"):
        open_dataset(tmp_path)
    folder = write_published(tmp_path / "data", HUMANML3D, motions=4)
    for path in (folder / "new_joint_vecs").glob("*.npy"):
        np.save(path, np.zeros((60, 100)))
    with pytest.raises(InvalidFile, match=r"has 100 features a frame, expected 263 \(humanml3d\) or 251 \(kit-ml\)"):
        open_dataset(folder)


def test_values_that_are_not_finite_are_named(tmp_path: Path) -> None:
    folder = write_published(tmp_path / "data", HUMANML3D, motions=4)
    path = folder / "new_joint_vecs" / "000001.npy"
    rows = np.load(path)
    rows[3, 5] = np.nan
    np.save(path, rows)
    data = open_dataset(folder)
    clip = next(clip for clip in data.clips if clip.id == "000001")
    with pytest.raises(InvalidFile, match=r"000001\.npy: holds values that are not finite"):
        data.features(clip)
