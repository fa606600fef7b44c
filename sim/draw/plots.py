"""The plots of the report: joints against their limits, feet over the floor, torques, and what servos really did."""

from typing import Any, Literal

import numpy as np

from ros_free_stack.messages import Floats, ServoTelemetry
from sim.playback.physics import Playback
from sim.reference import Reference

PLANNED, SIMULATED, LIMIT, GRID = "#0f766e", "#7c3aed", "#dc2626", "#d1d5db"
"""Not the colours of left and right, which mean a side in every picture."""
_COLUMNS = 5


def _figure(width: float, height: float, layout: Literal["constrained"] | None = "constrained") -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout=layout)
    FigureCanvasAgg(figure)
    return figure


def joints_plot(reference: Reference) -> Any:
    """Every joint's position over time, in rad, with its range as red lines."""
    robot, positions = reference.robot, reference.trajectory.joint_pos
    times = np.arange(len(positions)) * reference.dt
    figure, axes = _joint_axes(robot.joint_names)
    for index, (axis, limits) in enumerate(zip(axes, robot.joints.values(), strict=True)):
        axis.axhline(limits.lower, color=LIMIT, lw=0.8)
        axis.axhline(limits.upper, color=LIMIT, lw=0.8)
        axis.plot(times, positions[:, index], color=PLANNED, lw=1.2)
    return figure


def servo_angles_plot(telemetry: ServoTelemetry) -> Any:
    """Every streamed joint's commanded and measured angle over time, in rad."""
    figure, axes = _joint_axes(telemetry.joint_names)
    for index, axis in enumerate(axes):
        axis.plot(telemetry.time_s, telemetry.goal[:, index], color=PLANNED, lw=1.2)
        axis.plot(telemetry.time_s, telemetry.position[:, index], color=SIMULATED, lw=0.9)
        _span(axis, 0.2)
    return figure


def servo_health_plot(telemetry: ServoTelemetry) -> Any:
    """Current and temperature of the servos, the busiest of each by name, and how late each cycle began."""
    figure = _figure(14, 2.6)
    current, temperature, jitter = figure.subplots(1, 3)
    for axis, values, title, span in (
        (current, np.abs(telemetry.current), "current, A", 0.2),
        (temperature, telemetry.temperature, "temperature, deg C", 10.0),
    ):
        _all_and_highest(axis, telemetry, values)
        _span(axis, span)
        axis.set_title(title, fontsize=9)
    jitter.plot(telemetry.time_s, 1e3 * telemetry.late_s, color=PLANNED, lw=0.8)
    jitter.set_title("lateness of each cycle, ms", fontsize=9)
    jitter.set_ylim(bottom=0)
    _plain(jitter)
    figure.supxlabel("s", fontsize=8)
    return figure


def _all_and_highest(axis: Any, telemetry: ServoTelemetry, values: Floats) -> None:
    highest = int(values.max(axis=0).argmax())
    axis.plot(telemetry.time_s, values, color=GRID, lw=0.6)
    axis.plot(telemetry.time_s, values[:, highest], color=SIMULATED, lw=1.0, label=telemetry.joint_names[highest])
    axis.legend(fontsize=7, frameon=False)
    _plain(axis)


def _span(axis: Any, least: float) -> None:
    """Show at least this much, so that a rounding error does not look like a motion."""
    low, high = axis.get_ylim()
    if high - low < least:
        middle = (low + high) / 2
        axis.set_ylim(middle - least / 2, middle + least / 2)


def _joint_axes(names: tuple[str, ...]) -> tuple[Any, Any]:
    """A figure with one small plot a joint, in rad over s."""
    rows = -(-len(names) // _COLUMNS)
    figure = _figure(14, 1.35 * rows, layout=None)  # laying out dozens of axes by constraints takes seconds
    axes = figure.subplots(rows, _COLUMNS, sharex=True, squeeze=False).ravel()
    figure.subplots_adjust(0.05, 0.4 / (1.35 * rows), 0.99, 1 - 0.2 / (1.35 * rows), 0.2, 0.45)
    for axis in axes[len(names) :]:
        axis.set_visible(False)
    for axis, name in zip(axes, names, strict=False):
        axis.set_title(name.removesuffix("_joint"), fontsize=8, pad=2)
        _plain(axis)
    figure.supylabel("rad", fontsize=8)
    figure.supxlabel("s", fontsize=8)
    return figure, axes[: len(names)]


def feet_plot(reference: Reference, playback: Playback | None) -> Any:
    """Height of each sole's lowest corner in cm, shaded while the foot should stand; floor force where simulated."""
    feet = reference.robot.foot_names
    times = np.arange(len(reference.qpos)) * reference.dt
    figure = _figure(14, 2.6)
    axes = figure.subplots(1, len(feet), sharey=True, squeeze=False).ravel()
    for index, (axis, foot) in enumerate(zip(axes, feet, strict=True)):
        height = 100 * reference.soles[foot][..., 2].min(axis=1)
        planted = reference.trajectory.contacts[:, index]
        axis.fill_between(times, 0, 1, where=planted, transform=axis.get_xaxis_transform(), color=PLANNED,
                          alpha=0.1, lw=0, label="should stand")  # fmt: skip
        axis.axhline(0, color=GRID, lw=1)
        axis.plot(times, height, color=PLANNED, label="height, cm")
        axis.set_ylim(-1, max(3.0, 1.1 * float(height.max())))
        axis.set_title(f"{foot} sole", fontsize=9)
        _plain(axis)
        if playback is not None:
            force = axis.twinx()
            force.plot(times[: playback.frames], playback.contact_force[:, index], color=SIMULATED, lw=0.9)
            force.set_ylabel("simulated force, N", color=SIMULATED, fontsize=8)
            _plain(force)
    axes[0].set_ylabel("planned height, cm", color=PLANNED, fontsize=8)
    return figure


def torque_plot(reference: Reference, playback: Playback, limit: float) -> Any:
    """One bar a servo: the greatest torque that the motion needs of it over what it has, with the verdict's limit."""
    robot = reference.robot
    share = playback.needed.max(axis=0) / robot.effort
    figure = _figure(14, 2.8)
    axis = figure.subplots()
    names = [name.removesuffix("_joint") for name in robot.joint_names]
    axis.bar(names, share, color=[LIMIT if value > limit else PLANNED for value in share])
    axis.axhline(limit, color=LIMIT, lw=0.8)
    axis.set_ylim(0, max(1.1 * limit, 1.05 * float(share.max())))
    axis.set_ylabel("share of stall torque", fontsize=8)
    axis.tick_params(axis="x", rotation=60)
    _plain(axis)
    return figure


def _plain(axis: Any) -> None:
    axis.tick_params(labelsize=7, length=2)
    axis.grid(visible=False)
    for spine in axis.spines.values():
        spine.set_color(GRID)
