"""The motion encoding that corpus and models share."""

from ros_free_stack.formats.features import CHANNELS, HUMANML3D, decode

__all__ = ["CHANNELS", "HUMANML3D", "decode"]
