"""Word vectors: the input table of the packaged MiniLM, one vector a word piece, the same in every sentence.

They play the part that GloVe plays in T2M. Unlike the sentence embedding, they keep "left" and "right" apart.
"""

from collections.abc import Sequence

from safetensors import safe_open
from tokenizers import Tokenizer
from torch import Tensor

from generator.text.encoder import package_folder

TABLE = "embeddings.word_embeddings.weight"


class WordVectors:
    """The table, scaled to unit variance.

    Raises:
        MissingDependency: the package with the weights is not installed.
    """

    def __init__(self) -> None:
        folder = package_folder()
        self._tokenizer = Tokenizer.from_file(str(folder / "tokenizer.json"))
        self._tokenizer.no_truncation()
        self._tokenizer.no_padding()
        with safe_open(folder / "model.safetensors", framework="pt") as archive:
            table: Tensor = archive.get_tensor(TABLE)
        self._table = table / table.std()

    def __call__(self, texts: Sequence[str], longest: int) -> list[Tensor]:
        """(n, 384) vectors of the first word pieces of each text, at most `longest`; an empty text counts as one."""
        encodings = self._tokenizer.encode_batch(list(texts), add_special_tokens=False)
        return [self._table[encoding.ids[:longest] or [0]] for encoding in encodings]
