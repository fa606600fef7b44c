"""Folders in the published layout of HumanML3D or KIT-ML, of a few random motions."""

from pathlib import Path

import numpy as np

from ros_free_stack.formats.features import Skeleton

CAPTIONS = (
    "a person walks forward#a/DET person/NOUN walk/VERB forward/ADV#0.0#0.0",
    "a man walks forward, then he waves#a/DET man/NOUN walk/VERB then/ADV he/PRON wave/VERB#0.0#0.0",
)
EXCERPT = "he waves#he/PRON wave/VERB#1.0#5.0"


def write_published(folder: Path, skeleton: Skeleton, *, motions: int = 16, seed: int = 0) -> Path:
    """Motions of 60 to 120 frames; the first has a caption about a part of it, every fourth is for validation."""
    rng = np.random.default_rng(seed)
    for name in ("new_joint_vecs", "texts"):
        (folder / name).mkdir(parents=True)
    names = [f"{number:06d}" for number in range(motions)]
    for number, name in enumerate(names):
        frames = int(rng.integers(60, 121))
        features = 0.1 * rng.normal(size=(frames, skeleton.width)).cumsum(0)
        features[:, -4:] = rng.integers(2, size=(frames, 4))
        np.save(folder / "new_joint_vecs" / f"{name}.npy", features.astype(np.float32))
        lines = (*CAPTIONS, EXCERPT) if number == 0 else CAPTIONS
        (folder / "texts" / f"{name}.txt").write_text("\n".join(lines))
    (folder / "train.txt").write_text("\n".join(name for i, name in enumerate(names) if i % 4 != 3))
    (folder / "val.txt").write_text("\n".join(names[3::4]))
    return folder
