"""A pseudo terminal as the far end of a serial port: what a client writes, sets and does not read."""

import array
import fcntl
import os
import select
import sys
import termios
import time
import tty
from contextlib import suppress

_GET_RATES = 0x802C542A
"""Linux's TCGETS2, which knows rates that have no name too."""
_WORDS, _OUTPUT_RATE = 11, 10
"""Words of 4 bytes in what it fills in, and which of them is the rate at which the client writes."""
_NAMED = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name[0] == "B" and name[1:].isdigit()}


class Terminal:
    """One pseudo terminal. Only its far end is kept open: a client that leaves, and one that comes, are as on a wire.

    Attributes:
        port: path that a client opens.
    """

    def __init__(self) -> None:
        self._master, near = os.openpty()
        tty.setraw(near)
        self.port = os.ttyname(near)
        os.close(near)
        os.set_blocking(self._master, False)

    def close(self) -> None:
        """Hang up."""
        os.close(self._master)

    def read(self, patience_s: float) -> bytes:
        """What the client wrote; empty where nothing came for so long."""
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        events = poll.poll(1000 * patience_s)
        with suppress(BlockingIOError, OSError):
            if events and events[0][1] & select.POLLIN:
                return os.read(self._master, 4096)
        if events:
            time.sleep(patience_s)  # nobody has the port open
        return b""

    def write(self, data: bytes) -> None:
        """Say something; what a client does not read, or nobody hears, is lost as on a wire."""
        with suppress(BlockingIOError, OSError):
            os.write(self._master, data)

    @property
    def rate(self) -> int:
        """Bits a second that the client has set."""
        if sys.platform.startswith("linux"):
            words = array.array("I", bytes(4 * _WORDS))
            fcntl.ioctl(self._master, _GET_RATES, words)
            return words[_OUTPUT_RATE]
        return _NAMED[termios.tcgetattr(self._master)[5]]
