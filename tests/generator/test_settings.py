"""Presets: read, changed, refused where a setting is unknown or of another type."""

from pathlib import Path

import pytest

from generator.config import Training, checked
from generator.models.segmo.config import MaskLosses, TokenizerConfig, TransformerConfig
from generator.registry import find_preset
from generator.settings import read_preset
from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName

PRESET = """
title: for a test
published:
  sampling: {steps: 5}
  net:
    model: {width: 64}
    training: {batch: 32, iterations: 1000, learning_rate: 0.001}
small:
  net:
    model: {width: 8}
"""


def test_read_preset_small_changes_what_published_says(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(PRESET)
    large, small = read_preset(path, "published"), read_preset(path, "small")
    assert large.name == "mine" and large.sampling == {"steps": 5}
    assert large.stage("net")["model"] == {"width": 64} and small.stage("net")["model"] == {"width": 8}
    assert small.stage("net")["training"] == large.stage("net")["training"]
    assert large.stage("durations")["model"] == {"width": 256} and small.stage("durations")["model"] == {"width": 128}


def test_changed_replaces_settings_and_leaves_the_preset() -> None:
    _, preset = find_preset("segmo-published")
    changed = preset.changed(("mask.training.batch=8", "mask.training.milestones=[5, 9]", "mask.objective.start=codes"))
    training = checked(Training, changed.stage("mask")["training"], "mask.training")
    assert training.batch == 8 and training.milestones == (5, 9)
    assert changed.stage("mask")["objective"]["start"] == "codes"
    assert preset.stage("mask")["training"]["batch"] == 64


def test_segmo_published_is_the_papers() -> None:
    """SegMo, sections 3.2 to 3.5 and 4.1, on MoMask's set-up."""
    _, preset = find_preset("segmo-published", "published")
    mask = preset.stage("mask")
    assert mask["model"]["conditioning"] == "segments" and not mask["model"]["clauses"]
    assert mask["objective"] == {
        "alignment": "segment",
        "alignment_weight": 1.0,
        "segmentation": "uniform",
        "start": "random",
    }
    sizes = checked(TransformerConfig, mask["model"], "mask.model")
    assert (sizes.layers, sizes.heads, sizes.width, sizes.feed_forward, sizes.dropout) == (8, 6, 384, 1024, 0.2)
    tokenizer = checked(TokenizerConfig, preset.stage("tokenizer")["model"], "tokenizer.model")
    assert (tokenizer.width, tokenizer.codes, tokenizer.code_width, tokenizer.quantizers) == (512, 512, 512, 6)
    assert preset.stage("tokenizer")["objective"] == {"losses": "published", "window": 64}
    assert (preset.sampling["mask_guidance"], preset.sampling["residual_guidance"]) == (4.0, 5.0)
    assert (preset.sampling["steps"], preset.sampling["layers"], preset.sampling["top_k"]) == (10, 6, 0.9)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ("mask.batch=8", InvalidOption, "--set: expected STAGE.SECTION.SETTING=VALUE, found 'mask.batch=8'"),
        ("mask.training.batch", InvalidOption, "expected STAGE.SECTION.SETTING=VALUE"),
        (
            "masks.training.batch=8",
            UnknownName,
            "unknown stage 'masks'; did you mean mask",
        ),
        ("mask.sizes.width=8", UnknownName, "unknown section 'sizes'; valid: model, objective, training"),
        ("mask.training.batch=[", InvalidOption, "has no readable value"),
    ],
)
def test_changed_refuses_what_is_no_setting(change: str, error: type[Exception], words: str) -> None:
    _, preset = find_preset("segmo-layout")
    with pytest.raises(error, match=words.replace("[", r"\[")):
        preset.changed((change,))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            {"alignment": "pairs"},
            "unknown mask.objective.alignment 'pairs'; valid: batch, global, none, ",
        ),
        ({"alignment_weight": "much"}, "mask.objective.alignment_weight: expected a value of type float, found 'much'"),
        ({"alignment_weight": True}, "expected a value of type float, found True"),
        ({"weight": 1.0}, "unknown setting of mask.objective 'weight'; valid: alignment, alignment_weight"),
    ],
)
def test_checked_names_the_setting_that_is_wrong(settings: dict, words: str) -> None:
    with pytest.raises((InvalidOption, UnknownName), match=words):
        checked(MaskLosses, settings, "mask.objective")


def test_checked_names_what_is_missing_and_what_cannot_be() -> None:
    with pytest.raises(InvalidOption, match="t: lacks a setting, one of iterations, learning_rate"):
        checked(Training, {"batch": 8}, "t")
    with pytest.raises(InvalidOption, match=r"training\.batch: must be positive, found 0"):
        checked(Training, {"batch": 0, "iterations": 1, "learning_rate": 1}, "t")
    with pytest.raises(InvalidOption, match=r"training.betas: must be two numbers"):
        checked(Training, {"batch": 1, "iterations": 1, "learning_rate": 1, "betas": [0.5]}, "t")
    with pytest.raises(InvalidOption, match="must be a multiple of 4 heads, found 30"):
        TransformerConfig(30, 1, 4, 64, dropout=0.0, codes=8, quantizers=1)


def test_read_preset_names_damaged_files_and_unknown_sizes(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    for text, words in (
        ("title: [", "not a readable preset"),
        ("- a", "expected settings"),
        ("title: a", "lacks `publ"),
    ):
        path.write_text(text)
        with pytest.raises(InvalidFile, match=words):
            read_preset(path, "small")
    with pytest.raises(UnknownName, match="unknown size 'huge'; valid: published, small"):
        read_preset(path, "huge")
