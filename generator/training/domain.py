"""The known texts of a corpus, which the domain check compares prompts with."""

from pathlib import Path

from generator.data.dataset import MotionDataset
from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from generator.text.understanding import DOMAIN
from ros_free_stack.files import make_folder


def fit_domain(dataset: MotionDataset, out: Path) -> dict[str, float]:
    """Write the texts that cover all training segments to the weights folder; how many they are."""
    texts = {text for clip in dataset.split("train") for caption in clip.captions for text in caption.segments}
    domain = Domain.fit(texts, TextEncoder())
    domain.save(make_folder(out) / DOMAIN)
    return {"texts": float(len(texts)), "kept": float(len(domain.texts)), "finished": 1.0}
