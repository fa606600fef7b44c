"""A servo's control table as bytes, with the firmware's rules of access.

Source of the rules: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0" (error field) and the X series' control tables.
"""

from dataclasses import dataclass

from hw.protocol import StatusError
from hw.registers import ControlTable, Register
from hw.virtual.factory import CHOICES, CURRENT, CURRENT_POSITION, MULTI_TURN, POSITION

WATCHDOG_TRIPPED = 0xFF
GOALS = frozenset({"Goal PWM", "Goal Current", "Goal Velocity", "Goal Position"})
_LIMITED_BY = {"Goal PWM": "PWM Limit", "Goal Current": "Current Limit", "Goal Velocity": "Velocity Limit"}


class Refused(Exception):
    """An instruction that the firmware answers with an error code."""

    def __init__(self, code: StatusError) -> None:
        super().__init__(code.name)
        self.code = code


@dataclass(frozen=True)
class Refusal:
    """A write that did not happen."""

    address: int
    data: bytes
    code: StatusError


@dataclass(frozen=True)
class Change:
    """One stretch of bytes that a write sets; `register` is None where it is a mapping or spare indirect data."""

    address: int
    data: bytes
    register: Register | None


class Memory:
    """The bytes of a control table.

    Attributes:
        table: names, addresses and sizes.
        data: the bytes.
        ram: first address that is lost without power, and that indirect addresses may point to.
    """

    def __init__(self, table: ControlTable) -> None:
        self.table = table
        self.data = bytearray(table.size)
        self.ram = table["Torque Enable"].address
        plain = (register for register in table.registers.values() if not register.name.startswith("Indirect"))
        self._plain = {register.address: register for register in plain}
        self._owned = {a for register in self._plain.values() for a in range(register.address, register.end)}
        self._mirror = {
            block.data + i: block.address + 2 * i for block in table.indirect_blocks for i in range(block.count)
        }
        self._mapping = {a for b in table.indirect_blocks for a in range(b.address, b.address + 2 * b.count)}

    # By name, without the firmware's rules.

    def get(self, name: str) -> int:
        """Raw value of a register."""
        register = self.table[name]
        return register.unpack(self.data[register.address : register.end])

    def set(self, name: str, value: int) -> None:
        """Set a register from inside, without access rules."""
        register = self.table[name]
        self.data[register.address : register.end] = register.pack(value)

    def clear_ram(self) -> None:
        """Zero the RAM area and point every indirect address at its own data."""
        self.data[self.ram :] = bytes(len(self.data) - self.ram)
        for data, address in self._mirror.items():
            self.data[address : address + 2] = data.to_bytes(2, "little")

    def backed_up(self) -> list[slice]:
        """What a Control Table Backup covers: EEPROM, gains, profile, indirect addresses."""
        gains = slice(self.table["Velocity I Gain"].address, self.table["Feedforward 1st Gain"].end)
        profile = slice(self.table["Profile Acceleration"].address, self.table["Profile Velocity"].end)
        mappings = [slice(b.address, b.address + 2 * b.count) for b in self.table.indirect_blocks]
        return [slice(0, self.ram), gains, profile, *mappings]

    # As an instruction packet has it.

    def read(self, address: int, length: int) -> bytes:
        """Read bytes; Refused beyond the table."""
        if length == 0 or length > len(self.data):
            raise Refused(StatusError.DATA_LENGTH)
        if address + length > len(self.data):
            raise Refused(StatusError.ACCESS)
        if address not in self._mirror and address + length - 1 not in self._mirror:
            return bytes(self.data[address : address + length])
        return bytes(self.data[self._resolve(a)] for a in range(address, address + length))

    def apply(self, changes: list[Change]) -> None:
        """Set what `plan` allowed."""
        for change in changes:
            self.data[change.address : change.address + len(change.data)] = change.data

    def plan(self, address: int, data: bytes) -> list[Change]:
        """The changes that a write makes; Refused, with the firmware's error code, where one is not allowed."""
        if not data:
            raise Refused(StatusError.DATA_LENGTH)
        changes: list[Change] = []
        offset = 0
        while offset < len(data):
            start = self._resolve(address + offset)
            register = self._plain.get(start)
            if register is not None:
                size = register.size
                piece = data[offset : offset + size]
                whole = all(self._resolve(address + offset + i) == start + i for i in range(1, size))
                if len(piece) < size or not whole:
                    raise Refused(StatusError.DATA_LENGTH)
                self._check(register, register.unpack(piece))
            elif start in self._owned:
                raise Refused(StatusError.DATA_LENGTH)
            elif start in self._mapping:
                self._check_mapping(data[offset : offset + 2], start)
                size = 2
            elif start in self._mirror:
                size = 1
            else:
                raise Refused(StatusError.ACCESS)
            changes.append(Change(start, data[offset : offset + size], register))
            offset += size
        return changes

    def _resolve(self, address: int) -> int:
        """Where an address leads: indirect data lead to the address that their indirect address holds."""
        pointer = self._mirror.get(address)
        if pointer is None:
            return address
        target = int.from_bytes(self.data[pointer : pointer + 2], "little")
        return target if target < len(self.data) else address

    def _check_mapping(self, piece: bytes, start: int) -> None:
        if start % 2 or len(piece) < 2:
            raise Refused(StatusError.DATA_LENGTH)
        if self.get("Torque Enable"):
            raise Refused(StatusError.ACCESS)
        if not self.ram <= int.from_bytes(piece, "little") < len(self.data):
            raise Refused(StatusError.DATA_RANGE)

    def _check(self, register: Register, value: int) -> None:
        name = register.name
        if not register.writable or (register.eeprom and self.get("Torque Enable")):
            raise Refused(StatusError.ACCESS)
        if name in CHOICES and value not in CHOICES[name]:
            raise Refused(StatusError.DATA_RANGE)
        if name == "Operating Mode" and value in (CURRENT, CURRENT_POSITION) and "Goal Current" not in self.table:
            raise Refused(StatusError.DATA_RANGE)
        if name in GOALS and self.get("Bus Watchdog") == WATCHDOG_TRIPPED:
            raise Refused(StatusError.DATA_RANGE)
        if name == "Torque Enable" and value and self.get("Hardware Error Status") & self.get("Shutdown"):
            raise Refused(StatusError.RESULT_FAIL)
        if name == "Goal Position":
            self._check_position(value)
        limit = _LIMITED_BY.get(name)
        if limit is not None and limit in self.table and abs(value) > self.get(limit):
            raise Refused(StatusError.DATA_LIMIT)

    def _check_position(self, value: int) -> None:
        low, high = -MULTI_TURN, MULTI_TURN
        if self.get("Operating Mode") == POSITION:
            low, high = self.get("Min Position Limit"), self.get("Max Position Limit")
        if not low <= value <= high:
            raise Refused(StatusError.DATA_LIMIT)
