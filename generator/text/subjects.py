"""The subject "he" for every clause.

Terse prompts ("squats twice", "wave, then bow") mislead a parser, which takes their verbs for nouns. Given a subject
("he squats twice") it reads them right, so this module writes one in wherever a clause begins with a motion verb.
"""

import re

from generator.text.inflection import FINITE_FORMS, GERUNDS, past, third_person, word_set
from generator.text.wording import LIMBS, NUMBER, PEOPLE, SUBJECT, SUBORDINATORS

# After these a clause may begin.
_OPENERS = frozenset({"", ".", ";", ",", "and", "or", "but", "then", "simultaneously"})
_OPENING = r"(^|[.,;] |\b(?:and|or|but|then|simultaneously|after|before|while|as|when) )"
_PERSON = "|".join(sorted(PEOPLE))
_HUMAN_SUBJECT = re.compile(
    rf"{_OPENING}(?:(?:an?|the|this|that|some|another|one|two|three|both|all) (?:[a-z]+ )?)?(?:{_PERSON}) (?!and |or )"
)
_VERBS = "|".join(sorted((third_person(base) for base in set(FINITE_FORMS.values())), key=len, reverse=True))
_SUBJECT_IN_RUN_ON = re.compile(
    rf"(?<!with )(?<!to )(?<!at )(?<!the )\b(?:(?:an?|the) (?:person|man|woman|robot|figure|guy|girl|boy)|he|she|they)"
    rf" (?=(?:{_VERBS}|is|are|was)\b)"
)
_MISPLACED_THEN = re.compile(rf"\b{SUBJECT} then\b")
_LEADING_PARTICIPLE = re.compile(rf"(^|[.;] )(\w+ing)( [^,.;]*)?, (?={SUBJECT} )")
_LIMB = "|".join(sorted(LIMBS))
_LIMB_SUBJECT = re.compile(
    rf"(^|[.,;] |\b(?:and|then|simultaneously) )((?:the|his|her|their|your|both|a|one)"
    rf"(?: (?:left|right|other|both))? (?:{_LIMB})) ((?:is|are|was|were) (?:being )?)?([a-z]+)\b"
    r"(?:(,? (?:and|then) )([a-z]+ed)\b)?"
)
_NOUN_ACTION = re.compile(
    rf"(^|[.,;] |\b(?:and|then|simultaneously|after|before) )"
    rf"((?:(?:an?|the|one more|another|{NUMBER}|some|a few|a couple of|several) (?:[a-z]+ )?)?)"
    r"(jumping jacks?|star jumps?|push ups?|[a-z]+)"
    r"(?=$| ?[.,;]| (?:and|then|with|to|while|before|after|in|of|on|forwards?|up|he|simultaneously)\b)"
)
_WORD = re.compile(r"[a-z0-9]+(?:['-][a-z0-9]+)*|[.,;]")
_ADVERB = re.compile(r"[a-z]{2,}ly|once|again|also|both|immediately")
_JACKS = frozenset({"jack", "jacks"})
_CLOSERS = word_set(
    """
    forward forwards backward backwards around back left right up down away twice once times again over off sideways
    still quickly slowly place
    """
)
_CLOSING_OBJECTS = LIMBS | {"it", "them"}
_DETERMINERS = word_set("a an the one two three four five some his her their your")
_LIGHT = word_set(
    "throw land deliver do perform try go start begin keep practise practice come get make take give have continue"
)
_COMPOUND = word_set("squat jump kick step turn lunge hop push pull press punch skip")
_EXERCISES = word_set("does do doing performs takes throws makes gives")


def with_subjects(text: str) -> str:
    """Every clause of a plain wording with the subject "he" and its motion verb in the third person.

    Gerunds after a subordinator and participles ("walks waving") stay as they are. A gerund that begins the text is a
    verb ("waving" is "he waves"), and so are those coordinated with it, unless a clause with a subject follows it.
    """
    text = _MISPLACED_THEN.sub(f"then {SUBJECT}", _HUMAN_SUBJECT.sub(rf"\1{SUBJECT} ", text))
    text = _SUBJECT_IN_RUN_ON.sub(f"{SUBJECT} ", text)
    text = _LEADING_PARTICIPLE.sub(_leading_participle, text)
    text = _LIMB_SUBJECT.sub(_limb_subject, _NOUN_ACTION.sub(_noun_action, text))
    words = _WORD.findall(text)
    out: list[str] = []
    gerunds_are_verbs = True
    form = ""
    for place, word in enumerate(words):
        adverbs = _trailing_adverbs(out)
        before = out[-1 - adverbs] if len(out) > adverbs else ""
        following = words[place + 1] if place + 1 < len(words) else ""
        if word == "jumping" and following in _JACKS and before == SUBJECT:
            out += ["does", word]
        elif before == SUBJECT and (word in FINITE_FORMS or word in GERUNDS):
            out.append(third_person(FINITE_FORMS.get(word) or GERUNDS[word]))
            gerunds_are_verbs = word in GERUNDS
            form = form or _form(word)
        elif before in _OPENERS and (base := _opening_verb(word, following, gerunds=gerunds_are_verbs)):
            out.insert(len(out) - adverbs, SUBJECT)
            out.append(third_person(base))
            gerunds_are_verbs = word in GERUNDS
            form = form or _form(word)
        elif form and _form(word) in {form, "base"} and _runs_on_here(out, words, place, form):
            out += [",", SUBJECT, third_person(FINITE_FORMS[word])]
        else:
            out.append(word)
            gerunds_are_verbs = _gerunds_are_verbs_after(word, gerunds_are_verbs)
    return " ".join(out)


def _form(word: str) -> str:
    """Which inflection a finite verb has: the first verb's is that of all the verbs of a run-on sentence."""
    base = FINITE_FORMS.get(word)
    return "" if base is None else {past(base): "past", third_person(base): "third", base: "base"}[word]


def _runs_on(words: list[str], place: int) -> bool:
    """ "walks forward | turns": a verb after what ends a clause. Not so "a left | punch", "does hand | claps"."""
    if words[place] in LIMBS or place < 2:
        return False
    before, earlier = words[place - 1], words[place - 2]
    if before in _CLOSING_OBJECTS:
        return not _EXERCISES & set(words[:place]) and place + 1 < len(words)
    to_the_side = words[place - 3 : place - 1] in (["to", "the"], ["on", "the"], ["to", "his"], ["to", "her"])
    return before in _CLOSERS and (earlier not in _DETERMINERS or to_the_side)


def _runs_on_here(out: list[str], words: list[str], place: int, form: str) -> bool:
    word = words[place]
    return _runs_on(words, place) or (_form(word) == form and _verb_after_verb(out, word))


def _verb_after_verb(out: list[str], word: str) -> bool:
    """ "wave | bow", "stop | turn around"; not "jump | kick", "try | walking"."""
    if len(out) < 2 or out[-2] != SUBJECT or word in LIMBS:
        return False
    first, second = FINITE_FORMS.get(out[-1], ""), FINITE_FORMS.get(word, "")
    return bool(first) and first not in _LIGHT and not (first in _COMPOUND and second in _COMPOUND)


def _gerunds_are_verbs_after(word: str, so_far: bool) -> bool:
    if word in {".", ";", "then"}:
        return True
    return so_far and word not in SUBORDINATORS and word not in {SUBJECT, "is", "are", "was"}


def _opening_verb(word: str, following: str, *, gerunds: bool) -> str | None:
    """The base of a motion verb that begins a clause, None for any other word."""
    if word in GERUNDS:
        return GERUNDS[word] if gerunds and following not in _JACKS else None
    return FINITE_FORMS.get(word)


def _leading_participle(found: re.Match[str]) -> str:
    """ "standing on one leg, he waves" to "while standing on one leg, he waves"."""
    if found.group(2) not in GERUNDS:
        return found.group()
    return f"{found.group(1)}while {found.group(2)}{found.group(3) or ''}, "


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
    opener, limb, passive, verb, link, second = found.groups()
    base = FINITE_FORMS.get(verb) or GERUNDS.get(verb)
    if base is None:
        return found.group()
    if not passive or verb in GERUNDS:
        tail = f"{link}{second}" if second else ""
        return f"{opener}{SUBJECT} {third_person(base)} with {limb}{tail}"
    then = f"{link}{SUBJECT} {third_person(FINITE_FORMS[second])} {_it(limb)}" if second in FINITE_FORMS else ""
    return f"{opener}{SUBJECT} {third_person(base)} {limb}{then}"


def _it(limb: str) -> str:
    return "them" if limb.endswith("s") or limb.endswith("feet") else "it"


def _trailing_adverbs(words: list[str]) -> int:
    count = 0
    while count < len(words) and _ADVERB.fullmatch(words[-1 - count]):
        count += 1
    return count
