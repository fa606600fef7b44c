"""What a run says: two verdicts, whether the robot can do it and whether it is what was asked for."""

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pipeline.candidate import Candidate

PASSED = "PASSED"
INFEASIBLE = "INFEASIBLE"
NOT_AS_ASKED = "NOT AS ASKED"
LONGEST_NAME = 40
"""Letters of a prompt in the name of its folder."""
EXIT_CODES = {PASSED: 0, INFEASIBLE: 3, NOT_AS_ASKED: 5}


def outcome(best: "Candidate") -> str:
    """The run in a word."""
    if not best.judgement.passed:
        return INFEASIBLE
    return PASSED if best.sample.faithful else NOT_AS_ASKED


def verdict_words(best: "Candidate", searched: str) -> Iterator[str]:
    """Segments, what is not shown or not feasible, and both verdicts."""
    verdict = best.judgement.verdict
    for segment in best.motion.segments:
        yield f"{segment.start_s:5.2f} to {segment.end_s:5.2f} s  {segment.text}"
    yield from best.sample.amounts
    yield from (f"prompt mismatch: {line}" for line in best.sample.missing)
    yield from best.report.failures()
    yield searched
    yield from (note for note in verdict.notes if note.startswith(("played by", "changed", "tried")))
    for check in verdict.failures:
        yield f"failed {check.name}: {check.value:.3g} {check.unit}, limit {check.limit:.3g} {check.unit}"
    feasible = "yes" if verdict.passed else "no"
    faithful = "no, an action is missing" if not best.sample.faithful else "in part" if best.sample.missing else "yes"
    yield f"feasible: {feasible}; as asked: {faithful}"
    yield f"verdict: {outcome(best)}"


def closing_words(folder: str, servo: dict[str, Any] | None, *, dry_run: bool) -> Iterator[str]:
    """What the servos did, and where the report is."""
    if servo is not None and dry_run:
        yield f"servos: dry run, {servo['joints']} servos on {servo['port']} are ready, nothing was written"
    elif servo is not None:
        yield (
            f"servos: {servo['cycles']} cycles at {servo['rate_hz']:.1f} Hz, "
            f"jitter p99 {servo['jitter_p99_ms']:.2f} ms, {_noted(len(servo['errors']))}"
        )
    yield f"report: {folder}/report.html"


def searched_words(found: "tuple[Candidate, ...]", candidates: int, *, exhaustive: bool) -> str:
    """How far the search went."""
    robot = found[0].trajectory.robot
    feasible = sum(candidate.judgement.passed for candidate in found)
    if exhaustive or not feasible or len(found) == candidates:
        return f"{feasible} of {len(found)} candidates are feasible on {robot}"
    return (
        f"candidate {len(found)} of {candidates}, in the order in which they show the sentence, is the first that is "
        f"feasible on {robot}; --exhaustive judges them all"
    )


def slug(prompt: str) -> str:
    """A prompt as part of a folder's name."""
    return re.sub(r"[^a-z0-9]+", "-", prompt.lower()).strip("-")[:LONGEST_NAME].rstrip("-") or "prompt"


def _noted(count: int) -> str:
    """How often something went wrong that did not stop the stream."""
    return "no incidents" if not count else f"{count} incident{'s' * (count > 1)} without effect on the motion"
