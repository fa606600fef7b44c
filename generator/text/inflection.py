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
    amble boogie chuck comb dice dribble elevate embrace flag fling gesture hobble hug hunker hurl indicate lob
    munch nibble plop pour prowl saunter scrub shove sip slice sprint stare stir stoop strafe stroll strum
    stretch totter veer whisk yank haul polish jab
    accelerate advance applaud approach ascend backpedal balance beckon begin bend bicycle blow bounce bow box brace
    breakdance bring brush carry cartwheel catch chat cheer chop circle clap clean clench climb close collapse come
    conduct continue cook cover cower crab cradle crawl creep cross crouch cry cuddle curl curtsy cycle dab dance
    dangle dash deliver demonstrate descend dig dip direct dive do dodge drag dribble drink drive drop duck dust eat
    elbow elevate end enter exit extend face fall fight finish flail flap flex flick flinch flip fly fold freeze
    gallivant gallop gaze genuflect gesture get give glance go grab grasp greet grip halt handstand haul headbang hit
    hold hop hug hunch hurdle hurry hustle idle imitate inspect jab jerk jiggle jog juggle jump keep kick kiss kneel
    knock lean leap leapfrog lie lift limp look loosen lower lunge lurch make march meander meditate mime mimic
    moonwalk motion move nod nudge open overtake pace paddle pantomime parade pat pause peek peer perform pick
    pirouette pivot place play plod point pop pose pour practice practise prance pray present press pretend proceed
    pull pump punch push put raise reach recover rehearse relax remove rest retreat return ride rise rock roll rotate
    rub run rush salute saunter scoop scoot scramble scratch scurry search seem set shadowbox shake shift shimmy
    shiver shove shrug shuffle shut sidestep sidle sing sink sit skate skateboard ski skip slam slap slide slip slouch
    slump smash sneak somersault spar spin spread sprint squat squeeze squirm stagger stamp stand start stay steady
    steer step stir stomp stoop stop straighten stretch stride strike stroll struggle strut stumble swagger swat sway
    sweep swerve swim swing swipe swivel take talk tap throw tighten tilt tiptoe toss touch tremble trip trot trudge
    tug tumble turn twerk twirl twist type uncross unfold vacuum vault waddle wait walk wander warm wash watch wave
    weave whirl wiggle wink wipe wobble wriggle write yank yawn zigzag
    """
)

_IRREGULAR_THIRD = {"be": "is", "have": "has"}
_IRREGULAR_PAST = {
    "begin": "began", "bend": "bent", "blow": "blew", "bring": "brought", "catch": "caught", "come": "came",
    "creep": "crept", "dig": "dug", "do": "did", "drink": "drank", "drive": "drove", "eat": "ate", "fall": "fell",
    "fight": "fought", "fly": "flew", "freeze": "froze", "get": "got", "give": "gave", "go": "went", "hit": "hit",
    "hold": "held", "keep": "kept", "kneel": "knelt", "leap": "leapt", "lie": "lay", "make": "made", "put": "put",
    "ride": "rode", "rise": "rose", "run": "ran", "set": "set", "shake": "shook", "shut": "shut", "sing": "sang",
    "sink": "sank", "sit": "sat", "slide": "slid", "spin": "spun", "spread": "spread", "stand": "stood",
    "stride": "strode", "strike": "struck", "sweep": "swept", "swim": "swam", "swing": "swung", "take": "took",
    "throw": "threw", "weave": "wove", "write": "wrote",
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

PARTICIPLES = MappingProxyType(
    {"done": "do", "gone": "go", "taken": "take", "risen": "rise", "fallen": "fall", "given": "give", "thrown": "throw",
     "shaken": "shake", "swum": "swim", "drunk": "drink", "ridden": "ride", "frozen": "freeze", "lain": "lie",
     "come": "come", "run": "run", "begun": "begin", "gotten": "get", "woven": "weave", "stridden": "stride"}
)  # fmt: skip
"""Participles of motion verbs that differ from the past form, to the base."""

GERUNDS = MappingProxyType({gerund(base): base for base in MOTION_VERBS})
"""Every gerund of a motion verb, to its base."""
