import base64
import os
import pickle
import subprocess
import zlib
from collections import OrderedDict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.safe_pickle import UnsafePickle, read_pickle


class Calls:
    """Pickles as a call of a function."""

    def __init__(self, function, *arguments) -> None:
        self.call = (function, arguments)

    def __reduce__(self):
        return self.call


def same(first: object, second: object) -> None:
    np.testing.assert_equal(first, second)


plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text()
    | st.binary()
    | arrays.arrays(
        arrays.floating_dtypes() | arrays.integer_dtypes() | arrays.boolean_dtypes(),
        arrays.array_shapes(min_dims=0, min_side=0, max_side=4),
    ),
    lambda items: st.lists(items, max_size=4) | st.dictionaries(st.text(max_size=5), items, max_size=4),
    max_leaves=8,
)


@given(plain, st.integers(0, 5))
def test_plain_data_of_every_protocol(tmp_path_factory: pytest.TempPathFactory, data: object, protocol: int) -> None:
    path = tmp_path_factory.mktemp("pickle") / "a.pkl"
    path.write_bytes(pickle.dumps(data, protocol=protocol))
    same(read_pickle(path), data)


def test_scalars_ordered_dictionaries_and_fortran_order(tmp_path: Path) -> None:
    data = OrderedDict(fps=np.float32(30), name=np.str_("a"), grid=np.asfortranarray(np.arange(6.0).reshape(2, 3)))
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(data))
    same(read_pickle(tmp_path / "a.pkl"), dict(data))


@pytest.mark.parametrize("protocol", [0, 2, 4])
def test_nothing_that_a_pickle_names_is_run(tmp_path: Path, protocol: int) -> None:
    mark = tmp_path / "ran"
    evil = {
        "posix.system": Calls(os.system, f"touch {mark}"),
        "builtins.eval": Calls(eval, f"open({str(mark)!r}, 'w')"),
        "subprocess.run": Calls(subprocess.run, ["touch", str(mark)]),
        "_io.open": Calls(open, str(mark), "w"),
        "numpy.load": Calls(np.load, str(mark)),
        "builtins.getattr": Calls(getattr, "a", "upper"),
    }
    for name, call in evil.items():
        path = tmp_path / "evil.pkl"
        path.write_bytes(pickle.dumps({"fps": 30, "root_pos": [call]}, protocol=protocol))
        with pytest.raises(UnsafePickle, match=r"names .*, which is no plain data; refused") as error:
            read_pickle(path)
        assert name.rpartition(".")[2] in str(error.value)
        assert not mark.exists()
    path.write_bytes(pickle.dumps(evil["posix.system"], protocol=protocol))
    pickle.loads(path.read_bytes())
    assert mark.exists()  # the usual reader does run them


def test_a_call_hidden_in_an_array_is_refused_too(tmp_path: Path) -> None:
    mark = tmp_path / "ran"
    hidden = np.array([Calls(os.system, f"touch {mark}")], dtype=object)
    (tmp_path / "a.pkl").write_bytes(zlib.compress(pickle.dumps({"dof": hidden})))
    with pytest.raises(UnsafePickle):
        read_pickle(tmp_path / "a.pkl")
    assert not mark.exists()


def test_a_class_of_torch_is_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "a.pkl").write_bytes(b"ctorch._utils\n_rebuild_tensor_v2\n.")
    with pytest.raises(UnsafePickle, match=r"names torch\._utils\._rebuild_tensor_v2"):
        read_pickle(tmp_path / "a.pkl")


def test_persistent_objects_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.pkl").write_bytes(b"Psomewhere\n.")
    with pytest.raises(UnsafePickle, match="outside of the file"):
        read_pickle(tmp_path / "a.pkl")


# joblib.dump(JOBLIB_CLIPS, file, compress=True) of joblib 1.6
JOBLIB_FILE = (
    "eF59UctKw0AU7Ttt8dFSUVRwXRcWFy5cCEYEEQMR3LiSMGmnndhJMmQSShaFurBWmJ03X+nGP9BJOq1awbuYc4a5j3PuTErJe24eYxCV46MRok"
    "MYQ1tozOfYQghE69G3qWN3vMhlscWc7pBiEE0zvV4EAYrvA8QYDuANDp+y2iqP7C5FnIMoZ1UgNK+H0lyZJMqcIIbBKBjFqbz5QU8Wi/yl5L0w"
    "li+kvmAyu9A/hdfZC9xB2yiK/BmYpnnzKSM7jFwItqgjSv2R5bqIwUzsz5Vm8yxEnYHnYi+07DjEHIxGZNfSyiyUdwUf54roc6wqbCjc0pNblS"
    "GKPb8PpDJ3TGpkjaxLQ4UpkE2RvwLSJC0p/eRbOtn5K5zszsheqkj7rUfOm0gtup5cL+f1mRR/ICoD7GX70jwchQGicmvYZWG8KiaXbpdskoaU"
    "sr0ctLG0npHEXPQvUYeH8LDapfi86CHtOD9+4l871dX95tWYgsKkpAiKeOcLu0vpZg=="
)
JOBLIB_CLIPS = {
    "0-walk": {
        "pose_aa": np.arange(6.0).reshape(2, 3),
        "dof": np.asfortranarray(np.arange(4, dtype="f4").reshape(2, 2)),
        "fps": 30,
        "gender": "neutral",
        "empty": np.zeros((0, 3)),
        "list": [np.arange(3)],
    }
}


@pytest.mark.parametrize("compressed", [False, True])
def test_what_joblib_writes(tmp_path: Path, compressed: bool) -> None:
    packed = base64.b64decode(JOBLIB_FILE)
    whole = packed if compressed else zlib.decompress(packed)
    path = tmp_path / "a.pkl"
    path.write_bytes(whole)
    same(read_pickle(path), JOBLIB_CLIPS)
    for length in range(1, len(whole), 7):
        path.write_bytes(whole[:length])
        with pytest.raises(InvalidFile, match="not a readable pickle"):
            read_pickle(path)


@given(st.binary(max_size=300))
def test_garbage_is_one_clear_error(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.mktemp("pickle") / "a.pkl"
    path.write_bytes(b"\x80\x04" + data[:-1] + b"\xff")
    with pytest.raises(InvalidFile):
        read_pickle(path)


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match="cannot be read"):
        read_pickle(tmp_path / "none.pkl")


# An allowed type is given fields of objects by its state, and then bytes of the file are read as pointers.
TYPE_CONFUSION = (
    "gAN9KFgDAAAAZnBzSx5YCAAAAHJvb3Rfcm90WAEAAAB4WAcAAABkb2ZfcG9zWAEAAAB4WAgAAAByb290X3Bvc2NudW1weS5jb3JlLm51bWVyaWMK"
    "X2Zyb21idWZmZXIKKEMIQUFBQUFBQUFjbnVtcHkKZHR5cGUKWAIAAABWOIVSKEsDWAEAAAB8TlgBAAAAYYV9WAEAAABhY251bXB5CmR0eXBlClgB"
    "AAAAT4VSSwCGc0sISwFLAHRiSwGFVQFDdFJ1Lg=="
)
# The state of an array says that its bytes are objects.
OBJECTS_BY_STATE = (
    "gAJjbnVtcHkuY29yZS5tdWx0aWFycmF5Cl9yZWNvbnN0cnVjdApjbnVtcHkKbmRhcnJheQpLAIVVAWKHUihLAUoAAAAQhWNudW1weQpkdHlwZQpY"
    "AgAAAE84SwBLAYdSiV10Yi4="
)


@pytest.mark.parametrize("packed", [TYPE_CONFUSION, OBJECTS_BY_STATE])
def test_bytes_of_a_file_never_become_pointers(tmp_path: Path, packed: str) -> None:
    (tmp_path / "a.pkl").write_bytes(base64.b64decode(packed))
    with pytest.raises(InvalidFile, match="holds an array of"):
        read_pickle(tmp_path / "a.pkl")


def laughs() -> object:
    items: list[object] = ["ha"]
    for _ in range(60):
        items = [items, items]
    return items


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"\x80\x04B\xff\xff\xff\xff.", "truncated"),
        (b"\x80\x04\x8e" + (1 << 40).to_bytes(8, "little") + b".", "truncated"),
        (b"\x80\x04Nr\xff\xff\xff\x7f0.", "truncated|readable"),
        (b"\x80\x04cnumpy\nndarray\n(K\x05t}b.", "not a readable pickle"),
        (b"\x80\x04]}b.", "sets the state of a list"),
        (b"\x80\x04cnumpy\nndarray\n}b.", "sets the state of a type"),
        (b"\x80\x04cbuiltins\nset\n.", "holds a function or a type"),
        (pickle.dumps(np.zeros(2, dtype=[("a", "f8")])), "expected numbers or text"),
        (pickle.dumps(np.array(["2020-01-01"], dtype="M8[D]")), "expected numbers or text"),
        (pickle.dumps(laughs()), "comes to more than"),
        (zlib.compress(bytes(70 << 20)), "unpacks to more than"),
    ],
)
def test_what_would_take_too_much_or_makes_no_sense_is_refused(tmp_path: Path, data: bytes, words: str) -> None:
    (tmp_path / "a.pkl").write_bytes(data)
    with pytest.raises(InvalidFile, match=words):
        read_pickle(tmp_path / "a.pkl")


def test_nesting_has_an_end(tmp_path: Path) -> None:
    (tmp_path / "a.pkl").write_bytes(b"\x80\x04" + b"]" * 5000 + b"a" * 4999 + b".")
    with pytest.raises(InvalidFile, match="nested deeper than"):
        read_pickle(tmp_path / "a.pkl")


def test_changed_bytes_end_in_data_or_in_one_clear_error(tmp_path: Path) -> None:
    """A thousand pickles with some bytes changed; a crash would end the whole test run."""
    rng = np.random.default_rng(0)
    clip = {"fps": np.float32(30), "root": np.arange(6.0).reshape(2, 3), "names": ["a", "b"], "more": (1, None, b"x")}
    for number in range(1000):
        data = bytearray(pickle.dumps(clip, protocol=number % 6))
        for place in rng.integers(0, len(data), rng.integers(1, 5)):
            data[place] = rng.integers(0, 256)
        (tmp_path / "a.pkl").write_bytes(bytes(data))
        try:
            read_pickle(tmp_path / "a.pkl")
        except InvalidFile as error:
            assert "\n" not in str(error)
