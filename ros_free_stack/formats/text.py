"""Text of motion files and mappings, whatever program wrote it."""

import codecs
import unicodedata
from pathlib import Path
from typing import Final

from ros_free_stack.errors import InvalidFile

_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
"""Byte-order marks; those of UTF-32 begin with those of UTF-16."""


def read_text(path: Path) -> str:
    """The text of a file, by its byte-order mark, else UTF-8, else Latin-1; accents composed, line ends `\\n`.

    A joint's name is thus the same in a motion file and in the mapping that a user writes for it. The zeros and the
    end-of-file mark (ctrl-Z) that some programs leave at the end are dropped.

    Raises:
        InvalidFile: the file cannot be read, or its byte-order mark is wrong.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), None) or _without_mark(data)
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        raise InvalidFile(path, f"is not the {encoding} text that it begins as ({error.reason})") from None
    text = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\x00\x1a \t\n")
    return unicodedata.normalize("NFC", text) + "\n"


def _without_mark(data: bytes) -> str:
    start = data[:64]
    if start[1:2] == b"\x00" and start[1::2].count(0) > len(start) // 3:
        return "utf-16-le"
    if start[:1] == b"\x00" and start[::2].count(0) > len(start) // 3:
        return "utf-16-be"
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"
