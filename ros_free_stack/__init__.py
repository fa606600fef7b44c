"""Messages, errors, robot descriptions, file formats, rate and clock: what all stages share."""

__version__ = "0.1.0"
