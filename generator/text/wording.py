"""Plain wording before the parse: one spelling for connectives and counts, no lead-ins, no fillers."""

import re

from generator.text.amounts import plain_amounts
from generator.text.ellipsis import completed, described, sides_of_the_person
from generator.text.inflection import FINITE_FORMS, GERUNDS, PARTICIPLES, gerund, third_person, word_set
from generator.text.spoken import motion_words

_NUMBERS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
NUMBER = "|".join((*_NUMBERS, *map(str, range(len(_NUMBERS)))))

PEOPLE = word_set(
    """
    bot dude humanoid op3 g1 h1 t1 toddler lad fellow avatar mannequin
    person man woman guy boy girl lady gentleman human humanoid individual figure character robot actor dancer kid
    child stickman subject male female someone somebody he she it they you we i one
    people men women guys boys girls ladies gentlemen humans individuals figures persons dancers robots
    """
)
LIMBS = word_set("hand hands arm arms leg legs foot feet head knee knees elbow elbows shoulder shoulders palm palms")
SUBORDINATORS = frozenset({"after", "before", "while", "as", "when"})
SUBJECT = "he"

_VERBS = "|".join(sorted(FINITE_FORMS, key=len, reverse=True))
_PRONOUN = r"(?:he|she|it|they|you|we|i|one|someone|(?:the|a) (?:person|man|woman|robot|figure|guy|human))"
_SYMBOLS = (
    (re.compile(r"\s*(?:->|=>|→|>)\s*"), " then "),
    (re.compile(r"\s*[&+]\s*"), " and "),
    (re.compile(r"(^|[\s.;,])\d\s?[.)]\s+(?=[a-z])"), r"\1 . "),
    (re.compile(r"\(([a-z]+ly)\)"), r"\1"),
    (re.compile(r"[\"“”()\[\]:!?]+|\.{2,}|\s[-–—]+\s|—"), " . "),
    (re.compile(r"(?:\s*\.)+"), " ."),
)
_CONNECTIVES = (
    (re.compile(r"\bwhilst\b"), "while"),
    (re.compile(r"\bone after the other\b"), "one-after-the-other"),
    (re.compile(r"\bone after another\b"), "one-after-another"),
    (re.compile(r"(?<!more )(?<!less )(?<!other )(?<!rather )(?<!further )(?<!er )\bthan\b(?= (?:to )?\w+)"), "then"),
    (re.compile(r"\b(?:prior to|in advance of)\b"), "before"),
    (re.compile(r"\b(?:upon|on)(?= (?:\w+ing)\b)"), "after"),
    (re.compile(rf"\b(?:as soon as|once|now that)(?= {_PRONOUN}\b)"), "after"),
    (re.compile(rf"\b(?:after|when) ({_PRONOUN} )?(?:(?:has|have|had|is|are) )?(?:finish(?:ed|es)?|done)(?: with)? "
                r"(?=\w+ing\b)"), "after "),
    (re.compile(r"\b(?:only|just|shortly|soon|immediately|directly|straight)(?= (?:after|before)\b)"), ""),
    (re.compile(r"\b(?:(?:and )?(?:afterwards?|after (?:that|this|which)|following (?:that|this)|subsequently|"
                r"later on|(?:then )?finally|lastly|at last|in the end|at the end|eventually|next(?! to)|"
                r"second(?:ly)(?=[ ,])|third(?:ly)(?=[ ,])|(?:which is |is )?followed by)|and then)\b"), "then"),
    (re.compile(rf"(?:(?<=[.,;] )|(?<=and ))(?:first|second|third|fourth|fifth|last),? (?=(?:{_VERBS})\b)"), "then "),
    (re.compile(r",? ?\b(?:all )?(?:at the same time|simultaneously|meanwhile|in the meantime)\b,?"),
     " simultaneously"),
)  # fmt: skip
_MOTIONLESS = re.compile(
    r"^(?:(?:do not|don't|dont|never) move|no moving)(?: at all| a muscle| anymore| any more)?[ .!]*$"
)
_FIRST = re.compile(
    r"(^|[.;] ?|\b(?:he|she|they|person|man|woman|someone) )"
    r"(?:first(?:ly)?|at first|to (?:begin|start) with|initially),? "
)
_BUT_FIRST = re.compile(r"([^.;]+?),? but (?:first|before that|before this),? ([^.;]+)")
_HEDGES = re.compile(r"\b(?:appears?|seems?|is seen|can be seen) (?:to be |to |(?=\w+ing))")
_STARTS_BY = re.compile(
    r"\b(?:starts?|begins?|ends?|finish(?:es)?|continues?|concludes?)(?: off| out| up)? (?:by|with)(?= (\w+ing)\b)"
)
_RIGHT_BEFORE = re.compile(r"\b(\w+) right (?=(?:after|before)\b)")
_DIRECTED = word_set("turn look step lean walk move face go shift pivot run jump hop point glance sidestep")
_TIMES = re.compile(rf"\b(?:x ?(\d+)|({NUMBER}) ?(?:x|times?|×))(?![\w])")
_BOTH_OF = re.compile(r"\b(both|all) of (?=(?:the|his|her|their|your|its|my|our)\b)")
_OWN = re.compile(r"\b(his|her|their|your|its|my|our)(?: very)? own\b")
_POSSESSIVE = re.compile(rf"\b(?:(?:an?|the|this|that|another) )?(?:{'|'.join(sorted(PEOPLE))})'s (?:own )?(\w+)")
_PERFECT = re.compile(rf"\b({_PRONOUN} )(?:has|have|had|'ve) ((?:\w+ly )?)(\w+)\b")
_HAVING = re.compile(r"(^|[.,;] )?\b((?:(?:after|before) )?)having (\w+)\b")
_DURING = re.compile(r"\bduring (?=(?:an?|the|some)\b)")


def plain_wording(prompt: str) -> str:
    """Lower case, one spelling of counts ("twice", "three times"), of "then", "while" and "simultaneously"."""
    text = plain_amounts(sides_of_the_person(motion_words(prompt.lower().replace("’", "'"))))
    for pattern, plain in _SYMBOLS:
        text = pattern.sub(plain, text)
    text = _MOTIONLESS.sub("stand still", text)
    text = described(" ".join(text.split()).strip(" .,;"))
    text = _FIRST.sub(r"\1", text)
    text = _BUT_FIRST.sub(r"\2 . then \1", text)
    text = _HEDGES.sub(lambda found: "is " if found.group().endswith("be ") else "", text)
    text = _OWN.sub(r"\1", _BOTH_OF.sub(r"\1 ", text))
    text = _POSSESSIVE.sub(_possessive, text)
    text = _RIGHT_BEFORE.sub(_right_before, text)
    for pattern, plain in _CONNECTIVES:
        text = pattern.sub(plain, text)
    text = _STARTS_BY.sub(_starts_by, _HAVING.sub(_having, _PERFECT.sub(_perfect, text)))
    text = _DURING.sub("while doing ", text)
    text = " ".join(_TIMES.sub(_count, text.replace("thrice", "three times")).split()).strip(" .,;")
    return completed(text)


def _count(found: re.Match[str]) -> str:
    number = found.group(1) or found.group(2)
    word = _NUMBERS[int(number)] if number.isdigit() and int(number) < len(_NUMBERS) else number
    return {"one": "once", "two": "twice"}.get(word, f"{word} times")


def _possessive(found: re.Match[str]) -> str:
    """ "the person's left hand" to "the left hand"; "he's waving" to "he is waving"."""
    following = found.group(1)
    if following in GERUNDS or following.endswith("ing"):
        return found.group().replace("'s", " is")
    return f"the {following}"


def _right_before(found: re.Match[str]) -> str:
    """ "bows right before" to "bows before"; "turns right before" stays."""
    word = found.group(1)
    keeps = FINITE_FORMS.get(word) in _DIRECTED or GERUNDS.get(word) in _DIRECTED or word in {"the", "to"}
    return found.group() if keeps else f"{word} "


def _perfect(found: re.Match[str]) -> str:
    """ "he has turned" to "he turns"; "he has raised arms" too, "he has his arms up" stays."""
    base = FINITE_FORMS.get(found.group(3)) or PARTICIPLES.get(found.group(3))
    return found.group() if base is None else f"{found.group(1)}{found.group(2)}{third_person(base)}"


def _having(found: re.Match[str]) -> str:
    """ "after having bowed" to "after bowing"; "having bowed, he ..." to "after bowing, he ..."."""
    opener, link, word = found.groups()
    base = FINITE_FORMS.get(word) or PARTICIPLES.get(word)
    return found.group() if base is None else f"{opener or ''}{link or 'after '}{gerund(base)}"


def _starts_by(found: re.Match[str]) -> str:
    return "" if found.group(1) in GERUNDS else found.group()
