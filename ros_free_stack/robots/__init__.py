"""Robot descriptions as data: one YAML a robot says where its model is and what the model leaves out.

A description names the MuJoCo model, how human joints map onto robot bodies, the soles, joint limits that the
model lacks, the standing pose and, where the robot has Dynamixel servos, the servo map.
"""

from ros_free_stack.robots.catalogue import load_robot, robot_files, robot_names, user_folder
from ros_free_stack.robots.description import Attachment, Capsule, JointLimits, RobotDescription, Sole
from ros_free_stack.robots.reader import read_description
from ros_free_stack.robots.servos import (
    ServoBoard,
    ServoMap,
    ServoMode,
    ServoMotor,
    ServoSafety,
    ServoSettings,
    StopPolicy,
)

__all__ = [
    "Attachment",
    "Capsule",
    "JointLimits",
    "RobotDescription",
    "ServoBoard",
    "ServoMap",
    "ServoMode",
    "ServoMotor",
    "ServoSafety",
    "ServoSettings",
    "Sole",
    "StopPolicy",
    "load_robot",
    "read_description",
    "robot_files",
    "robot_names",
    "user_folder",
]
