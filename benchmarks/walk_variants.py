"""A walk in many files: does each come back as the same walk?

Every variant is a person's walk in a file as some program might write it: names of thirteen rigs, units, axes, channel
orders, rates, rest poses, text quirks, cuts, poses for calibration. What is read must have the right size, heading,
sides, rate and floor, or the reader must ask or refuse: nothing may be wrong without a word. One file in ten has a
fault besides that leaves no right answer or only one that has to be told.

    python -m benchmarks.walk_variants --count 2000
"""

import re
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro
from scipy.spatial.transform import Rotation

from benchmarks.rigs import RIGS, RigNames, build, world_turns, write
from ros_free_stack.errors import StackError
from ros_free_stack.formats.bvh import Bvh, write_bvh
from ros_free_stack.formats.frames import stand
from ros_free_stack.formats.registry import load_human
from ros_free_stack.formats.smpl import posed_joints
from ros_free_stack.formats.source import SourceOptions, Units
from ros_free_stack.formats.stature import METRES
from ros_free_stack.formats.upright import turned_up
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import INDEX

RATES = (24.0, 25.0, 29.97, 30.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)
ORDERS = ("ZXY", "ZYX", "XYZ", "YXZ", "YZX", "XZY")
LIMBS = tuple(f"{side}_{name}" for side in ("left", "right") for name in ("hip", "knee", "ankle", "shoulder", "elbow"))
FAULTY = 0.1
"""Share of the variants with a fault."""
ODD_UNIT_M = 0.003
"""A unit that nobody has, and in none of the others the person is one."""
TOLERANCE_M = 0.02
"""Largest error of hips, knees, ankles, shoulders and elbows."""

_HALF: dict[str, tuple[float, float, float]] = {
    "pelvis": (0, 0.94, 0), "spine1": (0, 1.055, -0.02), "spine2": (0, 1.185, -0.015), "spine3": (0, 1.25, -0.005),
    "neck": (0, 1.455, -0.02), "head": (0, 1.555, 0), "left_hip": (0.085, 0.865, 0), "left_knee": (0.085, 0.47, 0.02),
    "left_ankle": (0.085, 0.075, -0.02), "left_foot": (0.085, 0.02, 0.11), "left_collar": (0.075, 1.365, -0.015),
    "left_shoulder": (0.18, 1.4, -0.02), "left_elbow": (0.43, 1.39, -0.03), "left_wrist": (0.67, 1.39, -0.02),
}  # fmt: skip
_OTHER = {f"right{name.removeprefix('left')}": (-x, y, z) for name, (x, y, z) in _HALF.items() if name.startswith("l")}
REST = np.array([(_HALF | _OTHER)[name] for name in INDEX])
"""(22, 3) m, y up: a person of 1.7 m in the T-pose."""

_QUIRKS: dict[str, Callable[[str], bytes]] = {
    "plain": str.encode,
    "byte-order mark": lambda text: text.encode("utf-8-sig"),
    "UTF-16": lambda text: text.encode("utf-16"),
    "Windows line ends": lambda text: text.replace("\n", "\r\n").encode(),
    "old Mac line ends": lambda text: text.replace("\n", "\r").encode(),
    "ctrl-Z": lambda text: text.encode() + b"\x1a",
    "blank lines": lambda text: (
        text.replace("MOTION\n", "MOTION\n\n").replace("\nFrame Time", "\n\nFrame Time").encode()
    ),
    "lower-case keywords": lambda text: _keywords(text, str.lower),
    "upper-case keywords": lambda text: _keywords(text, str.upper),
    "mixed channels": lambda text: text.replace("Zposition", "ZPosition").replace("Xrotation", "xrotation").encode(),
    "braces on the line": lambda text: text.replace("\n{", " {").encode(),
    "one row more": lambda text: text.replace("Frames: ", "Frames: 1").encode(),
    "spaces at line ends": lambda text: text.replace("\n", " \t\n").encode(),
}


def _swapped(text: str) -> str:
    """A text whose names say left for right."""
    pairs = (("Left", "Right"), ("left", "right"), ("_l", "_r"), (".L", ".R"), (" L ", " R "), ("_L_", "_R_"))
    for left, right in (*pairs, ("JOINT L", "JOINT R"), ("JOINT l", "JOINT r"), (":L", ":R"), ("001_L", "001_R")):
        text = text.replace(left, "\0").replace(right, left).replace("\0", right)
    return text


_FRAME_TIME = re.compile(r"Frame Time: (\S+)")
_FAULTS: dict[str, Callable[[str], str]] = {
    "the rate as frame time": lambda text: _FRAME_TIME.sub(lambda m: f"Frame Time: {1 / float(m[1]):.4f}", text),
    "milliseconds": lambda text: _FRAME_TIME.sub(lambda m: f"Frame Time: {1000 * float(m[1]):.4f}", text),
    "a row cut short": lambda text: text.rstrip()[:-40],
    "left and right swapped": _swapped,
    "a nameless knee": lambda text: re.sub(
        r"JOINT \S*(?:Leg|[Cc]alf|[Ss]hin|[Kk]nee)\S*\n", "JOINT thing\n", text, count=1
    ),
}
"""Files in which one thing is wrong; the odd unit, which is no change of the text, is `odd unit`."""


@dataclass(frozen=True)
class Variant:
    """One file: how the walk is written in it."""

    rig: str
    prefix: str
    foreign_root: bool
    unit: Units
    up: str
    rest: str
    order: str
    moves: str
    all_move: bool
    fps: float
    quirk: str
    lead: str
    tall: float
    heading: float
    start: float
    seconds: float
    fault: str = ""


@dataclass(frozen=True)
class Arguments:
    """Options of the benchmark."""

    count: int = 2000
    """Variants."""
    seed: int = 0
    """Seed of their draw."""
    shown: int = 20
    """Failures to show."""


def draw(rng: np.random.Generator) -> Variant:
    """A variant at random."""

    def one(*choices: str) -> str:
        return choices[int(rng.integers(len(choices)))]

    rig = one(*RIGS)
    return Variant(
        rig=rig,
        prefix=one(*RIGS[rig].prefixes),
        foreign_root=bool(rng.random() < 0.2),
        unit=list(METRES)[int(rng.integers(len(METRES)))],
        up=one("y", "y", "z"),
        rest=one("T-pose", "T-pose", "arms down", "bones along x", "turned root"),
        order=one(*ORDERS),
        moves=one("XYZ", "XYZ", "XZY", "ZYX"),
        all_move=bool(rng.random() < 0.2),
        fps=float(rng.choice(RATES)),
        quirk=one(*_QUIRKS),
        lead=one("none", "none", "none", "one frame", "held", "last frame"),
        tall=float(rng.uniform(1.35, 2.05)),
        heading=float(rng.uniform(-np.pi, np.pi)),
        start=float(rng.uniform(0, 2)),
        seconds=float(rng.uniform(1.0, 3.0)),
        fault=one(*_FAULTS, "odd unit") if rng.random() < FAULTY else "",
    )


def walk(variant: Variant) -> tuple[dict[str, Floats], Floats, Floats]:
    """World rotations of the body's parts, places of the pelvis (T, 3), and joints (T, 22, 3), y up, m."""
    rest = variant.tall / 1.7 * REST
    time = variant.start + np.arange(round(variant.seconds * variant.fps) + 1) / variant.fps
    phase = 2 * np.pi * 0.9 * time
    local = np.zeros((len(time), 22, 3))
    local[:, 0, 1] = variant.heading + 0.1 * np.sin(phase)
    for side, sign in (("left", 1), ("right", -1)):
        swing = sign * np.sin(phase)
        local[:, INDEX[f"{side}_hip"], 0] = -0.45 * swing - 0.1
        local[:, INDEX[f"{side}_knee"], 0] = 0.35 + 0.35 * sign * np.cos(phase + 0.4)
        local[:, INDEX[f"{side}_ankle"], 0] = -0.15 + 0.2 * sign * np.cos(phase)
        local[:, INDEX[f"{side}_elbow"], 1] = -sign * (0.35 + 0.15 * swing)
        arm = Rotation.from_euler("zx", np.stack([np.full(len(time), -1.25 * sign), 0.4 * swing], axis=1))
        local[:, INDEX[f"{side}_shoulder"]] = arm.as_rotvec()
    along = np.array([np.sin(variant.heading), 0, np.cos(variant.heading)])
    root = 1.2 * (time - time[0])[:, None] * along + [0.3, 0, -0.8]
    joints = posed_joints(rest, local, root)
    root[:, 1] -= joints[..., 1].min(axis=1)  # the lower foot always stands
    joints = posed_joints(rest, local, root)
    turns = world_turns(Rotation.from_rotvec(local.reshape(-1, 3)).as_matrix().reshape(-1, 22, 3, 3))
    return turns, joints[:, 0], joints


def make(variant: Variant) -> tuple[bytes, Floats]:
    """The file of a variant and the (T, 22, 3) joints that are to be read from it, m, z up."""
    turns, root, joints = walk(variant)
    rig: RigNames = RIGS[variant.rig]
    upright = np.eye(3) if variant.up == "y" else np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    turns, root = _with_lead(variant, turns, root)
    turns = {role: upright @ turn for role, turn in turns.items()}
    bones = build(rig, variant.tall / 1.7 * REST, variant.prefix, foreign_root=variant.foreign_root)
    frames = {bone.role: _frame(variant, bone.role, upright) for bone in bones}
    data = write(
        bones,
        turns,
        root @ upright.T,
        fps=variant.fps,
        frames=frames,
        order=variant.order,
        moves=variant.moves,
        all_move=variant.all_move,
    )
    text = _text(data, ODD_UNIT_M if variant.fault == "odd unit" else METRES[variant.unit])
    text = _FAULTS[variant.fault](text) if variant.fault in _FAULTS else text
    return _QUIRKS[variant.quirk](text), stand(turned_up(joints, "y"))  # pyright: ignore


def judge(path: Path, variant: Variant, wanted: Floats) -> tuple[str, str]:
    """What became of a file: "right", "asked", "told" (wrong with a word about it) or "wrong"; and why."""
    try:
        motion, notes = load_human(path, SourceOptions())
    except StackError as error:
        return "asked", str(error).partition("\n")[0]
    problem = _problem(motion.joints, motion.fps, wanted, variant.fps)
    if not problem:
        return "right", ""
    doubts = [note for note in notes if "up: " in note or "--up overrules" in note or "settles" in note]
    return ("told", f"{problem}; {doubts[0]}") if doubts and "frames" not in problem else ("wrong", problem)


def _problem(joints: Floats, fps: float, wanted: Floats, rate: float) -> str:
    if abs(fps - rate) > 1e-3 * rate:
        return f"{fps:g} fps instead of {rate:g}"
    if len(joints) != len(wanted):
        return f"{len(joints)} frames instead of {len(wanted)}"
    places = [INDEX[name] for name in LIMBS]
    error = float(np.linalg.norm(joints[:, places] - wanted[:, places], axis=-1).max())
    return "" if error < TOLERANCE_M else f"joints are {100 * error:.0f} cm off"


def run(arguments: Arguments) -> tuple[Counter[str], list[str]]:
    """How often each outcome came, for sound files and faulty ones, and the variants that should not have got it."""
    rng = np.random.default_rng(arguments.seed)
    counts: Counter[str] = Counter()
    failures: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walk.bvh"
        for _ in range(arguments.count):
            variant = draw(rng)
            data, wanted = make(variant)
            path.write_bytes(data)
            outcome, why = judge(path, variant, wanted)
            counts[f"{'faulty' if variant.fault else 'sound'}, {outcome}"] += 1
            if outcome != "right" and (outcome == "wrong" or not variant.fault):
                failures.append(f"{outcome}: {why}\n    {variant}")
    return counts, failures


def _with_lead(variant: Variant, turns: dict[str, Floats], root: Floats) -> tuple[dict[str, Floats], Floats]:
    """The motion with a T-pose at the scene's origin before or after it."""
    count = {"none": 0, "one frame": 1, "held": round(variant.fps), "last frame": 1}[variant.lead]
    pose = np.tile(np.eye(3), (count, 1, 1))
    place = np.tile(variant.tall / 1.7 * REST[0], (count, 1))
    last = variant.lead == "last frame"
    parts = {role: (turn, pose) if last else (pose, turn) for role, turn in turns.items()}
    return {role: np.concatenate(part) for role, part in parts.items()}, np.concatenate(
        [root, place] if last else [place, root]
    )


def _frame(variant: Variant, role: str, upright: Floats) -> Floats:
    """The rig's own frame of a part of the body in the T-pose."""
    if variant.rest == "turned root":
        return np.eye(3)
    if variant.rest == "arms down" and role.partition("_")[2] in ("shoulder", "elbow", "wrist"):
        sign = 1 if role.startswith("left") else -1
        return Rotation.from_euler("z", 1.3 * sign).as_matrix() @ upright.T
    if variant.rest == "bones along x" and role != "pelvis":
        return Rotation.from_rotvec(np.random.default_rng(sum(map(ord, role))).normal(size=3)).as_matrix()
    return upright.T


def _text(data: Bvh, metres: float) -> str:
    """A BVH file's text, lengths in a unit of so many metres."""
    joints = tuple(replace(joint, offset=joint.offset / metres) for joint in data.joints)
    channels = [channel for joint in joints for channel in joint.channels]
    scale = np.array([1 / metres if channel.endswith("position") else 1.0 for channel in channels])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.bvh"
        write_bvh(path, Bvh(joints, data.values * scale, data.fps))
        return path.read_text(encoding="utf-8")


def _keywords(text: str, change: Callable[[str], str]) -> bytes:
    for word in ("HIERARCHY", "ROOT", "JOINT", "OFFSET", "CHANNELS", "End Site", "MOTION", "Frames:", "Frame Time:"):
        text = text.replace(word, change(word))
    return text.encode()


def main(arguments: Arguments) -> int:
    """Print the outcomes; 1 where a file was wrong without a word or fewer than 99 % were right."""
    counts, failures = run(arguments)
    wrong = 0
    for kind in ("sound", "faulty"):
        number = sum(count for name, count in counts.items() if name.startswith(kind))
        outcomes = {outcome: counts[f"{kind}, {outcome}"] for outcome in ("right", "asked", "told", "wrong")}
        shares = ", ".join(f"{outcome} {n} ({100 * n / max(number, 1):.1f} %)" for outcome, n in outcomes.items())
        print(f"{number} {kind} files: {shares}")
        wrong += outcomes["wrong"] + (kind == "sound" and outcomes["right"] < 0.99 * number)
    print("\n".join(failures[: arguments.shown]))
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main(tyro.cli(Arguments)))
