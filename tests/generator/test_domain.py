import re
from pathlib import Path

import numpy as np
import pytest

from generator.data.vocabulary import VOCABULARY, Draw, Voice, entry, phrase
from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from ros_free_stack.errors import InvalidFile, OutOfDomain


def _phrases(text: str) -> list[str]:
    return [f"a person {' '.join(part.split())}" for part in text.split(",")]


# The threshold was chosen on these two.
KNOWN_DEVELOPMENT = _phrases(
    """
    walks ahead, strolls ahead, greets with the left hand, does three squats, waves hello with both hands, bows
    politely, takes a bow, raises the left arm, lifts both arms overhead, applauds, points at something in
    front, takes a step backward, walks in a circle, turns around, marches on the spot, jabs with the right
    fist, throws a kick with the left leg, stands on one leg, looks left and right, hops on the right foot,
    leaps forward, sits on a chair, gets up from a chair, kneels on one knee, picks something up from the floor,
    stretches the arms, crosses the arms over the chest, puts the hands on the hips, shrugs the shoulders,
    shakes the head no, nods yes, salutes like a soldier, scratches the head, drinks from a cup, wipes a window,
    pushes a heavy box away, throws a ball, sneaks quietly, jogs in place, runs forward, does jumping jacks,
    lunges forward, tiptoes, dances happily, twists the torso, sways from side to side, leans to the left, bends
    forward to touch the toes, flaps the arms like a bird, swings the arms, makes big circles with the arms,
    beckons someone closer, touches the right shoulder, stomps the left foot, steps sideways to the right,
    crouches down low, boxes, stands still, waves while walking forward, walks backward slowly, reaches up high,
    shakes hands, lifts the right knee, walks to the left, moves forward quickly, spins around to the left
    """
)
UNKNOWN_DEVELOPMENT = _phrases(
    """
    plays the piano, eats a sandwich, solves the equation, cooks dinner, drives a car, reads a book, writes a
    letter, paints the ceiling blue, sings a song, sleeps in a bed, swims across the lake, rides a horse, plays
    the guitar, thinks about life, buys groceries, watches television, programs a computer, speaks French, falls
    in love, invests in stocks, rides a bicycle, does a backflip, does a cartwheel, climbs a ladder, crawls on
    all fours, knits a scarf, brushes the teeth, plays chess, shoots a gun, flies an airplane, calls a friend on
    the phone, washes the dishes, eats soup, drinks poison and dies, laughs at a joke, cries, explodes, becomes
    a doctor, pays taxes, votes in the election, plays golf, hits a baseball with a bat, combs the hair, does
    push ups
    """
)
# Nothing was chosen on these two.
KNOWN_HELD_OUT = _phrases(
    """
    ambles forward, paces ahead at an easy speed, waves goodbye with the right hand, gives a friendly wave,
    squats down low three times, performs two squats, claps the hands twice, claps loudly, hurls something with
    the right arm, raises a hand high, holds both arms out to the sides, rotates to the right, makes a half
    turn, pivots on the spot, sidesteps to the left, backs away, strides forward with big steps, marches in
    place lifting the knees high, punches the air, fights with the fists, kicks high with the right leg,
    balances on the left foot, glances around, peers down at the floor, jumps up and down, hops in place, takes
    a seat, rises from the seat, drops to one knee, grabs an object off the ground, stretches the whole body,
    folds the arms, stands with the hands on the waist, says no with the head, gives a salute, rubs the head
    with the left hand, sips from a mug, cleans a window with the right hand, shoves something forward with both
    hands, creeps on tiptoe, runs on the spot, does star jumps, steps into a lunge, rises onto the toes, dances
    to music, swivels the upper body, rocks from side to side, tilts to the right, bends over at the waist,
    flaps like a chicken, swings both arms back and forth, circles both arms, motions to come here, touches the
    head with both hands, stamps on the floor, squats while raising both arms, waves the right hand while
    marching, points up at the sky, extends the left arm forward, jogs in a curve to the right, walks around in
    a circle clockwise, bows deeply
    """
)
UNKNOWN_HELD_OUT = _phrases(
    """
    bakes a cake, plays the violin, repairs the engine, mows the lawn, studies mathematics, types on a keyboard,
    sails a boat, surfs a wave, rides a skateboard, chops vegetables, feeds the dog, milks a cow, takes a
    photograph, sends an email, proves a theorem, teaches a class, marries his girlfriend, sells a house, smokes
    a cigarette, digs a hole, rows a boat, does a handstand, does sit ups, rolls on the floor, breakdances on
    the head, somersaults, vacuums the carpet, irons a shirt, shaves, puts on a jacket, plays the drums, juggles
    balls, ties the shoelaces, dreams of money, melts, teleports to Mars, orders a pizza, translates the
    document, counts to one hundred, plays tennis, fishes in the river, plays video games
    """
)


@pytest.fixture(scope="module")
def domain() -> Domain:
    """The domain of forty phrasings of every action of the corpus."""
    rng = np.random.default_rng(0)
    texts = [
        phrase(name, entry(name).sample(Draw(rng)), Voice(), rng).third
        for name in sorted(VOCABULARY)
        for _ in range(40)
    ]
    return Domain.fit((re.sub(r"\b(his|her|their|its)\b", "the", f"a person {text}") for text in texts), TextEncoder())


def test_development_lists_are_told_apart(domain: Domain) -> None:
    assert (domain.similarity(KNOWN_DEVELOPMENT) >= domain.threshold).mean() >= 0.95
    assert (domain.similarity(UNKNOWN_DEVELOPMENT) < domain.threshold).mean() >= 0.95


def test_held_out_lists_are_told_apart(domain: Domain) -> None:
    known, unknown = domain.similarity(KNOWN_HELD_OUT), domain.similarity(UNKNOWN_HELD_OUT)
    assert (known >= domain.threshold).mean() >= 0.9
    assert (unknown < domain.threshold).mean() >= 0.92
    assert (known[:, None] > unknown).mean() >= 0.98


def test_training_texts_are_inside(domain: Domain) -> None:
    domain.check(domain.texts[:50])


def test_an_unknown_segment_is_named_with_known_ones(domain: Domain) -> None:
    with pytest.raises(OutOfDomain) as caught:
        domain.check(["a person bows", "a person plays the piano"])
    assert caught.value.segment == "a person plays the piano"
    assert len(set(caught.value.nearest)) == 3 and set(caught.value.nearest) <= set(domain.texts)


@pytest.mark.parametrize("segment", ["the stock market falls", "a dog walks forward"])
def test_only_human_beings(domain: Domain, segment: str) -> None:
    with pytest.raises(OutOfDomain):
        domain.check([segment])


def test_limit_keeps_the_most_different_texts(domain: Domain) -> None:
    texts = ["a person bows", "a person bows down", "a person walks", "a person claps"]
    small = Domain.fit(texts, domain.encoder, limit=3)
    assert len(small.texts) == 3
    assert len({text.split()[2] for text in small.texts}) == 3


def test_survives_its_file(domain: Domain, tmp_path: Path) -> None:
    domain.save(tmp_path / "domain.safetensors")
    again = Domain.load(tmp_path / "domain.safetensors", domain.encoder)
    assert again.texts == domain.texts and again.threshold == domain.threshold
    queries = KNOWN_HELD_OUT[:5]
    np.testing.assert_allclose(again.similarity(queries), domain.similarity(queries), atol=2e-3)


def test_broken_files(domain: Domain, tmp_path: Path) -> None:
    path = tmp_path / "domain.safetensors"
    with pytest.raises(InvalidFile, match="no such file"):
        Domain.load(path, domain.encoder)
    domain.save(path)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(InvalidFile, match="known texts"):
        Domain.load(path, domain.encoder)
