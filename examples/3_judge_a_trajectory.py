"""Judge a trajectory: every check with its value and limit, the physics playback, and a picture.

python examples/3_judge_a_trajectory.py out/trajectory.npz
"""

import sys
from pathlib import Path

from ros_free_stack.files import load_trajectory, save_verdict
from ros_free_stack.robots import load_robot
from sim.draw.storyboard import write_storyboard
from sim.judge.verdict import judge


def main(path: Path) -> None:
    trajectory = load_trajectory(path)
    robot = load_robot(trajectory.robot)
    # Servos get plain angles from the driver, so that is what they are judged by; other robots may use feedback.
    judgement = judge(trajectory, robot, controller="pd" if robot.servos else "default")
    for check in judgement.verdict.checks:
        mark = "pass" if check.passed else "FAIL"
        print(
            f"{mark}  {check.name:22s} {check.value:10.4g} {check.unit:10s} limit {check.limit:.4g}  {check.worst_item}"
        )
    print("feasible" if judgement.passed else "infeasible")
    save_verdict(path.with_name("verdict.json"), judgement.verdict)
    write_storyboard(path.with_suffix(".png"), None, judgement.reference, trajectory.robot)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
