"""The `stream` subcommand: the driver of `hw`, and the bodies of `sim` to look at the way to the first pose."""

from dataclasses import dataclass
from functools import partial

from hw.cli import Stream as StreamAlone
from hw.stream import WayCheck
from ros_free_stack.robots import RobotDescription


@dataclass(frozen=True, kw_only=True)
class Stream(StreamAlone):
    """Play a trajectory with a passing verdict on servos, real or emulated.

    Examples:
        python launch.py stream out/run/trajectory.npz out/run/verdict.json --dry-run
        python launch.py stream out/run/trajectory.npz out/run/verdict.json --servo /dev/ttyUSB0 --telemetry stream.npz
    """

    def _way_check(self, robot: RobotDescription) -> WayCheck | None:
        from sim.judge.way_in import check_way_in

        return partial(check_way_in, robot)
