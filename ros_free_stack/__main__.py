"""`python -m ros_free_stack`: the command line, which alone of this package knows the others."""

import sys

from pipeline.command_line import entry

if __name__ == "__main__":
    sys.exit(entry())
