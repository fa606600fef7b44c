"""The wheel: all packages inside `ros_free_stack`, so that nothing as general as `sim` is installed at the top.

A checkout, and an editable install of it, keep the packages side by side. For a wheel their names are put below
`ros_free_stack` in every import, and in the strings that name a module to import.
"""

import ast
import re
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.egg_info import egg_info

TOP = "ros_free_stack"
INNER = ("generator", "retarget", "sim", "hw", "pipeline")
_MODULE = re.compile(rf"(?:{'|'.join(INNER)})(?:\.\w+)+(?::\w+)?")


class BuildPackages(build_py):
    """Moves the inner packages below the top one after they were collected."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        built = Path(self.build_lib)
        for name in INNER:
            if (built / name).is_dir():
                shutil.rmtree(built / TOP / name, ignore_errors=True)
                (built / name).rename(built / TOP / name)
        for path in built.rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            moved = below_top(text)
            if moved != text:
                path.write_text(moved, encoding="utf-8")


class Names(egg_info):
    """States the one package that a wheel puts at the top."""

    def run(self) -> None:
        super().run()
        (Path(self.egg_info) / "top_level.txt").write_text(f"{TOP}\n", encoding="utf-8")


def below_top(text: str) -> str:
    """A module's text with the inner packages' names below the top one, in imports and in names of modules."""
    lines = text.splitlines(keepends=True)
    edits: list[tuple[int, int, str, str]] = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and not node.level and _is_inner(node.module or ""):
            edits.append((node.lineno, node.col_offset, f"from {node.module}", f"from {TOP}.{node.module}"))
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if _is_inner(alias.name):
                    if alias.asname is None:
                        raise SystemExit(f"line {node.lineno}: import {alias.name} as something, or from it")
                    edits.append((alias.lineno, alias.col_offset, alias.name, f"{TOP}.{alias.name}"))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and _MODULE.fullmatch(node.value):
            edits.append((node.lineno, node.col_offset, node.value, f"{TOP}.{node.value}"))
    for line, column, old, new in sorted(edits, reverse=True):
        row = lines[line - 1]
        start = row.encode()[:column].decode()  # columns count bytes
        lines[line - 1] = start + row[len(start) :].replace(old, new, 1)
    return "".join(lines)


def _is_inner(module: str) -> bool:
    return module.partition(".")[0] in INNER


setup(cmdclass={"build_py": BuildPackages, "egg_info": Names})
