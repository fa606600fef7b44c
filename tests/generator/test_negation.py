import pytest

from generator.text.negation import without_negations


@pytest.mark.parametrize(
    ("text", "kept", "left_out"),
    [
        ("walk forward without moving your arms", "walk forward", ["without moving your arms"]),
        ("he squats but does not stand up", "he squats", ["does not stand up"]),
        ("do not bow , wave", "wave", ["do not bow"]),
        ("without bending the knees , touch your toes", "touch your toes", ["without bending the knees"]),
        ("waves with the right hand , not with the left", "waves with the right hand", ["not with the left"]),
        ("he stands without falling , then hops", "he stands , then hops", ["without falling"]),
        ("he walks without moving the arms and bows", "he walks and bows", ["without moving the arms"]),
        ("raises the left arm instead of the right arm", "raises the left arm", ["instead of the right arm"]),
        ("he never turns", "", ["he never turns"]),
    ],
)
def test_what_is_not_done_is_left_out(text: str, kept: str, left_out: list[str]):
    assert without_negations(text) == (kept, tuple(left_out))


@pytest.mark.parametrize(
    "text",
    ["he jogs without moving forward", "he ties a knot", "he walks forward", "he notices something"],
)
def test_the_rest_stays(text: str):
    assert without_negations(text) == (text, ())


def test_double_negation_is_a_request():
    assert without_negations("clap twice and don't forget to bow") == ("clap twice then bow", ())
