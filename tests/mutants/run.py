"""Do the tests notice? Each mutant of safety code is put into a copy of the packages, where its tests must fail.

python -m tests.mutants.run                     # all of tests/mutants/mutants.yaml
python -m tests.mutants.run --only hw/safety    # those whose file or words hold this
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import Queue
from typing import Any, TypeVar

import tyro
import yaml

ROOT = Path(__file__).parents[2]
LIST = Path(__file__).with_name("mutants.yaml")
COPIED = ("ros_free_stack", "generator", "retarget", "sim", "hw", "pipeline", "tests", "launch.py", "pyproject.toml")
LONGEST_S = 600.0
Result = TypeVar("Result")


@dataclass(frozen=True)
class Mutant:
    """One change of one line.

    Attributes:
        file: path from the root.
        text: what stands there, once in the file.
        becomes: what is put there instead.
        tests: pytest's arguments: the tests that ought to notice.
        equivalent: why no test can notice, where that is so; such a mutant is not run.
    """

    file: str
    text: str
    becomes: str
    tests: tuple[str, ...]
    equivalent: str = ""

    @property
    def name(self) -> str:
        return f"{self.file}: {' '.join(self.text.split())} -> {' '.join(self.becomes.split()) or '(nothing)'}"

    def applied(self, source: str) -> str:
        """The mutated source; ValueError where the text is not there once."""
        if source.count(self.text) != 1:
            raise ValueError(f"{self.name}: the text stands {source.count(self.text)} times in the file, expected once")
        return source.replace(self.text, self.becomes)


def load(path: Path = LIST) -> tuple[Mutant, ...]:
    """The list, checked against the sources: groups of mutants of one file with the tests that they share."""
    groups: list[dict[str, Any]] = yaml.safe_load(path.read_text(encoding="utf-8"))
    mutants = tuple(
        Mutant(
            group["file"],
            item["text"],
            item["becomes"],
            tuple(item.get("tests", group["tests"])),
            item.get("equivalent", ""),
        )
        for group in groups
        for item in group["mutants"]
    )
    for mutant in mutants:
        mutant.applied((ROOT / mutant.file).read_text(encoding="utf-8"))
    return mutants


@contextmanager
def copies(count: int) -> Iterator["Queue[Path]"]:
    """Folders with the packages, one for each mutant that is tried at a time."""
    with tempfile.TemporaryDirectory(prefix="mutants-") as parent:
        free: Queue[Path] = Queue()
        for number in range(count):
            folder = Path(parent) / str(number)
            for name in COPIED:
                source = ROOT / name
                if source.is_dir():
                    shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
                else:
                    shutil.copy(source, folder / name)
            free.put(folder)
        yield free


def noticed(mutant: Mutant, folder: Path) -> bool:
    """Whether a test fails with the mutant in the folder."""
    path = folder / mutant.file
    source = path.read_text(encoding="utf-8")
    path.write_text(mutant.applied(source), encoding="utf-8")
    try:
        # A test that hangs has noticed too.
        return _pytest(folder, mutant.tests) != 0
    finally:
        path.write_text(source, encoding="utf-8")


def _pytest(folder: Path, tests: tuple[str, ...]) -> int:
    """Exit code of pytest; 5 (no test ran) and 4 (bad arguments) end everything, since they would pass for a death."""
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--reruns", "0", *tests]
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(folder), "HYPOTHESIS_STORAGE_DIRECTORY": ""}
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LONGEST_S, check=False
        )
    except subprocess.TimeoutExpired:
        return 1
    if done.returncode in (4, 5):
        raise SystemExit(f"error: pytest {' '.join(tests)} ran nothing:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.returncode


def main(only: str = "", jobs: int = 2) -> None:
    """Try every mutant; exit code 1 if one survives.

    Args:
        only: try those whose file, text or replacement holds this.
        jobs: how many at a time.
    """
    chosen = [mutant for mutant in load() if only in mutant.name]
    equivalent = [mutant for mutant in chosen if mutant.equivalent]
    tried = [mutant for mutant in chosen if not mutant.equivalent]
    survived: list[Mutant] = []
    with copies(jobs) as free, ThreadPoolExecutor(jobs) as pool:

        def with_copy(work: Callable[[Path], Result]) -> Result:
            folder = free.get()
            try:
                return work(folder)
            finally:
                free.put(folder)

        # Tests that fail without a mutant would kill every one.
        suites = sorted({mutant.tests for mutant in tried})
        for suite, code in zip(
            suites, pool.map(lambda suite: with_copy(lambda at: _pytest(at, suite)), suites), strict=True
        ):
            if code != 0:
                raise SystemExit(f"error: without a mutant, pytest {' '.join(suite)} fails")
        for mutant, killed in zip(
            tried, pool.map(lambda item: with_copy(lambda at: noticed(item, at)), tried), strict=True
        ):
            print("killed  " if killed else "SURVIVED", mutant.name, flush=True)
            if not killed:
                survived.append(mutant)
    for mutant in equivalent:
        print("same    ", mutant.name, "|", mutant.equivalent)
    print(f"{len(tried) - len(survived)} killed, {len(survived)} survived, {len(equivalent)} equivalent")
    raise SystemExit(bool(survived))


if __name__ == "__main__":
    tyro.cli(main)
