"""Segment texts to moments: each clause to its action frame, and what only their order tells."""

from collections.abc import Sequence
from dataclasses import replace

from generator.text import lexicon
from generator.text.clause_frame import action_frame, best_matches, left_over, unknown_action
from generator.text.clause_parts import apart, with_purpose
from generator.text.clause_tokens import ClauseTokens
from generator.text.frame import ActionFrame, Amount, Moment, Unknown, Words
from generator.text.inflection import FINITE_FORMS, GERUNDS, third_person
from generator.text.meanwhile import LINK
from generator.text.splitter import PERSON

AROUND = 180.0


def moments(segments: Sequence[str]) -> tuple[Moment, ...]:
    """The moments of segment texts in temporal order; a segment of several actions in order gives several.

    Raises:
        InvalidPrompt: an amount is out of the range that works.
    """
    found: list[Moment] = []
    for segment in segments:
        found.extend(_segment(segment, found))
    shown = [moment for moment in found if moment.actions or moment.unknown]
    return tuple(shown or [replace(moment, unknown=(Unknown(moment.words),)) for moment in found])


def _segment(segment: str, before: Sequence[Moment]) -> list[Moment]:
    if not segment.startswith(f"{PERSON} "):
        limb = any(named.place < 3 for named in ClauseTokens(segment).limbs)
        return [Moment(segment, (), (Words(segment),)) if limb else Moment(segment, (), unknown=(Unknown(segment),))]
    if ClauseTokens(segment.removeprefix(f"{PERSON} ")).completes and before:
        return []
    main, *meanwhile = segment.removeprefix(f"{PERSON} ").split(LINK)
    parts = _in_order(main)
    clauses = [part for rest in meanwhile for part in _at_once(rest)]
    texts = [f"{PERSON} {part}" for part in parts]
    if clauses:
        texts[0] = segment if len(parts) == 1 else LINK.join([texts[0], *meanwhile])
    return [
        _moment(text, [part, *clauses] if place == 0 else [part], before)
        for place, (text, part) in enumerate(zip(texts, parts, strict=True))
    ]


def _moment(words: str, clauses: Sequence[str], before: Sequence[Moment]) -> Moment:
    actions: list[ActionFrame] = []
    not_shown: list[Words] = []
    unknown: list[Unknown] = []
    for text in (part for clause in clauses for part in apart(clause)):
        clause = ClauseTokens(text)
        best, match = best_matches(clause)
        if best is None or best is not match:
            unknown.append(unknown_action(clause, best))
        if match is None:
            continue
        frame = _fitting(action_frame(clause, match), clause, before)
        if "count" in frame.amounts and not lexicon.actions()[frame.action].counts:
            not_shown.append(Words(frame.amounts["count"].text))
        _add(actions, frame)
        not_shown += [Words(phrase) for phrase in left_over(clause, match)]
    return Moment(words, tuple(actions), tuple(not_shown), tuple(unknown))


def _add(actions: list[ActionFrame], frame: ActionFrame) -> None:
    """One action that is told twice stays one: "makes a turn pivoting to the left"."""
    for place, other in enumerate(actions):
        if other.action == frame.action and (other.side == frame.side or not frame.side):
            actions[place] = replace(
                other,
                way=other.way or frame.way,
                speed=other.speed or frame.speed,
                amounts={**frame.amounts, **other.amounts},
                words=f"{other.words} {frame.words}",
                objects=(*other.objects, *frame.objects),
            )
            return
    actions.append(frame)


def _in_order(main: str) -> list[str]:
    """The clause, or its parts joined by "and" where no row reads it whole."""
    pieces = _finite_pieces(main)
    if len(pieces) == 1:
        return with_purpose(main)
    _, whole = best_matches(ClauseTokens(main))
    parts = [best_matches(ClauseTokens(piece))[1] for piece in pieces]
    if whole is not None and (not whole.left or any(part is None for part in parts)):
        return [main]
    return pieces


def _finite_pieces(text: str) -> list[str]:
    """A clause cut before each "and" that a finite verb follows."""
    pieces = [[]] if not text else [[text.split(maxsplit=1)[0]]]
    words = text.split()
    for place in range(1, len(words)):
        following = words[place + 1] if place + 1 < len(words) else ""
        if words[place] == "and" and following in FINITE_FORMS and FINITE_FORMS[following] != following:
            pieces.append([])
        else:
            pieces[-1].append(words[place])
    return [" ".join(piece) for piece in pieces if piece]


def _at_once(text: str) -> list[str]:
    """ "waving and slowly nodding" as finite clauses."""
    clauses: list[list[str]] = [[]]
    words = text.split()
    for place, word in enumerate(words):
        following = words[place + 1 : place + 3]
        if word == "and" and any(next_word in GERUNDS for next_word in following[:2]) and clauses[-1]:
            clauses.append([])
        else:
            clauses[-1].append(third_person(GERUNDS[word]) if word in GERUNDS and not _has_verb(clauses[-1]) else word)
    return [" ".join(clause) for clause in clauses if clause]


def _has_verb(words: Sequence[str]) -> bool:
    return any(word in FINITE_FORMS for word in words)


def _fitting(frame: ActionFrame, clause: ClauseTokens, before: Sequence[Moment]) -> ActionFrame:
    """What a word means beside the others and after what came before."""
    words = {token.text for token in clause.tokens}
    lemmas = {token.lemma for token in clause.tokens}
    if "angle" in frame.options:
        frame = _turned(frame, float(frame.options["angle"]))
    if frame.action == "turn" and "angle" not in frame.amounts:
        if lemmas & {"circle"} or ("around" in words and frame.count and lemmas & {"spin", "turn"}):
            frame = _turned(frame, 2 * AROUND)
        elif (words & {"around", "round"} or ("back" in words and not frame.way)) and not lemmas & {
            "spin",
            "whirl",
            "twirl",
        }:
            frame = _turned(frame, AROUND)
    onward = frame.action in {"walk", "jog", "step"} and frame.way in {"backward", ""}
    if onward and "back" in words and not words & {"backward", "backwards"} and _has_turned(before):
        frame = replace(frame, way="forward")
    return frame


def _turned(frame: ActionFrame, degrees: float) -> ActionFrame:
    count = frame.count or 1
    amount = Amount("angle", degrees * count, "around", (0, 0))
    kept = {kind: amount for kind, amount in frame.amounts.items() if kind != "count" or degrees < 2 * AROUND}
    return replace(frame, amounts={**kept, "angle": amount})


def _has_turned(before: Sequence[Moment]) -> bool:
    """Whether the last moment turned the person around, so that "back" is ahead."""
    last = before[-1].actions if before else ()
    return any(frame.action == "turn" and (frame.value("angle") or 0) >= 135 for frame in last)
