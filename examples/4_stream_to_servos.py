"""Stream a judged trajectory to servos: the virtual bus by default, a serial port where one is named.

python examples/4_stream_to_servos.py out/trajectory.npz out/verdict.json sim
"""

import sys
from functools import partial
from pathlib import Path

from hw.stream import stream
from ros_free_stack.files import load_trajectory, load_verdict
from ros_free_stack.robots import load_robot
from sim.judge.way_in import check_way_in


def main(trajectory_path: Path, verdict_path: Path, port: str) -> None:
    trajectory = load_trajectory(trajectory_path)
    robot = load_robot(trajectory.robot)
    look = partial(check_way_in, robot)
    report = stream(trajectory, load_verdict(verdict_path), robot, port=port, check_way=look)
    print(f"{report.cycles} cycles to {report.joints} servos, jitter p99 {report.jitter_p99_ms:.2f} ms")
    print(f"following error {report.following_error_rad:.3f} rad at worst, peak current {report.peak_current_a:.2f} A")
    for error in report.errors:
        print(f"note: {error}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3] if len(sys.argv) > 3 else "sim")
