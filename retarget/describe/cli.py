"""The `robots add` subcommand."""

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from ros_free_stack.console import Command, progress, say

if TYPE_CHECKING:
    from retarget.describe.proposal import Proposal
    from ros_free_stack.robots import RobotDescription


@dataclass(frozen=True, kw_only=True)
class RobotsAdd(Command):
    """Describe a robot from its MuJoCo model: propose, draw for review, check, write.

    Example: python launch.py robots add my_robot/model.xml --accept
    """

    model: Annotated[str, tyro.conf.Positional]
    """MJCF file, or menagerie:NAME for a robot of MuJoCo Menagerie."""
    name: str | None = None
    """Name to call it by; made of the file's name by default."""
    out: Path | None = None
    """Description to write (.yaml); in the folder of your robots by default (RFS_ROBOTS, or `robots` where one works).
    The picture appears beside it."""
    given: Path | None = None
    """YAML file with keys of a description that are known: root_body, torso_body, mount, attachments."""
    accept: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Write the description without asking; without a terminal nothing is written otherwise."""

    def run(self) -> int:
        """0 where a description works, written or only reviewed; 2 where something is open or a check fails."""
        from retarget.describe.checks import check_description
        from retarget.describe.drawing import draw_proposal
        from retarget.describe.given import read_given
        from retarget.describe.proposal import propose
        from retarget.describe.writing import description_text, model_entry
        from ros_free_stack.files import make_folder, write_text
        from ros_free_stack.robot_model import read_spec

        model, entry = self._source()
        name, out = self._destination(model)
        given = read_given(self.given) if self.given else None
        proposal = propose(read_spec(model), model, given=given, progress=_bar)
        if proposal.questions:
            return self._undecided(proposal)
        make_folder(out.parent)
        text = description_text(proposal, name=name, title=name, model=entry or model_entry(model, out.parent))
        checks = check_description(_described(text, out.parent))
        picture = out.with_suffix(".png")
        draw_proposal(proposal, picture, name)
        failed = [check for check in checks if not check.passed]
        written = not failed and (self.accept or _agreed(picture))
        if written:
            write_text(out, text)
        self.report(
            {
                "name": name,
                "description": str(out) if written else None,
                "picture": str(picture),
                "attachments": {joint: item.body for joint, item in proposal.attachments.items()},
                "guessed": proposal.guessed | {k: ", ".join(v) for k, v in proposal.limits.guessed.items() if v},
                "checks": {check.name: {"passed": check.passed, "detail": check.detail} for check in checks},
            },
            *(f"{joint:15s} {item.body}" for joint, item in proposal.attachments.items()),
            *(f"guess: {key}: {words}" for key, words in proposal.guessed.items()),
            *(f"{'ok    ' if check.passed else 'FAILED'} {check.name}: {check.detail}" for check in checks),
            f"picture: {picture}",
            f"written: {out}; now --robot {name} works" if written else "nothing written; --accept writes it",
        )
        return 2 if failed else 0

    def _source(self) -> tuple[Path, dict[str, str] | None]:
        """The model's file, and how a description names it where it is no file of the user's."""
        from ros_free_stack.errors import InvalidFile
        from ros_free_stack.menagerie import PREFIX, menagerie_folder, menagerie_model

        if self.model.startswith(PREFIX):
            robot = self.model.removeprefix(PREFIX)
            model = menagerie_model(robot)
            return model, {"menagerie": robot, "file": str(model.relative_to(menagerie_folder(robot)))}
        model = Path(self.model)
        if not model.is_file():
            raise InvalidFile(model, "no such model file; expected an MJCF file or menagerie:NAME")
        return model, None

    def _destination(self, model: Path) -> tuple[str, Path]:
        from retarget.describe.writing import legal_name
        from ros_free_stack.errors import InvalidOption
        from ros_free_stack.robots import robot_names, user_folder

        name = self.name or legal_name(model.stem)
        if name != legal_name(name):
            raise InvalidOption("--name", f"expected lower-case letters, digits and _, found {name!r}")
        out = self.out or user_folder() / f"{name}.yaml"
        if out.suffix != ".yaml":
            raise InvalidOption("--out", f"expected a name that ends in .yaml, found {str(out)!r}")
        if name in robot_names() and self.out is None:
            raise InvalidOption("--name", f"a robot named {name} is described already; choose another")
        return name, out

    def _undecided(self, proposal: "Proposal") -> int:
        """Tell what is open and how to say it; nothing is written."""
        questions = [{"key": q.key, "problem": q.problem, "candidates": list(q.candidates)} for q in proposal.questions]
        self.report(
            {"description": None, "undecided": questions},
            "could not decide, nothing is written:",
            *(f"  {question}" for question in proposal.questions),
            "write what you know into a YAML file, such as",
            "  attachments: {left_knee: {body: NAME}, right_knee: {body: NAME}}",
            "and run again with --given FILE",
        )
        return 2


def _described(text: str, folder: Path) -> "RobotDescription":
    """The description as if it had been written into a folder."""
    import tempfile

    from ros_free_stack.robots import read_description

    with tempfile.NamedTemporaryFile("w", dir=folder, suffix=".tmp", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        return read_description(Path(file.name))


def _agreed(picture: Path) -> bool:
    """Whether a person at a terminal says yes."""
    if not sys.stdin.isatty():
        return False
    say(f"look at {picture}; write the description? [y/N]")
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _bar(bodies: list[int]) -> Iterable[int]:
    return progress(bodies, "fitting capsules")
