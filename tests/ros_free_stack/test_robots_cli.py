"""What `robots show` tells about the servos."""

import json

import pytest

from ros_free_stack.cli import RobotsShow


def test_show_tells_servos_and_safety(capsys: pytest.CaptureFixture[str]) -> None:
    assert RobotsShow(robot="op3", json=True).run() == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["joints"]["r_el"]["servo_id"] == 5
    assert shown["joints"]["r_el"]["servo_model"] == "XM430-W350"
    assert shown["servo_safety"]["temperature"] == 70
    assert shown["servo_settings"]["mode"] == "position"
    assert RobotsShow(robot="op3").run() == 0
    text = capsys.readouterr().out
    assert "servo 5, XM430-W350" in text and "following_error 0.5" in text and "2000000 baud" in text


def test_show_of_a_robot_without_servos(capsys: pytest.CaptureFixture[str]) -> None:
    assert RobotsShow(robot="g1").run() == 0
    assert "servo" not in capsys.readouterr().out
