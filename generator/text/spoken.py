"""What is said to the listener, not of the motion: address, requests, thanks, fillers, slips of the tongue."""

import re
from typing import Final

from generator.text.inflection import FINITE_FORMS, GERUNDS
from generator.text.numbers import PLAIN

_ROBOT = (
    r"(?:(?:my |the |this |little |dear )*(?:robot|bot|friend|buddy|mate|pal|dude|man|op3|g1|h1|t1|humanoid|there|you))"
)
_LABEL = re.compile(
    r"^\W*(?:(?:test |text |my |the )?(?:prompt|text|pose|anim|animation|caption|motion|input|command|task|description|"
    r"action|sequence|request|idea|combo|\w+ combo)\s*\d*\s*[:=])\s*"
)
_GREETING = re.compile(
    rf"^(?:(?:hey|hi|hello|dear|ok|okay|yo|well|so|alright|all right|listen|now|um+|uh+|er+m*|hm+|oh|and|but|like|"
    rf"basically|actually|maybe|perhaps|kindly|please|pls|plz)(?: {_ROBOT})?(?:[,!:. ]+|$)|{_ROBOT}[,!:] *)+"
)
_YOU = (
    r"(?:you|u|it|him|her|them|he|she|they|someone|somebody|"
    r"(?:the|a|my|this) (?:robot|bot|person|man|woman|figure|guy|op3|g1))"
)
_ASKED = (
    rf"(?:is|would) it (?:be )?(?:possible|ok|okay)(?: for {_YOU})? to",
    rf"(?:are|is) {_YOU} able to",
    rf"(?:can|could|would|will|may|might) {_YOU}",
    rf"(?:do you think|i was wondering if|i wonder if) {_YOU} (?:can|could|would|might)",
    rf"(?:i'd|i would|we'd|i) (?:really )?(?:appreciate|like|love|want|need|prefer|wish)(?: it)?(?: (?:if|for|that))?"
    rf"(?: to see)?(?: to have)? {_YOU}(?: (?:can|could|would|to))?",
    rf"it would be (?:nice|great|cool|good|lovely) if {_YOU} (?:can|could|would)?",
    rf"(?:i'm |i am |we're )?(?:just )?(?:trying|hoping|going) to (?:get|make|have) {_YOU}(?: to)?",
    rf"(?:make|let|have|get|tell|ask|order|command|see|watch) {_YOU}(?: (?:to|do|go))?(?= [a-z])(?! {_YOU})",
    rf"(?:let me|let's|let us|i want to|i'd like to|i would like to|i'd love to) (?:see|watch) {_YOU}",
    rf"(?:show me|demonstrate|show)(?: (?:how|that))?(?: (?:{_YOU}))?(?: (?:can|would))?(?: to)?(?= [a-z])",
    r"(?:do (?:me|us) a favou?r(?: and)?)",
    r"(?:if (?:you don't mind|possible|you can|you would|you please|that's ok|you like))",
    r"(?:be (?:so )?(?:nice|kind|good|a dear|able)(?: enough)?(?: as)?(?: (?:and|to))?)",
    r"(?:(?:go|feel) (?:ahead|free)(?: and| to)?|go and|come and|try (?:to|and)|attempt to|pretend to|"
    r"please remember to)",
    r"(?:imagine|picture|simulate|generate|create|animate|visuali[sz]e|render|produce|i want|i need)(?: me)?"
    r"(?= (?:an?|the|some|someone|somebody)\b)",
    r"(?:an? |the |some )?(?:simple |short |quick |smooth )?"
    r"(?:motion|animation|video|clip|movement|gif|scene)s? (?:of|showing|where|in which|with)",
    r"(?:mind)(?= \w+ing)",
    r"(?:let's|lets|let us)(?= [a-z]+)",
    r"(?:please|pls|plz|kindly|maybe|perhaps|possibly|just|now|ok|okay|then|um+|uh+|hm+|like|so|simply)",
)
_REQUEST = re.compile(rf"^(?:{'|'.join(_ASKED)})[,: ]+")
_TAIL = re.compile(
    r"[,.!? ]+(?:for me|for us|please|pls|plz|thanks(?: a lot)?|thank you(?: (?:so|very) much)?|thx|ty|cheers|lol|haha|"
    r"or (?:something|whatever)(?: like that)?(?=\W*$)|or so|i guess|i think|i suppose|you know|if you can|"
    r"if possible|if you don't mind|"
    r"will you|would you|could you|can you|won't you|ok|okay|"
    r"right\?|right away|right now|asap|now|ya know|or something|"
    r"if that's ok(?:ay)?|if you like|for a change)[.!? ]*$"
)
_FILLERS = re.compile(
    r"(?:(?<=^)|(?<=[ ,.]))(?:please|pls|plz|kindly|maybe|perhaps|possibly|um+|uh+|er+m*|hm+|simply|basically|"
    r"just|kinda|"
    r"kind of|sort of|sorta|you know|i guess|literally|honestly|probably|um|(?<=, )like(?=,))(?=[ ,.]|$),?"
)
_PLAIN = re.compile(r"^ *(?:an? )?(?:simple|basic|normal|regular|standard|nice|proper|realistic|good|classic) (?=\w+)")
_MARKER = (
    r"(?:\s*(?:,|\.{2,}|…|\s-+|—|;|\.)\s*(?:(?:and|but|or|oh|well|um+|uh+|er+)[, ]+)?)"
    r"(?:no,? wait|wait,? no|actually no|no,? actually|no,? no|no|actually|i mean|i meant|sorry|or rather|"
    r"rather|scratch that|"
    r"strike that|correction|make (?:that|it)|er+|uh+|oops|wait|my bad|nope)\b"
    r"(?:[,. ]*(?:i mean|i meant|actually|no|wait|make (?:that|it)|sorry|that's wrong|rather))*[,.: ]+"
)
_CORRECTION = re.compile(rf"^(?P<said>.+?){_MARKER}(?P<meant>(?:(?!{_MARKER}).)+)$")
_DIRECTIONS = (
    r"(?:(?:to (?:the|your|his|her|their|its) )?(?:left|right)|forwards?|backwards?|back|ahead|up|down|sideways)"
)
_LIMB = r"(?:hands?|arms?|legs?|foot|feet|knees?|fists?|shoulders?|side)"
_SLOTS: Final = (
    re.compile(rf"(?:with |on |using )?(?:(?:the|your|his|her|their|its|my) )?(?:left|right|both)(?: {_LIMB})"),
    re.compile(rf"(?:{PLAIN} times|once|twice|thrice)"),
    re.compile(rf"{_DIRECTIONS}"),
    re.compile(r"(?:slowly|quickly|fast)"),
    re.compile(rf"{PLAIN} \w+"),
)
_CLAUSE_START = re.compile(
    r"(?:,? (?:and )?then |, and |, | and |\. |; )(?!.*(?:,? (?:and )?then |, and |, | and |\. |; ))"
)
_LAST_LIMB = re.compile(r"(?:(?:the|your|his|her|their|its|my) )?(?:left|right|both)\b(?! (?:hand|arm|leg|foot))")


def motion_words(text: str) -> str:
    """A prompt in lower case without what is said to the listener, and with slips of the tongue put right.

    `hey robot, could you wave with your left, no, your right hand for me, please?` -> `wave with your right hand`
    """
    text = text.strip(" \"'“”`")
    text = _without_lead_in(_corrected(_LABEL.sub("", text)))
    while (shorter := _without_tail(text)) != text:
        text = shorter
    text = _PLAIN.sub("", _FILLERS.sub("", text))
    return " ".join(text.split()).strip(" ,.?!") or text


def _without_lead_in(text: str) -> str:
    while True:
        shorter = _REQUEST.sub("", _GREETING.sub("", text).strip(" ,.!\"'")).strip(" ,.\"'")
        if shorter == text or not shorter:
            return text
        text = shorter


def _without_tail(text: str) -> str:
    cut = _TAIL.search(text)
    if cut is None or cut.start() == 0:
        return text
    return text[: cut.start()]


def _corrected(text: str) -> str:
    """Without what the speaker takes back."""
    for _ in range(3):
        found = _CORRECTION.match(text)
        if found is None:
            return text
        text = _put_right(found["said"], found["meant"])
    return text


def _put_right(said: str, meant: str) -> str:
    first, *_ = meant.split()
    word = first.strip(",.")
    if word in FINITE_FORMS or word in GERUNDS or (word in {"he", "she", "they", "the", "a"} and _begins_clause(meant)):
        cut = _CLAUSE_START.search(said)
        return f"{said[: cut.end()] if cut else ''}{meant}"
    for slot in _SLOTS:
        new = slot.match(meant)
        if new is None:
            continue
        olds = list(slot.finditer(said)) or list(_LAST_LIMB.finditer(said))
        if olds:
            return f"{said[: olds[-1].start()]}{meant}" + ("" if " " in meant[new.end() :] else said[olds[-1].end() :])
    return f"{said}, {meant}"


def _begins_clause(text: str) -> bool:
    words = text.split()[:4]
    return any(word.strip(",.") in FINITE_FORMS for word in words[1:])
