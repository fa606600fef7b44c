"""What a sentence leaves out or folds in: verbs that are said once, clauses inside a subject, ways back and forth."""

import re
from typing import Final

from generator.text.inflection import FINITE_FORMS, GERUNDS, third_person, word_set
from generator.text.numbers import NUMBER

_PEOPLE = r"(?:person|man|woman|guy|girl|boy|robot|figure|someone|somebody|human|humanoid|child|one|he|she|they)"
_THIRD = "|".join(
    sorted(
        (third_person(base) for base in set(FINITE_FORMS.values()) - {"hand", "head", "elbow"}), key=len, reverse=True
    )
)
_UNIT = r"(?:met(?:er|re)s?|centimet(?:er|re)s|steps?|paces?|degrees)"
_AMOUNT = rf"(?:(?:{NUMBER} (?:more )?{_UNIT}|again) )?"
_SIDE = r"(?:(?:to|towards) (?:the|his|her|their|your|its) )?(?:left|right)(?: side| direction)?"
_WAY = rf"(?:(?:back )?{_SIDE}|back(?:wards?)?|forwards?|ahead|sideways|up|down)"
_LINK = r"(?:,? (?:and )?then (?:again )?|, and |, | and )"
_TRAVELS: Final = word_set("walk step run jog go move jump hop pace turn sidestep shuffle lean march take rotate spin")
_TURNS: Final = word_set("look point lean glance gaze kick punch")
_FORMS = sorted(
    {form for table in (FINITE_FORMS, GERUNDS) for form, base in table.items() if base in _TRAVELS | _TURNS},
    key=len,
    reverse=True,
)
_SECOND_WAY = re.compile(
    rf"\b(?P<verb>{'|'.join(_FORMS)})\b(?P<mid>(?: (?!and\b|then\b|after\b|before\b|while\b|as\b)[\w'-]+){{0,6}}?)"
    rf" (?P<way>{_WAY})(?P<link>{_LINK})(?P<second>{_AMOUNT}{_WAY})"
    r"(?=$|[.,;]| (?:and|then|again)\b| to (?:the|his|her|their|its|where) (?!left|right))"
)
_STEPS = re.compile(rf"\b{NUMBER} (?:\w+ )?steps?\b|\bsteps?\b")
_WITH_OBJECT = word_set("arm arms hand hands head torso waist body upper hips hip weight leg legs side one")
_ON_FOOT = "|".join(form for form in _FORMS if re.match(r"walk|pac|jog|run|ran\b", form))
_BACK_AND_FORTH = re.compile(
    rf"\b(?P<verb>{_ON_FOOT})"
    r"(?P<how>(?: \w+ly)?)(?: around| up)? (?:back and forth|to and fro|up and down|forth and back)\b"
)
_POSTURE = r"(?:sitting|standing|kneeling|seated|lying|crouching)"
_RELATIVE = re.compile(
    rf"\b(?P<who>{_PEOPLE}),? (?:who|that|which)(?:'s| is| was| are| were)(?: currently| already)? (?P<doing>\w+ing)"
    rf"(?P<rest>(?: (?!and\b|then\b)[a-z]+){{0,5}}?),? (?P<verb>{_THIRD})\b"
)
_WHO = re.compile(rf"\b(?P<who>{_PEOPLE}),? (?:who|that)(?: is| was| are| were|'s)?(?= \w+)")
_ATTRIBUTE = re.compile(
    rf"\b(?P<who>{_PEOPLE}) (?P<with>with [^,.;]*?) (?P<verb>{_THIRD})\b"
    r"(?P<rest>[^,.;]*)"
)
_LIMB_FIRST = re.compile(
    r"(?:(?<=^)|(?<=, )|(?<=then )|(?<=and ))(?P<limb>(?:left|right) (?:hand|arm|leg|foot|knee|fist)) "
    r"(?P<verb>wave|punch|kick|salute|jab|point|stomp|clap|throw|swing|hop|lunge|balance)s?(?=$|[,.;]| (?:and|then)\b)"
)
_HELD_LIMBS = re.compile(
    r"(^|[.;,] |then )((?:both |the |his |her |their |your )?(?:hands?|arms?|fists?)) "
    r"(up|down|on|above|over|behind|out|crossed|folded|together|in front|in the air|akimbo|at)(?= |$)"
)
_VIEWER = re.compile(
    r"\b(?:viewer's |our |the camera's )?(?P<side>left|right)(?P<limb> (?:hand|arm|leg|foot|knee))? "
    r"\((?:our|your|my|the viewer's|viewer's|the person's|screen)[^)]*\)"
)
_AS_IF = re.compile(rf"\b(?:like|as if|as though) (?:{_PEOPLE}|they|it) (?:is|are|was|were) ([a-z]+)")
_PHASES = re.compile(
    r"\b(?:starts?|started|begins?|began|continues?|continued|keeps?|kept|proceeds?|proceeded|resumes?|resumed|goes on)"
    r"(?P<to> to)? (?P<adverb>\w+ly )?(?P<doing>[a-z]+)\b"
)
_BEGINS = re.compile(
    r"\b(?P<who>standing(?: still| in place| there)?|sitting|kneeling) (?:begins?|starts?) to (?P<verb>[a-z]+)"
)
_CLOCKWISE = re.compile(r"\b(?:(counter|anti)[ -]?)?clock[ -]?wise\b")


def described(text: str) -> str:
    """Clauses and descriptions within a subject, and sides as others see them, put in plain order.

    `someone who is kneeling gets up` -> `someone gets up`
    `a person with hands dangling walks slowly` -> `a person walks slowly with hands dangling`
    """
    text = _CLOCKWISE.sub(lambda found: "counterclockwise" if found[1] else "clockwise", text)
    text = _LIMB_FIRST.sub(r"\g<verb> with the \g<limb>", text)
    text = _HELD_LIMBS.sub(
        lambda found: f"{found[1]}{'raise' if found[3] == 'up' else 'hold'} {found[2]} {found[3]}", text
    )
    text = _AS_IF.sub(r"as if \1", text)
    text = _RELATIVE.sub(_relative, text)
    text = _WHO.sub(lambda found: found["who"] if _verb_follows(text, found.end()) else found.group(), text)
    text = _ATTRIBUTE.sub(r"\g<who> \g<verb>\g<rest> \g<with>", text)
    return _PHASES.sub(_without_phase, _BEGINS.sub(lambda found: third_person(found["verb"]), text))


def _without_phase(found: re.Match[str]) -> str:
    """ "starts clapping", "proceeds to sit down" as the action itself."""
    base = GERUNDS.get(found["doing"]) or FINITE_FORMS.get(found["doing"])
    if base is None or (found["doing"] in GERUNDS) == (found["to"] is not None):
        return found.group()
    return f"{found['adverb'] or ''}{third_person(base)}"


def sides_of_the_person(text: str) -> str:
    """`right hand (our left hand)` -> `right hand`."""
    return _VIEWER.sub(lambda found: f"{found['side']}{found['limb'] or ''}", text)


def completed(text: str) -> str:
    """Every direction with its verb, and ways back and forth as the turns that they are.

    `steps to the left, then to the right, then back` -> `steps to the left, then steps to the right, then steps back`
    """
    text = _BACK_AND_FORTH.sub(_there_and_back, text)
    while (longer := _SECOND_WAY.sub(_repeated, text)) != text:
        text = longer
    return text


def _relative(found: re.Match[str]) -> str:
    posture = re.fullmatch(_POSTURE, found["doing"])
    if posture:
        return f"{found['who']} {found['verb']}"
    return f"{found['who']} {found['verb']} while {found['doing']}{found['rest']}"


def _verb_follows(text: str, place: int) -> bool:
    word = re.match(r" ([a-z]+)", text[place:])
    return bool(word) and (word[1] in FINITE_FORMS or word[1] in GERUNDS)


def _there_and_back(found: re.Match[str]) -> str:
    verb = found["verb"]
    if verb in GERUNDS:
        return f"{verb}{found['how']} forward, then turning around, then {verb}{found['how']} forward"
    turn = "turn" if FINITE_FORMS[verb] == verb else "turns" if verb == third_person(FINITE_FORMS[verb]) else "turned"
    return f"{verb}{found['how']} forward, then {turn} around, then {verb}{found['how']} forward"


def _repeated(found: re.Match[str]) -> str:
    base = FINITE_FORMS.get(found["verb"]) or GERUNDS[found["verb"]]
    explicit = "then" in found["link"] or "," in found["link"]
    words = set(found["mid"].split())
    if (
        words & _WITH_OBJECT
        or (base in _TURNS and not explicit)
        or (base == "take" and not _STEPS.search(found["mid"]))
    ):
        return found.group()
    if found["way"] in {"up", "down"} or found["second"] in {"up", "down"}:
        return found.group()
    diagonal = found["link"] == " and " and found["way"] in {"forward", "forwards", "back", "backward", "backwards"}
    if diagonal and re.search(r"left|right", found["second"]):
        return found.group()
    if re.search(r"\b(?:head|torso|waist|body|hips?) (?:is|are|was|were) $", found.string[: found.start()]):
        return found.group()
    object_ = " a step" if base == "take" and not _STEPS.search(found["second"]) else ""
    link = found["link"] if "then" in found["link"] else ", then "
    return f"{found['verb']}{found['mid']} {found['way']}{link}{found['verb']}{object_} {found['second']}"
