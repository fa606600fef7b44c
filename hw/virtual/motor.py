"""The physics of one geared DC servo motor: torque, speed, current, heat."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class MotorModel:
    """Data-sheet values at `nominal_voltage`; the defaults are those of the XM430-W350 at 12 V.

    Attributes:
        stall_torque: N m at the horn.
        no_load_speed: rad/s.
        stall_current: A.
        nominal_voltage: V.
        inertia: kg m^2 at the horn, rotor and gears included.
        friction: N m of Coulomb friction.
        heat_capacity: J/K of winding and case.
        thermal_resistance: K/W from the case to the room.
    """

    stall_torque: float = 4.1
    no_load_speed: float = 4.82
    stall_current: float = 2.3
    nominal_voltage: float = 12.0
    inertia: float = 0.01
    friction: float = 0.05
    heat_capacity: float = 60.0
    thermal_resistance: float = 5.0

    @property
    def resistance(self) -> float:
        """Ohm."""
        return self.nominal_voltage / self.stall_current


ROOM_TEMPERATURE = 25.0


@dataclass
class Motor:
    """State of one motor.

    Attributes:
        position: rad. velocity: rad/s. current: A. temperature: deg C.
        load: N m that the world exerts on the horn.
        jammed: the horn cannot move.
    """

    model: MotorModel
    position: float = 0.0
    velocity: float = 0.0
    current: float = 0.0
    temperature: float = 30.0
    load: float = 0.0
    jammed: bool = False

    def step(self, duty: float, voltage: float, dt: float) -> None:
        """Advance by `dt` s with the bridge at `duty` (-1 to 1, 0 brakes) of `voltage` V."""
        model = self.model
        drive = duty * voltage / model.nominal_voltage
        damping = model.stall_torque / model.no_load_speed
        self._move(model.stall_torque * drive + self.load, damping, dt)
        self._draw(drive, dt)

    def coast(self, dt: float) -> None:
        """Advance by `dt` s with the bridge open: only the gears' friction holds."""
        self._move(self.load, damping=self._gear_damping, dt=dt)
        self._rest(dt)

    def torque(self, duty: float | None, voltage: float) -> float:
        """N m at the horn, with the bridge at `duty` or (None) open."""
        model = self.model
        if duty is None:
            return -self._gear_damping * self.velocity
        drive = duty * voltage / model.nominal_voltage
        return model.stall_torque * (drive - self.velocity / model.no_load_speed)

    def be_moved(self, position: float, velocity: float, *, duty: float | None, voltage: float, dt: float) -> None:
        """Take position and velocity from a world that had the torque for `dt` s."""
        self.position, self.velocity = position, velocity
        if duty is None:
            self._rest(dt)
        else:
            self._draw(duty * voltage / self.model.nominal_voltage, dt)

    def duty_of(self, current: float) -> float:
        """The duty that draws `current` A at the present speed."""
        return current / self.model.stall_current + self.velocity / self.model.no_load_speed

    @property
    def _gear_damping(self) -> float:
        return 0.05 * self.model.stall_torque / self.model.no_load_speed

    def _draw(self, drive: float, dt: float) -> None:
        self.current = self.model.stall_current * (drive - self.velocity / self.model.no_load_speed)
        self._heat(dt)

    def _rest(self, dt: float) -> None:
        self.current = 0.0
        self._heat(dt)

    def _move(self, torque: float, damping: float, dt: float) -> None:
        # Damping is taken implicitly, so that any step is stable.
        model = self.model
        free = (self.velocity + dt / model.inertia * torque) / (1 + dt / model.inertia * damping)
        stopped_by_friction = dt / model.inertia * model.friction / (1 + dt / model.inertia * damping)
        velocity = math.copysign(max(0.0, abs(free) - stopped_by_friction), free)
        self.velocity = 0.0 if self.jammed else velocity
        self.position += dt * self.velocity

    def _heat(self, dt: float) -> None:
        model = self.model
        power = model.resistance * self.current**2 - (self.temperature - ROOM_TEMPERATURE) / model.thermal_resistance
        self.temperature += dt * power / model.heat_capacity
