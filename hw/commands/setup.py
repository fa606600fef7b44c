"""`servos configure` and `calibrate`: set a rig up for its robot."""

import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import tyro

from hw.commands.base import BusCommand, Row
from hw.configure import apply_changes, planned_changes
from hw.guide import calibrate
from hw.outputs import check_output
from ros_free_stack.errors import InvalidOption


@dataclass(frozen=True, kw_only=True)
class ServosConfigure(BusCommand):
    """Show which registers differ from what the robot needs; write them with --write."""

    write: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Write the changes (EEPROM included)."""

    def run(self) -> int:
        with self.opened(mute_too=True) as servos:
            changes = planned_changes(servos)
            if self.write:
                apply_changes(servos, changes)
            if self.json:
                self.report({"written": self.write, "changes": [asdict(change) for change in changes]})
                return 0
            rows: list[Row] = [
                dict(
                    zip(
                        ("servo", "register", "now", "wanted"),
                        (c.servo, c.register, *c.describe(servos.table(c.index))),
                        strict=True,
                    )
                )
                for c in changes
            ]
            self.table("written" if self.write else "would be written with --write", rows)
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosCalibrate(BusCommand):
    """Measure zero, direction and range of each joint: you move the limp robot, the servos say where it is."""

    out: Path = Path("calibration.yaml")
    """Where the calibration goes."""

    def run(self) -> int:
        if not sys.stdin.isatty():
            raise InvalidOption("servos calibrate", "needs a terminal: it asks you to move the robot")
        check_output("--out", self.out, inputs={"--calibration": self.calibration})
        with self.opened() as servos:
            try:
                calibration = calibrate(servos, lambda text: input(f"{text} "))
            except EOFError:
                raise InvalidOption("servos calibrate", "the terminal was closed; nothing was written") from None
        calibration.save(self.out)
        self.report({"calibration": str(self.out), "joints": len(calibration.joints)}, f"wrote {self.out}")
        return 0
