"""Texts as the models read them: rows, masks, clauses, numbers."""

import numpy as np
import pytest
import torch

from generator.text.condition import read_texts
from generator.text.encoder import TextEncoder

WALK, WAVE = "a person walks forward", "a person waves twice"
BOTH = "a person walks forward while waving twice"


@pytest.fixture(scope="module")
def encoder() -> TextEncoder:
    return TextEncoder()


def test_read_texts_gives_a_row_for_each_sentence(encoder: TextEncoder) -> None:
    found = read_texts(encoder, [(f"{WALK}, then waves twice", (WALK, WAVE)), (BOTH, (BOTH,))])
    assert len(found) == 2
    assert found.segments.shape == (2, 2, 384) and found.clauses.shape == (2, 2, 2, 384)
    assert found.token_mask.sum(1).tolist() == [
        len(encoder.encode([s]).tokens[0]) for s in (f"{WALK}, then waves twice", BOTH)
    ]
    assert (found.tokens[~found.token_mask] == 0).all()
    single = encoder.encode_sentences([WALK, WAVE, BOTH])
    np.testing.assert_allclose(found.segments[0].numpy(), single[:2], atol=1e-5)
    np.testing.assert_allclose(found.segments[1, 0].numpy(), single[2], atol=1e-5)
    np.testing.assert_allclose(found.clauses[1, 0, 0].numpy(), single[0], atol=1e-5)
    assert (found.clauses[0, :, 1] == 0).all() and (found.clauses[1, 0, 1] != 0).any()
    assert found.counts[0].tolist() == [[0, 0], [2, 0]] and found.counts[1, 0].tolist() == [0, 2]
    assert not found.segment_mask.any()


def test_lasting_gives_frames_and_with_them_the_mask_of_segments(encoder: TextEncoder) -> None:
    found = read_texts(encoder, [("walks, then waves", (WALK, WAVE)), (WALK, (WALK,))])
    found = found.lasting(torch.tensor([[40, 20], [60, 0]]))
    assert found.segment_mask.tolist() == [[True, True], [True, False]]
    assert found[torch.tensor([1, 1])].frames.tolist() == [[60, 0], [60, 0]]
    assert found.repeated(2).frames.tolist() == [[40, 20], [60, 0]] * 2
    assert found.parts is None and found.to("cpu").repeated(2).parts is None
