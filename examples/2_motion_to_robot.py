"""A human motion to a robot's joints: retarget it and see what the robot could not follow.

python examples/2_motion_to_robot.py out/human_motion.npz op3 out/trajectory.npz
"""

import sys
from pathlib import Path

from retarget.pipeline import Retargeter
from ros_free_stack.files import load_motion, save_trajectory
from ros_free_stack.robots import load_robot


def main(motion: Path, robot: str, out: Path) -> None:
    result = Retargeter(load_robot(robot)).retarget(load_motion(motion))
    for limb, error in result.report.position_error_cm.items():
        print(f"{limb:16s} {error.mean:5.2f} cm off on average, {error.max:5.2f} at worst")
    for error in result.report.tracking_errors:
        print(f"tracking error: {error}")
    save_trajectory(out, result.trajectory)
    print(f"wrote {out}: {result.trajectory.duration_s:.1f} s, {len(result.trajectory.joint_names)} joints")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
