"""Segment texts to action frames, with all that is said of the actions and what is left over."""

import pytest

from generator.corpus.words import VOCABULARY
from generator.text.amounts import amounts, plain_amounts
from generator.text.canonical import segment_text, sentence
from generator.text.frame import ActionFrame, Amount, Moment
from generator.text.frame_parser import moments
from generator.text.lexicon import FAMILIES, actions, lines, rows, ways_of
from ros_free_stack.errors import InvalidPrompt

PERSON = "a person "
CONFUSABLE = {"step", "walk", "touch", "cover", "swing_club", "swing_racket", "jog", "sneak", "punch"}
"""Actions whose wordings must name a way, or that share one."""


def read(text: str) -> Moment:
    (moment,) = moments([PERSON + text])
    return moment


@pytest.mark.parametrize(
    ("text", "action", "side", "way", "speed"),
    [
        ("waves with the left hand", "wave", "left", "", ""),
        ("says goodbye with the right hand", "wave", "right", "", ""),
        ("lifts both arms above the head", "raise_arm", "both", "up", ""),
        ("sticks the right arm out to the side", "raise_arm", "right", "side", ""),
        ("touches the nose with the left hand", "touch", "left", "face", ""),
        ("ambles backwards slowly", "walk", "", "backward", "slow"),
        ("walks forward and to the left", "walk", "", "diagonal_left", ""),
        ("looks over the right shoulder", "look", "", "right", ""),
        ("lifts the left leg and balances", "balance", "right", "", ""),
        ("raises the right hand to salute", "salute", "right", "", ""),
        ("plays the piano", "play_piano", "", "", ""),
        ("hits a ball with a baseball bat", "swing_club", "", "baseball", ""),
        ("turns clockwise", "turn", "", "right", ""),
        ("grabs a box off the floor", "pick_up", "", "", ""),
        ("has a seat", "sit_down", "", "", ""),
    ],
)
def test_moments_action_side_way_and_speed(text: str, action: str, side: str, way: str, speed: str) -> None:
    moment = read(text)
    (frame,) = moment.actions
    assert (frame.action, frame.side, frame.way, frame.speed) == (action, side, way, speed)
    assert moment.not_shown == moment.unknown == ()
    assert frame.confidence == 1.0


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("walks forward happily", ["happily"]),
        ("walks like a zombie", ["like a zombie"]),
        ("kicks backwards with the left leg", ["backwards"]),
        ("sits down twice", ["twice"]),
        ("swings the left arm", ["the left"]),
    ],
)
def test_moments_words_that_no_motion_shows_are_kept(text: str, told: list[str]) -> None:
    assert [words.text for words in read(text).not_shown] == told


@pytest.mark.parametrize(
    ("text", "named", "near"),
    [
        ("does a backflip", "backflip", ("jump", "squat")),
        ("walks up the stairs", "walks stairs", ("march", "knee_lift")),
        ("bakes a cake", "bakes", ()),
        ("does a photosynthesis", "photosynthesis", ()),
    ],
)
def test_moments_unknown_actions_are_named(text: str, named: str, near: tuple[str, ...]) -> None:
    (unknown,) = read(text).unknown
    assert (unknown.text, unknown.near) == (named, near)


def test_moments_other_subjects_are_unknown() -> None:
    (moment,) = moments(["the horse kicks"])
    assert moment.actions == () and moment.unknown[0].text == "the horse kicks"


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("walks while waving the left hand and nodding", ["walk", "wave", "nod"]),
        ("walks with the hands on the hips", ["walk", "hands_on_hips"]),
        ("bends over holding a box", ["bend_forward", "carry"]),
    ],
)
def test_moments_actions_at_the_same_time(text: str, names: list[str]) -> None:
    assert [frame.action for frame in read(text).actions] == names


def test_moments_what_somebody_goes_to_do_comes_after() -> None:
    found = moments(["a person walks forward to sit on a chair"])
    assert [moment.actions[0].action for moment in found] == ["walk", "sit_down"]


def test_moments_back_is_ahead_after_a_turn_around() -> None:
    _, walk = moments(["a person turns around", "a person walks back"])
    assert walk.actions[0].way == "forward"
    (alone,) = moments(["a person walks back"])
    assert alone.actions[0].way == "backward"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("walks two metres", {"distance": 2.0}),
        ("walks 150 centimetres", {"distance": 1.5}),
        ("turns 45 degrees", {"angle": 45.0}),
        ("makes two full turns", {"angle": 720.0}),
        ("waves three times for four seconds", {"count": 3.0, "duration": 4.0}),
        ("takes a couple of steps to the left", {"count": 2.0}),
        ("jumps with two feet", {}),
        ("raises one arm", {}),
        ("hops on all fours", {}),
    ],
)
def test_amounts_by_kind(text: str, expected: dict[str, float]) -> None:
    assert {kind: amount.value for kind, amount in amounts(text).items()} == pytest.approx(expected)


@pytest.mark.parametrize("text", ["walks 400 metres", "turns 5000 degrees", "waves a thousand times", "waits an hour"])
def test_amounts_out_of_range_name_the_range(text: str) -> None:
    with pytest.raises(InvalidPrompt, match=r"is out of range: [\d.]+ to [\d.]+ "):
        amounts(text)


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("walk 1.5 m back", "walk 150 centimetres back"),
        ("turn 45°", "turn 45 degrees"),
        ("walk half a metre", "walk 50 centimetres"),
        ("walk one and a half metres", "walk 150 centimetres"),
        ("wave for 4s", "wave for 4 seconds"),
        ("stand on two feet", "stand on two feet"),
    ],
)
def test_plain_amounts(text: str, plain: str) -> None:
    assert plain_amounts(text) == plain


def test_tables_name_every_action_of_the_vocabulary_and_no_other() -> None:
    assert set(actions()) == set(VOCABULARY)
    assert {row.action for row in rows() if row.known} == set(VOCABULARY)
    assert {name for row in rows() for name in row.near} <= set(VOCABULARY)
    assert all(cell for family in FAMILIES for line in lines(family) for cell in line.split("\t"))


@pytest.mark.parametrize("name", sorted(set(VOCABULARY) - CONFUSABLE))
def test_segment_text_reads_as_the_frame_that_it_words(name: str) -> None:
    for way in ("", *(way.name for way in ways_of(name))):
        for side in ("", "left", "both") if actions()[name].limb else ("",):
            frame = ActionFrame(name, side=side, way=way)
            (again,) = moments([segment_text(Moment("", (frame,)))])
            (found,) = again.actions
            assert (found.action, found.side, found.way) == (name, side, way)
            assert again.not_shown == again.unknown == ()


def test_segment_text_keeps_count_speed_angle_and_what_happens_meanwhile() -> None:
    def count(number: float) -> dict[str, Amount]:
        return {"count": Amount("count", number, "", (0, 0))}

    wave = ActionFrame("wave", side="left", amounts=count(3), speed="slow")  # pyright: ignore[reportArgumentType]
    assert segment_text(Moment("", (wave, ActionFrame("walk")))) == (
        "a person waves with the left hand three times slowly while walking"
    )
    turn = ActionFrame("turn", way="left", amounts={"angle": Amount("angle", 90.0, "", (0, 0))})
    assert segment_text(Moment("", (turn,))) == "a person turns 90 degrees to the left"
    jacks = ActionFrame("jumping_jacks", amounts=count(2))  # pyright: ignore[reportArgumentType]
    assert segment_text(Moment("", (jacks,))) == "a person does two jumping jacks"
    assert sentence(["a person waves", "a person bows"]) == "a person waves, then bows"
