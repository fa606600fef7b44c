"""What this machine has: each finding is one line with the remedy where something is missing."""

import ctypes.util
import os
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec

REQUIRED_PACKAGES = ("mujoco", "casadi", "daqp", "torch", "transformers", "spacy", "dynamixel_sdk", "serial")


@dataclass(frozen=True)
class Finding:
    """One part of the machine: whether it is there, in words, and whether the stack works without it."""

    name: str
    ok: bool
    detail: str
    optional: bool = False


def examine() -> tuple[Finding, ...]:
    """Look at Python, packages, compiler, GL and serial ports; imports nothing heavy."""
    probes: tuple[Callable[[], Finding], ...] = (_python, _packages, _compiler, _gl, _ports)
    return tuple(probe() for probe in probes)


def _python() -> Finding:
    version = ".".join(str(number) for number in sys.version_info[:3])
    return Finding("python", sys.version_info >= (3, 11), f"{version}, 3.11 or newer is needed")


def _packages() -> Finding:
    missing = [name for name in REQUIRED_PACKAGES if find_spec(name) is None]
    detail = f"missing {', '.join(missing)}: run make setup" if missing else "all required packages are installed"
    return Finding("packages", not missing, detail)


def _compiler() -> Finding:
    compiler = shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc") or shutil.which("clang")
    detail = compiler or "no C compiler: retargeting runs in CasADi's virtual machine, several times slower"
    return Finding("compiler", compiler is not None, detail, optional=True)


def _gl() -> Finding:
    found = [name for name in ("EGL", "OSMesa") if ctypes.util.find_library(name)]
    remedy = "no EGL or OSMesa: no video; on Debian or Ubuntu: apt install libegl1 libosmesa6"
    return Finding("gl", bool(found), ", ".join(found) or remedy, optional=True)


def _ports() -> Finding:
    from serial.tools.list_ports import comports

    ports = [port.device for port in comports()]
    return Finding("ports", bool(ports), ", ".join(ports) or "no serial port; --servo sim needs none", optional=True)
