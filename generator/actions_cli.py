"""The `actions` subcommand: what sentences may ask for, from the catalogue that the model was taught with."""

import inspect
from dataclasses import dataclass
from typing import Annotated, Any, Final

import tyro

from ros_free_stack.console import Command, print_table

EXAMPLES: Final = 2
"""Sentences that are shown for each action."""
_AMOUNTS: Final = {
    "side": "side", "count": "count", "speed": "speed", "size": "size", "angle": "angle", "way": "direction",
}  # fmt: skip
"""Parameters that a sentence may name, and the word for each."""


@dataclass(frozen=True, kw_only=True)
class Actions(Command):
    """List the actions that a sentence may ask for, with what may be said of each and sentences that say it.

    Examples:
        python launch.py actions
        python launch.py actions kick
    """

    about: Annotated[str | None, tyro.conf.Positional] = None
    """List only actions with this word in their name or sentences."""

    def run(self) -> int:
        from generator.corpus.actions import ACTIONS
        from ros_free_stack.errors import UnknownName

        rows = [_row(name) for name in ACTIONS]
        if self.about is not None:
            word = self.about.lower()
            rows = [row for row in rows if word in " ".join([row["name"].replace("_", " "), *row["examples"]]).lower()]
            if not rows:
                raise UnknownName("action", self.about, ACTIONS)
        if self.json:
            self.report({"actions": rows})
        else:
            cells = [(row["name"], row["body"], " ".join(row["may_say"]), "; ".join(row["examples"])) for row in rows]
            print_table(("action", "body", "may say", "for example"), cells)
        return 0


def _row(name: str) -> dict[str, Any]:
    from generator.corpus.actions import ACTIONS

    found = ACTIONS[name]
    return {
        "name": name,
        "body": found.part,
        "does": inspect.getdoc(found.perform) or "",
        "may_say": [word for parameter, word in _AMOUNTS.items() if parameter in found.parameters],
        "examples": _examples(name),
    }


def _examples(name: str) -> list[str]:
    """Sentences that mean the action, the same ones every time."""
    import numpy as np

    from generator.corpus.captions import segment_text
    from generator.corpus.vocabulary.entry import Draw, Voice
    from generator.corpus.words import entry, phrase

    rng = np.random.default_rng(0)
    found: list[str] = []
    for _ in range(4 * EXAMPLES):
        text = segment_text(phrase(name, entry(name).sample(Draw(rng)), Voice(), rng))
        if text not in found:
            found.append(text)
    return found[:EXAMPLES]
