"""The wheel works outside the checkout, with one name at the top, beside a user's own `launch` or `sim`."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import launch

ROOT = Path(launch.__file__).parent
PACKAGES = ("ros_free_stack", "generator", "retarget", "sim", "hw", "pipeline")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel's content, built from a copy of the sources."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    ignored = shutil.ignore_patterns("__pycache__", "*.pyc")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, source / name, ignore=ignored)
    for name in ("setup.py", "pyproject.toml", "README.md", "LICENSE", "NOTICE"):
        shutil.copy(ROOT / name, source / name)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-index", "--no-build-isolation", "-w", folder]
    subprocess.run([*command, source], check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "installed")
    return folder / "installed"


@pytest.fixture
def others(tmp_path: Path) -> Path:
    """A user's own modules with names that this project's sources have too."""
    for name in ("launch", "sim", "hw", "generator"):
        (tmp_path / f"{name}.py").write_text(f"OWNER = 'user'\nassert __name__ == '{name}'\n")
    return tmp_path


def python(installed: Path, others: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python in the user's folder, with the wheel behind the user's modules."""
    variables = os.environ | {"PYTHONPATH": f"{others}{os.pathsep}{installed}"}
    return subprocess.run(
        [sys.executable, *arguments], env=variables, cwd=others, capture_output=True, text=True, check=False
    )


def test_one_name_at_the_top_and_all_files_below(installed: Path):
    top = {path.name for path in installed.iterdir() if not path.name.endswith(".dist-info")}
    assert top == {"ros_free_stack"}
    for name in PACKAGES:
        target = installed / "ros_free_stack" / ("" if name == "ros_free_stack" else name)
        for path in (ROOT / name).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                assert (target / path.relative_to(ROOT / name)).is_file(), path


def test_modules_of_the_user_stay_the_users(installed: Path, others: Path):
    code = """
import launch, sim, hw, generator
from ros_free_stack.sim.judge import verdict
from ros_free_stack.generator.registry import GENERATORS, resolved
import ros_free_stack.pipeline.pipeline, ros_free_stack.hw.stream, ros_free_stack.retarget.pipeline
assert {launch.OWNER, sim.OWNER, hw.OWNER, generator.OWNER} == {"user"}
print(*(resolved(item.model).__module__ for item in GENERATORS.values()))
"""
    done = python(installed, others, "-c", code)
    assert done.returncode == 0, done.stderr
    assert done.stdout and all(name.startswith("ros_free_stack.generator.models.") for name in done.stdout.split())


def test_every_command_is_found(installed: Path, others: Path):
    code = """
from ros_free_stack.pipeline.command_line import command_class
from ros_free_stack.pipeline.commands import COMMANDS
for name in COMMANDS:
    assert command_class(name).__module__.startswith("ros_free_stack."), name
"""
    done = python(installed, others, "-c", code)
    assert done.returncode == 0, done.stderr


def test_a_sentence_becomes_motion(installed: Path, others: Path):
    done = python(installed, others, "-m", "ros_free_stack", "generate", "a person waves", "--out", "wave.npz")
    assert done.returncode == 0, done.stderr
    assert (others / "wave.npz").is_file()
