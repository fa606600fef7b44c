"""The `completion` subcommand: a shell's completion of commands, options and robots."""

from dataclasses import dataclass
from typing import Annotated, Literal

import tyro

from pipeline.command_line import SCRIPT, command_class
from pipeline.commands import COMMANDS
from ros_free_stack.console import Command

Shell = Literal["bash", "zsh", "fish"]


@dataclass(frozen=True, kw_only=True)
class Completion(Command):
    """Print a script that completes commands, options and robots of `rfs` in a shell.

    Examples:
        rfs completion bash > ~/.local/share/bash-completion/completions/rfs
        rfs completion zsh > ~/.zfunc/_rfs        (with fpath+=~/.zfunc before compinit)
        rfs completion fish > ~/.config/fish/completions/rfs.fish
    """

    shell: Annotated[Shell, tyro.conf.Positional]
    """Which shell."""

    def run(self) -> int:
        script = completion_script(self.shell)
        self.report({"shell": self.shell, "script": script}, script)
        return 0


def completion_script(shell: Shell) -> str:
    """The script for a shell: every command and option by name, robots after `--robot`, files elsewhere."""
    from pipeline.usage_errors import option_names
    from ros_free_stack.robots import robot_names

    options = {name: option_names(command_class(name)) for name in COMMANDS}
    robots = " ".join(robot_names())
    return _fish(options, robots) if shell == "fish" else _bash(options, robots, zsh=shell == "zsh")


def _bash(options: dict[str, tuple[str, ...]], robots: str, *, zsh: bool) -> str:
    heads = " ".join(dict.fromkeys(name.partition(" ")[0] for name in COMMANDS))
    inside: dict[str, list[str]] = {}
    for group, _, second in (name.partition(" ") for name in COMMANDS):
        inside.setdefault(group, []).extend([second] if second else [])
    cases = [f'    "{group}") words="{" ".join(names)}" ;;' for group, names in inside.items() if names]
    cases += [f'    "{name}"|"{name} "*) words="{" ".join(flags)} --help" ;;' for name, flags in options.items()]
    return "\n".join(
        [
            *(["#compdef rfs", "autoload -U +X bashcompinit && bashcompinit"] if zsh else []),
            "_rfs() {",
            '  local word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" words=""',
            '  local typed="${COMP_WORDS[*]:1:COMP_CWORD-1}"',
            f'  if [ "$before" = --robot ]; then COMPREPLY=($(compgen -W "{robots}" -- "$word")); return; fi',
            '  case "$typed" in',
            f'    "") words="{heads} --version --help" ;;',
            *cases,
            "  esac",
            '  COMPREPLY=($(compgen -W "$words" -- "$word"))',
            '  if [ ${#COMPREPLY[@]} -eq 0 ]; then COMPREPLY=($(compgen -f -- "$word")); fi',
            "}",
            f"complete -o filenames -F _rfs {SCRIPT}",
        ]
    )


def _fish(options: dict[str, tuple[str, ...]], robots: str) -> str:
    lines = [f"complete -c {SCRIPT} -n __fish_use_subcommand -f -a '--version --help'"]
    for name, (_, words) in COMMANDS.items():
        first, _, second = name.partition(" ")
        seen = f"__fish_seen_subcommand_from {first}"
        if second:
            lines.append(f"complete -c {SCRIPT} -n __fish_use_subcommand -f -a {first}")
            lines.append(f"complete -c {SCRIPT} -n '{seen}' -f -a {second} -d {_quoted(words)}")
            seen += f"; and __fish_seen_subcommand_from {second}"
        else:
            lines.append(f"complete -c {SCRIPT} -n __fish_use_subcommand -f -a {first} -d {_quoted(words)}")
        for flag in options[name]:
            values = f" -x -a '{robots}'" if flag == "--robot" else ""
            lines.append(f"complete -c {SCRIPT} -n '{seen}' -l {flag.removeprefix('--')}{values}")
    return "\n".join(dict.fromkeys(lines))


def _quoted(words: str) -> str:
    return "'" + words.replace("\\", "\\\\").replace("'", "\\'") + "'"
