"""OpenGL without a display: EGL or OSMesa, whichever works."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes.util import find_library
from typing import Any

from ros_free_stack.console import say
from ros_free_stack.errors import MissingDependency

_LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}


@contextmanager
def gl_context(width: int, height: int) -> Iterator[None]:
    """A current OpenGL context of a size in pixels; one line on stderr says which library and driver draw.

    The library is the one that MUJOCO_GL names, else EGL, else OSMesa; one without a working driver is passed over.

    Raises:
        MissingDependency: none is installed, or none works.
    """
    backend, context = _open(width, height)
    try:
        from OpenGL.GL import GL_RENDERER, glGetString

        driver = bytes(glGetString(GL_RENDERER) or b"an unnamed driver").decode(errors="replace")
        say(f"drawing with {backend.upper()} on {driver.partition(' (')[0]}")
        yield
    finally:
        context.free()


def _open(width: int, height: int) -> tuple[str, Any]:
    found = [backend for backend in _wanted() if find_library(_LIBRARIES[backend])]
    if not found:
        raise MissingDependency(
            "an OpenGL library for drawing without a display",
            "install libegl1 or libosmesa6 (apt-get install libegl1); only the video needs it",
        )
    problems: list[str] = []
    for backend in found:
        try:
            return backend, _context(backend, width, height)
        except (ImportError, AttributeError, RuntimeError, OSError) as error:
            problems.append(f"{backend.upper()}: {' '.join(str(error).split())}")
            _forget_opengl()
    raise MissingDependency("a working OpenGL driver", "; ".join(problems))


def _wanted() -> list[str]:
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    return [chosen] if chosen in _LIBRARIES else list(_LIBRARIES)


def _context(backend: str, width: int, height: int) -> Any:
    os.environ["PYOPENGL_PLATFORM"] = backend
    if backend == "egl":
        from mujoco.egl import GLContext
    else:
        from mujoco.osmesa import GLContext
    context = GLContext(width, height)
    context.make_current()
    return context


def _forget_opengl() -> None:
    """PyOpenGL binds to one library when it is imported, so a second try needs a new import."""
    for name in list(sys.modules):
        if name.partition(".")[0] == "OpenGL" or name.startswith(("mujoco.egl", "mujoco.osmesa")):
            del sys.modules[name]
