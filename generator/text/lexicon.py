"""The tables of `tables/`: how actions are worded by people and by the corpus, read once.

A row of an action's table lists verbs, words that must be there too, and words that may. Words are matched as lemmas
in any order, so that what stands between them does not matter; the row that explains most of a clause wins.
"""

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Final

from generator.text.inflection import FINITE_FORMS, GERUNDS, PARTICIPLES

TABLES: Final = Path(__file__).parent / "tables"
FAMILIES: Final = ("arms", "work", "legs")
ANY: Final = "*"
"""Among the words that may be there: any object."""

_PLURALS = {
    "has": "have",
    "had": "have",
    "having": "have",
    "feet": "foot",
    "teeth": "tooth",
    "people": "person",
    "knives": "knife",
    "men": "man",
    "women": "woman",
}
_KEEP = frozenset({"left", "across", "towards", "upwards", "downwards", "backwards", "forwards", "sideways", "always"})


@dataclass(frozen=True)
class Row:
    """One way to say an action.

    Attributes:
        action: its name in the vocabulary; of an unknown action the words that name it.
        verbs: any of them; none where a noun of `needed` is enough.
        needed: groups of words of which one each must be there.
        barred: words that must not be there.
        allowed: words that this row explains besides.
        options: what follows from it.
        near: for an unknown action, known ones near in meaning.
    """

    action: str
    verbs: frozenset[str]
    needed: tuple[frozenset[str], ...]
    barred: frozenset[str]
    allowed: frozenset[str]
    options: dict[str, str] = field(default_factory=dict[str, str])
    near: tuple[str, ...] = ()

    @property
    def known(self) -> bool:
        return not self.near


@dataclass(frozen=True)
class Way:
    """One of a set of ways: its name, the corpus's wording, the words that say it."""

    name: str
    wording: str
    words: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class ActionWords:
    """How the corpus words an action.

    Attributes:
        name: in the vocabulary.
        limb: whose side matters, "" for none.
        ways: name of its sets of ways, joined by "+", "" for none.
        wording: a template; see `tables/actions.tsv`.
        counted: the template where a count is named.
    """

    name: str
    limb: str
    ways: str
    wording: str
    counted: str

    @property
    def counts(self) -> bool:
        """Whether the corpus ever says how often."""
        return "{times}" in self.counted or "{some:" in self.counted


@cache
def rows() -> tuple[Row, ...]:
    """All rows of all families, unknown actions last."""
    known = [_row(line) for family in FAMILIES for line in lines(family)]
    return (*known, *(_unknown(line) for line in lines("unknown")))


@cache
def ways() -> dict[str, tuple[Way, ...]]:
    """The sets of ways by name."""
    found: dict[str, tuple[Way, ...]] = {}
    for line in lines("ways"):
        group, name, wording, words = line.split("\t")
        way = Way(name, wording, tuple(tuple(word.replace("_", "+").split("+")) for word in words.split()))
        found[group] = (*found.get(group, ()), way)
    return found


@cache
def ways_of(action: str) -> tuple[Way, ...]:
    """The ways that an action can have, none for many."""
    groups = actions()[action].ways
    return tuple(way for group in groups.split("+") if group for way in ways()[group])


@cache
def actions() -> dict[str, ActionWords]:
    """The wordings of all actions by name."""
    table = (line.split("\t") for line in lines("actions"))
    return {
        name: ActionWords(name, limb.strip("-"), group.strip("-"), wordings[0], wordings[-1])
        for name, limb, group, *wordings in table
    }


@cache
def word_lists() -> dict[str, frozenset[str]]:
    """The lists of `words.tsv` by name."""
    found: dict[str, frozenset[str]] = {}
    for line in lines("words"):
        name, words = line.split("\t")
        found[name] = found.get(name, frozenset()) | frozenset(words.split())
    return found


@cache
def verbs() -> frozenset[str]:
    """Every verb of every row."""
    return frozenset(verb for row in rows() for verb in row.verbs)


@cache
def lemma(word: str) -> str:
    """The base of a verb form, the singular of a noun, else the word itself: `waves` -> `wave`, `feet` -> `foot`."""
    if word in _KEEP:
        return word
    if base := FINITE_FORMS.get(word) or GERUNDS.get(word) or PARTICIPLES.get(word) or _PLURALS.get(word):
        return base
    if word.endswith(("ches", "shes", "sses", "xes")):
        return word[:-2]
    if word.endswith("ies") and len(word) > 4:
        return f"{word[:-3]}y"
    return word[:-1] if word.endswith("s") and not word.endswith(("ss", "us", "is")) and len(word) > 3 else word


def lines(table: str) -> list[str]:
    """The lines of a table without its comments."""
    text = (TABLES / f"{table}.tsv").read_text(encoding="utf-8")
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def _row(line: str) -> Row:
    action, verbs, needed, allowed, *options = line.split("\t")
    groups = _words(needed)
    return Row(
        action,
        frozenset(_words(verbs)),
        tuple(frozenset(group.split("|")) for group in groups if group[0] != "!"),
        frozenset(group[1:] for group in groups if group[0] == "!"),
        frozenset(_words(allowed)),
        dict(option.split("=") for part in options for option in part.split()),
    )


def _unknown(line: str) -> Row:
    action, verbs, needed, near = line.split("\t")
    return Row(action, *_parts(verbs, needed), frozenset(), near=tuple(near.split()))


def _parts(verbs: str, needed: str) -> tuple[frozenset[str], tuple[frozenset[str], ...], frozenset[str]]:
    row = _row(f"\t{verbs}\t{needed}\t-")
    return row.verbs, row.needed, row.barred


def _words(cell: str) -> list[str]:
    return [] if cell == "-" else cell.split()
