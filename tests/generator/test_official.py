"""The published evaluator, on small files in the published layout: found, read, refused where not as published."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from generator.datasets.published import PublishedMotions
from generator.evaluation.cli import Evaluate
from generator.evaluation.official import (
    NETWORKS,
    STATISTICS,
    MovementEncoder,
    OfficialEmbedder,
    OfficialFiles,
    SequenceEncoder,
    TextEncoder,
)
from generator.evaluation.pairs import Pair
from generator.evaluation.published import published_pairs
from generator.evaluation.words import TAGS, PublishedWords
from ros_free_stack.errors import InvalidFile

WORDS = ["unk", "sos", "eos", "a", "person", "walk", "slowly"]
WHOLE = "a person walks#a/DET person/NOUN walk/VERB#0.0#0.0\n"
EXCERPT = "slowly#slowly/ADV#1.0#4.0\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The published layout with 40 random motions and networks that were never trained."""
    folder, rng = tmp_path_factory.mktemp("official"), np.random.default_rng(0)
    data = folder / "HumanML3D"
    for name in ("new_joint_vecs", "texts"):
        (data / name).mkdir(parents=True)
    names = [f"{number:06d}" for number in range(40)]
    for number, name in enumerate(names):
        np.save(data / "new_joint_vecs" / f"{name}.npy", rng.normal(size=(60 + number, 263)).astype(np.float32))
        (data / "texts" / f"{name}.txt").write_text(WHOLE + EXCERPT * (number < 2))
    np.save(data / "new_joint_vecs" / "short.npy", rng.normal(size=(39, 263)))
    (data / "texts" / "short.txt").write_text(WHOLE)
    for split in ("train", "test"):
        (data / f"{split}.txt").write_text("\n".join([*names, "short", "absent"]))
    (folder / "glove").mkdir()
    np.save(folder / "glove" / "our_vab_data.npy", rng.normal(size=(len(WORDS), 300)))
    (folder / "glove" / "our_vab_words.pkl").write_bytes(pickle.dumps(WORDS))
    (folder / "glove" / "our_vab_idx.pkl").write_bytes(pickle.dumps({word: i for i, word in enumerate(WORDS)}))
    torch.manual_seed(0)
    networks: dict[str, nn.Module] = {
        "movement_encoder": MovementEncoder(),
        "motion_encoder": SequenceEncoder(512, 1024),
        "text_encoder": TextEncoder(),
    }
    (folder / NETWORKS).parent.mkdir(parents=True)
    torch.save({**{name: net.state_dict() for name, net in networks.items()}, "epoch": 1}, folder / NETWORKS)
    (folder / STATISTICS).mkdir(parents=True)
    np.save(folder / STATISTICS / "mean.npy", np.zeros(263))
    np.save(folder / STATISTICS / "std.npy", np.ones(263))
    return folder


@pytest.fixture(scope="module")
def embedder(folder: Path) -> OfficialEmbedder:
    return OfficialEmbedder(OfficialFiles.find(folder))


def test_the_command_takes_the_published_files(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert Evaluate(official=folder, rows="real", runs=2).run() == 0
    assert "official evaluator, 42 clips" in capsys.readouterr().out


def test_motions_and_captions_follow_the_published_rules(folder: Path) -> None:
    data = PublishedMotions.open(folder / "HumanML3D", split="test", segments=False)
    pairs = published_pairs(data, "test", clips=None, seed=0)
    assert len(pairs) == 42  # 40 motions, the spans of two captions; too short and absent motions are left out
    assert {pair.frames for pair in pairs if pair.text == "slowly"} <= {36, 40}  # 3 s at most, or a token less
    assert all(pair.frames % 4 == 0 for pair in pairs)
    spare = [pair.frames for pair in pairs if pair.text != "slowly"]
    assert len(set(spare)) > 8
    assert pairs[0].segments == (pairs[0].text,)
    assert len(published_pairs(data, "test", clips=32, seed=0)) == 32


def test_names_of_the_weights_are_the_published_ones() -> None:
    gru = {
        f"gru.{kind}_l0{way}" for kind in ("weight_ih", "weight_hh", "bias_ih", "bias_hh") for way in ("", "_reverse")
    }

    def both(*layers: str) -> set[str]:
        return {f"{layer}.{part}" for layer in layers for part in ("weight", "bias")}

    sequence = {"hidden"} | gru | both("input_emb", "output_net.0", "output_net.1", "output_net.3")
    assert set(MovementEncoder().state_dict()) == both("main.0", "main.3", "out_net")
    assert set(SequenceEncoder(512, 1024).state_dict()) == sequence
    text = TextEncoder().state_dict()
    assert set(text) == sequence | both("pos_emb")
    assert text["pos_emb.weight"].shape == (300, 15)
    assert text["hidden"].shape == (2, 1, 512)


def test_a_caption_is_read_with_its_marks_and_parts_of_speech(folder: Path) -> None:
    words = PublishedWords(folder / "glove")
    table = np.load(folder / "glove" / "our_vab_data.npy").astype(np.float32)
    vectors, tags = words([("a", "DET"), ("walk", "VERB"), ("zorbs", "VERB")])
    rows = [WORDS.index(word) for word in ("sos", "a", "walk", "unk", "eos")]
    assert np.array_equal(vectors.numpy(), table[rows])
    assert [TAGS[i] for i in tags.argmax(1)] == ["OTHER", "DET", "Act_VIP", "OTHER", "OTHER"]
    assert len(words([("a", "DET")] * 30)[0]) == 22


def test_embeddings_do_not_depend_on_the_batch(embedder: OfficialEmbedder) -> None:
    rng = np.random.default_rng(0)
    motions = [rng.normal(size=(frames, 263)).astype(np.float32) for frames in (40, 196, 80)]
    together = embedder.motions(motions)
    assert together.shape == (3, 512)
    assert np.allclose(embedder.motions(motions[2:]), together[2:], atol=1e-4)
    captions = (("a", "DET"), ("person", "NOUN")), (("walk", "VERB"),)
    pairs = [Pair(motions[0], "", ("",), tokens) for tokens in captions]
    texts = embedder.texts(pairs)
    assert np.allclose(embedder.texts(pairs[1:]), texts[1:], atol=1e-4)
    assert not np.allclose(texts[0], texts[1], atol=1e-3)


def test_a_missing_part_is_named_with_the_places_looked_in(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match=r"lacks the data set; looked for .*dataset/HumanML3D/new_joint_vecs"):
        OfficialFiles.find(tmp_path)
    for name in ("HumanML3D", "glove"):
        (tmp_path / name).symlink_to(folder / name)
    with pytest.raises(InvalidFile, match=r"lacks the evaluator's networks; .*t2m/text_mot_match/model/finest.tar"):
        OfficialFiles.find(tmp_path)


class _Attack:
    def __reduce__(self):
        return print, ("code of the file was run",)


def test_pickles_that_would_run_code_are_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("our_vab_data.npy", "our_vab_idx.pkl"):
        (tmp_path / name).symlink_to(folder / "glove" / name)
    (tmp_path / "our_vab_words.pkl").write_bytes(pickle.dumps(_Attack()))
    with pytest.raises(InvalidFile, match="plain data is expected"):
        PublishedWords(tmp_path)
    files = OfficialFiles.find(folder)
    attack = tmp_path / "finest.tar"
    torch.save({"movement_encoder": _Attack()}, attack)
    with pytest.raises(InvalidFile, match="not a readable checkpoint"):
        OfficialEmbedder(OfficialFiles(files.dataset, files.words, attack, files.statistics))
    assert "code of the file" not in capsys.readouterr().out


def test_networks_of_another_size_are_named(folder: Path, tmp_path: Path) -> None:
    files, other = OfficialFiles.find(folder), tmp_path / "finest.tar"
    torch.save({"movement_encoder": MovementEncoder(8).state_dict()}, other)
    with pytest.raises(InvalidFile, match="movement_encoder does not fit the published sizes"):
        OfficialEmbedder(OfficialFiles(files.dataset, files.words, other, files.statistics))
    torch.save({"epoch": 1}, other)
    with pytest.raises(InvalidFile, match="has no movement_encoder; found epoch"):
        OfficialEmbedder(OfficialFiles(files.dataset, files.words, other, files.statistics))
