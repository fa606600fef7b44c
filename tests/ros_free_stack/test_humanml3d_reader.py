from pathlib import Path

import numpy as np
import pytest

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.formats.features import decode, encode
from ros_free_stack.formats.humanml3d import PublishedDataset, TaggedCaption, open_humanml3d

CAPTIONS = """a person waves.#a/DET person/NOUN wave/VERB#0.0#0.0
a man steps left#a/DET man/NOUN step/VERB left/ADV#1.5#3.0
he stops#he/PRON stop/VERB#nan#nan
"""


@pytest.fixture
def dataset(tmp_path: Path) -> PublishedDataset:
    for folder in ("new_joint_vecs", "new_joints", "texts"):
        (tmp_path / folder).mkdir()
    rng = np.random.default_rng(0)
    joints = np.cumsum(0.01 * rng.normal(size=(21, 22, 3)), axis=0) + rng.normal(size=(22, 3))
    features = encode(joints)
    np.save(tmp_path / "new_joint_vecs/000001.npy", features.astype(np.float32))
    np.save(tmp_path / "new_joints/000001.npy", decode(features)[..., [1, 2, 0]].astype(np.float32))
    (tmp_path / "texts/000001.txt").write_text(CAPTIONS, encoding="utf-8")
    (tmp_path / "train.txt").write_text("000001\nM000001\n", encoding="utf-8")
    np.save(tmp_path / "Mean.npy", np.zeros(263))
    np.save(tmp_path / "Std.npy", np.ones(263))
    return open_humanml3d(tmp_path)


def test_splits(dataset: PublishedDataset) -> None:
    assert dataset.split("train") == ("000001", "M000001")
    with pytest.raises(UnknownName, match="valid: test, train, val"):
        dataset.split("dev")
    with pytest.raises(InvalidFile, match=r"val\.txt: cannot be read"):
        dataset.split("val")


def test_captions(dataset: PublishedDataset) -> None:
    whole, part, odd = dataset.captions("000001")
    tokens = (("a", "DET"), ("person", "NOUN"), ("wave", "VERB"))
    assert whole == TaggedCaption("a person waves.", tokens, 0.0, None)
    assert (part.start_s, part.end_s) == (1.5, 3.0)
    assert (odd.start_s, odd.end_s) == (0.0, None)


def test_joints_are_those_of_the_features(dataset: PublishedDataset) -> None:
    np.testing.assert_allclose(dataset.joints("000001"), decode(dataset.features("000001")), atol=1e-5)


def test_statistics(dataset: PublishedDataset) -> None:
    mean, std = dataset.statistics()
    assert mean.shape == std.shape == (263,)
    assert std.all()


@pytest.mark.parametrize("line", ["a person waves", "a#a/DET#x#1.0", "a#a/DET#3.0#1.0", "a#b#c#0#0"])
def test_a_bad_caption_names_its_line(dataset: PublishedDataset, line: str) -> None:
    path = dataset.folder / "texts/000001.txt"
    path.write_text(f"a person waves.#a/DET#0.0#0.0\n{line}\n", encoding="utf-8")
    with pytest.raises(InvalidFile, match=r"000001\.txt: line 2"):
        dataset.captions("000001")


def test_broken_arrays_are_refused(dataset: PublishedDataset) -> None:
    path = dataset.folder / "new_joint_vecs/000001.npy"
    np.save(path, np.zeros((5, 251)))
    with pytest.raises(InvalidFile, match=r"expected floats of shape \(T, 263\)"):
        dataset.features("000001")
    values = np.zeros((5, 263))
    values[3, 0] = np.nan
    np.save(path, values)
    with pytest.raises(InvalidFile, match="row 3"):
        dataset.features("000001")
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(InvalidFile, match=r"not a readable \.npy"):
        dataset.features("000001")
    with pytest.raises(InvalidFile, match="no such file"):
        dataset.features("000002")


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match="new_joint_vecs: missing"):
        open_humanml3d(tmp_path)
