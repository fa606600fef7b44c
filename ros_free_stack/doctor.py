"""What this machine has: each finding is one line with the remedy where something is missing.

Only the standard library is imported, so that it works where nothing is installed yet.
"""

import importlib.metadata
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from ros_free_stack import __version__

DISTRIBUTION = "ros-free-stack"
MIB = 1024 * 1024
LEAST_MEMORY_MIB, LEAST_DISK_MIB = 3000, 500
GL_TIMEOUT_S = 20


@dataclass(frozen=True)
class Finding:
    """One part of the machine: whether it is there, in words, and whether the stack works without it."""

    name: str
    ok: bool
    detail: str
    optional: bool = False


def examine() -> tuple[Finding, ...]:
    """Look at Python, packages, compiler, GL, processor, memory, disk, caches, weights, settings and serial ports."""
    probes: tuple[Callable[[], Finding], ...] = (
        _version, _python, _packages, _compiler, _gl, _processor, _memory, _disk, _cache, _weights, _robots, _ports,
    )  # fmt: skip
    return tuple(probe() for probe in probes)


def print_findings(*, as_json: bool) -> int:
    """Print all findings; the exit code is 2 where something that is needed lacks."""
    findings = examine()
    if as_json:
        print(json.dumps({item.name: {"ok": item.ok, "detail": item.detail} for item in findings}, indent=2))
    else:
        print("\n".join(line(item) for item in findings))
    return exit_code(findings)


def line(finding: Finding) -> str:
    """A finding for people."""
    word = "ok  " if finding.ok else "none" if finding.optional else "LACK"
    return f"{word}  {finding.name:10s} {finding.detail}"


def exit_code(findings: tuple[Finding, ...]) -> int:
    """0 where all that is needed is there, else 2."""
    return 0 if all(finding.ok or finding.optional for finding in findings) else 2


def _version() -> Finding:
    return Finding("version", True, f"{DISTRIBUTION} {__version__} in {Path(__file__).parents[1]}")


def _python() -> Finding:
    detail = f"{platform.python_version()} at {sys.executable}, 3.11 or newer is needed"
    return Finding("python", sys.version_info >= (3, 11), detail)


def _packages() -> Finding:
    """Every dependency with its version, as the installed project declares them."""
    try:
        declared = importlib.metadata.requires(DISTRIBUTION) or []
    except importlib.metadata.PackageNotFoundError:
        return Finding("packages", False, "the project is not installed: run make setup")
    names = [_requirement_name(item) for item in declared if "extra ==" not in item]
    found = {name: _installed(name) for name in names}
    missing = [name for name, version in found.items() if version is None]
    if missing:
        return Finding("packages", False, f"missing {', '.join(missing)}: run make setup")
    return Finding("packages", True, ", ".join(f"{name} {version}" for name, version in found.items()))


def _requirement_name(requirement: str) -> str:
    return requirement.replace(";", " ").split(" ")[0].split("<")[0].split(">")[0].split("=")[0].split("[")[0]


def _installed(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _compiler() -> Finding:
    """The compiler that the retargeter calls, tried on a function of one line."""
    command = shutil.which(os.environ.get("CC", "cc"))
    slower = "retargeting runs in CasADi's virtual machine, several times slower"
    if command is None:
        return Finding("compiler", False, f"no C compiler: {slower}; on Debian or Ubuntu: apt install gcc", True)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "probe.c"
        source.write_text("double probe(double x) { return x; }\n", encoding="utf-8")
        target = [str(source), "-o", str(source.with_suffix(".so"))]
        done = subprocess.run(
            [command, "-O1", "-fPIC", "-shared", *target], capture_output=True, text=True, check=False
        )
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ["it failed"])[0]
        return Finding("compiler", False, f"{command} makes no shared library ({why}): {slower}", True)
    return Finding("compiler", True, f"{command} makes shared libraries", True)


_GL_PROBE = """
import mujoco, sys
context = mujoco.GLContext(16, 16); context.make_current()
mujoco.MjrContext(mujoco.MjModel.from_xml_string('<mujoco/>'), mujoco.mjtFontScale.mjFONTSCALE_100)
"""


def _gl() -> Finding:
    """Open a context, each way in a process of its own: a library that is there may still not work."""
    if find_spec("mujoco") is None:
        return Finding("gl", False, "not tried: mujoco is not installed", True)
    for backend in ("egl", "osmesa"):
        command = [sys.executable, "-c", _GL_PROBE]
        variables = os.environ | {"MUJOCO_GL": backend}
        try:
            done = subprocess.run(command, env=variables, capture_output=True, timeout=GL_TIMEOUT_S, check=False)
        except subprocess.TimeoutExpired:
            continue
        if done.returncode == 0:
            return Finding("gl", True, f"{backend.upper()}: a context opens, videos can be drawn", True)
    remedy = "neither EGL nor OSMesa opens a context: no video; on Debian or Ubuntu: apt install libegl1 libosmesa6"
    return Finding("gl", False, remedy, True)


def _processor() -> Finding:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    flags: set[str] = set()
    with_flags = Path("/proc/cpuinfo")
    if with_flags.is_file():
        lines = (row for row in with_flags.read_text(encoding="utf-8").splitlines() if row.startswith("flags"))
        flags = set(next(lines, "").split())
    known = [name for name in ("avx2", "avx512f", "avx512_bf16", "amx_bf16") if name in flags]
    return Finding("processor", True, f"{cores} cores, {platform.machine()}{''.join(f', {name}' for name in known)}")


def _memory() -> Finding:
    if not hasattr(os, "sysconf") or "SC_PHYS_PAGES" not in os.sysconf_names:
        return Finding("memory", True, "not known on this system", True)
    total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // MIB
    return Finding("memory", total >= LEAST_MEMORY_MIB, f"{total} MiB, {LEAST_MEMORY_MIB} MiB are needed", True)


def _disk() -> Finding:
    free = shutil.disk_usage(Path.cwd()).free // MIB
    return Finding("disk", free >= LEAST_DISK_MIB, f"{free} MiB free in this folder", True)


def _cache() -> Finding:
    """Compiled kinematics and thinned models; without a writable folder they are made anew at every start."""
    if find_spec("platformdirs") is None:
        return Finding("cache", False, "not tried: platformdirs is not installed", True)
    import platformdirs

    folder = Path(platformdirs.user_cache_dir(DISTRIBUTION))
    there = next(path for path in (folder, *folder.parents) if path.exists())
    if not os.access(there, os.W_OK):
        return Finding("cache", False, f"{folder} cannot be written: models are compiled anew at every start", True)
    files = [path for path in folder.rglob("*") if path.is_file()] if folder.is_dir() else []
    size = sum(path.stat().st_size for path in files) / MIB
    return Finding("cache", True, f"{folder}: {len(files)} files, {size:.1f} MiB; may be deleted at any time", True)


def _weights() -> Finding:
    here = Path(__file__).parent  # the generator is beside this package in a checkout, and inside it in a wheel
    folder = next((path for path in (here.parent, here) if (path / "generator").is_dir()), here) / "generator/weights"
    files = sorted(folder.rglob("*.safetensors"))
    if not files:
        return Finding("weights", False, "no trained weights beside the generator: fetch the repository whole")
    size = sum(path.stat().st_size for path in files) / MIB
    return Finding("weights", True, f"{len(files)} files, {size:.1f} MiB in {folder}")


def _robots() -> Finding:
    folder = Path(os.environ.get("RFS_ROBOTS") or "robots")
    own = sorted(path.stem for path in folder.glob("*.yaml")) if folder.is_dir() else []
    detail = f"{', '.join(own)} in {folder}" if own else f"no own descriptions in {folder} (RFS_ROBOTS names another)"
    return Finding("robots", True, detail, True)


def _ports() -> Finding:
    """Serial ports with what keeps a stream from working well on them."""
    if find_spec("serial") is None:
        return Finding("ports", False, "not tried: pyserial is not installed", True)
    from serial.tools.list_ports import comports

    ports = [_port(port.device) for port in comports()]
    return Finding("ports", bool(ports), "; ".join(ports) or "no serial port; --servo sim needs none", True)


def _port(device: str) -> str:
    words = [device]
    if not os.access(device, os.R_OK | os.W_OK):
        words.append("no permission (add yourself to the group dialout and log in again)")
    timer = Path("/sys/bus/usb-serial/devices") / Path(device).name / "latency_timer"
    if timer.is_file():
        latency = timer.read_text(encoding="utf-8").strip()
        words.append(f"latency timer {latency} ms" + ("" if latency == "1" else ", 1 is wanted"))
    return ", ".join(words)
