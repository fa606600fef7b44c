"""The servos' ear: finds instruction packets in what the host sends, and tells which were damaged.

Firmware answers a damaged packet with a CRC error, which the host's own parser has no use for; so this is another
parser, and the two prove each other.
"""

from dataclasses import dataclass

from hw.protocol import HEADER, HEADER_SIZE, MAX_LENGTH, Packet, crc16, unstuff

_SHORTEST = 3
"""Length field of a packet with an instruction and a CRC alone."""


@dataclass(frozen=True)
class Damaged:
    """A packet whose CRC was wrong; `id` is as it came."""

    id: int


class Receiver:
    """Takes bytes as they come, cut anywhere."""

    def __init__(self) -> None:
        self._waiting = b""

    def feed(self, data: bytes) -> list[Packet | Damaged]:
        """Take more bytes; return what they complete."""
        waiting, done = self._waiting + data, 0
        found: list[Packet | Damaged] = []
        while (start := waiting.find(HEADER, done)) >= 0:
            done = start
            length = int.from_bytes(waiting[start + 5 : start + HEADER_SIZE], "little")
            end = start + HEADER_SIZE + length
            if len(waiting) < start + HEADER_SIZE:
                break
            if not _SHORTEST <= length <= MAX_LENGTH:
                done = start + len(HEADER)
            elif len(waiting) < end:
                break
            elif crc16(waiting[start : end - 2]) == int.from_bytes(waiting[end - 2 : end], "little"):
                body = unstuff(waiting[start + HEADER_SIZE : end - 2])
                found.append(Packet(waiting[start + 4], body[0], body[1:]))
                done = end
            else:
                # A wrong length would swallow what follows: look again just after this header.
                found.append(Damaged(waiting[start + 4]))
                done = start + len(HEADER)
        if start < 0:
            # All but a tail that may be the beginning of a header is noise.
            done = max(done, len(waiting) - len(HEADER) + 1)
        self._waiting = waiting[done:]
        return found

    def rest(self) -> None:
        """The line went quiet: what came of a packet so far will not be completed."""
        self._waiting = b""
