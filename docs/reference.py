"""Pages that the site's builder makes from the code: every command with its options, and the Python API."""

import importlib
import inspect
import re
from typing import Any

import tyro
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from pipeline.commands import COMMANDS

MODULES: dict[str, tuple[str, ...]] = {
    "The whole path": ("pipeline.pipeline", "pipeline.candidate"),
    "Text to motion": ("generator.performer", "generator.model", "generator.text.understanding", "generator.amounts"),
    "Motion to trajectory": ("retarget.pipeline", "retarget.report", "retarget.solve.online"),
    "Verdict": ("sim.judge.verdict", "sim.judge.repair", "ros_free_stack.thresholds"),
    "Servos": ("hw.stream", "hw.driver", "hw.gate", "hw.virtual.bus"),
    "What crosses between stages": (
        "ros_free_stack.messages",
        "ros_free_stack.servo_path",
        "ros_free_stack.robots",
        "ros_free_stack.files",
        "ros_free_stack.errors",
    ),
}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
    for name, content in (("commands.md", commands_page()), ("api.md", api_page())):
        files.append(File.generated(config, name, content=content))
    return files


def commands_page() -> str:
    """Every subcommand: what it is for, and what `--help` says."""
    parts = ["# Commands", "", "`python launch.py COMMAND` in a checkout, `rfs COMMAND` where it is installed.", ""]
    for name, (place, words) in COMMANDS.items():
        parts += [f"## {name}", "", f"{words[0].upper()}{words[1:]}.", "", "```text", _help(name, place), "```", ""]
    return "\n".join(parts)


def api_page() -> str:
    """The modules that a program of one's own calls, by stage."""
    parts = ["# Python API", "", "`examples/` in the repository has a script of a screen for each stage.", ""]
    for title, modules in MODULES.items():
        parts += [f"## {title}", "", *(f"::: {module}\n    options:\n      heading_level: 3\n" for module in modules)]
    return "\n".join(parts)


def _help(name: str, place: str) -> str:
    module, class_name = place.split(":")
    command: Any = getattr(importlib.import_module(module), class_name)
    text = tyro.extras.get_parser(command, prog=f"rfs {name}", description=inspect.getdoc(command)).format_help()
    return re.sub(r"\x1b\[[0-9;]*m", "", text).rstrip()
