"""Control tables by name, read from the `.model` files that dynamixel-sdk installs: no address is written here.

The files give address, size and, for some registers, unit and scale. What they leave out follows from the names:
registers that report (Present ..., Moving, ...) are read-only, and everything before "Torque Enable" is EEPROM.
"""

from dataclasses import dataclass
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable

from ros_free_stack.errors import InvalidFile, UnknownName

_READ_ONLY = frozenset(
    {"Model Number", "Model Information", "Firmware Version", "Registered Instruction", "Hardware Error Status",
     "Realtime Tick", "Moving", "Moving Status", "Velocity Trajectory", "Position Trajectory"}
)  # fmt: skip
_SIGNED = frozenset(
    {"Homing Offset", "Goal PWM", "Goal Current", "Goal Velocity", "Goal Position", "Present PWM", "Present Load",
     "Present Current", "Present Velocity", "Present Position", "Velocity Trajectory", "Position Trajectory"}
)  # fmt: skip
_CANONICAL = {"BUS Watchdog": "Bus Watchdog", "Secondary ID": "Secondary(Shadow) ID"}
"""What the files of some models call a register that all others call by another name."""
_OLDER = "_fw"
"""Mark of the file that holds for a model's firmware up to the version that follows."""
_USUAL_FIRMWARE = 52
_FAMILIES = ("X", "2X", "MX")
_UNLIKE = frozenset({"XL320"})
"""Of these letters, but with registers, units and modes of its own."""


@dataclass(frozen=True)
class Register:
    """One entry of a control table.

    Attributes:
        name: as in the ROBOTIS e-Manual.
        address: first byte.
        size: bytes, little endian.
        signed: two's complement.
        writable: whether a Write may change it.
        eeprom: kept without power; locked while torque is on.
    """

    name: str
    address: int
    size: int
    signed: bool
    writable: bool
    eeprom: bool

    @property
    def end(self) -> int:
        return self.address + self.size

    @property
    def lowest(self) -> int:
        return -(1 << (8 * self.size - 1)) if self.signed else 0

    @property
    def highest(self) -> int:
        return (1 << (8 * self.size - self.signed)) - 1

    def pack(self, value: int) -> bytes:
        """Raw value to bytes; OverflowError where it does not fit."""
        return int(value).to_bytes(self.size, "little", signed=self.signed)

    def unpack(self, data: bytes | bytearray) -> int:
        """Bytes to raw value."""
        return int.from_bytes(data, "little", signed=self.signed)


@dataclass(frozen=True)
class IndirectBlock:
    """Registers that mirror others: `count` addresses of 2 bytes at `address`, their data bytes at `data`."""

    address: int
    data: int
    count: int


@dataclass(frozen=True)
class ControlTable:
    """The control table of one servo model.

    Attributes:
        model: ROBOTIS's name, e.g. "XM430-W350".
        number: model number, as a ping reports it.
        firmware: a version that it holds for: the last one of an older table.
        registers: by name.
        zero_position: raw position of 0 rad.
        rad_per_tick: rad of one position unit.
        scales: register name to (SI value of one unit, unit), as far as the file knows.
    """

    model: str
    number: int
    firmware: int
    registers: dict[str, Register]
    zero_position: int
    rad_per_tick: float
    scales: dict[str, tuple[float, str]]

    def __getitem__(self, name: str) -> Register:
        if name not in self.registers:
            raise UnknownName(f"register of {self.model}", name, self.registers)
        return self.registers[name]

    def __contains__(self, name: str) -> bool:
        return name in self.registers

    @property
    def size(self) -> int:
        """One past the last address."""
        plain = max(register.end for register in self.registers.values())
        return max([plain, *(block.data + block.count for block in self.indirect_blocks)])

    @property
    def indirect_blocks(self) -> tuple[IndirectBlock, ...]:
        """The blocks of indirect addresses; their lengths follow from where their data begin."""
        if "Indirect Address 1" not in self:
            return ()
        blocks = [self._block("Indirect Address 1", "Indirect Data 1")]
        if self["Indirect Address Read"].address >= blocks[0].data:
            blocks.append(self._block("Indirect Address Read", "Indirect Data Read"))
        return tuple(blocks)

    def _block(self, address: str, data: str) -> IndirectBlock:
        first, mirror = self[address].address, self[data].address
        return IndirectBlock(first, mirror, (mirror - first) // 2)


def _folder() -> Traversable:
    return resources.files("dynamixel_easy_sdk") / "control_table"


@cache
def _numbers() -> dict[str, int]:
    """Model name to model number, for every model that the SDK knows."""
    rows = (_folder() / "dynamixel.model").read_text(encoding="utf-8").splitlines()[1:]
    pairs = (row.split() for row in rows if row.strip())
    return {_model_name(file): int(number) for number, file in pairs}


def _model_name(file: str) -> str:
    return file.removesuffix(".model").upper().replace("_", "-")


def all_model_names() -> tuple[str, ...]:
    """Names of all models that the SDK has a table for, whatever their family."""
    return tuple(sorted(_numbers()))


def model_names() -> tuple[str, ...]:
    """Names of all X-series models (the name starts with X, or 2X for the double ones)."""
    return tuple(sorted(name for name in _numbers() if name.startswith(("X", "2X"))))


def is_driven(model: str) -> bool:
    """Whether it is of a family whose registers, units and error bits this package knows: X, 2X, or MX with
    Protocol 2.0. The PRO, P and Y series and grippers report other things under the same names."""
    return model.startswith(_FAMILIES) and model not in _UNLIKE


def model_name(number: int) -> str:
    """Name of the model with this number; UnknownName where the SDK has no table for it."""
    for name, known in _numbers().items():
        if known == number:
            return name
    raise UnknownName("servo model number", str(number), (f"{n} ({name})" for name, n in _numbers().items()))


@cache
def control_table(model: str, firmware: int | None = None) -> ControlTable:
    """The control table of a model by name, of its newest firmware where none is given.

    Raises:
        UnknownName: no such model.
        InvalidFile: the SDK's file is damaged.
    """
    if model not in _numbers():
        raise UnknownName("servo model", model, _numbers())
    version, path = _file(model.lower().replace("-", "_"), firmware)
    try:
        sections = _sections(path.read_text(encoding="utf-8"))
        info = {row[0]: float(row[1]) for row in sections["type info"]}
        rows = [(int(row[0]), int(row[1]), _CANONICAL.get(row[2], row[2])) for row in sections["control table"]]
        ram = next(address for address, _, name in rows if name == "Torque Enable")
        zero = int(info["value_of_zero_radian_position"])
        lowest = int(info["value_of_min_radian_position"])
        return ControlTable(
            model=model,
            number=_numbers()[model],
            firmware=version,
            registers={name: _register(name, address, size, ram) for address, size, name in rows},
            zero_position=zero,
            rad_per_tick=-info["min_radian"] / (zero - lowest),
            scales={row[0]: (float(row[1]), row[2]) for row in sections["unit info"]},
        )
    except (OSError, KeyError, IndexError, ValueError, StopIteration) as error:
        raise InvalidFile(str(path), f"not a readable control table ({type(error).__name__}: {error})") from None


def _older(stem: str) -> list[tuple[int, Traversable]]:
    """Last firmware version and file of each older table of a model, the oldest first."""
    found: list[tuple[int, Traversable]] = []
    for file in _folder().iterdir():
        name, mark, version = file.name.removesuffix(".model").partition(_OLDER)
        if mark and name == stem and version.isdigit():
            found.append((int(version), file))
    return sorted(found, key=lambda item: item[0])


def _file(stem: str, firmware: int | None) -> tuple[int, Traversable]:
    """A version that a model's table holds for, and its file."""
    older = _older(stem)
    for version, file in older if firmware is not None else ():
        if firmware is not None and firmware <= version:
            return version, file
    return older[-1][0] + 1 if older else _USUAL_FIRMWARE, _folder() / f"{stem}.model"


def _sections(text: str) -> dict[str, list[list[str]]]:
    """Section name to its tab-separated rows, without the line of column titles."""
    sections: dict[str, list[list[str]]] = {}
    current: list[list[str]] = []
    for line in (raw.strip() for raw in text.splitlines()):
        if line.startswith("["):
            current = sections.setdefault(line.strip("[]"), [])
        elif line:
            current.append(line.split("\t"))
    return {name: rows[1:] for name, rows in sections.items()}


def _register(name: str, address: int, size: int, ram: int) -> Register:
    return Register(
        name=name,
        address=address,
        size=size,
        signed=name in _SIGNED,
        writable=not (name in _READ_ONLY or name.startswith("Present ")),
        eeprom=address < ram,
    )
