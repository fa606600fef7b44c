"""One clause to an action frame: the row of the lexicon that explains most of its words, and what it leaves over."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from generator.text.clause_tokens import ARMS, LEGS, SIDES, ClauseTokens
from generator.text.frame import ActionFrame, Unknown
from generator.text.lexicon import ANY, Row, Way, actions, rows, verbs, ways_of, word_lists

VERB, NEEDED, ALLOWED, OBJECT = 3.0, 2.0, 1.0, 0.5
LEFT_OVER, LOST_VERB, UNKNOWN_ROW = -1.0, -4.0, 0.6
_BEFORE_VERB = frozenset({"to", "and", "by", "then", "or", "is", "for"})
_BEFORE_SIDE = frozenset({"with", "on", "using", "use"})


@dataclass
class Match:
    """A clause as one row reads it; places are those of tokens."""

    row: Row
    score: float
    head: int
    explained: set[int]
    objects: list[int] = field(default_factory=list[int])
    left: list[int] = field(default_factory=list[int])
    side: str = ""
    way: str = ""
    speed: str = ""
    options: dict[str, str] = field(default_factory=dict[str, str])


def best_matches(clause: ClauseTokens) -> tuple[Match | None, Match | None]:
    """The match that explains most, and the best one as a known action; None where no row fits."""
    found = [match for row in rows() if (match := _read(row, clause)) is not None]
    found.sort(key=lambda match: -match.score)
    return next(iter(found), None), next((match for match in found if match.row.known), None)


def action_frame(clause: ClauseTokens, match: Match) -> ActionFrame:
    """The frame of a match of a known action."""
    meaning = len(match.explained) + len(match.left)
    return ActionFrame(
        action=match.row.action,
        side=match.side,
        way=match.way,
        speed=match.speed,
        amounts=dict(clause.amounts),
        options={**match.options, **match.row.options},
        words=clause.text,
        objects=tuple(
            clause.tokens[i].text
            for i in sorted((*match.objects, *match.left))
            if i < clause.compared and not clause.tokens[i].text.endswith("ly")
        ),
        confidence=len(match.explained) / meaning if meaning else 1.0,
    )


def unknown_action(clause: ClauseTokens, match: Match | None) -> Unknown:
    """What of a clause names an action that is not known."""
    if match is not None:
        places = sorted(match.explained)
        return Unknown(" ".join(clause.tokens[i].text for i in places), match.row.near, clause.text)
    light, neutral = word_lists()["light"], word_lists()["neutral"]
    head = clause.tokens[clause.head] if len(clause) else None
    if head is not None and head.lemma not in light:
        return Unknown(head.text, clause=clause.text)
    named = [token.text for token in clause.tokens[clause.head + 1 :] if token.text not in neutral]
    return Unknown(" ".join(named[:3]) or clause.text, clause=clause.text)


def _read(row: Row, clause: ClauseTokens) -> Match | None:
    head = _verb(row, clause)
    if head is None:
        return None
    used: set[int] = set() if head < 0 else {head}
    for group in row.needed:
        place = _find(group, clause, used)
        if not place:
            return None
        used |= place
    if any(_find({word}, clause, used) for word in row.barred):
        return None
    match = Match(row, 0.0, head, set(used))
    if row.known:
        _details(match, clause)
    else:
        match.explained |= set(clause.measured)
    _leave(match, clause)
    score = VERB + NEEDED * len(row.needed) + OBJECT * len(match.objects) + LEFT_OVER * len(match.left)
    score += ALLOWED * (len(match.explained) - len(used))
    if row.known and clause.head not in match.explained and not _is_light(clause):
        score += LOST_VERB
    if not row.known:
        match.explained = used
        score += UNKNOWN_ROW - LEFT_OVER * len(match.left)
    match.score = score
    return match if score > 0 else None


def _verb(row: Row, clause: ClauseTokens) -> int | None:
    """Place of the row's verb, -1 where it has none, None where the clause lacks it."""
    if not row.verbs:
        return -1
    light = _is_light(clause)
    for i, token in enumerate(clause.tokens):
        if i < clause.compared and token.among(row.verbs):
            before = clause.tokens[i - 1].text if i else ""
            if i == clause.head or light or before in _BEFORE_VERB or clause.gerund(i) or clause.finite(i):
                return i
    return None


def _is_light(clause: ClauseTokens) -> bool:
    return bool(len(clause)) and clause.tokens[clause.head].lemma in word_lists()["light"]


def _find(words: set[str] | frozenset[str], clause: ClauseTokens, used: set[int]) -> set[int]:
    """Places of the first of the words that stands there and is not used yet; "a_b" is two words in a row."""
    for i, token in enumerate(clause.tokens):
        if i not in used and i not in clause.told_sides and token.among(words):
            return {i}
    for compound in (word.split("_") for word in words if "_" in word):
        for i in range(len(clause) - len(compound) + 1):
            window = clause.tokens[i : i + len(compound)]
            if all(token.among({word}) for token, word in zip(window, compound, strict=True)):
                return set(range(i, i + len(compound)))
    return set()


def _details(match: Match, clause: ClauseTokens) -> None:
    """Side, way, speed and size."""
    action = actions()[match.row.action]
    match.explained |= set(clause.measured)
    for limb in clause.limbs:
        if limb.lemma in match.row.allowed or limb.place in match.explained or _acts(action.limb, limb.lemma):
            sided = bool(action.limb) or limb.side not in SIDES or limb.lemma not in ARMS | LEGS
            match.explained |= {limb.place, *(limb.told_by if sided else ())}
    match.side = _side(match, clause)
    match.way = match.row.options.get("direction", "") or _way(match, clause, ways_of(action.name))
    lists = word_lists()
    for i, token in enumerate(clause.tokens):
        for speed in ("slow", "fast"):
            if token.text in lists[speed]:
                match.speed = speed
                match.explained.add(i)
        if token.among(lists["size"]):
            match.explained.add(i)
        if token.among(match.row.allowed) or any(token.among(group) for group in match.row.needed):
            match.explained.add(i)
            if token.lemma in {"lower"}:
                match.options["lower"] = "yes"


def _acts(limb: str, named: str) -> bool:
    """Whether an action of that limb is done with the named one."""
    if limb in ("hand", "arm"):
        return named in ARMS
    return limb in ("leg", "knee", "foot") and named in LEGS


def _side(match: Match, clause: ClauseTokens) -> str:
    """The side of the limb that acts."""
    limb = actions()[match.row.action].limb
    acting = [named for named in clause.limbs if _acts(limb, named.lemma) and named.place < clause.compared]
    with_it = [
        named
        for named in acting
        if _BEFORE_SIDE & {t.text for t in clause.tokens[max(0, named.place - 4) : named.place]}
    ]
    if match.row.action == "shake_hand":  # "shakes hands" is done with one
        acting = [named for named in acting if named.told_by]
    chosen = next((named for named in (*with_it, *acting) if named.side and named in acting), None)
    if chosen is not None:
        lifted = match.row.action == "balance" and chosen not in with_it and chosen.side in SIDES
        if lifted and any(token.lemma in {"lift", "raise", "hold"} for token in clause.tokens):
            return next(iter(SIDES - {chosen.side}))
        return chosen.side
    if not limb or acting:
        return ""
    for i, token in enumerate(clause.tokens):
        near = {t.text for t in clause.tokens[max(0, i - 2) : i]}
        directed = any(way.name in SIDES for way in ways_of(match.row.action))
        if token.text in SIDES | {"both"} and (near & _BEFORE_SIDE or not directed) and "to" not in near:
            match.explained.add(i)
            return token.text
    return ""


def _way(match: Match, clause: ClauseTokens, choices: tuple[Way, ...]) -> str:
    """The first of the ways that the words say, in the order of the table."""
    taken = {i for limb in clause.limbs if limb.lemma in ARMS | LEGS for i in limb.told_by if i in clause.told_sides}
    free = [i for i in range(len(clause)) if i not in taken and i not in clause.measured]
    for way in choices:
        for words in way.words:
            places = [next((i for i in free if clause.tokens[i].among({word})), -1) for word in words]
            if min(places) >= 0:
                single = {word for words in way.words if len(words) == 1 for word in words}
                match.explained |= {*places, *(i for i in free if clause.tokens[i].among(single))}
                return way.name
    return ""


def _leave(match: Match, clause: ClauseTokens) -> None:
    """Sort what is not explained: objects, and what is left over."""
    lists = word_lists()
    wild = ANY in match.row.allowed
    for i, token in enumerate(clause.tokens):
        if i in match.explained or i >= clause.purpose or token.among(lists["neutral"]):
            continue
        if i == clause.head and token.lemma in lists["light"]:
            continue
        is_object = i > match.head and not token.text.endswith("ly") and i < clause.compared
        if is_object and token.lemma in lists["things"] and (wild or match.row.action in {"walk", "reach", "sit_down"}):
            continue
        if wild and is_object and token.text not in lists["direction"] and not _names_action(clause, i):
            match.objects.append(i)
        else:
            match.left.append(i)


def _names_action(clause: ClauseTokens, place: int) -> bool:
    """Whether a word is a verb form rather than an object."""
    before = clause.tokens[place - 1].text if place else ""
    return clause.tokens[place].lemma in verbs() and (clause.gerund(place) or before in {"and", "to"})


def left_over(clause: ClauseTokens, match: Match) -> Iterator[str]:
    """Phrases of the words that a match leaves over, with what leads in: `like a zombie`, `with a smile`."""
    places = sorted(match.left)
    if places and max(places) >= clause.compared:
        start = clause.compared
        yield " ".join(token.text for token in clause.tokens[start:])
        places = [place for place in places if place < start]
    group: list[int] = []
    for place in places:
        if group and any(clause.tokens[i].text not in word_lists()["neutral"] for i in range(group[-1] + 1, place)):
            yield _phrase(clause, group)
            group = []
        group.append(place)
    if group:
        yield _phrase(clause, group)


def _phrase(clause: ClauseTokens, group: list[int]) -> str:
    start = group[0]
    while start and clause.tokens[start - 1].text in {"a", "an", "the", "very", "with", "of", "his", "her", "their"}:
        start -= 1
    return " ".join(token.text for token in clause.tokens[start : group[-1] + 1])
