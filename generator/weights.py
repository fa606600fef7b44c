"""Trained weights on disk: one folder a model with `weights.safetensors` (matrices in fp16) and `config.json`."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from safetensors import SafetensorError
from safetensors.torch import load_file, save_file
from torch import Tensor, float16, nn

from generator.config import from_json, to_json
from generator.registry import training_command
from ros_free_stack.errors import InvalidFile, NoWeights
from ros_free_stack.files import atomic_path, write_json

WEIGHTS, CONFIG = "weights.safetensors", "config.json"
FORMAT_VERSION = 1

Config = TypeVar("Config")


@dataclass(frozen=True)
class Weights:
    """What a model's folder holds.

    Attributes:
        config: the saved configuration as plain data.
        facts: what else was noted, such as the digest of the tokenizer whose tokens the model speaks.
        state: tensors by name, in the precision of the file.
        digest: SHA-256 of the tensors' file.
    """

    folder: Path
    config: dict[str, Any]
    facts: dict[str, Any]
    state: dict[str, Tensor]
    digest: str

    def config_as(self, kind: type[Config]) -> Config:
        """The configuration as its dataclass, or NoWeights."""
        return from_json(kind, self.config)

    def fill(self, module: nn.Module) -> None:
        """Copy the tensors into a module, or NoWeights where they do not fit it."""
        try:
            module.load_state_dict(
                {name: value.float() if value.is_floating_point() else value for name, value in self.state.items()}
            )
        except RuntimeError as error:
            problem = str(error).splitlines()[-1].strip()
            raise NoWeights(f"{self.folder}: the weights do not fit their configuration ({problem})") from None


def save(folder: Path, config: Any, module: nn.Module, facts: Mapping[str, Any]) -> None:
    """Write a model's weights and configuration, each atomically; vectors (means, biases) stay in fp32."""
    state = {
        name: (value.to(float16) if value.is_floating_point() and value.ndim > 1 else value).detach().cpu().contiguous()
        for name, value in module.state_dict().items()
    }
    with atomic_path(folder / WEIGHTS) as temporary:
        save_file(state, temporary)
    write_json(folder / CONFIG, {"version": FORMAT_VERSION, "config": to_json(config), "facts": dict(facts)})


def load(folder: Path, what: str) -> Weights:
    """Read a model's folder.

    Raises:
        NoWeights: there is none, or another version of the program wrote it; the message says how to train it.
        InvalidFile: a file is damaged.
    """
    path = folder / WEIGHTS
    if not path.is_file() or not (folder / CONFIG).is_file():
        raise NoWeights(f"{folder}: no trained {what}; train it with `{training_command(what, folder)}`")
    try:
        data = json.loads((folder / CONFIG).read_text(encoding="utf-8"))
        config, facts, version = data["config"], data["facts"], data["version"]
    except (ValueError, KeyError, TypeError) as error:
        raise InvalidFile(folder / CONFIG, f"not a model's configuration ({error!r})") from None
    if version != FORMAT_VERSION:
        raise NoWeights(f"{folder}: weights of format {version}, this program reads {FORMAT_VERSION}; train again")
    try:
        return Weights(folder, config, facts, load_file(path), digest(folder))
    except (SafetensorError, OSError) as error:
        raise InvalidFile(path, f"not readable weights ({error})") from None


def digest(folder: Path) -> str:
    """SHA-256 of a model's tensors."""
    return hashlib.sha256((folder / WEIGHTS).read_bytes()).hexdigest()
