"""Amounts of a sentence: which segments they belong to, how they are planned, and the last exact step."""

import numpy as np
import pytest

from generator.amounts import BENT, Measured, Wanted, fit, followed_words, measured, plan, wanted_of
from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from generator.text.frame import ActionFrame, Amount, Kind, Moment
from ros_free_stack.errors import InvalidPrompt
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS

WALK, WAVE = "a person walks forward", "a person waves"


def amount(kind: Kind, value: float) -> Amount:
    return Amount(kind, value, f"{value:g}", (0, 1))


def wanted(kind: Kind, value: float, segment: int = 0) -> Wanted:
    return Wanted(segment, segment + 1, amount(kind, value))


def walk() -> HumanMotion:
    scene = Scene(1)
    perform(scene, "walk", steps=5)
    positions = joints(scene.solve(0.5))
    return HumanMotion(positions, FPS, WALK, (Segment(WALK, 0.0, len(positions) / FPS),))


def test_wanted_of_names_the_segment_and_the_first_of_a_kind():
    frames = (
        ActionFrame("wave", amounts={"duration": amount("duration", 5.0), "count": amount("count", 2)}),
        ActionFrame("walk", amounts={"distance": amount("distance", 3.0), "duration": amount("duration", 9.0)}),
    )
    moments = (Moment("bows", (ActionFrame("bow"),)), Moment("waves while walking", frames))
    assert wanted_of(moments) == (wanted("distance", 3.0, 1), wanted("duration", 5.0, 1))


def test_plan_gives_a_segment_the_time_that_its_amount_needs():
    found = plan((WALK, WAVE), [wanted("distance", 3.0)], [Measured(1.5, 0.0, 2.5)])
    assert found.segments == (WALK, WAVE) and found.seconds == (5.0, None)
    found = plan((WALK, WAVE), [wanted("distance", 1.6)], [Measured(1.5, 0.0, 2.5)])
    assert found.seconds == (None, None), "what is near is bent"


def test_plan_repeats_what_is_too_long_at_once():
    found = plan((WAVE, WALK), [wanted("distance", 9.0, 1)], [Measured(1.5, 0.0, 2.5)])
    assert found.segments == (WAVE, WALK, WALK, WALK) and found.seconds == (None, 5.0, 5.0, 5.0)
    assert [(item.first, item.last) for item in found.wanted] == [(1, 4)]
    turned = plan((WALK,), [wanted("angle", 360.0)], [Measured(0.0, 90.0, 2.0)])
    assert len(turned.segments) == 4


def test_plan_refuses_what_no_motion_can_hold():
    with pytest.raises(InvalidPrompt, match="too much for one motion: about 38 is possible"):
        plan((WALK,), [wanted("distance", 90.0)], [Measured(1.5, 0.0, 2.5)])


@pytest.mark.parametrize(("kind", "factor"), [("distance", 0.8), ("distance", 1.3), ("duration", 1.4)])
def test_fit_comes_to_the_amount(kind: Kind, factor: float):
    motion = walk()
    (before,) = measured(motion, [wanted(kind, 1.0)])
    asked = wanted(kind, factor * before.of(kind))
    found = fit(motion, [asked], lambda bent: None, lambda bent, _: measured(bent, [asked]))
    assert found.measured[0].of(kind) == pytest.approx(asked.amount.value, rel=0.01)
    assert "not followed" not in followed_words([asked], found.measured)[0]


def test_fit_of_two_amounts_of_one_segment():
    motion = walk()
    (before,) = measured(motion, [wanted("distance", 1.0)])
    both = [wanted("distance", 1.2 * before.distance), wanted("duration", 1.3 * before.duration)]
    found = fit(motion, both, lambda bent: None, lambda bent, _: measured(bent, both))
    assert found.measured[0].distance == pytest.approx(both[0].amount.value, rel=0.02)
    assert found.measured[1].duration == pytest.approx(both[1].amount.value, abs=0.06)


def test_fit_goes_no_further_than_looks_natural_and_says_so():
    motion = walk()
    (before,) = measured(motion, [wanted("distance", 1.0)])
    asked = wanted("distance", 5 * before.distance)
    found = fit(motion, [asked], lambda bent: None, lambda bent, _: measured(bent, [asked]))
    assert found.measured[0].distance == pytest.approx(BENT["distance"][1] * before.distance, rel=0.01)
    assert followed_words([asked], found.measured)[0].endswith("(not followed)")


def test_fit_measures_what_becomes_of_the_motion_not_the_motion():
    """A robot that makes half of the person's way, whatever that is."""
    motion = walk()
    (before,) = measured(motion, [wanted("distance", 1.0)])
    asked = wanted("distance", 0.6 * before.distance)

    def robot(bent: HumanMotion, _: None) -> tuple[Measured, ...]:
        (human,) = measured(bent, [asked])
        return (Measured(human.distance / 2, human.angle, human.duration),)

    found = fit(motion, [asked], lambda bent: None, robot)
    assert found.measured[0].distance == pytest.approx(asked.amount.value, rel=0.01)
    assert np.isfinite(found.motion.joints).all()
