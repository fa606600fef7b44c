"""Checks of a physics playback against its reference."""

import numpy as np

from ros_free_stack.messages import Check, Floats
from ros_free_stack.robots import ServoMotor
from ros_free_stack.thresholds import Threshold
from sim.playback.physics import Playback
from sim.reference import Reference, body_points

ROOM_C = 25.0


def fall_height(playback: Playback, threshold: Threshold) -> Check:
    """Greatest error of the torso's height in m (BeyondMimic ends an episode at 0.25 m)."""
    frame = int(np.argmax(playback.height_error))
    return threshold.check(
        "fall_height",
        playback.height_error[frame],
        "How far the torso drops from where it should be: beyond the limit the robot has fallen.",
        worst_frame=frame,
    )


def fall_orientation(playback: Playback, threshold: Threshold) -> Check:
    """Greatest error of gravity along the torso's z axis, 0 upright to 2 (BeyondMimic ends at 0.8)."""
    frame = int(np.argmax(playback.orientation_error))
    return threshold.check(
        "fall_orientation",
        playback.orientation_error[frame],
        "How far the torso tilts from how it should stand: beyond the limit the robot has fallen.",
        worst_frame=frame,
    )


def mpjpe_global(reference: Reference, playback: Playback, threshold: Threshold) -> Check:
    """Mean distance in m between where the robot's joints are and should be, in the world (MPJPE)."""
    error = _point_errors(reference, playback, own_frame=False)
    return threshold.check(
        "mpjpe_global",
        error.mean(),
        "How far the body is from the planned motion on average, drift over the floor included.",
        worst_frame=int(np.argmax(error)),
    )


def mpjpe_relative(reference: Reference, playback: Playback, threshold: Threshold) -> Check:
    """The same distance in the frame of the root body, so that only the pose counts."""
    error = _point_errors(reference, playback, own_frame=True)
    return threshold.check(
        "mpjpe_relative",
        error.mean(),
        "How far the pose is from the planned pose on average.",
        worst_frame=int(np.argmax(error)),
    )


def joint_velocity_error(reference: Reference, playback: Playback, threshold: Threshold) -> Check:
    """Root mean square over joints and frames of simulated minus planned joint velocity, rad/s."""
    planned = np.zeros_like(playback.joint_vel)
    if len(reference.qpos) > 1:
        planned = np.gradient(reference.trajectory.joint_pos, reference.dt, axis=0)[: playback.frames]
    by_frame = np.sqrt(((playback.joint_vel - planned) ** 2).mean(axis=1))
    return threshold.check(
        "joint_velocity_error",
        np.sqrt((by_frame**2).mean()),
        "How far joint speeds are from the planned ones.",
        worst_frame=int(np.argmax(by_frame)),
    )


def torque_peak(reference: Reference, playback: Playback, threshold: Threshold) -> Check:
    """Greatest torque that the motion needs (inverse dynamics with floor forces) over the servo's stall torque.

    On servos with a speed-torque line, tau <= tau_stall (1 - v / v_no_load), the share of the stall torque that speed
    costs counts as needed too: tau / tau_stall + v / v_no_load <= 1 is that line. Braking gains the same share.
    """
    robot = reference.robot
    ratio = playback.needed / robot.effort
    frame, joint = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    return threshold.check(
        "torque_peak",
        ratio[frame, joint],
        "The highest torque that the motion needs of a servo as a share of what it has.",
        worst_frame=int(frame),
        worst_item=robot.joint_names[int(joint)],
    )


def torque_saturation(reference: Reference, playback: Playback, threshold: Threshold) -> Check:
    """Share of the time that the busiest servo spent at its torque limit in the playback."""
    joint = int(np.argmax(playback.saturated.mean(axis=0)))
    share = playback.saturated[:, joint]
    return threshold.check(
        "torque_saturation",
        share.mean(),
        "How much of the time the busiest servo gave all it has.",
        worst_frame=int(np.argmax(share)),
        worst_item=reference.robot.joint_names[joint] if share.any() else "",
    )


def power_peak(reference: Reference, playback: Playback, threshold: Threshold) -> Check:
    """Highest electrical power that all servos draw together over what the supply gives.

    Voltage of a servo times its current, summed over those that draw any: `sim.playback.physics` says how. Only for
    robots whose description has the motor's figures.
    """
    share = playback.power / motor(reference).supply_power
    return threshold.check(
        "power_peak",
        share.max(),
        "The most power that all servos together draw as a share of what the supply gives.",
        worst_frame=int(np.argmax(share)),
    )


def servo_heat(reference: Reference, playback: Playback, threshold: Threshold) -> Check:
    """Warming of the hottest servo over the clip as a share of what it may warm by.

    C dT/dt = I^2 R - T / R_th from room temperature (25 deg C), against the temperature at which a stream stops
    (`servo_safety`). Only for robots whose description has the motor's figures.
    """
    servos = reference.robot.servos
    allowed = (servos.safety.temperature if servos else np.inf) - ROOM_C
    joint = int(np.argmax(playback.heating.max(axis=0)))
    warmed = playback.heating[:, joint]
    return threshold.check(
        "servo_heat",
        warmed.max() / allowed,
        "How much the hottest servo warms as a share of what it may.",
        worst_frame=int(np.argmax(warmed)),
        worst_item=reference.robot.joint_names[joint],
    )


def motor(reference: Reference) -> ServoMotor:
    """The robot's motor; ValueError where its description has none."""
    found = reference.robot.servos.motor if reference.robot.servos else None
    if found is None:
        raise ValueError(f"{reference.robot.name} has no motor figures in its description")
    return found


def _point_errors(reference: Reference, playback: Playback, *, own_frame: bool) -> Floats:
    """(N,) mean distance in m over the attachment points."""
    frames = playback.frames
    root = reference.model.body(reference.robot.root_body).id
    distances: list[Floats] = []
    for joint, item in reference.robot.attachments.items():
        planned = reference.attachments[joint][:frames]
        actual = body_points(reference.model, playback.body_pos, playback.body_rot, item.body, (item.offset,))[:, 0]
        if own_frame:
            planned = _into(planned, reference.body_pos[:frames, root], reference.body_rot[:frames, root])
            actual = _into(actual, playback.body_pos[:, root], playback.body_rot[:, root])
        distances.append(np.linalg.norm(planned - actual, axis=1))
    return np.mean(distances, axis=0)


def _into(points: Floats, origin: Floats, rotation: Floats) -> Floats:
    """World points (T, 3) in frames at `origin` (T, 3) with `rotation` (T, 3, 3)."""
    return np.einsum("tji,tj->ti", rotation, points - origin)
