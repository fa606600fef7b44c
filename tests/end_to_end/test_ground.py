"""What was generated is found again where it was put, with the trained weights."""

import json
from pathlib import Path

import pytest

import launch
from generator.registry import DEFAULT, WEIGHTS_FOLDER

PROMPT = "a person bows, waves with the left hand, then walks forward"

pytestmark = pytest.mark.skipif(
    not (WEIGHTS_FOLDER / DEFAULT / "grounding").is_dir(), reason="the weights folder holds no grounding model"
)


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("ground") / "motion.npz"
    assert launch.main(["generate", PROMPT, "--seed", "2", "--out", str(path)]) == 0
    return path


def test_each_segment_is_found_where_it_is(generated: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert launch.main(["caption", str(generated), "--top", "5", "--json"]) == 0
    true = json.loads(capsys.readouterr().out)["segments"]
    assert launch.main(["ground", str(generated), PROMPT, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["segments"]
    assert len(found) == len(true) == 3
    for place, segment in zip(found, true, strict=True):
        both = min(place["end_s"], segment["end_s"]) - max(place["start_s"], segment["start_s"])
        either = max(place["end_s"], segment["end_s"]) - min(place["start_s"], segment["start_s"])
        assert both > 0.5 * either


def test_captions_name_the_deeds(generated: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert launch.main(["caption", str(generated), "--top", "1", "--json"]) == 0
    bow, wave, walk = (s["texts"][0]["text"] for s in json.loads(capsys.readouterr().out)["segments"])
    assert "bow" in bow
    assert "wav" in wave and "left" in wave
    assert "walk" in walk or "step" in walk
