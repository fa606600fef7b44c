"""Serial ports as the system sees them: who has one, why one cannot be opened, and its latency timer."""

import errno
import os
import stat
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import serial
from serial.tools import list_ports

from ros_free_stack.errors import PortError

if sys.platform != "win32":
    import fcntl
    import grp
    import termios

_LATENCY_MS = 1
_PSEUDO = "/dev/pts/"


@contextmanager
def claimed(port: str) -> Generator[None]:
    """Have a port alone: no second program of this project, which could only break in, can claim it meanwhile.

    Claimed before it is opened, because opening alone sets the rate and empties the buffers of whoever uses it.

    Raises:
        PortError: another program has it, which is named, or it cannot be opened.
    """
    if sys.platform == "win32":
        yield  # the system itself lets a port be opened only once
        return
    try:
        handle = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise unopened(port, error) from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise PortError(port, _taken(port)) from None
        yield
    finally:
        os.close(handle)


def keep_out_others(opened: serial.Serial, port: str) -> None:
    """Let no program at all open the port again, where the system can do that; for after it is open."""
    # A pseudo terminal would keep the mark of a program that was killed, and let nobody in again.
    if sys.platform != "win32" and not os.path.realpath(port).startswith(_PSEUDO):
        with suppress(OSError):
            fcntl.ioctl(opened.fileno(), termios.TIOCEXCL)


def unopened(port: str, error: Exception) -> PortError:
    """Why a port cannot be opened, and what to do about it."""
    number = getattr(error, "errno", None)
    if number == errno.EBUSY:
        return PortError(port, _taken(port))
    reason = os.strerror(number) if number else str(error)
    if number in (errno.EACCES, errno.EPERM):
        return PortError(port, f"cannot be opened ({reason}): {_how_to_be_let_in(port)}")
    found = ", ".join(item.device for item in list_ports.comports()) or "none"
    return PortError(port, f"cannot be opened ({reason}); serial ports here: {found}; or use sim")


def _taken(port: str) -> str:
    holders = ", ".join(_holders(port)) or "another program"
    return f"is in use by {holders}: two programs on one bus break each other's packets; end that one first"


def _holders(port: str) -> list[str]:
    """Programs that have the port open, as far as this user may see them; this one left out unless it is alone."""
    device = os.path.realpath(port)
    found: dict[int, str] = {}
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if any(str(file.readlink()) == device for file in (process / "fd").iterdir()):
                name = (process / "comm").read_text().strip()
                found[int(process.name)] = f"{name} (process {process.name})"
    others = {number: words for number, words in found.items() if number != os.getpid()}
    return list((others or found).values())


def _how_to_be_let_in(port: str) -> str:
    """What lets this user open the port."""
    if sys.platform == "win32":
        return "end the program that has it"
    with suppress(OSError, KeyError):
        status = Path(port).stat()
        group = grp.getgrgid(status.st_gid).gr_name
        if status.st_mode & stat.S_IWGRP and group != "root":
            return f"join its group with `sudo usermod -aG {group} $USER`, then log in again"
    name = Path(os.path.realpath(port)).name
    return (
        f'as root, add the udev rule KERNEL=="{name.rstrip("0123456789")}*", MODE="0666" in '
        "/etc/udev/rules.d/99-dynamixel.rules, then plug the adapter in again"
    )


@dataclass(frozen=True)
class Latency:
    """What became of a port's latency timer: whether it is as low as it should be, and words for a person."""

    ok: bool
    words: str


def lower_latency(port: str, devices: Path = Path("/sys/bus/usb-serial/devices")) -> Latency:
    """Set a USB serial adapter's latency timer to 1 ms where Linux lets us; `devices` is where it lists them."""
    if not sys.platform.startswith("linux"):
        return Latency(False, "not settable on this system: set the adapter's latency timer to 1 ms in its driver")
    file = devices / Path(port).resolve().name / "latency_timer"
    if not file.exists():
        return Latency(True, "the port has none")
    try:
        before = int(file.read_text())
        if before > _LATENCY_MS:
            file.write_text(str(_LATENCY_MS))
        return Latency(True, f"{min(before, _LATENCY_MS)} ms")
    except (OSError, ValueError):
        return Latency(False, f"not lowered to {_LATENCY_MS} ms: as root, echo {_LATENCY_MS} > {file}")
