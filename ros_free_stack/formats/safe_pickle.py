"""Pickles of plain data, read without running anything that they name.

A pickle is a program: the usual reader calls whatever function it names, and lets it set the state of what it made.
Here every name that is known stands for an inert note of what was asked for; arrays are made afterwards, from bytes,
shape and type that were checked. The interpreter is Python's own in Python, whose reads cannot claim more memory than
the file has. What joblib writes (PHC and its descendants) is read too: zlib-compressed files, and arrays whose bytes
lie in the stream after a `NumpyArrayWrapper`.
"""

import io
import pickle
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Final, cast

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.pickle_notes import ArrayNote, BadNote, DTypeNote, JoblibNote, Note, ScalarNote, plain

LARGEST: Final = 1 << 30
"""Bytes of a pickle, and of what a compressed one unpacks to."""
PACKED: Final = (64 << 20, 100)
"""A compressed pickle may unpack to so many bytes, or to so many times its size."""


class UnsafePickle(InvalidFile):
    """A pickle names something that is not plain data."""


def read_pickle(path: Path, *, skip: int = 0) -> object:
    """What a pickle of plain data holds: dictionaries, lists, tuples, numpy arrays, numbers, text, None.

    Args:
        path: the file.
        skip: bytes before the pickle, such as the header of a `.npy`.

    Raises:
        UnsafePickle: it names anything else; nothing of it was run.
        InvalidFile: it is missing, truncated, too large or no pickle at all.
    """
    try:
        if (size := path.stat().st_size) > LARGEST:
            raise InvalidFile(path, f"has {size} bytes, at most {LARGEST} are read")
        stream = io.BytesIO(_unpacked(path, path.read_bytes()[skip:]))
        return plain(_Unpickler(path, stream).load())
    except InvalidFile:
        raise
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except MemoryError:
        raise InvalidFile(path, "claims arrays larger than memory") from None
    except BadNote as error:
        raise InvalidFile(path, f"not a readable pickle ({_printable(str(error))})") from None
    except Exception as error:  # a damaged pickle can raise anything
        told = _printable(f"{type(error).__name__}: {error}")
        raise InvalidFile(path, f"not a readable pickle (truncated? {told})") from None


def _unpacked(path: Path, data: bytes) -> bytes:
    """The pickle itself, of a file that may be compressed."""
    if data[:1] != b"\x78":  # zlib's first byte; no pickle starts so
        return data
    most = min(LARGEST, max(PACKED[0], PACKED[1] * len(data)))
    unpacker = zlib.decompressobj()
    found = unpacker.decompress(data, most)
    if unpacker.unconsumed_tail:
        raise InvalidFile(path, f"unpacks to more than {most} bytes, which is more than it is read for")
    if not unpacker.eof:
        raise InvalidFile(path, "not a readable pickle (truncated: its compressed data end early)")
    return found


class _Unpickler(pickle._Unpickler):  # pyright: ignore[reportPrivateUsage, reportUntypedBaseClass, reportAttributeAccessIssue]
    dispatch: ClassVar[dict[int, Callable[..., None]]] = dict(pickle._Unpickler.dispatch)  # pyright: ignore

    def __init__(self, path: Path, stream: io.BytesIO) -> None:
        super().__init__(stream, encoding="latin1")
        self._path, self._stream = path, stream
        self._known: dict[tuple[str, str], Any] = {
            ("numpy", "ndarray"): Note,
            ("numpy", "dtype"): DTypeNote,
            ("collections", "OrderedDict"): dict,
            ("_codecs", "encode"): _latin1,
            ("joblib.numpy_pickle", "NumpyArrayWrapper"): JoblibNote,
        }
        for core in ("numpy._core", "numpy.core"):
            self._known[f"{core}.multiarray", "_reconstruct"] = ArrayNote.begun
            self._known[f"{core}.multiarray", "scalar"] = ScalarNote
            self._known[f"{core}.numeric", "_frombuffer"] = ArrayNote.of_buffer
        for module in ("builtins", "__builtin__"):
            self._known |= {(module, kind.__name__): kind for kind in (complex, set, frozenset)}
            self._known[module, "bytes"] = _no_bytes

    def find_class(self, module: str, name: str) -> Any:
        try:
            return self._known[module, name]
        except KeyError:
            name = _printable(f"{module}.{name}")
            problem = f"names {name}, which is no plain data; refused (valid: numpy arrays, numbers, text, containers)"
            raise UnsafePickle(self._path, problem) from None

    def persistent_load(self, pid: Any) -> Any:
        raise UnsafePickle(self._path, "refers to something outside of the file; refused")

    def load_build(self) -> None:
        """The state of a note; nothing else has one that a file may set."""
        stack = cast(list[Any], self.stack)  # pyright: ignore
        state = stack.pop()
        note: object = stack[-1]
        if not isinstance(note, Note):
            raise BadNote(f"sets the state of a {type(note).__name__}")
        note.state = state
        if isinstance(note, JoblibNote):
            note.read(self._stream)

    dispatch[pickle.BUILD[0]] = load_build


def _printable(text: str) -> str:
    """Words of a file on one line that is not too long."""
    return "".join(letter if letter.isprintable() else "?" for letter in text[:200])


def _latin1(text: str, encoding: str) -> bytes:
    """How pickles of protocol 2 and less hold bytes."""
    if encoding != "latin1":
        raise BadNote(f"bytes in {encoding}")
    return text.encode("latin1")


def _no_bytes() -> bytes:
    """How pickles of protocol 2 and less hold empty bytes."""
    return b""
