"""A folder to the data set that it holds."""

from pathlib import Path

from generator.datasets.authored import MANIFEST, AuthoredCorpus
from generator.datasets.dataset import MotionDataset
from generator.datasets.published import PublishedMotions
from ros_free_stack.errors import InvalidFile


def open_dataset(folder: Path) -> MotionDataset:
    """The corpus that `data build` wrote, or a folder in the published layout of HumanML3D or KIT-ML.

    Raises:
        InvalidFile: it is neither, or something in it is damaged.
    """
    if (folder / MANIFEST).exists():
        return AuthoredCorpus.open(folder)
    if (folder / "new_joint_vecs").is_dir():
        return PublishedMotions.open(folder)
    raise InvalidFile(
        folder,
        "holds no motion data set; expected what `launch.py data build --out FOLDER` writes, or new_joint_vecs/, "
        "texts/ and train.txt of HumanML3D or KIT-ML",
    )
