"""Clauses of a parsed sentence: where each action begins and ends, and how it is linked to the ones before it."""

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import TYPE_CHECKING

from generator.text.inflection import FINITE_FORMS, GERUNDS, gerund, third_person, word_set
from generator.text.wording import LIMBS, PEOPLE, SUBJECT, SUBORDINATORS

if TYPE_CHECKING:
    from spacy.tokens import Doc, Token

_COORDINATORS = frozenset({"and", "or", "but", "then", ".", ";"})
_CONNECTIVES = _COORDINATORS | SUBORDINATORS | {",", "simultaneously"}
_FINITE_TAGS = frozenset({"VBZ", "VBP", "VBD", "VB"})
_CLAUSE_LABELS = frozenset({"ROOT", "conj", "ccomp", "parataxis", "dep", "advcl", "appos"})
_NO_CLAUSE_AFTER = word_set("to who that which if by without in of for from with")
_BEFORE_VERB = frozenset({"aux", "auxpass", "neg", "advmod"})
_MANNERS = word_set("using lifting curving bending keeping making leaning facing taking going leading")
_COMPARISONS = frozenset({"like", "if", "though", "because"})
_NEVER_VERBS = frozenset({"left", "right", "jack", "jacks"}) | (LIMBS - {"hand", "hands", "head", "elbow", "elbows"})
_EXERCISES = (
    (word_set("calf knee leg"), word_set("raises lifts")),
    (word_set("star squat tuck box split frog lunge"), word_set("jump jumps")),
    (word_set("push pull sit chin press"), word_set("ups")),
    (word_set("jump jumping"), word_set("jack jacks")),
)
"""First and second words of exercises whose names look like verbs."""
POSSESSIVES = frozenset({"your", "their", "his", "its", "my", "our"})
_OTHERS = {"him": "them", "me": "them", "you": "them", "us": "them", "himself": "themselves", "itself": "themselves",
           "herself": "themselves", "yourself": "themselves", "myself": "themselves"}  # fmt: skip


class Link(Enum):
    """How a clause is placed in time against the clause that it belongs to."""

    NEXT = "next"
    AFTER = "after"
    BEFORE = "before"
    WHILE = "while"


@dataclass(frozen=True)
class Clause:
    """One verb with all that belongs to it: "slowly" + "walk" + "to the left".

    `leading`: its main clause follows ("after waving, he bows"). `parallel`: it is coordinated with the clause just
    before it and shares that one's link ("after waving and clapping"). `new_sentence`: a full stop precedes it.
    `plain_and`: only "and" links it, no word of time. `subject` is empty for a human being.
    """

    subject: str
    adverbs: str
    verb: str
    rest: str
    link: Link = Link.NEXT
    leading: bool = False
    parallel: bool = False
    plain_and: bool = False
    new_sentence: bool = False

    @property
    def third(self) -> str:
        """ "slowly walks to the left"."""
        return _join(self.adverbs, third_person(self.verb), self.rest)

    @property
    def gerund(self) -> str:
        """ "slowly walking to the left"."""
        return _join(self.adverbs, gerund(self.verb), self.rest)


def clauses(doc: "Doc") -> list[Clause]:
    """The clauses of a parsed text in the order of writing; none where it has no verb."""
    heads = [token for token in doc if _is_head(token) and not _is_object(token)]
    heads = [head for place, head in enumerate(heads) if not (place and _is_done(head, heads[place - 1]))]
    starts = [_start(head) for head in heads]
    found: list[Clause] = []
    for place, head in enumerate(heads):
        end = starts[place + 1] if place + 1 < len(heads) else len(doc)
        floor = heads[place - 1].i + 1 if place else 0
        first = _connectives_before(doc, starts[place], floor)
        link_words = {token.text for token in doc[first : starts[place]]}
        together = "simultaneously" in link_words or any(t.text == "simultaneously" for t in doc[starts[place] : end])
        together = together or (place == 1 and any(t.text == "simultaneously" for t in doc[: heads[0].i]))
        link = Link.WHILE if together and place else _link(head, link_words)
        found.append(
            Clause(
                subject=_subject(doc, starts[place], head),
                adverbs=_words(doc, starts[place], head.i, adverbs_only=True),
                verb=_base(head),
                rest=_join(
                    _words(doc, head.i + 1, end),
                    _attribute(doc, starts[place], head),
                    _words(doc, 0, first) if place == 0 else "",
                ),
                link=link,
                leading=link is not Link.NEXT and (place == 0 or bool(link_words & _COORDINATORS)) and not together,
                parallel=place > 0 and not link_words & SUBORDINATORS and _is_parallel(heads, place),
                plain_and="and" in link_words and link_words <= {"and", ","},
                new_sentence=bool(link_words & {".", ";"}),
            )
        )
    return found


def other_subject(doc: "Doc") -> Clause | None:
    """The clause of a text whose subject is neither a person nor a limb ("the horse kicks"), None for any other."""
    root = next((token for token in doc if token.dep_ == "ROOT"), None)
    if root is None:
        return None
    subject = next((child for child in root.children if child.dep_ == "nsubj" and child.tag_ in {"NN", "NNS"}), None)
    if root.tag_ not in _FINITE_TAGS or subject is None or subject.i > root.i:
        return None
    if subject.text in PEOPLE | LIMBS or subject.text in FINITE_FORMS:
        return None
    return Clause(_words(doc, 0, root.i), "", root.lemma_, _words(doc, root.i + 1, len(doc)))


def _is_head(token: "Token") -> bool:
    other_noun = _governor(token) == "or" and token.text not in FINITE_FORMS and token.text not in GERUNDS
    if (
        other_noun
        or token.text in _NEVER_VERBS
        or _names_exercise(token)
        or any(child.dep_ == "auxpass" for child in token.children)
    ):
        return False
    if _governor(token) == SUBJECT and (token.text in FINITE_FORMS or token.tag_ in _FINITE_TAGS | {"VBG"}):
        return not _is_auxiliary(token)
    if token.tag_ == "VBG" or token.text in GERUNDS:
        return _is_gerund_head(token)
    if token.dep_ not in _CLAUSE_LABELS or _governor(token) in _NO_CLAUSE_AFTER:
        return False
    if token.tag_ == "NNS":  # a rare verb that the tagger took for a noun: "he juggles and meditates"
        return token.dep_ == "conj" and token.head.tag_ == "VBZ" and token.n_lefts == 0 and _is_head(token.head)
    participle = token.tag_ == "VBD" and _governor(token) in LIMBS  # "with the arms stretched out"
    return token.tag_ in _FINITE_TAGS and not participle


def _names_exercise(token: "Token") -> bool:
    """A word of "calf raises", "star jumps", "push ups"."""
    words = [word.text for word in token.doc[max(0, token.i - 1) : token.i + 2]]
    return any(a in first and b in second for a, b in pairwise(words) for first, second in _EXERCISES)


def _is_object(token: "Token") -> bool:
    """A noun that was parsed as a verb with its determiner as subject: "does two hops", "does calf raises"."""
    start = _start(token)
    subject = start < token.i and token.doc[start].text != SUBJECT and token.doc[start].dep_ not in _BEFORE_VERB
    return subject and start > 0 and token.doc[start - 1].text not in _CONNECTIVES


def _is_done(token: "Token", previous: "Token") -> bool:
    """A noun that was parsed as a verb after "does": "does walking lunges", "performs bicep curls"."""
    between = {word.text for word in token.doc[previous.i + 1 : token.i]}
    return previous.lemma_ in {"do", "perform"} and not between & (_CONNECTIVES | {SUBJECT, "to"})


def _is_auxiliary(token: "Token") -> bool:
    """True for the "is" of "is walking", false for that of "is pushed", which is itself the verb to inflect."""
    walking = token.lemma_ == "be" and token.head.tag_ == "VBG"
    has_walked = token.lemma_ == "have" and token.head.tag_ == "VBN"
    return token.dep_ == "aux" and (walking or has_walked)


def _is_gerund_head(token: "Token") -> bool:
    governor = _governor(token)
    compared = any(child.dep_ == "mark" and child.text in _COMPARISONS for child in token.children)
    if governor in _NO_CLAUSE_AFTER or compared:
        return False
    if governor in SUBORDINATORS or any(child.dep_ == "aux" and child.lemma_ == "be" for child in token.children):
        return True
    if governor in {"and", "or", ","}:
        return token.text in GERUNDS or token.dep_ in {"conj", "advcl"}
    return token.dep_ == "advcl" and token.text not in _MANNERS


def _governor(token: "Token") -> str:
    """The nearest word before a verb that is neither its adverb nor its auxiliary."""
    place = token.i - 1
    while place >= 0 and _belongs_before(token.doc[place], token):
        place -= 1
    return token.doc[place].text if place >= 0 else ""


def _belongs_before(token: "Token", verb: "Token") -> bool:
    """Auxiliaries and adverbs of a verb, which stand between it and its subject."""
    if token.dep_ in _BEFORE_VERB - {"advmod"} and token.text != "to":
        return True
    return token.tag_ == "RB" and token.text not in _CONNECTIVES and (token.head == verb or token.text.endswith("ly"))


def _start(head: "Token") -> int:
    """Where the clause of a verb starts: at its subject, else at its adverbs and auxiliaries."""
    doc, place = head.doc, head.i
    while place > 0 and _belongs_before(doc[place - 1], head):
        place -= 1
    if place > 0 and doc[place - 1].text == SUBJECT:
        return place - 1
    subjects = [child for child in head.children if child.dep_ in {"nsubj", "nsubjpass"} and child.i < head.i]
    if subjects and (subjects[0].left_edge.i == 0 or doc[subjects[0].left_edge.i - 1].dep_ != "prep"):
        return min(place, subjects[0].left_edge.i)
    return place


def _subject(doc: "Doc", start: int, head: "Token") -> str:
    """The words of a subject that is no human being, "" for one that is (or none)."""
    nouns = [token.text for token in doc[start : head.i] if token.dep_ not in _BEFORE_VERB]
    return "" if not nouns or nouns[0] == SUBJECT or nouns[-1] in PEOPLE else " ".join(nouns)


def _attribute(doc: "Doc", start: int, head: "Token") -> str:
    """What stands with a human subject: "with legs bent" of "a person with legs bent walks"."""
    words = [token.text for token in doc[start : start + 2]]
    return _words(doc, start + 1, head.i) if words == [SUBJECT, "with"] and start + 1 < head.i else ""


def _connectives_before(doc: "Doc", start: int, floor: int) -> int:
    while start > floor and doc[start - 1].text in _CONNECTIVES:
        start -= 1
    return start


def _link(head: "Token", words: set[str]) -> Link:
    if "after" in words:
        return Link.AFTER
    if "before" in words:
        return Link.BEFORE
    participle = head.tag_ == "VBG" and _governor(head) != SUBJECT
    return Link.WHILE if words & {"while", "as", "when"} or participle else Link.NEXT


def _is_parallel(heads: list["Token"], place: int) -> bool:
    """A gerund coordinated with another verb in -ing: "after waving and clapping", "is standing and waving".

    After a mere comma it is so only within a list that an "and" ends, else it is a participle: "is dancing, raising
    the hands".
    """
    head, previous, following = heads[place], heads[place - 1], heads[place + 1 : place + 2]
    if not (head.text.endswith("ing") and previous.text.endswith("ing")):
        return False
    in_list = bool(following) and following[0].text.endswith("ing") and _governor(following[0]) == "and"
    return _governor(head) in {"and", "or"} or (_governor(head) == "," and in_list)


def _base(head: "Token") -> str:
    return FINITE_FORMS.get(head.text) or GERUNDS.get(head.text) or head.lemma_


def _words(doc: "Doc", start: int, end: int, *, adverbs_only: bool = False) -> str:
    while end > start and doc[end - 1].text in _CONNECTIVES:
        end -= 1
    words: list[str] = []
    for token in doc[start:end]:
        ability = token.text == SUBJECT and token.i + 1 < end and token.nbor().tag_ == "MD"  # "as fast as he can"
        if (token.text in {"simultaneously", ".", ";", SUBJECT} and not ability) or (
            adverbs_only and token.tag_ != "RB"
        ):
            continue
        if token.text in POSSESSIVES or (token.text == "her" and token.tag_ == "PRP$"):
            if words[-1:] not in (["both"], ["all"], ["the"]):
                words.append("the")
            continue
        if token.text == "the" and words[-1:] == ["both"] and token.i + 1 < end and token.nbor().text in LIMBS:
            continue
        words.append(_OTHERS.get(token.text, token.text))
    return _join(*words)


def _join(*parts: str) -> str:
    return (
        " ".join(part for part in parts if part)
        .replace(" ,", ",")
        .replace(" 's", "'s")
        .replace(" - ", "-")
        .replace("one-after-the-other", "one after the other")
        .replace("one-after-another", "one after another")
        .strip(", ")
    )
