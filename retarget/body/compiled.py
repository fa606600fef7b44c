"""CasADi functions as machine code: generated C, compiled once, cached by content; CasADi's VM where that fails."""

import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import platformdirs

from ros_free_stack.console import say

FLAGS = ("-O1", "-fPIC", "-shared")


class BufferedFunction:
    """A CasADi function called on fixed memory: write into `inputs`, call, read from `outputs`.

    `inputs` and `outputs` hold one Fortran-ordered (rows, columns) array a name. A call allocates nothing.
    """

    def __init__(self, function: ca.Function) -> None:
        self._buffer, self._evaluate = function.buffer()
        self.inputs: dict[str, np.ndarray] = {}
        self.outputs: dict[str, np.ndarray] = {}
        for i, name in enumerate(function.name_in()):
            memory = np.zeros(function.numel_in(i))
            self._buffer.set_arg(i, memory.data)
            self.inputs[name] = memory.reshape(function.size_in(i), order="F")
        for i, name in enumerate(function.name_out()):
            memory = np.zeros(function.numel_out(i))
            self._buffer.set_res(i, memory.data)
            self.outputs[name] = memory.reshape(function.size_out(i), order="F")

    def read_from(self, name: str, memory: np.ndarray) -> None:
        """Take an input from `memory`, C-ordered (columns, rows), from now on."""
        self._buffer.set_arg(list(self.inputs).index(name), memory.reshape(-1).data)
        self.inputs[name] = memory.T

    def write_to(self, name: str, memory: np.ndarray) -> None:
        """Write an output into `memory`, C-ordered (columns, rows), from now on."""
        self._buffer.set_res(list(self.outputs).index(name), memory.reshape(-1).data)
        self.outputs[name] = memory.T

    def __call__(self) -> dict[str, np.ndarray]:
        self._evaluate()
        return self.outputs


def compiled(function: ca.Function, folder: Path | None = None) -> ca.Function:
    """The function as machine code, or itself where no C compiler works. Same results, several times faster.

    Args:
        function: an SX function.
        folder: of compiled functions, the user's cache folder by default; the key is the hash of the C text,
            the flags, the compiler's version and the machine, so nothing in it goes stale. Processes may share it:
            a library is compiled under a temporary name and renamed.
    """
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None:
        _warn("no C compiler is found")
        return function
    generator = ca.CodeGenerator(function.name() + ".c")
    generator.add(function)
    text = generator.dump()
    try:
        folder = folder or platformdirs.user_cache_path("ros-free-stack") / "compiled"
        library = folder / f"{function.name()}-{_key(text, compiler)}.so"
        if not library.is_file():
            folder.mkdir(parents=True, exist_ok=True)
            _compile(compiler, text, library)
        return _load(function, library)
    except (OSError, subprocess.SubprocessError, RuntimeError) as error:
        _warn(_reason(error))
        return function


@cache
def _warn(reason: str) -> None:
    """One line, once a process."""
    say(f"retargeting is several times slower, its code was not compiled: {reason}")


def _reason(error: Exception) -> str:
    if isinstance(error, subprocess.CalledProcessError):
        lines = error.stderr.decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"the compiler ended with {error.returncode}"
    return (error.strerror if isinstance(error, OSError) else None) or str(error).splitlines()[0]


def _key(text: str, compiler: str) -> str:
    parts = (text.encode(), " ".join(FLAGS).encode(), _version(compiler), platform.platform().encode())
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:24]


@cache
def _version(compiler: str) -> bytes:
    return subprocess.run([compiler, "--version"], capture_output=True, check=True).stdout


def _compile(compiler: str, text: str, library: Path) -> None:
    with tempfile.TemporaryDirectory(dir=library.parent, prefix=".compile-") as name:
        source, output = Path(name) / "function.c", Path(name) / "function.so"
        source.write_text(text, encoding="utf-8")
        subprocess.run([compiler, *FLAGS, source, "-o", output, "-lm"], check=True, capture_output=True)
        output.replace(library)


def _load(function: ca.Function, library: Path) -> ca.Function:
    try:
        return ca.external(function.name(), str(library))
    except RuntimeError:
        # A library that does not load (a damaged cache) must not stay: the next process compiles it anew.
        library.unlink(missing_ok=True)
        raise
