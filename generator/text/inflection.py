"""English verb forms: third person singular, gerund, and the way back from any form of a motion verb to its base.

The rules are those of school grammar; `MOTION_VERBS` (from the verbs that people use in captions of human motion)
tells verbs from nouns that look alike ("waves", "steps", "punch") where a tagger sees too little context.
"""

import re
from types import MappingProxyType


def word_set(words: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(words.split())


MOTION_VERBS = word_set(
    """
    accelerate advance approach balance beckon bend bounce bow box brace bring brush carry cartwheel catch chop
    circle clap clean clench climb close collapse come cover crawl creep cross crouch curl curtsy dab dance dash dip
    dive do dodge drag drink drop duck dust elbow enter exit extend face fall fight flail flap flex flip fold
    freeze gallop gesture get give glance go grab greet grip halt hit hold hop hug hunch hurdle hurry imitate
    inspect jab
    jerk jog juggle jump kick kneel knock lean leap lie lift limp look lower lunge lurch make march mime mimic move
    nod open pace paddle pantomime pat pause perform pick pivot place play point pose pour practise practice prance
    pray press pretend proceed pull pump punch push put raise rock recover
    reach rest retreat return ride rise roll rotate rub run
    rush salute saunter scoop scratch scurry sway seem shadowbox shake shift shiver shrug shuffle sidestep set sit skate
    skip slam slap slide slip slouch smash sneak spin spread sprint squat squeeze stagger stamp stand start stay
    steady step stir stomp stoop stop straighten stretch stride strike stroll strut stumble swat sweep swim swing
    swipe take tap throw tilt tiptoe toss touch trip trot trudge tug tumble turn twirl twist type uncross unfold
    vault waddle wait walk wander wash wave weave wiggle wipe wobble yawn zigzag
    applaud motion rehearse gaze shimmy spar
    """
)

_IRREGULAR_THIRD = {"be": "is", "have": "has"}
_IRREGULAR_PAST = {
    "bend": "bent", "bring": "brought", "catch": "caught", "come": "came", "creep": "crept", "do": "did",
    "drink": "drank", "fall": "fell", "fight": "fought", "freeze": "froze", "get": "got", "give": "gave", "go": "went",
    "hit": "hit", "hold": "held", "kneel": "knelt", "leap": "leapt", "lie": "lay", "make": "made", "put": "put",
    "ride": "rode", "rise": "rose", "run": "ran", "set": "set", "shake": "shook", "sit": "sat", "slide": "slid",
    "spin": "spun",
    "spread": "spread", "stand": "stood", "stride": "strode", "strike": "struck", "sweep": "swept", "swim": "swam",
    "swing": "swung", "take": "took", "throw": "threw", "weave": "wove",
}  # fmt: skip
_DOUBLING_IN_LONG_WORDS = frozenset({"begin", "forget", "zigzag", "unzip", "admit", "prefer"})
_ONE_SHORT_SYLLABLE = re.compile(r"[^aeiou]*(?:qu)?[aeiouy][^aeiouwxy]")


def third_person(base: str) -> str:
    """ "wave" to "waves", "catch" to "catches", "carry" to "carries"."""
    if base in _IRREGULAR_THIRD:
        return _IRREGULAR_THIRD[base]
    if re.search(r"(?:s|x|z|ch|sh|o)$", base):
        return f"{base}es"
    if re.search(r"[^aeiou]y$", base):
        return f"{base[:-1]}ies"
    return f"{base}s"


def gerund(base: str) -> str:
    """ "wave" to "waving", "run" to "running", "lie" to "lying"."""
    if base.endswith("ie"):
        return f"{base[:-2]}ying"
    if base != "be" and re.search(r"[^eoy]e$", base):
        return f"{base[:-1]}ing"
    return f"{_doubled(base)}ing"


def past(base: str) -> str:
    """ "wave" to "waved", "clap" to "clapped", "throw" to "threw"."""
    if base in _IRREGULAR_PAST:
        return _IRREGULAR_PAST[base]
    if base.endswith("e"):
        return f"{base}d"
    if re.search(r"[^aeiou]y$", base):
        return f"{base[:-1]}ied"
    return f"{_doubled(base)}ed"


def _doubled(base: str) -> str:
    doubles = base in _DOUBLING_IN_LONG_WORDS or _ONE_SHORT_SYLLABLE.fullmatch(base)
    return base + base[-1] if doubles else base


def _forms() -> dict[str, str]:
    finite = {form(base): base for base in MOTION_VERBS for form in (past, third_person)}
    return finite | {base: base for base in MOTION_VERBS}


FINITE_FORMS = MappingProxyType(_forms())
"""Every base, third person and past form of a motion verb, to its base."""

GERUNDS = MappingProxyType({gerund(base): base for base in MOTION_VERBS})
"""Every gerund of a motion verb, to its base."""
