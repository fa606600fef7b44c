"""The emulated servo against the e-Manual's rules."""

import pytest

from hw.protocol import StatusError
from hw.registers import control_table, model_names
from hw.units import to_raw, to_si
from hw.virtual.memory import WATCHDOG_TRIPPED, Refused
from hw.virtual.servo import INPUT_VOLTAGE, OVERHEATING, OVERLOAD, Servo


def make(**options: object) -> Servo:
    return Servo.make(1, **options)  # type: ignore[arg-type]


def write(servo: Servo, name: str, value: int) -> None:
    register = servo.table[name]
    servo.write(register.address, register.pack(value))


def run(servo: Servo, seconds: float) -> None:
    for _ in range(round(seconds / 0.008)):
        servo.hear()
        servo.advance(0.008)


def refusal(servo: Servo, name: str, value: int) -> StatusError:
    with pytest.raises(Refused) as caught:
        write(servo, name, value)
    assert servo.refusals[-1].code == caught.value.code
    return caught.value.code


@pytest.mark.parametrize("model", [name for name in model_names() if name != "XL320"])
def test_every_model_moves_to_its_goal(model: str) -> None:
    servo = Servo.make(1, model=model)
    write(servo, "Torque Enable", 1)
    write(servo, "Goal Position", 2500)
    run(servo, 1.5)
    assert abs(servo.get("Present Position") - 2500) <= 3
    assert servo.get("Model Number") == control_table(model).number


def test_access_rules() -> None:
    servo = make()
    assert refusal(servo, "Present Position", 5) == StatusError.ACCESS
    assert refusal(servo, "Operating Mode", 2) == StatusError.DATA_RANGE
    assert refusal(servo, "Goal Position", 4096) == StatusError.DATA_LIMIT
    write(servo, "Torque Enable", 1)
    assert refusal(servo, "Operating Mode", 4) == StatusError.ACCESS
    assert refusal(servo, "Goal Current", 1194) == StatusError.DATA_LIMIT
    assert refusal(servo, "Torque Enable", 2) == StatusError.DATA_RANGE
    address = servo.table["Goal Position"].address
    for data in (b"", b"\1\2", b"\1\2\3\4\5"):
        with pytest.raises(Refused):
            servo.write(address, data)
    with pytest.raises(Refused):
        servo.read(len(servo.memory) - 1, 2)


def test_a_refused_write_changes_nothing() -> None:
    servo = make()
    register = servo.table["Profile Velocity"]
    goal = servo.table["Goal Position"]
    before = bytes(servo.memory)
    with pytest.raises(Refused):
        servo.write(register.address, register.pack(7) + goal.pack(9999))
    assert bytes(servo.memory) == before


def test_indirect_addresses() -> None:
    servo = make()
    block, led, goal = servo.table.indirect_blocks[0], servo.table["LED"], servo.table["Goal Position"]
    addresses = [led.address, *range(goal.address, goal.end)]
    servo.write(block.address, b"".join(a.to_bytes(2, "little") for a in addresses))
    servo.write(block.data, b"\x01" + goal.pack(3000))
    assert servo.get("LED") == 1
    assert servo.get("Goal Position") == 3000
    assert servo.read(block.data, 5) == b"\x01" + goal.pack(3000)
    with pytest.raises(Refused):
        servo.write(block.data, b"\x01" + goal.pack(5000))
    write(servo, "Torque Enable", 1)
    with pytest.raises(Refused) as caught:
        servo.write(block.address, (65).to_bytes(2, "little"))
    assert caught.value.code == StatusError.ACCESS


def test_watchdog_trips_holds_and_is_cleared_on_purpose() -> None:
    servo = make()
    write(servo, "Torque Enable", 1)
    write(servo, "Bus Watchdog", 5)
    write(servo, "Goal Position", 4000)
    for _ in range(40):
        servo.advance(0.008)
    assert servo.get("Bus Watchdog") == WATCHDOG_TRIPPED
    stopped = servo.get("Present Position")
    assert 2048 < stopped < 3900
    run(servo, 0.5)
    assert abs(servo.get("Present Position") - servo.get("Goal Position")) < 40
    assert refusal(servo, "Goal Position", 3000) == StatusError.DATA_RANGE
    write(servo, "Bus Watchdog", 0)
    write(servo, "Goal Position", 3000)
    run(servo, 1.0)
    assert abs(servo.get("Present Position") - 3000) <= 3


def test_motor_reaches_its_data_sheet() -> None:
    servo = make()
    write(servo, "Operating Mode", 16)
    write(servo, "Torque Enable", 1)
    write(servo, "Goal PWM", 885)
    run(servo, 1.0)
    assert servo.motor.velocity == pytest.approx(4.82, rel=0.03)
    servo.motor.jammed = True
    run(servo, 0.1)
    assert servo.motor.current == pytest.approx(2.3, rel=0.01)


def test_overload_and_heat_shut_the_servo_down_until_it_reboots() -> None:
    servo = make()
    servo.motor.jammed = True
    write(servo, "Torque Enable", 1)
    write(servo, "Goal Position", 4000)
    run(servo, 3.0)
    assert servo.get("Hardware Error Status") & OVERLOAD
    assert servo.alert and not servo.torque_on
    assert refusal(servo, "Torque Enable", 1) == StatusError.RESULT_FAIL
    servo.reboot(0.0)
    servo.motor.jammed = False
    write(servo, "Torque Enable", 1)
    servo.motor.temperature = 81.0
    run(servo, 0.1)
    assert servo.get("Hardware Error Status") & OVERHEATING
    assert not servo.torque_on


def test_low_voltage_alerts_but_holds() -> None:
    servo = make()
    write(servo, "Torque Enable", 1)
    servo.supply_voltage = 9.0
    run(servo, 0.1)
    assert servo.alert and servo.torque_on


def test_profile_limits_speed_and_acceleration() -> None:
    servo = make()
    table = servo.table
    write(servo, "Profile Velocity", to_raw(table, "Profile Velocity", 1.0))
    write(servo, "Profile Acceleration", to_raw(table, "Profile Acceleration", 5.0))
    write(servo, "Torque Enable", 1)
    write(servo, "Goal Position", 4000)
    speeds = []
    for _ in range(500):
        servo.advance(0.008)
        speeds.append(to_si(table, "Present Velocity", servo.get("Present Velocity")))
    assert max(speeds) == pytest.approx(1.0, abs=0.1)
    assert abs(servo.get("Present Position") - 4000) <= 3


def test_current_limits_the_force_of_current_based_position() -> None:
    servo = make()
    write(servo, "Operating Mode", 5)
    write(servo, "Goal Current", to_raw(servo.table, "Goal Current", 0.5))
    write(servo, "Torque Enable", 1)
    servo.motor.jammed = True
    write(servo, "Goal Position", 4000)
    run(servo, 0.5)
    assert servo.motor.current == pytest.approx(0.5, abs=0.02)


def test_reboot_keeps_eeprom_and_loses_ram() -> None:
    servo = make()
    write(servo, "Max Position Limit", 3000)
    write(servo, "Position P Gain", 400)
    write(servo, "LED", 1)
    servo.reboot(0.1)
    assert not servo.answering
    servo.advance(0.2)
    assert servo.answering
    assert (servo.get("Max Position Limit"), servo.get("Position P Gain"), servo.get("LED")) == (3000, 800, 0)
    assert servo.id == 1


def test_reverse_mode_turns_everything_around() -> None:
    plain, reverse = make(), make()
    write(reverse, "Drive Mode", 1)
    for servo in (plain, reverse):
        write(servo, "Torque Enable", 1)
        write(servo, "Goal Position", 2500)
        run(servo, 1.0)
        assert abs(servo.get("Present Position") - 2500) <= 3
    assert reverse.motor.position == pytest.approx(-plain.motor.position, abs=0.01)
    write(reverse, "Goal Position", 3500)
    reverse.advance(0.05)
    assert reverse.motor.velocity < 0
    assert reverse.get("Present Velocity") > 0 and reverse.get("Present Current") > 0


def test_time_based_profile_arrives_in_time() -> None:
    servo = make()
    write(servo, "Drive Mode", 4)
    write(servo, "Profile Velocity", 1000)
    write(servo, "Profile Acceleration", 300)
    write(servo, "Torque Enable", 1)
    write(servo, "Goal Position", 3000)
    run(servo, 0.5)
    assert servo.get("Position Trajectory") == pytest.approx((2048 + 3000) / 2, abs=20)
    assert servo.get("Moving Status") & 0b110010 == 0b110010
    assert servo.get("Moving") == 1
    run(servo, 0.7)
    assert abs(servo.get("Present Position") - 3000) <= 3
    assert (servo.get("Moving"), servo.get("Moving Status")) == (0, 1)


def test_torque_on_by_goal_update() -> None:
    servo = make()
    write(servo, "Drive Mode", 8)
    write(servo, "Goal Position", 2200)
    assert servo.torque_on
    servo.fail(OVERLOAD)
    write(servo, "Goal Position", 2300)
    assert not servo.torque_on


def test_velocity_and_current_modes() -> None:
    servo = make()
    write(servo, "Operating Mode", 1)
    write(servo, "Torque Enable", 1)
    write(servo, "Profile Acceleration", to_raw(servo.table, "Profile Acceleration", 2.0))
    write(servo, "Goal Velocity", to_raw(servo.table, "Goal Velocity", 2.0))
    run(servo, 0.5)
    assert servo.motor.velocity == pytest.approx(1.0, abs=0.15)
    run(servo, 1.5)
    assert servo.motor.velocity == pytest.approx(2.0, abs=0.1)
    write(servo, "Torque Enable", 0)
    write(servo, "Operating Mode", 0)
    servo.motor.jammed = True
    write(servo, "Torque Enable", 1)
    write(servo, "Goal Current", to_raw(servo.table, "Goal Current", 0.7))
    run(servo, 0.2)
    assert servo.motor.current == pytest.approx(0.7, abs=0.01)


def test_extended_position_turns_more_than_once_and_forgets_turns_on_reboot() -> None:
    servo = make()
    write(servo, "Operating Mode", 4)
    assert refusal(servo, "Goal Position", 1_048_576) == StatusError.DATA_LIMIT
    write(servo, "Torque Enable", 1)
    write(servo, "Goal Position", 9000)
    run(servo, 4.0)
    assert abs(servo.get("Present Position") - 9000) <= 3
    servo.reboot(0.0)
    assert abs(servo.get("Present Position") - 9000 % 4096) <= 3


def test_goal_pwm_bounds_the_output_of_every_mode() -> None:
    servo = make()
    write(servo, "Torque Enable", 1)
    write(servo, "Goal PWM", 177)
    write(servo, "Goal Position", 4000)
    run(servo, 0.3)
    assert servo.get("Present PWM") == 177
    assert servo.motor.velocity == pytest.approx(0.2 * 4.82, abs=0.1)
    assert refusal(servo, "Goal PWM", 886) == StatusError.DATA_LIMIT


def test_shutdown_mask_decides_what_goes_limp() -> None:
    servo = make()
    write(servo, "Shutdown", INPUT_VOLTAGE)
    write(servo, "Torque Enable", 1)
    servo.fail(OVERLOAD)
    assert servo.torque_on and servo.alert
    servo.supply_voltage = 9.0
    run(servo, 0.02)
    assert not servo.torque_on


def test_a_heavy_current_heats_the_motor() -> None:
    servo = make()
    servo.motor.jammed = True
    write(servo, "Operating Mode", 16)
    write(servo, "Shutdown", 0)
    write(servo, "Torque Enable", 1)
    write(servo, "Goal PWM", 600)
    before = servo.get("Present Temperature")
    for _ in range(60):
        servo.hear()
        servo.advance(1.0)
    assert servo.get("Present Temperature") > before + 8


def test_every_goal_is_kept_and_judged() -> None:
    servo = make()
    write(servo, "Min Position Limit", 1000)
    write(servo, "Max Position Limit", 3000)
    for value in (1500, 2500):
        write(servo, "Goal Position", value)
    assert refusal(servo, "Goal Position", 3001) == StatusError.DATA_LIMIT
    assert list(servo.goals.values) == [1500, 2500, 3001]
    assert servo.goals.outside == 1
    assert servo.goal_extremes == (1500, 2500)
    assert servo.goals.beyond(1500, 2400) == 2


def test_models_differ_in_voltage_and_modes() -> None:
    small, plain = make(model="XL330-M288"), make(model="XL430-W250")
    run(small, 0.1)
    assert small.get("Present Input Voltage") == 50 and not small.alert
    assert refusal(plain, "Operating Mode", 5) == StatusError.DATA_RANGE
