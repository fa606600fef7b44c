"""GloVe vectors and parts of speech, as the published evaluator reads a caption."""

import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from torch import Tensor

from ros_free_stack.errors import InvalidFile

FILES: Final = ("our_vab_data.npy", "our_vab_words.pkl", "our_vab_idx.pkl")
WIDTH: Final = 300
LONGEST: Final = 20
"""Words of a caption that are read; the marks of beginning and end come on top."""

# fmt: off
TAGS: Final = (
    "VERB", "NOUN", "DET", "ADP", "NUM", "AUX", "PRON", "ADJ", "ADV",
    "Loc_VIP", "Body_VIP", "Obj_VIP", "Act_VIP", "Desc_VIP", "OTHER",
)
"""Parts of speech in the order of the published one-hot vectors; some words count as a part of their own."""

SPECIAL: Final = {
    "Loc_VIP": ("left", "right", "clockwise", "counterclockwise", "anticlockwise", "forward", "back", "backward",
                "up", "down", "straight", "curve"),
    "Body_VIP": ("arm", "chin", "foot", "feet", "face", "hand", "mouth", "leg", "waist", "eye", "knee", "shoulder",
                 "thigh"),
    "Obj_VIP": ("stair", "dumbbell", "chair", "window", "floor", "car", "ball", "handrail", "baseball", "basketball"),
    "Act_VIP": ("walk", "run", "swing", "pick", "bring", "kick", "put", "squat", "throw", "hop", "dance", "jump",
                "turn", "stumble", "stop", "sit", "lift", "lower", "raise", "wash", "stand", "kneel", "stroll", "rub",
                "bend", "balance", "flap", "jog", "shuffle", "lean", "rotate", "spin", "spread", "climb"),
    "Desc_VIP": ("slowly", "carefully", "fast", "careful", "slow", "quickly", "happy", "angry", "sad", "happily",
                 "angrily", "sadly"),
}
# fmt: on


class PublishedWords:
    """Words with their parts of speech to vectors.

    Args:
        folder: with `our_vab_data.npy` (N, 300), `our_vab_words.pkl` (N words), `our_vab_idx.pkl` (word to row).

    Raises:
        InvalidFile: a file is missing or is not what its name says.
    """

    def __init__(self, folder: Path) -> None:
        data, words, rows = (folder / name for name in FILES)
        try:
            self._vectors = np.load(data, allow_pickle=False).astype(np.float32)
        except (OSError, ValueError, EOFError) as error:
            raise InvalidFile(data, f"not the GloVe vectors ({error})") from None
        if self._vectors.ndim != 2 or self._vectors.shape[1] != WIDTH:
            raise InvalidFile(data, f"expected shape (N, {WIDTH}), found {self._vectors.shape}")
        known, places = _plain_pickle(words), _plain_pickle(rows)
        if not isinstance(known, list | tuple):
            raise InvalidFile(words, f"expected a list of words, found {type(known).__name__}")
        if not isinstance(places, dict) or not all(isinstance(places.get(word), int) for word in (*known, "unk")):
            raise InvalidFile(rows, "expected the row of each word, of `unk` too")
        self._row: dict[str, int] = {word: places[word] for word in known}
        if max(self._row.values()) >= len(self._vectors):
            raise InvalidFile(rows, f"names row {max(self._row.values())} of {len(self._vectors)} vectors")
        self._tag = {word: tag for tag, words in SPECIAL.items() for word in words}

    def __call__(self, tokens: Sequence[tuple[str, str]]) -> tuple[Tensor, Tensor]:
        """(word, part of speech) of a caption to vectors (n, 300) and one-hot parts of speech (n, 15)."""
        marked = [("sos", "OTHER"), *tokens[:LONGEST], ("eos", "OTHER")]
        vectors = [self._vectors[self._row.get(word, self._row["unk"])] for word, _ in marked]
        tags = [self._one_hot(word, tag) for word, tag in marked]
        return torch.from_numpy(np.stack(vectors)), torch.tensor(tags)

    def _one_hot(self, word: str, tag: str) -> list[float]:
        """A word without a vector counts as OTHER, whatever its tag."""
        tag = self._tag.get(word, tag) if word in self._row else "OTHER"
        number = TAGS.index(tag if tag in TAGS else "OTHER")
        return [float(number == place) for place in range(len(TAGS))]


class _PlainUnpickler(pickle.Unpickler):
    """Reads containers, strings and numbers; anything that would run code is refused."""

    def find_class(self, module_name: str, global_name: str, /) -> Any:
        raise pickle.UnpicklingError(f"it asks for {module_name}.{global_name}, plain data is expected")


def _plain_pickle(path: Path) -> Any:
    try:
        with path.open("rb") as stream:
            return _PlainUnpickler(stream).load()
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except (pickle.UnpicklingError, EOFError, ValueError, IndexError, KeyError, AttributeError, UnicodeError) as error:
        raise InvalidFile(path, f"not a readable pickle ({error})") from None
