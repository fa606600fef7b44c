"""Seconds of the parts of one fresh process, from its imports to its first motion, as one JSON object on stdout.

`benchmarks/generation_speed.py` starts this file; nothing is imported before the clock runs.
"""

import json
import sys
from time import perf_counter


def main(folder: str, candidates: int, threads: int, duration_s: float, prompt: str) -> dict[str, float]:
    """Time each part of one prompt's way, s."""
    found: dict[str, float] = {}
    last = perf_counter()

    def lap(part: str) -> None:
        nonlocal last
        now = perf_counter()
        found[part], last = now - last, now

    import torch

    torch.set_num_threads(threads)
    lap("import torch")
    from pathlib import Path

    from generator.performer import Performer
    from generator.registry import SHARED
    from generator.text.domain import Domain
    from generator.text.encoder import TextEncoder
    from generator.text.splitter import Splitter
    from generator.text.understanding import DOMAIN

    lap("import generator")
    import spacy  # noqa: F401

    lap("import spaCy")
    splitter = Splitter()
    lap("load splitter")
    segments = splitter.split(prompt)
    lap("split")
    encoder = TextEncoder()
    lap("load text encoder")
    domain = Domain.load(Path(folder) / SHARED / DOMAIN, encoder)
    lap("load known texts")
    domain.similarity(segments)
    lap("check known")
    generator = Performer.load(Path(folder), text_encoder=encoder)
    lap("load weights")
    generator.generate(prompt, segments, seed=0, candidates=candidates, duration_s=duration_s)
    lap("generate")
    return found


if __name__ == "__main__":
    _, weights, candidates, threads, duration_s, prompt = sys.argv
    print(json.dumps(main(weights, int(candidates), int(threads), float(duration_s), prompt)))
