"""Stages of a pipeline, made once, in the background where somebody says early that they will be needed."""

from collections.abc import Callable
from concurrent.futures import Future
from threading import Lock, Thread
from typing import Any, TypeVar

Stage = TypeVar("Stage")


class Stages:
    """What was made, by name.

    Imports and models load side by side: much of that is reading files and linking libraries, which needs no Python.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._made: dict[str, Future[Any]] = {}

    def begin(self, name: str, make: Callable[[], object]) -> None:
        """Make a stage in the background, unless it is there or on its way."""
        future, claimed = self._claimed(name)
        if claimed:
            Thread(target=self._fulfil, args=(name, future, make), name=f"loading {name}").start()

    def get(self, name: str, make: Callable[[], Stage]) -> Stage:
        """The stage, made here and now if nobody has begun to; what making it raises is raised here."""
        future, claimed = self._claimed(name)
        if claimed:
            self._fulfil(name, future, make)
        return future.result()

    def _claimed(self, name: str) -> "tuple[Future[Any], bool]":
        """The stage's future, and whether it is the caller who has to fulfil it."""
        with self._lock:
            claimed = name not in self._made
            return self._made.setdefault(name, Future()), claimed

    def _fulfil(self, name: str, future: "Future[Any]", make: Callable[[], object]) -> None:
        try:
            future.set_result(make())
        except BaseException as error:
            with self._lock:  # the next one who asks may try again
                del self._made[name]
            future.set_exception(error)
