"""Pickles of plain data, read without running anything that they name.

A pickle is a program: the usual reader calls whatever function it names. This one knows numpy arrays, scalars and
types, containers, numbers and text, and refuses every other name. It also reads what joblib writes (PHC and its
descendants): zlib-compressed files, and arrays whose bytes lie in the stream after a `NumpyArrayWrapper`.
"""

import io
import pickle
import zlib
from collections import OrderedDict
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from numpy._core import multiarray, numeric

from ros_free_stack.errors import InvalidFile

_JOBLIB_ARRAY: Final = ("joblib.numpy_pickle", "NumpyArrayWrapper")


class UnsafePickle(InvalidFile):
    """A pickle names something that is not plain data."""


def read_pickle(path: Path, *, skip: int = 0) -> object:
    """What a pickle of plain data holds: dictionaries, lists, tuples, numpy arrays, numbers, text, None.

    Args:
        path: the file.
        skip: bytes before the pickle, such as the header of a `.npy`.

    Raises:
        UnsafePickle: it names anything else; nothing of it was run.
        InvalidFile: it is missing, truncated or no pickle at all.
    """
    try:
        data = path.read_bytes()[skip:]
        if data[:1] == b"\x78":  # zlib's first byte; no pickle starts so
            data = zlib.decompress(data)
        stream = io.BytesIO(data)
        return _plain(_Unpickler(path, stream).load())
    except InvalidFile:
        raise
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except MemoryError:
        raise InvalidFile(path, "claims arrays larger than memory") from None
    except Exception as error:  # a damaged pickle can raise anything
        raise InvalidFile(path, f"not a readable pickle (truncated? {type(error).__name__}: {error})") from None


class _JoblibArray:
    """Stands in for joblib's wrapper; reads the array's bytes as soon as its state is known."""

    stream: io.BytesIO

    def __setstate__(self, state: dict[str, Any]) -> None:
        if state.get("numpy_array_alignment_bytes") is not None:
            self.stream.read(self.stream.read(1)[0])
        shape, dtype = tuple(int(size) for size in state["shape"]), np.dtype(state["dtype"])
        if dtype.hasobject:
            raise ValueError("an array of objects")
        count = int(np.prod(shape, dtype=np.int64))
        data = self.stream.read(count * dtype.itemsize)
        self.array = np.frombuffer(data, dtype, count).reshape(shape, order=state["order"])


class _Unpickler(pickle.Unpickler):
    def __init__(self, path: Path, stream: io.BytesIO) -> None:
        super().__init__(stream, encoding="latin1")
        self._path = path
        self._known: dict[tuple[str, str], Any] = {
            ("numpy", "ndarray"): np.ndarray,
            ("numpy", "dtype"): np.dtype,
            ("collections", "OrderedDict"): OrderedDict,
            ("_codecs", "encode"): _latin1,
            _JOBLIB_ARRAY: type("JoblibArray", (_JoblibArray,), {"stream": stream}),
        }
        for core in ("numpy._core", "numpy.core"):
            self._known[f"{core}.multiarray", "_reconstruct"] = multiarray._reconstruct  # pyright: ignore
            self._known[f"{core}.multiarray", "scalar"] = multiarray.scalar  # pyright: ignore
            self._known[f"{core}.numeric", "_frombuffer"] = numeric._frombuffer  # pyright: ignore
        for module in ("builtins", "__builtin__"):
            self._known |= {(module, kind.__name__): kind for kind in (complex, set, frozenset)}
            self._known[module, "bytes"] = _no_bytes

    def find_class(self, module_name: str, global_name: str, /) -> Any:
        try:
            return self._known[module_name, global_name]
        except KeyError:
            name = f"{module_name}.{global_name}"
            problem = f"names {name}, which is no plain data; refused (valid: numpy arrays, numbers, text, containers)"
            raise UnsafePickle(self._path, problem) from None

    def persistent_load(self, pid: Any) -> Any:
        raise UnsafePickle(self._path, "refers to something outside of the file; refused")


def _latin1(text: str, encoding: str) -> bytes:
    """How pickles of protocol 2 and less hold bytes."""
    if encoding != "latin1":
        raise ValueError(f"bytes in {encoding}")
    return text.encode("latin1")


def _no_bytes() -> bytes:
    """How pickles of protocol 2 and less hold empty bytes."""
    return b""


def _plain(value: Any) -> object:
    """Joblib's arrays in their places."""
    if isinstance(value, _JoblibArray):
        return value.array
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in cast(dict[Any, Any], value).items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in cast(list[Any], value)]
    return cast(object, value)
