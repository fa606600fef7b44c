"""Presets: what a generator's stages are built of and how they are trained, one YAML file each.

A file holds settings of every stage in three sections: `model` (sizes), `training` (batch,
optimiser, schedule) and `objective` (losses). `published` is for a GPU; `small` changes what has to be changed to train
on two processor cores. What all generators share stands in `shared.yaml` beside them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, get_args

import yaml

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName

FOLDER: Final = Path(__file__).parent / "presets"
SHARED_FILE: Final = "shared.yaml"
Size = Literal["small", "published"]
SECTIONS: Final = ("model", "training", "objective")

Settings = dict[str, Any]


@dataclass(frozen=True)
class Preset:
    """Settings of one size.

    Attributes:
        name: as given to `--preset`.
        title: for people.
        stages: by stage and section.
        sampling: how the trained generator is sampled from; noted with its weights.
    """

    name: str
    title: str
    stages: dict[str, dict[str, Settings]]
    sampling: Settings

    def stage(self, name: str) -> dict[str, Settings]:
        """Sections of a stage, or UnknownName."""
        if name not in self.stages:
            raise UnknownName(f"stage of preset {self.name}", name, self.stages)
        return self.stages[name]

    def changed(self, overrides: Sequence[str]) -> "Preset":
        """With settings such as `mask.training.batch=8` instead of its own.

        Raises:
            InvalidOption: one is not of this form.
            UnknownName: there is no such stage or section; a setting is checked where its stage is built.
        """
        stages = {stage: {section: dict(own) for section, own in it.items()} for stage, it in self.stages.items()}
        for text in overrides:
            path, equals, value = text.partition("=")
            keys = path.split(".")
            if not equals or len(keys) != 3:
                raise InvalidOption("--set", f"expected STAGE.SECTION.SETTING=VALUE, found {text!r}")
            stage, section, setting = keys
            if stage not in stages:
                raise UnknownName("stage", stage, stages)
            if section not in SECTIONS:
                raise UnknownName("section", section, SECTIONS)
            stages[stage].setdefault(section, {})[setting] = _value(text, value)
        return Preset(self.name, self.title, stages, self.sampling)


def read_preset(path: Path, size: str) -> Preset:
    """The preset of a file in one size.

    Raises:
        UnknownName: there is no such size.
        InvalidFile: the file is damaged.
    """
    if size not in get_args(Size):
        raise UnknownName("size", size, get_args(Size))
    data, shared = _read(path), _read(FOLDER / SHARED_FILE)
    for key in ("title", "published", "small"):
        if key not in data:
            raise InvalidFile(path, f"lacks `{key}`")
    stages: dict[str, dict[str, Settings]] = {}
    for source in (shared, data):
        stages = _merged(stages, source["published"])
        if size == "small":
            stages = _merged(stages, source["small"])
    sampling = stages.pop("sampling", {})
    return Preset(path.stem, data["title"], stages, sampling)


def _merged(base: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """The base with what the change says; mappings are merged, all else is replaced."""
    out = dict(base)
    for key, value in change.items():
        both = isinstance(value, Mapping) and isinstance(out.get(key), Mapping)
        out[key] = _merged(out[key], value) if both else value
    return out


def _read(path: Path) -> dict[str, Any]:
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError, UnicodeDecodeError) as error:
        raise InvalidFile(path, f"not a readable preset ({str(error).splitlines()[0]})") from None
    if not isinstance(data, dict):
        raise InvalidFile(path, f"expected settings by name, found {type(data).__name__}")
    return data


def _value(text: str, value: str) -> Any:
    try:
        return yaml.safe_load(value)
    except yaml.YAMLError:
        raise InvalidOption("--set", f"{text!r} has no readable value") from None
