import errno
import subprocess
import sys
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from retarget.body.compiled import BufferedFunction, compiled

SCRIPT = """
import sys
from pathlib import Path
import casadi as ca
from retarget.body.compiled import compiled
x = ca.SX.sym("x", 2, 3)
print(compiled(ca.Function("square", [x], [x * ca.sin(x)], ["x"], ["y"]), Path(sys.argv[1])).class_name())
"""


@pytest.fixture
def square() -> ca.Function:
    x = ca.SX.sym("x", 2, 3)
    return ca.Function("square", [x], [x * ca.sin(x)], ["x"], ["y"])


def value(function: ca.Function) -> np.ndarray:
    buffered = BufferedFunction(function)
    buffered.inputs["x"][:] = np.arange(6).reshape(2, 3)
    return buffered()["y"].copy()


def test_buffers_keep_rows_and_columns(square):
    x = np.arange(6).reshape(2, 3)
    np.testing.assert_allclose(value(square), x * np.sin(x), atol=1e-15)


def test_machine_code_gives_the_same_numbers_and_is_cached(square, tmp_path):
    function = compiled(square, tmp_path)
    if function is square:
        pytest.skip("no C compiler")
    np.testing.assert_allclose(value(function), value(square), atol=1e-15)
    (library,) = tmp_path.glob("*.so")
    written = library.stat().st_mtime_ns
    compiled(square, tmp_path)
    assert library.stat().st_mtime_ns == written


def test_two_processes_share_one_cache(tmp_path):
    command = [sys.executable, "-c", SCRIPT, str(tmp_path)]
    root = Path(__file__).parents[2]
    processes = [subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    answers = {process.communicate()[0].strip() for process in processes}
    assert len(answers) == 1 and all(process.returncode == 0 for process in processes)
    assert len(list(tmp_path.glob("*.so"))) <= 1 and not list(tmp_path.glob(".compile-*"))


def test_without_a_compiler_the_function_itself_is_used(square, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    assert compiled(square, tmp_path) is square


def test_a_cache_that_cannot_be_written_is_no_error(square, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    assert compiled(square, blocked / "cache") is square


def test_a_full_disk_leaves_nothing_half_written_and_says_so_once(square, tmp_path, monkeypatch, capsys):
    if compiled(square, tmp_path / "probe") is square:
        pytest.skip("no C compiler")

    def full(*_args, **_options):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    for _ in range(2):
        assert compiled(square, tmp_path / "cache") is square
    assert not list((tmp_path / "cache").iterdir())
    warnings = capsys.readouterr().err.splitlines()
    assert len(warnings) == 1 and "No space left on device" in warnings[0]


def test_a_compiler_that_fails_leaves_nothing_half_written(square, tmp_path, monkeypatch, capsys):
    broken = tmp_path / "cc"
    broken.write_text('#!/bin/sh\n[ "$1" = --version ] && exit 0\necho half > "$6"\necho no room >&2\nexit 1\n')
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    assert compiled(square, tmp_path / "cache") is square
    assert not list((tmp_path / "cache").iterdir())
    assert "no room" in capsys.readouterr().err


def test_a_damaged_library_is_removed_and_compiled_again(square, tmp_path):
    if compiled(square, tmp_path) is square:
        pytest.skip("no C compiler")
    (library,) = tmp_path.glob("*.so")
    library.unlink()
    library.write_bytes(b"damaged")
    np.testing.assert_allclose(value(compiled(square, tmp_path)), value(square), atol=1e-15)
    assert compiled(square, tmp_path) is not square
