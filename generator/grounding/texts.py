"""The texts that motion segments are told with: the most frequent ones of the training split, embedded once."""

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

from torch import Tensor

from generator.datasets.dataset import MotionDataset
from generator.grounding.space import AlignedSpace
from generator.text.encoder import TextEncoder
from generator.training.stages import StageJob
from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import atomic_path

LIMIT: Final = 4000
FILE: Final = "texts.safetensors"


@dataclass(frozen=True)
class KnownTexts:
    """Texts and their embeddings (N, W) in the shared space."""

    texts: tuple[str, ...]
    embeddings: Tensor

    @classmethod
    def fit(cls, dataset: MotionDataset, space: AlignedSpace) -> Self:
        """The most frequent segment texts of the training split."""
        counts = Counter(
            text for clip in dataset.split("train") for caption in clip.captions for text in caption.segments
        )
        texts = tuple(sorted(text for text, _ in counts.most_common(LIMIT)))
        return cls(texts, space.texts(TextEncoder(), texts))

    def nearest(self, segments: Tensor, count: int) -> list[list[tuple[str, float]]]:
        """The `count` most similar texts of each motion segment (A, W) with their cosines, the best first."""
        similarity, rows = (segments @ self.embeddings.T).topk(min(count, len(self.texts)), dim=1)
        return [
            [(self.texts[row], float(value)) for row, value in zip(rows[i].tolist(), similarity[i], strict=True)]
            for i in range(len(segments))
        ]

    def save(self, folder: Path) -> None:
        """Write texts and embeddings (float16) beside the model's weights."""
        from safetensors.torch import save_file

        with atomic_path(folder / FILE) as temporary:
            arrays = {"embeddings": self.embeddings.half().contiguous()}
            save_file(arrays, temporary, {"texts": json.dumps(self.texts)})

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read what `save` wrote, or InvalidFile."""
        from safetensors import SafetensorError, safe_open

        path = folder / FILE
        if not path.is_file():
            raise InvalidFile(path, "no such file; `launch.py train grounding` writes it")
        try:
            with safe_open(path, framework="pt") as archive:
                texts = tuple(json.loads((archive.metadata() or {})["texts"]))
                return cls(texts, archive.get_tensor("embeddings").float())
        except (SafetensorError, KeyError, ValueError) as error:
            raise InvalidFile(path, f"not the known texts of a grounding model ({error})") from None


def after_training(job: StageJob) -> None:
    """Embed the known texts with a grounding model that was just trained, and keep them beside it."""
    folder = job.folder(job.stage)
    KnownTexts.fit(job.dataset, AlignedSpace.load(folder.parent)).save(folder)
