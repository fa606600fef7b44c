"""What a pickle asks for, noted down, and made afterwards from what was checked."""

import io
import re
from math import prod
from typing import Any, Final, cast

import numpy as np

PLAIN: Final = re.compile(r"[<>|=]?(?:[biufc]\d{1,2}|[SU]\d{1,6}|\?)")
"""Types of which bytes make numbers or text, whatever the bytes are."""
OBJECT: Final = re.compile(r"[<>|=]?O8?")
MOST_DIMENSIONS: Final = 8
MOST_ITEMS: Final = 20_000_000
"""Items of all containers together, those that are named several times counted each time."""
DEEPEST: Final = 100


class BadNote(ValueError):
    """A pickle asks for something that makes no sense."""


class Note:
    """Something that a pickle asks for; `state` is what it says of it later."""

    def __init__(self, *arguments: Any) -> None:
        self.arguments: tuple[Any, ...] = arguments
        self.state: Any = None

    @property
    def said(self) -> tuple[Any, ...]:
        """The state where it is a tuple, else nothing."""
        state: object = self.state
        return cast(tuple[Any, ...], state) if isinstance(state, tuple) else ()

    def made(self) -> Any:
        """What was asked for."""
        raise BadNote("holds a type where data should be")


class DTypeNote(Note):
    """An array's element type: its code, and in its state the order of bytes."""

    @property
    def code(self) -> str:
        """The code, such as `f8`."""
        code = self.arguments[0] if self.arguments else None
        code = code.decode("latin1") if isinstance(code, bytes) else code
        if not isinstance(code, str):
            raise BadNote("names an array type by something that is no text")
        return code

    def dtype(self) -> np.dtype[Any]:
        """The numpy type; BadNote unless it is one of numbers or text."""
        if not PLAIN.fullmatch(self.code):
            raise BadNote(f"holds an array of {self.code!r}, expected numbers or text")
        try:
            found = np.dtype(self.code)
        except TypeError:
            raise BadNote(f"holds an array of {self.code!r}, which is no type") from None
        order = self.said[1] if len(self.said) > 1 else "="
        if order not in ("<", ">", "|", "="):
            raise BadNote(f"holds an array in byte order {order!r}")
        return found if order == "=" else found.newbyteorder(order)


class ArrayNote(Note):
    """An array: shape, type, order and bytes come as its state."""

    @classmethod
    def begun(cls, *arguments: Any) -> "ArrayNote":
        """What `numpy._core.multiarray._reconstruct` begins."""
        return cls(*arguments)

    @classmethod
    def of_buffer(cls, data: Any, dtype: Any, shape: Any, order: Any) -> "ArrayNote":
        """What `numpy._core.numeric._frombuffer` makes."""
        note = cls()
        note.state = (1, shape, dtype, order == "F", data)
        return note

    def made(self) -> Any:
        if len(self.said) not in (4, 5):
            raise BadNote("holds an array without its data")
        shape, dtype, fortran, data = self.said[-4:]
        if isinstance(dtype, DTypeNote) and OBJECT.fullmatch(dtype.code):
            return _of_objects(checked_shape(shape), data)
        return array_of(shape, dtype, fortran=bool(fortran), data=data)


class ScalarNote(Note):
    """A number or a text of numpy: its type and its bytes."""

    def made(self) -> Any:
        if len(self.arguments) != 2:
            raise BadNote("holds a number without its bytes")
        return array_of((), self.arguments[0], fortran=False, data=self.arguments[1])[()]


class JoblibNote(Note):
    """Joblib's wrapper: the array's bytes lie in the stream behind its state."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.data = b""

    def read(self, stream: io.BytesIO) -> None:
        """Take the bytes as soon as the state is known."""
        state = self.state
        if not isinstance(state, dict):
            raise BadNote("holds a wrapped array without its state")
        state = cast(dict[str, Any], state)
        if state.get("numpy_array_alignment_bytes") is not None:
            stream.read(stream.read(1)[0])
        self.data = stream.read(prod(checked_shape(state.get("shape"))) * dtype_of(state.get("dtype")).itemsize)

    def made(self) -> Any:
        state = cast(dict[str, Any], self.state or {})
        return array_of(state.get("shape"), state.get("dtype"), fortran=state.get("order") == "F", data=self.data)


def dtype_of(note: Any) -> np.dtype[Any]:
    """The numpy type of a note of one."""
    if not isinstance(note, DTypeNote):
        raise BadNote("holds an array without a type")
    return note.dtype()


def checked_shape(shape: Any) -> tuple[int, ...]:
    """A shape whose sizes are whole numbers that can be multiplied."""
    sizes = cast(tuple[Any, ...], shape)
    if not isinstance(shape, tuple) or len(sizes) > MOST_DIMENSIONS:
        raise BadNote("holds an array without a proper shape")
    if not all(type(size) is int and 0 <= size < 1 << 40 for size in sizes):
        raise BadNote("holds an array whose shape is no whole numbers")
    return cast(tuple[int, ...], sizes)


def array_of(shape: Any, dtype: Any, *, fortran: bool, data: Any) -> np.ndarray[Any, Any]:
    """An array of its own memory; BadNote unless there are just as many bytes as it needs."""
    sizes, kind = checked_shape(shape), dtype_of(dtype)
    content = data.encode("latin1") if isinstance(data, str) else data
    content = bytes(content) if isinstance(content, bytearray) else content
    wanted = prod(sizes) * kind.itemsize
    if not isinstance(content, bytes) or len(content) != wanted:
        found = len(content) if isinstance(content, bytes) else "no"
        raise BadNote(f"holds an array of {wanted} bytes with {found} bytes in it")
    if not wanted:
        return np.zeros(sizes, kind)
    return np.frombuffer(content, kind).reshape(sizes, order="F" if fortran else "C").copy(order="K")


def _of_objects(shape: tuple[int, ...], data: Any) -> object:
    """The items of an array of objects of at most one dimension, as they are."""
    items = cast(list[Any], data) if isinstance(data, list) else None
    if len(shape) > 1 or items is None or len(items) != prod(shape):
        raise BadNote("holds an array of objects, expected numbers or text")
    return items[0] if shape == () else items


def plain(value: Any) -> object:
    """A value with everything made that is noted down in it; tuples as lists.

    Raises:
        BadNote: something cannot be made, lies too deep, or comes to too many items.
    """
    return _Making().of(value, 0)[0]


class _Making:
    """Makes values, each once, and counts what they come to where they are named again."""

    def __init__(self) -> None:
        self._done: dict[int, tuple[Any, int]] = {}
        self._kept: list[Any] = []

    def of(self, value: Any, depth: int) -> tuple[Any, int]:
        """What becomes of a value, and how many items it has with all that is in it."""
        if isinstance(value, Note | dict | list | tuple | set | frozenset):
            if id(cast(object, value)) in self._done:
                return self._done[id(cast(object, value))]
            if depth > DEEPEST:
                raise BadNote(f"is nested deeper than {DEEPEST}")
            made = self._made(value, depth)
            if made[1] > MOST_ITEMS:
                raise BadNote(f"comes to more than {MOST_ITEMS} items")
            self._kept.append(value)  # an id means nothing once its owner is gone
            self._done[id(cast(object, value))] = made
            return made
        if callable(value):
            raise BadNote("holds a function or a type where data should be")
        return value, 1

    def _made(self, value: Any, depth: int) -> tuple[Any, int]:
        if isinstance(value, Note):
            made = value.made()
            return self.of(made, depth + 1) if isinstance(made, Note | dict | list | tuple) else (made, 1)
        if isinstance(value, dict):
            items = cast(dict[Any, Any], value).items()
            pairs = [(self.of(key, depth + 1), self.of(item, depth + 1)) for key, item in items]
            count = 1 + sum(key[1] + item[1] for key, item in pairs)
            return {key[0]: item[0] for key, item in pairs}, count
        found = [self.of(item, depth + 1) for item in cast(list[Any], value)]
        items = [item for item, _ in found]
        made = type(cast(set[Any], value))(items) if isinstance(value, set | frozenset) else items
        return made, 1 + sum(count for _, count in found)
