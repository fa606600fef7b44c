#!/usr/bin/env python3
"""Command a humanoid by text: the command line of a checkout. Where the project is installed, `rfs` is the same."""

import sys

from pipeline.command_line import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
