"""Raw values and SI."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw.registers import control_table
from hw.units import scale, to_raw, to_si
from ros_free_stack.errors import UnsafeCommand

TABLE = control_table("XM430-W350")
NAMES = [name for name in TABLE.registers if not name.startswith("Indirect")]


@settings(deadline=None)
@given(st.sampled_from(NAMES), st.data())
def test_raw_values_survive_the_round_trip(name: str, data: st.DataObject) -> None:
    register = TABLE[name]
    raw = data.draw(st.integers(register.lowest // 2, register.highest // 2))
    assert to_raw(TABLE, name, to_si(TABLE, name, raw)) == raw


def test_known_values() -> None:
    assert to_si(TABLE, "Present Position", 2048) == 0
    assert to_si(TABLE, "Present Position", 3072) == pytest.approx(math.pi / 2)
    assert to_si(TABLE, "Present Position", 2048 - 3 * 4096) == pytest.approx(-6 * math.pi)
    assert to_si(TABLE, "Present Velocity", -100) == pytest.approx(-100 * 0.229 * 2 * math.pi / 60, rel=1e-3)
    assert to_si(TABLE, "Present Input Voltage", 119) == pytest.approx(11.9)
    assert to_si(TABLE, "Goal Current", 1193) == pytest.approx(3.21, abs=0.01)
    assert to_si(TABLE, "Bus Watchdog", 10) == pytest.approx(0.2)
    assert scale(TABLE, "LED")[2] == "raw"


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e9])
def test_what_a_register_cannot_hold_is_refused(value: float) -> None:
    with pytest.raises(UnsafeCommand, match="Goal Position"):
        to_raw(TABLE, "Goal Position", value)
