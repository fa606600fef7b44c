"""Plain wording before the parse: one spelling for connectives and counts, no lead-ins, a subject for every verb.

Terse prompts ("squats twice", "wave, then bow") mislead a parser, which takes their verbs for nouns. Given a subject
("he squats twice") it reads them right, so this module writes one in wherever a clause begins with a motion verb.
"""

import re

from generator.text.inflection import FINITE_FORMS, GERUNDS, third_person, word_set

_NUMBERS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
_NUMBER = "|".join((*_NUMBERS, *map(str, range(len(_NUMBERS)))))

_LEAD_INS = re.compile(
    r"^(?:(?:please|ok|okay|hey|hi|hello|now|so|robot|just|"
    r"(?:can|could|would|will) you|you (?:should|must|have to|need to)|"
    r"i(?: would|'d)? (?:want|like|need) "
    r"(?:you|him|her|it|them|someone|somebody|(?:the|a) (?:robot|person|man|woman)) to|"
    r"(?:make|let|have) (?:him|her|it|them|the robot|(?:a|the) (?:person|man|woman|figure))|let's|try to|"
    r"(?:show|generate|create|simulate|animate)(?: me)?(?= (?:a|an|the|some)\b)|"
    r"(?:an? |the )?(?:motion|animation|video|clip) (?:of|showing|in which))[, ]+)+"
)
_THEN = re.compile(
    r"\b(?:(?:and )?(?:afterwards?|after (?:that|this|which)|following (?:that|this)|subsequently|later on|"
    r"(?:then )?finally|lastly|at last|in the end|at the end|eventually|next(?! to)|second(?:ly)(?=[ ,])|"
    r"third(?:ly)(?=[ ,])|(?:which is |is )?followed by)|and then)\b"
)
_FIRST = re.compile(
    r"(^|[.;] ?|\b(?:he|she|they|person|man|woman|someone) )"
    r"(?:first(?:ly)?|at first|to (?:begin|start) with|initially),? "
)
_BUT_FIRST = re.compile(r"([^.;]+?),? but first ([^.;]+)")
_TOGETHER = re.compile(r",? ?\b(?:all )?(?:at the same time|simultaneously|meanwhile|in the meantime)\b,?")
_HEDGES = re.compile(r"\b(?:appears?|seems?|is seen|can be seen) (?:to be |to |(?=\w+ing))")
_TIMES = re.compile(rf"\b(?:x ?(\d+)|({_NUMBER}) ?(?:x|times?|×))(?![\w])")

# After these a clause may begin.
OPENERS = frozenset({"", ".", ";", ",", "and", "or", "but", "then", "simultaneously"})
SUBORDINATORS = frozenset({"after", "before", "while", "as", "when"})
SUBJECT = "he"

PEOPLE = word_set(
    """
    person man woman guy boy girl lady gentleman human humanoid individual figure character robot actor dancer kid
    child stickman subject male female someone somebody he she it they you we i
    """
)
_HUMAN_SUBJECT = re.compile(
    r"(^|[.,;] |\b(?:and|or|but|then|simultaneously|after|before|while|as|when) )"
    rf"(?:(?:an?|the|this|that|some|another|one) (?:[a-z]+ )?)?(?:{'|'.join(sorted(PEOPLE))})(?:'s)? (?!and |or )"
)
_MISPLACED_THEN = re.compile(rf"\b{SUBJECT} then\b")
LIMBS = word_set("hand hands arm arms leg legs foot feet head knee knees elbow elbows shoulder shoulders palm palms")
_LIMB = "|".join(sorted(LIMBS))
_LIMB_SUBJECT = re.compile(
    rf"(^|[.,;] |\b(?:and|then|simultaneously) )((?:the|his|her|their|your|both|a|one|a person's|the person's)"
    rf"(?: (?:left|right|other|both))? (?:{_LIMB})) ((?:is|are|was|were) (?:being )?)?([a-z]+)\b"
)
_NOUN_ACTION = re.compile(
    rf"(^|[.,;] |\b(?:and|then|simultaneously|after|before) )"
    rf"((?:(?:an?|the|one more|another|{_NUMBER}|some|a few|a couple of|several) (?:[a-z]+ )?)?)"
    r"(jumping jacks?|star jumps?|push ups?|[a-z]+)"
    r"(?=$| ?[.,;]| (?:and|then|with|to|while|before|after|in|of|forwards?|up)\b)"
)
_WORD = re.compile(r"[a-z0-9]+(?:['-][a-z0-9]+)*|[.,;]")
_ADVERB = re.compile(r"[a-z]{2,}ly|once|again|also|both|immediately")
_JACKS = frozenset({"jack", "jacks"})


def plain_wording(prompt: str) -> str:
    """Lower case, one spelling of counts ("twice", "three times"), of "then", "while" and "simultaneously"."""
    text = prompt.lower().replace("’", "'").strip()
    text = re.sub(r"[\"“”()\[\]:!?]+|\.{2,}|\s[-–—]+\s|—", " . ", text)
    text = re.sub(r"(?:\s*\.)+", " .", " ".join(text.split())).strip(" .,;")
    text = _LEAD_INS.sub("", text)
    text = _FIRST.sub(r"\1", text)
    text = _BUT_FIRST.sub(r"\2 . then \1", text.replace("whilst", "while"))
    text = _HEDGES.sub(lambda found: "is " if found.group().endswith("be ") else "", text)
    text = _THEN.sub("then", text)
    text = _TOGETHER.sub(" simultaneously", text)
    return " ".join(_TIMES.sub(_count, text).split())


def _count(found: re.Match[str]) -> str:
    number = found.group(1) or found.group(2)
    word = _NUMBERS[int(number)] if number.isdigit() and int(number) < len(_NUMBERS) else number
    return {"one": "once", "two": "twice"}.get(word, f"{word} times")


def with_subjects(text: str) -> str:
    """Every clause with the subject "he" and its motion verb in the third person; gerunds after a subordinator and
    participles ("walks waving") stay as they are.

    A gerund that begins the text is a verb ("waving" is "he waves"), and so are those coordinated with it.
    """
    text = _MISPLACED_THEN.sub(f"then {SUBJECT}", _HUMAN_SUBJECT.sub(rf"\1{SUBJECT} ", text))
    text = _LIMB_SUBJECT.sub(_limb_subject, _NOUN_ACTION.sub(_noun_action, text))
    words = _WORD.findall(text)
    out: list[str] = []
    gerunds_are_verbs = True
    for place, word in enumerate(words):
        adverbs = _trailing_adverbs(out)
        before = out[-1 - adverbs] if len(out) > adverbs else ""
        following = words[place + 1] if place + 1 < len(words) else ""
        if before == SUBJECT and (word in FINITE_FORMS or word in GERUNDS):
            out.append(third_person(FINITE_FORMS.get(word) or GERUNDS[word]))
            gerunds_are_verbs = word in GERUNDS
        elif before in OPENERS and (base := _opening_verb(word, following, gerunds=gerunds_are_verbs)):
            out.insert(len(out) - adverbs, SUBJECT)
            out.append(third_person(base))
            gerunds_are_verbs = word in GERUNDS
        else:
            out.append(word)
            gerunds_are_verbs = _gerunds_are_verbs_after(word, gerunds_are_verbs)
    return " ".join(out)


def _gerunds_are_verbs_after(word: str, so_far: bool) -> bool:
    if word in {".", ";", "then"}:
        return True
    return so_far and word not in SUBORDINATORS and word not in {SUBJECT, "is", "are", "was"}


def _opening_verb(word: str, following: str, *, gerunds: bool) -> str | None:
    """The base of a motion verb that begins a clause, None for any other word."""
    if word in GERUNDS:
        return GERUNDS[word] if gerunds and following not in _JACKS else None
    return FINITE_FORMS.get(word)


def _noun_action(found: re.Match[str]) -> str:
    """ "a bow" to "does a bow", "after a bow" to "after doing a bow"; other nouns are left alone."""
    opener, quantity, noun = found.groups()
    compound = " " in noun
    if not compound and not (quantity and noun in FINITE_FORMS):
        return found.group()
    verb = "doing" if opener.strip() in {"after", "before"} else f"{SUBJECT} does"
    return f"{opener}{verb} {quantity}{noun}"


def _limb_subject(found: re.Match[str]) -> str:
    """ "the left hand waves" to "he waves with the left hand", "the left arm is raised" to "he raises the left arm"."""
    opener, limb, passive, verb = found.groups()
    base = FINITE_FORMS.get(verb) or GERUNDS.get(verb)
    if base is None:
        return found.group()
    return f"{opener}{SUBJECT} {third_person(base)} {'' if passive and verb in FINITE_FORMS else 'with '}{limb}"


def _trailing_adverbs(words: list[str]) -> int:
    count = 0
    while count < len(words) and _ADVERB.fullmatch(words[-1 - count]):
        count += 1
    return count
