"""ParTY as users meet it: trained, generating, editing and evaluated from the command line; what is known stays."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from generator import weights
from generator.cli import Generate, Train
from generator.datasets.authored import AuthoredCorpus
from generator.evaluation.cli import Evaluate
from generator.model import Known, Sampling, TextCondition
from generator.models.party.config import PartySampling, TokenizerConfig, TransformerConfig
from generator.models.party.generation import Generation
from generator.models.party.model import Party
from generator.models.party.network import PartyNetwork
from generator.models.party.objectives.corpus import TokenBatches, TokenCorpus
from generator.models.party.objectives.part_texts import part_texts
from generator.models.party.objectives.transformer import from_job
from generator.models.party.tokenizer import PartyTokenizer
from generator.registry import WEIGHTS_FOLDER, generator
from generator.training.loop import Run, train
from ros_free_stack.errors import InvalidOption, NoWeights
from ros_free_stack.files import load_motion
from tests.generator.tiny_dataset import write_tiny_dataset
from tests.generator.tiny_party import SMALLER, tiny_party_job

STILL = "No significant movement"


def with_part_texts(folder: Path) -> Path:
    """Let the tiny data set say what arms and legs do."""
    lines = []
    for line in (folder / "clips.jsonl").read_text().splitlines():
        clip = json.loads(line)
        for segment in clip["segments"]:
            waves = "waves" in segment["text"]
            segment["arms"] = segment["text"].removeprefix("a person ") if waves else STILL
            segment["legs"] = "walks forward" if "walks" in segment["text"] else STILL
        lines.append(json.dumps(clip) + "\n")
    (folder / "clips.jsonl").write_text("".join(lines))
    return folder


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_part_texts(write_tiny_dataset(tmp_path_factory.mktemp("party") / "data", clips=48))


@pytest.fixture(scope="module")
def trained(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    before, out = torch.get_num_threads(), tmp_path_factory.mktemp("weights")
    command = Train(stage="all", preset="party-small", set=SMALLER, dataset=data, out=out, threads=1, device="cpu")
    assert command.run() == 0
    torch.set_num_threads(before)
    return out


@pytest.fixture(params=[(8, 8), (8, 12)])
def model(request: pytest.FixtureRequest) -> Party:
    """Tiny models that were never trained."""
    torch.manual_seed(0)
    window, part_window = request.param
    config = TokenizerConfig(("whole", "arms", "legs"), window, part_window, 16, 12, 1, 16, 8, 8, groups=2)
    tokenizer = PartyTokenizer(config)
    for name, buffer in tokenizer.named_buffers():
        if name.endswith("codebooks"):
            buffer.normal_()
    sizes = TransformerConfig(16, 1, 1, 4, 32, 0.0, 2, 6, 3, 3, conditioning="layout")
    return Party(tokenizer.eval(), PartyNetwork(sizes, config).eval(), "tiny")


def text(*frames: tuple[int, ...]) -> TextCondition:
    rows, count = len(frames), len(frames[0])
    torch.manual_seed(1)
    return TextCondition(
        torch.randn(rows, 384),
        torch.zeros(rows, 1, 384),
        torch.ones(rows, 1, dtype=torch.bool),
        torch.randn(rows, count, 384),
        torch.randn(rows, count, 2, 384),
        torch.zeros(rows, count, 2, dtype=torch.long),
        torch.tensor(frames),
    )


def noise(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_party_trains_generates_edits_and_is_evaluated(
    data: Path, trained: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, again, edited = (tmp_path / name for name in ("first.npz", "again.npz", "edited.npz"))
    walk, sway = "a person walks forward", "a person sways"
    for out in (first, again):
        command = Generate(prompt=walk, out=out, generator="party", weights=trained, duration=4.0, anyway=True)
        assert command.run() == 0
    motion = load_motion(first)
    assert motion.source.startswith("party ") and len(motion.joints) == 80
    assert motion.joints.tobytes() == load_motion(again).joints.tobytes()
    command = Generate(prompt=sway, out=edited, generator="party", weights=trained, edit=first, range=(1.6, 2.8))
    assert command.run() == 0
    changed = load_motion(edited)
    assert len(changed.joints) == 80 and changed.joints[:32].tobytes() == motion.joints[:32].tobytes()
    assert not np.allclose(changed.joints[33:55], motion.joints[33:55], atol=1e-3)
    capsys.readouterr()
    evaluate = Evaluate(
        generator="party", weights=(trained,), evaluator=trained / "shared" / "evaluator", dataset=data, split="train",
        runs=2, json=True,
    )  # fmt: skip
    assert evaluate.run() == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert list(rows) == ["real", "reconstruction", "first", "resampled"]
    assert all(np.isfinite(rows[row][metric]["mean"]) for row in rows for metric in ("fid", "tc", "sc"))


def test_party_without_weights_says_how_to_train_it(tmp_path: Path) -> None:
    with pytest.raises(NoWeights) as caught:
        Party.load(tmp_path / "party", device="cpu")
    assert str(caught.value) == (
        f"{tmp_path}/party/tokenizer: no trained tokenizer; train it with `python launch.py train tokenizer "
        f"--preset party-small --dataset DATASET --out {tmp_path}`"
    )


def test_party_refuses_weights_of_another_model_and_of_another_tokenizer(trained: Path, tmp_path: Path) -> None:
    place = tmp_path / "party"
    place.mkdir()
    (place / "tokenizer").symlink_to(WEIGHTS_FOLDER / "segmo" / "tokenizer")
    (place / "transformer").symlink_to(trained / "party" / "transformer")
    with pytest.raises(NoWeights, match="holds weights of another generator than party; train it with `python launch"):
        generator("party").load(tmp_path, "cpu")
    (place / "tokenizer").unlink()
    (place / "tokenizer").mkdir()
    saved = weights.load(trained / "party" / "tokenizer", "tokenizer")
    other = PartyTokenizer(saved.config_as(TokenizerConfig))
    weights.save(place / "tokenizer", other.config, other, {"generator": "party"})
    with pytest.raises(NoWeights, match="was trained with another tokenizer"):
        generator("party").load(tmp_path, "cpu")


def test_party_data_without_part_texts_trains_and_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = AuthoredCorpus.open(write_tiny_dataset(tmp_path / "data", clips=8))
    tiny_party_job("tokenizer", data, tmp_path / "out", iterations=1).run()
    capsys.readouterr()
    tiny_party_job("transformer", data, tmp_path / "out", iterations=1).run()
    assert "trained without the auxiliary loss of part texts" in capsys.readouterr().err
    header = (tmp_path / "out" / "party" / "transformer" / "curve.csv").read_text().splitlines()[0]
    assert "diversity" in header and "auxiliary" not in header
    assert weights.load(tmp_path / "out" / "party" / "transformer", "transformer").facts["part_texts"] == 0


def test_party_data_with_part_texts_trains_the_grounding(trained: Path) -> None:
    header = (trained / "party" / "transformer" / "curve.csv").read_text().splitlines()[0]
    assert "auxiliary" in header
    assert weights.load(trained / "party" / "transformer", "transformer").facts["part_texts"] == 1


def test_part_texts_of_a_part_that_rests_are_the_text_itself(data: Path) -> None:
    clip = next(
        clip for clip in AuthoredCorpus.open(data).clips
        if [("waves" in s.text, "walks" in s.text) for s in clip.segments] == [(True, False), (False, True)]
    )  # fmt: skip
    (found,) = part_texts(clip, ("arms", "legs", "trunk"))
    assert found is not None
    caption = clip.captions[0]
    waves = caption.segments[0].removeprefix("a person ")
    assert found["arms"] == (waves, waves, caption.segments[1])
    assert found["legs"] == ("walks forward", caption.segments[0], "walks forward")
    assert found["trunk"] == (caption.text, *caption.segments), "nobody says what the trunk does"


def test_training_window_of_broken_tokens_is_refused(data: Path, tmp_path: Path) -> None:
    job = tiny_party_job("tokenizer", AuthoredCorpus.open(data), tmp_path, "tokenizer.objective.window=44")
    with pytest.raises(InvalidOption, match="must be a multiple of the 8 frames of a token of whole, found 44"):
        job.run()


def test_token_batches_follow_from_the_seed_and_hold_each_clip_to_its_length(data: Path, trained: Path) -> None:
    corpus = TokenCorpus.build(AuthoredCorpus.open(data), trained / "party" / "tokenizer", "cpu")
    one, two = (TokenBatches(corpus, batch=8, conditioning="layout", seed=3).training(5) for _ in range(2))
    assert all(torch.equal(one.tokens[body], two.tokens[body]) for body in ("whole", "arms", "legs"))
    counts = one.condition.counts(8)
    for row, count in enumerate(counts.tolist()):
        assert not one.tokens["whole"][row, count:].any()
        assert one.condition.frames[row].sum() == 8 * count
    assert one.told["arms"].shape == one.condition.texts.shape[:2]
    sentence = TokenBatches(corpus, batch=8, conditioning="sentence", seed=3).training(5)
    assert sentence.condition.texts.shape[1] == 1
    assert torch.equal(sentence.condition.texts[:, 0], one.condition.texts[:, 0])


def test_network_learns_its_clips_and_generates_them_from_their_texts(data: Path, tmp_path: Path) -> None:
    dataset = AuthoredCorpus.open(data)
    torch.manual_seed(0)
    tiny_party_job("tokenizer", dataset, tmp_path, "tokenizer.training.ema=0.0", iterations=30).run()
    faster = ("learning_rate=0.005", "ema=0.0", "batch=16")
    job = tiny_party_job(
        "transformer", dataset, tmp_path, *(f"transformer.training.{change}" for change in faster), iterations=100
    )  # fmt: skip
    torch.manual_seed(0)
    objective = from_job(job)
    train(objective, job.training, tmp_path / "party" / "transformer", Run(100))
    corpus = TokenCorpus.build(dataset, tmp_path / "party" / "tokenizer", "cpu")
    batch = TokenBatches(corpus, batch=8, conditioning="layout", seed=0).collate(corpus.train, [0] * len(corpus.train))
    with torch.inference_mode():
        generation = Generation(objective.model.eval(), batch.condition, PartySampling(top_k=0.01), noise())
        found, _ = generation.run()
    counts = batch.condition.counts(8)
    inside = torch.arange(found["whole"].shape[1]) < counts[:, None]
    alike = (found["whole"] == batch.tokens["whole"])[inside].float().mean()
    commonest = batch.tokens["whole"][inside].mode(0).values
    guessed = (batch.tokens["whole"][inside] == commonest).float().mean()
    assert alike > 0.7 and alike > guessed + 0.2, (alike, guessed)


def test_party_samples_are_as_long_as_their_segments(model: Party) -> None:
    samples = model.sample(text((24, 16), (40, 64)), known=None, sampling=Sampling(), noise=noise())
    assert [tuple(sample.features.shape) for sample in samples] == [(40, 263), (104, 263)]
    assert (model.spec.least_frames, model.spec.most_frames) == (40, 192)
    with pytest.raises(InvalidOption, match="motions are whole tokens of 8 frames, found 42 frames"):
        model.sample(text((20, 22)), known=None, sampling=Sampling(), noise=noise())


def test_party_sample_does_not_depend_on_what_it_is_batched_with(model: Party) -> None:
    greedy = replace(model, settings=replace(model.settings, top_k=0.01))
    both = text((24, 16), (40, 64))
    (alone,) = greedy.sample(both[:1], known=None, sampling=Sampling(), noise=noise())
    together = greedy.sample(both, known=None, sampling=Sampling(), noise=noise())
    assert torch.allclose(alone.features, together[0].features, atol=1e-4)


def test_party_tokens_of_own_samples_stay_exactly(model: Party) -> None:
    condition = text((40, 56))
    (first,) = model.sample(condition, known=None, sampling=Sampling(), noise=noise())
    assert first.latent is not None and first.latent.shape == (4, 12)
    mask = torch.ones(1, 96, dtype=torch.bool)
    mask[:, 24:48] = False
    known = Known(first.features[None], mask, *[first.features[:0]] * 2, latent=first.latent[:, None])
    (again,) = model.sample(condition, known=known, sampling=Sampling(), noise=noise(5))
    assert again.latent is not None
    assert torch.equal(again.latent[:2, :3], first.latent[:2, :3])
    assert torch.equal(again.latent[:2, 6:], first.latent[:2, 6:])
    assert not torch.equal(again.latent[:2, 3:6], first.latent[:2, 3:6])


def test_party_given_features_are_read_together_with_what_lies_before(model: Party) -> None:
    given = torch.randn(72, 263)
    tokens = model.tokenizer.encode(given[None], torch.tensor([72]))["whole"]
    mask = torch.zeros(1, 72, dtype=torch.bool)
    mask[:, :24] = True
    features = torch.cat([given[48:], torch.randn(48, 263)])[None]
    known = Known(features, mask, given[:48], given[:0])
    (found,) = model.sample(text((24, 48)), known=known, sampling=Sampling(), noise=noise())
    assert found.latent is not None
    assert torch.equal(found.latent[:2, :2], tokens[0, 6:8].T), "the last token also sees what follows it"


def test_party_reconstruction_goes_through_the_tokens(model: Party) -> None:
    features = torch.randn(45, 263)
    frames = torch.tensor([45])
    found = model.reconstruct(features)
    assert found.shape == (45, 263), "frames that fill no whole token too"
    assert torch.equal(found, model.tokenizer.decode(model.tokenizer.encode(features[None], frames), frames)[0])
