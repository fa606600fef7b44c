"""A proposal as a description file: YAML with a comment on everything that is a guess."""

import os
import re
from collections.abc import Iterable
from pathlib import Path

from retarget.describe.joint_limits import DEFAULT_ACCELERATION, DEFAULT_VELOCITY, EFFORT_SHARE
from retarget.describe.proposal import Proposal, rounded
from ros_free_stack.robots import Attachment, Capsule, JointLimits


def legal_name(text: str) -> str:
    """A robot's name made of a file's: lower-case letters, digits and underscores."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_") or "robot"


def model_entry(model: Path, folder: Path) -> dict[str, str]:
    """How a description in `folder` names a model file: relative to itself where they share a folder."""
    model, folder = model.resolve(), folder.resolve()
    near = folder in model.parents or folder.parent in model.parents
    return {"file": os.path.relpath(model, folder) if near else str(model)}


def description_text(proposal: Proposal, *, name: str, title: str, model: dict[str, str]) -> str:
    """The whole file."""
    notes = proposal.guessed
    lines = [
        f"# {title}. Proposed from its model; what is guessed says so.",
        f"name: {name}",
        f"title: {_text(title)}",
        "model:",
        *(f"  {key}: {_text(value)}" for key, value in model.items()),
        *([] if proposal.mount == "free" else ["mount: fixed"]),
        f"root_body: {_text(proposal.root_body)}",
        f"torso_body: {_text(proposal.torso_body)}",
        f"torso_lean: {proposal.torso_lean}{_note(notes, 'torso_lean')}",
        *_section("attachments", notes, (f"{joint}: {_attachment(at)}" for joint, at in proposal.attachments.items())),
        *_section("soles", notes, _soles(proposal)),
        *_section("capsules", notes, _capsules(proposal.capsules)),
        *_section("collision_pairs", notes, (f"{a}: [{', '.join(b)}]" for a, b in proposal.collision_pairs.items())),
        "",
        "limits_source: >-",
        *(f"  {line}" for line in limits_source(proposal)),
        "joints:",
        *(_joint(item, limits, proposal) for item, limits in proposal.limits.limits.items()),
        *_section("standing", notes, (f"{joint}: {angle}" for joint, angle in proposal.standing.items())),
    ]
    return "\n".join(lines) + "\n"


def limits_source(proposal: Proposal) -> list[str]:
    """Where the limits come from, one sentence a line."""
    swept = [name for name, words in proposal.limits.guessed.items() if "range" in words]
    weak = [name for name, words in proposal.limits.guessed.items() if "effort" in words]
    stated = len(proposal.limits.limits)
    lines: list[str] = []
    if len(swept) < stated:
        lines.append("Ranges are the model's own" + ("." if not swept else ", except where a comment says otherwise."))
    if swept:
        lines.append(
            "Ranges that the model lacks are swept: the joint turned until its limb meets itself or the trunk."
        )
    if len(weak) < stated:
        lines.append("Torques are the model's own" + ("." if not weak else ", except where a comment says otherwise."))
    if weak:
        lines.append(
            f"Torques that the model lacks are guessed: {EFFORT_SHARE:g} of the weight at an arm of the robot's size."
        )
    lines.append(
        f"Speeds and accelerations are guessed, since MuJoCo models state none: {DEFAULT_VELOCITY:g} rad/s and "
        f"{DEFAULT_ACCELERATION:g} rad/s^2; put the maker's figures in their place."
    )
    return lines


def _section(key: str, notes: dict[str, str], entries: Iterable[str]) -> list[str]:
    lines = [f"  {entry}" for entry in entries]
    return ["", *([f"# {notes[key]}"] if key in notes else []), f"{key}:", *lines] if lines else []


def _note(notes: dict[str, str], key: str) -> str:
    return f"  # {notes[key]}" if key in notes else ""


def _attachment(item: Attachment) -> str:
    offset = f", offset: {_numbers(item.offset)}" if any(item.offset) else ""
    return f"{{body: {_text(item.body)}{offset}}}"


def _soles(proposal: Proposal) -> Iterable[str]:
    for side, (body, corners) in proposal.soles.items():
        places = ", ".join(_numbers(rounded(corner)) for corner in corners)
        yield f"{side}: {{body: {_text(body)}, ankle: {side}_ankle, corners: [{places}]}}"


def _capsules(capsules: dict[str, tuple[Capsule, ...]]) -> Iterable[str]:
    for body, items in capsules.items():
        texts = [f"{{start: {_numbers(c.start)}, end: {_numbers(c.end)}, radius: {c.radius:g}}}" for c in items]
        if len(texts) == 1:
            yield f"{_text(body)}: [{texts[0]}]"
        else:
            yield "\n".join([f"{_text(body)}:", *(f"    - {text}" for text in texts)])


def _joint(name: str, limits: JointLimits, proposal: Proposal) -> str:
    words = proposal.limits.guessed[name]
    note = f"  # guessed: {', '.join(words)}" if words else ""
    return (
        f"  {_text(name)}: {{range: [{limits.lower:g}, {limits.upper:g}], velocity: {limits.velocity:g}, "
        f"acceleration: {limits.acceleration:g}, effort: {limits.effort:g}}}{note}"
    )


def _numbers(point: Iterable[float]) -> str:
    return "[" + ", ".join(f"{value + 0.0:g}" for value in point) + "]"


def _text(value: str) -> str:
    """A YAML string: quoted where it could be read as something else."""
    plain = value.replace("_", "").replace("-", "").isalnum() and not value[0].isdigit()
    words = value.lower() not in ("yes", "no", "on", "off", "true", "false", "null", "y", "n")
    return value if plain and words else "'" + value.replace("'", "''") + "'"
