from dataclasses import replace

import pytest

from retarget.body.geometry import measure
from retarget.pipeline import Retargeter
from ros_free_stack.errors import InvalidFile, UnsupportedModel
from ros_free_stack.robots import RobotDescription, load_robot


@pytest.fixture(scope="module")
def robot() -> RobotDescription:
    return load_robot("op3")


def test_a_robot_without_feet_is_refused(robot):
    with pytest.raises(UnsupportedModel, match="no soles to stand on; valid: soles, or mount: fixed"):
        Retargeter(replace(robot, soles={}))


def test_a_missing_attachment_is_named(robot):
    attachments = {name: item for name, item in robot.attachments.items() if name != "left_ankle"}
    with pytest.raises(UnsupportedModel, match="attaches no left_ankle"):
        measure(replace(robot, attachments=attachments))


def test_an_attachment_to_a_missing_body_is_named(robot):
    knee = replace(robot.attachments["left_knee"], body="no_such_link")
    with pytest.raises(InvalidFile, match=r"'no_such_link' that op3\.xml lacks"):
        measure(replace(robot, attachments=robot.attachments | {"left_knee": knee}))
