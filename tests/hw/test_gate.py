"""The gate: what a judge really says opens it, and each forged or unfit verdict is refused by name."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from hw.gate import let_through
from ros_free_stack.criteria import limits_of, required_checks
from ros_free_stack.errors import InvalidFile, ModelMismatch, StackError, UnsafeCommand
from ros_free_stack.files import load_verdict, save_verdict
from ros_free_stack.messages import Check, Verdict
from ros_free_stack.robots import load_robot
from tests.hw.verdicts import judged, motion

OP3, G1 = load_robot("op3"), load_robot("g1")
TRAJECTORY = motion(OP3, seconds=0.2)
GOOD = judged(TRAJECTORY)

Forge = Callable[[Verdict], Verdict]


def changed(name: str, **fields: object) -> Forge:
    """A verdict with other numbers in one check."""

    def forge(verdict: Verdict) -> Verdict:
        checks = (replace(c, **fields) if c.name == name else c for c in verdict.checks)  # pyright: ignore[reportArgumentType]
        return replace(verdict, checks=tuple(checks))

    return forge


def without(*names: str) -> Forge:
    return lambda verdict: replace(verdict, checks=tuple(c for c in verdict.checks if c.name not in names))


def with_(*checks: Check) -> Forge:
    return lambda verdict: replace(verdict, checks=(*verdict.checks, *checks))


FORGED: dict[str, tuple[Forge, str]] = {
    "value over its limit": (changed("torque_peak", value=9.0), "says that torque_peak passed"),
    "value under its least": (changed("temporal_coherence", value=0.0), "says that temporal_coherence passed"),
    "no number": (changed("jerk", value=math.nan), "says that jerk passed"),
    "limit moved": (changed("zmp_outside", value=0.5, limit=1.0), "limit of zmp_outside is not this robot's"),
    "no limit": (changed("self_collision", limit=math.inf), "limit of self_collision is not this robot's"),
    "limit without a number": (changed("mpjpe_global", limit=math.nan), "limit of mpjpe_global is not this robot's"),
    "sense turned round": (changed("fall_height", value=9.0, minimum=True), "limit of fall_height is not this"),
    "other unit": (changed("joint_range", unit="deg"), "limit of joint_range is not this robot's"),
    "failed check": (changed("foot_skate", passed=False), r"did not pass .foot_skate."),
    "no check": (lambda v: replace(v, checks=()), "holds no check"),
    "one check left": (lambda v: replace(v, checks=v.checks[:1]), "lacks joint_velocity, "),
    "without a fall": (without("fall_height", "fall_orientation"), "lacks fall_height, fall_orientation"),
    "without power": (without("power_peak"), "lacks power_peak"),
    "check twice": (with_(GOOD.checks[0]), "joint_range more than once"),
    "invented check": (with_(Check("looks_good", 0.0, "1", 1.0, True)), r"there are not .looks_good."),
    "lenient": (lambda v: replace(v, level="lenient"), "limits are lenient"),
    "strict by word alone": (lambda v: replace(v, level="strict"), "is not this robot's"),
    "other limits": (lambda v: replace(v, limits_sha256="0" * 64), "other limits"),
    "no limits named": (lambda v: replace(v, limits_sha256=""), "other limits"),
    "without physics": (lambda v: replace(v, physics=False), "without physics"),
    "balance feedback": (lambda v: replace(v, controller="default"), r"default controller.*--mount fixed"),
    "whole-body control": (lambda v: replace(v, controller="wbc"), "wbc controller"),
    "held by its root": (lambda v: replace(v, mount="fixed"), "--mount fixed"),
    "other path": (lambda v: replace(v, path_digest="0" * 64), "another path between the frames"),
    "no path": (lambda v: replace(v, path_digest=""), "another path between the frames"),
    "other trajectory": (lambda v: replace(v, trajectory_digest="0" * 64), "another trajectory"),
    "other model": (lambda v: replace(v, model_sha256="0" * 64), "another trajectory or model"),
    "other robot": (lambda v: replace(v, robot="g1"), "of g1, not of op3"),
}


def test_let_through_takes_what_the_judge_says() -> None:
    let_through(TRAJECTORY, GOOD, OP3, "free")
    let_through(TRAJECTORY, GOOD, OP3, "fixed")
    let_through(TRAJECTORY, judged(TRAJECTORY, mount="fixed"), OP3, "fixed")
    let_through(TRAJECTORY, judged(TRAJECTORY, level="strict"), OP3, "free")


@pytest.mark.parametrize("name", FORGED)
def test_let_through_refuses_a_forged_verdict_by_name(name: str) -> None:
    forge, words = FORGED[name]
    with pytest.raises(UnsafeCommand, match=words):
        let_through(TRAJECTORY, forge(GOOD), OP3, "free")


def test_let_through_refuses_another_robot() -> None:
    with pytest.raises(ModelMismatch, match="not for this g1"):
        let_through(TRAJECTORY, GOOD, G1, "free")
    with pytest.raises(ModelMismatch, match="retarget and judge"):
        let_through(TRAJECTORY, GOOD, replace(OP3, sha256="0" * 64), "free")


@pytest.mark.parametrize("mount", ["free", "fixed"])
def test_let_through_demands_each_check_that_the_mount_requires(mount: str) -> None:
    verdict = judged(TRAJECTORY, mount=mount)  # pyright: ignore[reportArgumentType]
    for name in required_checks(OP3, verdict.mount):
        with pytest.raises(UnsafeCommand, match=f"lacks {name}"):
            let_through(TRAJECTORY, without(name)(verdict), OP3, "fixed")


def test_required_checks_of_a_held_robot_have_no_balance() -> None:
    free, fixed = set(required_checks(OP3, "free")), set(required_checks(OP3, "fixed"))
    assert free - fixed == {
        "ground_penetration",
        "floating",
        "foot_skate",
        "foot_skate_peak",
        "zmp_outside",
        "fall_height",
        "fall_orientation",
        "mpjpe_global",
    }
    assert fixed < free <= set(limits_of(OP3, "default"))
    assert "power_peak" not in required_checks(G1, "free")


@pytest.mark.parametrize(
    ("edit", "error", "words"),
    [
        (lambda data: data | {"passed": False}, InvalidFile, "says passed: false"),
        (lambda data: data | {"passed": "yes"}, InvalidFile, 'says passed: "yes"'),
        (lambda data: data["checks"][0].update(passed=False) or data, InvalidFile, "its checks do not"),
        (lambda data: data["checks"][0].update(value=2.0) or data, UnsafeCommand, "says that joint_range passed"),
        (lambda data: data["checks"][0].update(passed="true") or data, InvalidFile, "expected true or false"),
        (lambda data: data | {"level": "easy"}, InvalidFile, "expected one of strict, default, lenient"),
        (lambda data: data | {"state": "guessed"}, InvalidFile, "expected one of true, estimated"),
        (lambda data: {k: v for k, v in data.items() if k != "limits_sha256"}, UnsafeCommand, "other limits"),
        (lambda data: {k: v for k, v in data.items() if k != "controller"}, UnsafeCommand, "default controller"),
    ],
)
def test_load_verdict_of_a_file_edited_by_hand(
    tmp_path: Path, edit: Callable[[dict], dict], error: type[StackError], words: str
) -> None:
    path = tmp_path / "verdict.json"
    save_verdict(path, GOOD)
    assert load_verdict(path) == GOOD
    path.write_text(json.dumps(edit(json.loads(path.read_text()))))
    with pytest.raises(error, match=words):
        let_through(TRAJECTORY, load_verdict(path), OP3, "free")
