"""The watch over readings and pace, without a bus."""

from dataclasses import replace

import numpy as np
import pytest

from hw.cycle import Reading
from hw.rig import Rig
from hw.safety import LostContact, Watch
from ros_free_stack.errors import BusFault, DeadlineFault, ServoFault
from ros_free_stack.robots import ServoSafety, load_robot

OP3 = load_robot("op3")
assert OP3.servos is not None
ROBOT = replace(OP3, servos=replace(OP3.servos, models={"l_el": "XL430-W250"}))
RIG = Rig.of_robot(ROBOT, only=("r_el", "l_el"))
SAFETY = ServoSafety(lost_after=3, late_after=4, current_s=0.03, following_s=0.03)
YES, NO, ZERO = np.ones(2, dtype=bool), np.zeros(2, dtype=bool), np.zeros(2)
GOOD = Reading(
    asked=YES, fresh=YES, age_s=ZERO, alert=NO, refusal=np.zeros(2, np.uint8), torque=YES, tripped=NO,
    error=np.zeros(2, np.uint8),
    position=ZERO, velocity=ZERO, current=ZERO, voltage=np.full(2, 12.0), temperature=np.full(2, 30.0),
)  # fmt: skip
SECOND = np.array([False, True])


def watch() -> Watch:
    return Watch(RIG, SAFETY, np.array([9.5, 11.0]))


@pytest.mark.parametrize(
    ("reading", "words"),
    [
        (replace(GOOD, alert=SECOND), "l_el .*alert, cause not yet read"),
        (replace(GOOD, error=np.array([0, 32], np.uint8)), "l_el .*overload"),
        (replace(GOOD, tripped=SECOND), "l_el .*watchdog tripped.*servos release"),
        (replace(GOOD, torque=~SECOND), "l_el .*torque went off by itself"),
        (replace(GOOD, temperature=np.array([69.0, 71.0])), "l_el .*71 deg C, limit 70 deg C"),
        (replace(GOOD, voltage=np.array([10.0, 10.0])), "l_el .*10.0 V, minimum 11.0 V"),
    ],
)
def test_one_bad_reading_is_enough(reading: Reading, words: str) -> None:
    with pytest.raises(ServoFault, match=words):
        watch().check(reading, ZERO)


@pytest.mark.parametrize(
    ("reading", "words"),
    [
        (replace(GOOD, current=np.array([2.1, 0.8])), r"r_el .*2.10 A for 0.03 s, limit 2 A for 0.03 s"),
        (replace(GOOD, current=np.array([1.9, -0.95])), r"l_el .*0.95 of full load for .*, limit 0.9 of full load"),
        (replace(GOOD, position=np.array([0.0, 0.6])), r"l_el .*following error 0.60 rad for 0.03 s, limit 0.5 rad"),
        (replace(GOOD, position=np.array([-0.6, 0.0])), r"r_el .*following error 0.60 rad for 0.03 s, limit 0.5 rad"),
    ],
)
def test_strain_counts_only_if_it_lasts(reading: Reading, words: str) -> None:
    judge = watch()
    for _ in range(3):
        judge.check(reading, ZERO)
    judge.check(GOOD, ZERO)
    for _ in range(3):
        judge.check(reading, ZERO)
    with pytest.raises(ServoFault, match=words):
        judge.check(reading, ZERO)


def test_a_servo_may_miss_some_readings_but_not_many_in_a_row() -> None:
    judge, missed = watch(), replace(GOOD, fresh=~SECOND)
    for reading in (missed, missed, GOOD, missed, missed):
        judge.check(reading, ZERO)
    assert judge.lost_replies == 4
    with pytest.raises(LostContact) as caught:
        judge.check(missed, ZERO)
    assert caught.value.suspects == (1,)


def test_a_servo_that_is_not_asked_is_not_missed() -> None:
    judge = watch()
    for _ in range(20):
        judge.check(replace(GOOD, fresh=NO, asked=NO), ZERO)
    assert judge.lost_replies == 0


def test_refusals_are_named() -> None:
    judge, refused = watch(), replace(GOOD, fresh=~SECOND, refusal=np.array([0, 7], np.uint8))
    judge.check(refused, ZERO)
    judge.check(refused, ZERO)
    with pytest.raises(BusFault, match=r"l_el .* refuses to be read: access"):
        judge.check(refused, ZERO)


def test_late_cycles_count_in_a_row_and_a_stall_at_once() -> None:
    judge = watch()
    for late in (0.009, 0.009, 0.009, 0.001, 0.009, 0.009, 0.009):
        judge.check_pace(late)
    with pytest.raises(DeadlineFault, match="4 cycles in a row were late: 125 Hz"):
        judge.check_pace(0.009)
    with pytest.raises(DeadlineFault, match=r"paused for 0.60 s, limit 0.5 s"):
        watch().check_pace(0.6)


@pytest.mark.parametrize("what", ["position", "current"])
def test_an_old_reading_is_not_judged_again(what: str) -> None:
    """Where a servo is read in every seventh cycle, one reading beside the goal is no fault that lasts."""
    judge = watch()
    bad = replace(GOOD, **{what: np.full(2, 2.5)})
    judge.check(bad, ZERO)
    for _ in range(100):
        judge.check(replace(bad, asked=NO, fresh=NO), ZERO)
    judge.check(GOOD, ZERO)
    judge.check(bad, ZERO)


def test_a_new_reading_speaks_for_the_time_since_the_last() -> None:
    judge = watch()
    for _ in range(4):
        judge.check(replace(GOOD, asked=NO, fresh=NO), ZERO)
    with pytest.raises(ServoFault, match=r"r_el .*following error 0.60 rad for 0.04 s"):
        judge.check(replace(GOOD, position=np.array([-0.6, 0.0])), ZERO)
