"""Control tables read from the SDK's model files."""

import pytest
from dynamixel_easy_sdk.control_table import ControlTable as SdkTable

from hw.registers import control_table, model_name, model_names
from ros_free_stack.errors import UnknownName


@pytest.mark.parametrize("model", model_names())
def test_every_x_model_agrees_with_the_sdks_own_reader(model: str) -> None:
    table = control_table(model)
    theirs = SdkTable.getControlTable(table.number)
    assert {name: (r.address, r.size) for name, r in table.registers.items()} == {
        name: (item.address, item.size) for name, item in theirs.items()
    }
    assert model_name(table.number) == model


def test_the_servo_of_op3() -> None:
    table = control_table("XM430-W350")
    assert table.number == 1020
    assert table["Goal Position"].address == 116
    assert table["Goal Position"].signed
    assert table.rad_per_tick * 4096 == pytest.approx(2 * 3.14159265)
    assert [(b.address, b.data, b.count) for b in table.indirect_blocks] == [(168, 224, 28), (578, 634, 28)]


def test_access_follows_from_the_names() -> None:
    table = control_table("XM430-W350")
    assert table["Operating Mode"].eeprom and table["Operating Mode"].writable
    assert not table["Torque Enable"].eeprom
    for name in ("Present Position", "Hardware Error Status", "Model Number", "Moving"):
        assert not table[name].writable


def test_signed_values_survive() -> None:
    register = control_table("XM430-W350")["Goal Position"]
    for value in (-1_048_575, -1, 0, 1, 1_048_575):
        assert register.unpack(register.pack(value)) == value


def test_unknown_names_list_the_valid_ones() -> None:
    with pytest.raises(UnknownName, match="XM430-W350"):
        control_table("XM430-W351")
    with pytest.raises(UnknownName, match="Present Position"):
        control_table("XM430-W350")["Present Positon"]
    with pytest.raises(UnknownName, match="1020 \\(XM430-W350\\)"):
        model_name(4711)
