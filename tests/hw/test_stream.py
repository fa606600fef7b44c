"""From files to servos: refusals, an end-to-end stream, and what becomes of the servos when the host is stopped."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hw.stream import check_port, stream
from hw.virtual.bus import VirtualBus
from ros_free_stack.errors import (
    InvalidFile,
    InvalidOption,
    LostServo,
    PortError,
    ServoFault,
    UnsafeCommand,
)
from ros_free_stack.files import load_telemetry, save_trajectory, save_verdict
from ros_free_stack.messages import Mount
from ros_free_stack.robots import ServoSafety, load_robot
from tests.hw.verdicts import judged, motion

OP3 = load_robot("op3")
SAFETY = ServoSafety(stall_s=60, late_after=10**6, watchdog_s=2.5, hold_s=0.03, lost_after=50)
ROOT = Path(__file__).parents[2]


def test_a_whole_robot_follows_a_trajectory(tmp_path: Path) -> None:
    trajectory, file = motion(OP3), tmp_path / "telemetry.npz"
    with VirtualBus.of_robot(OP3) as bus:
        report = stream(trajectory, judged(trajectory), OP3, port=bus.port, telemetry=file, safety=SAFETY)
        servos = list(bus.network.servos.values())
        assert not any(servo.torque_on for servo in servos)
        assert not any(servo.refusals for servo in servos)
        low, high = bus.servo(5).goal_extremes or (0, 0)
        assert (high - low) * servos[0].table.rad_per_tick == pytest.approx(0.6, abs=0.01)
    assert report.joints == 20
    assert report.method == "fast sync read"
    assert 0 < report.following_error_rms_rad < report.following_error_rad < 0.3
    assert report.smoothing_error_rad < 0.002
    assert report.peak_current_a > 0
    data = report.as_dict()
    json.dumps(data)
    assert {"cycles", "rate_hz", "jitter_p99_ms", "errors"} <= data.keys()
    recorded = load_telemetry(file)
    assert recorded.joint_names == OP3.joint_names
    assert recorded.goal.shape == recorded.position.shape == (report.cycles, 20)
    assert np.ptp(recorded.position[:, OP3.joint_names.index("r_el")]) == pytest.approx(0.6, abs=0.1)


def test_sim_starts_its_own_bus_and_a_partial_rig_moves_only_its_joints() -> None:
    trajectory = motion(OP3, seconds=0.5)
    report = stream(trajectory, judged(trajectory), OP3, port="sim", joints=("r_el", "r_sho_roll"), safety=SAFETY)
    assert report.joints == 2
    assert report.cycles > 0
    assert len(report.skipped) == 18 and "r_el" not in report.skipped


def test_a_dry_run_writes_nothing() -> None:
    trajectory = motion(OP3, seconds=0.2)
    with VirtualBus.of_robot(OP3) as bus:
        before = {i: servo.get("Goal Position") for i, servo in bus.network.servos.items()}
        report = stream(trajectory, judged(trajectory), OP3, port=bus.port, dry_run=True)
        assert report.dry_run and report.rate is None
        assert {i: servo.get("Goal Position") for i, servo in bus.network.servos.items()} == before
        assert all(servo.goal_extremes is None for servo in bus.network.servos.values())


def test_only_a_verdict_that_the_gate_takes_opens_a_port() -> None:
    trajectory, no_port = motion(OP3, seconds=0.2), "/dev/nothing"
    with pytest.raises(UnsafeCommand, match="without physics"):
        stream(trajectory, replace(judged(trajectory), physics=False), OP3, port=no_port)
    with pytest.raises(UnsafeCommand, match="--mount fixed"):
        stream(trajectory, judged(trajectory, mount="fixed"), OP3, port=no_port)
    with pytest.raises(PortError, match=no_port):
        stream(trajectory, judged(trajectory), OP3, port=no_port)


@pytest.mark.parametrize("mount", ["free", "fixed"])
def test_a_fixed_mount_plays_both_verdicts(mount: Mount) -> None:
    trajectory = motion(OP3, seconds=0.2)
    verdict = judged(trajectory, mount=mount)
    assert stream(trajectory, verdict, OP3, port="sim", mount="fixed", dry_run=True).mount == "fixed"


def test_a_rig_with_some_joints_present_names_the_missing_until_they_are_left_out() -> None:
    trajectory = motion(OP3, seconds=0.2)
    present = ("r_el", "r_sho_roll", "r_sho_pitch")
    with VirtualBus.of_robot(OP3) as bus:
        with bus.locked:
            for identity in (7, 19):
                bus.servo(identity).dead = True
        with pytest.raises(LostServo, match=r"no answer from head_pan .servo 19., r_hip_yaw .servo 7. .*--joints"):
            stream(trajectory, judged(trajectory), OP3, port=bus.port, dry_run=True)
        report = stream(trajectory, judged(trajectory), OP3, port=bus.port, joints=present, safety=SAFETY)
        assert report.joints == 3 and len(report.skipped) == 17
        assert all(bus.servo(i).goal_extremes is None for i in (7, 8, 19))


def test_telemetry_outlives_a_fault(tmp_path: Path) -> None:
    trajectory, file = motion(OP3, seconds=2), tmp_path / "telemetry.npz"
    hot = replace(SAFETY, temperature=1.0)
    with VirtualBus.of_robot(OP3) as bus:
        with pytest.raises(ServoFault, match="limit 1 deg C"):
            stream(trajectory, judged(trajectory), OP3, port=bus.port, telemetry=file, safety=hot)
        assert not file.exists(), "the first reading stopped it: there is nothing to tell"
        jammed = replace(SAFETY, following_error=0.05, following_s=0.02)
        with bus.locked:
            bus.servo(5).motor.jammed = True
        with pytest.raises(ServoFault, match=r"r_el .* following error"):
            stream(trajectory, judged(trajectory), OP3, port=bus.port, telemetry=file, safety=jammed)
    assert len(load_telemetry(file).time_s) > 2


def test_telemetry_that_cannot_be_written_is_refused_before_anything_moves(tmp_path: Path) -> None:
    trajectory = motion(OP3, seconds=0.2)
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidFile, match="not a writable folder"):
        stream(trajectory, judged(trajectory), OP3, port="/dev/nothing", telemetry=tmp_path / "file" / "t.npz")


def test_a_robot_without_servos_says_so() -> None:
    g1 = load_robot("g1")
    trajectory = motion(g1, seconds=0.2)
    with pytest.raises(InvalidOption, match="g1 has no Dynamixel servos"):
        stream(trajectory, judged(trajectory), g1, port="sim")
    with pytest.raises(InvalidOption, match="g1 has no Dynamixel servos"):
        check_port("sim", g1)


def test_the_way_to_the_first_pose_is_looked_at_before_torque_comes_on() -> None:
    trajectory = motion(OP3, seconds=0.2)
    seen: list[tuple[tuple[str, ...], np.ndarray]] = []

    def refuse(names: tuple[str, ...], goals: np.ndarray) -> None:
        seen.append((names, goals))
        raise UnsafeCommand("the hand is in the way")

    with VirtualBus.of_robot(OP3) as bus:
        stands = [servo.motor.position for servo in bus.network.servos.values()]
        with pytest.raises(UnsafeCommand, match="in the way"):
            stream(trajectory, judged(trajectory), OP3, port=bus.port, safety=SAFETY, check_way=refuse)
        assert all(servo.goal_extremes is None and not servo.torque_on for servo in bus.network.servos.values())
        assert [servo.motor.position for servo in bus.network.servos.values()] == stands
    ((names, goals),) = seen
    assert names == OP3.joint_names
    assert np.allclose(goals[-1], trajectory.joint_pos[0], atol=1e-9)


def test_check_port() -> None:
    check_port("sim", OP3)
    with pytest.raises(PortError, match="/dev/nothing"):
        check_port("/dev/nothing", OP3)


def host(bus: VirtualBus, tmp_path: Path) -> subprocess.Popen[str]:
    """A process that streams for long; returns once the robot moves."""
    trajectory = motion(OP3, seconds=60)
    save_trajectory(tmp_path / "trajectory.npz", trajectory)
    save_verdict(tmp_path / "verdict.json", judged(trajectory))
    code = "import sys, tyro; from hw.cli import Stream; sys.exit(tyro.cli(Stream).run())"
    files = [str(tmp_path / "trajectory.npz"), str(tmp_path / "verdict.json")]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *files, "--servo", bus.port], cwd=ROOT, stderr=subprocess.PIPE, text=True
    )
    elbow = bus.servo(5)
    start = elbow.get("Present Position")
    wait_until(lambda: elbow.torque_on and abs(elbow.get("Present Position") - start) > 50, process)
    return process


def wait_until(done: Callable[[], bool], process: subprocess.Popen[str] | None = None) -> None:
    end = time.monotonic() + 120
    while not done():
        assert time.monotonic() < end, "waited in vain"
        if process is not None and process.poll() is not None:
            pytest.fail(f"the host ended: {process.stderr.read() if process.stderr else ''}")
        time.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGQUIT, signal.SIGTERM])
def test_an_interrupt_ends_with_torque_off(tmp_path: Path, number: signal.Signals) -> None:
    with VirtualBus.of_robot(OP3) as bus:
        process = host(bus, tmp_path)
        process.send_signal(number)
        process.communicate(timeout=120)
        assert process.returncode != 0
        servos = list(bus.network.servos.values())
        assert not any(servo.torque_on for servo in servos)
        assert all(servo.get("Bus Watchdog") == 0 for servo in servos)
        assert not any(servo.refusals for servo in servos)


def test_a_killed_host_leaves_servos_that_stop_by_themselves(tmp_path: Path) -> None:
    with VirtualBus.of_robot(OP3) as bus:
        process = host(bus, tmp_path)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate(timeout=120)
        servos = list(bus.network.servos.values())
        wait_until(lambda: all(servo.get("Bus Watchdog") == 0xFF for servo in servos))
        with bus.locked:
            for servo in servos:
                assert abs(servo.get("Goal Position") - servo.get("Present Position")) < 300
        still = [servo.get("Goal Position") for servo in servos]
        wait_until(lambda: not any(servo.get("Moving") for servo in servos))
        assert [servo.get("Goal Position") for servo in servos] == still
