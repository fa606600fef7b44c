"""Servos that move one mechanism together: their torques go to a simulation, positions and velocities come back.

The simulation is any function, so that a robot in MuJoCo can hang on the emulated bus without either knowing the other.
"""

from collections.abc import Callable, Iterable, Mapping

from hw.virtual.servo import Servo

World = Callable[[float, Mapping[int, float]], Mapping[int, tuple[float, float]]]
"""Called with the time to pass (s, at most 2 ms) and the torque of each servo by id (N m, back electromotive force and
gear friction included); returns position (rad) and velocity (rad/s) of each servo's horn by id."""


def move_together(servos: Iterable[Servo], world: World, dt: float) -> None:
    """Let every servo drive for `dt` s, and the world answer."""
    duties = {servo.id: (servo, servo.drive(dt)) for servo in servos}
    states = world(dt, {key: servo.motor.torque(duty, servo.supply_voltage) for key, (servo, duty) in duties.items()})
    for key, (servo, duty) in duties.items():
        position, velocity = states[key]
        servo.motor.be_moved(position, velocity, duty=duty, voltage=servo.supply_voltage, dt=dt)
