"""Starting a project: a working example, and what a repository needs around it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final

from assistant import __version__
from assistant.program.diagnostics import Diagnostic, Refused
from assistant.program.system.bounded import read_file
from assistant.program.system.writing import write_all
from assistant.project import rules
from assistant.project.schema import FILE, schema_text
from assistant.resources import resource
from assistant.sources.project import read_project

PROJECT: Final = "assistant.toml"
EXAMPLE: Final[Mapping[str, str]] = {
    "drawings/plate.dxf": "drawings/plate.dxf",
    "drawings/plate.process.toml": "drawings/plate.process.toml",
    PROJECT: "assistant.toml",
}
"""Files of the example → their templates; written where there is no project yet.

The project is the last: who is killed before it begins anew.
"""
AROUND: Final[Mapping[str, str]] = {
    ".gitignore": "gitignore",
    ".pre-commit-config.yaml": "pre-commit-config.yaml",
    ".github/workflows/robot.yml": "github.yml",
    ".gitlab-ci.yml": "gitlab-ci.yml",
}
"""What a repository needs; each written unless it is there."""
IGNORED: Final = "/build/ and .robot-assistant/"
VERSION: Final = "{{ version }}"


@dataclass(frozen=True, slots=True)
class Started:
    """written, in their order. findings: what was there already."""

    folder: FilePath
    written: tuple[FilePath, ...]
    findings: tuple[Diagnostic, ...] = ()


def start(folder: FilePath) -> Started:
    """Writes what is missing of a project into a folder; overwrites nothing.

    Raises Refused (exit status 2) if a file cannot be written.
    """
    contents = {name: _text(template) for name, template in AROUND.items()}
    contents[FILE] = schema_text().encode()
    if not _has_project(folder):
        contents = {**{name: _text(EXAMPLE[name]) for name in EXAMPLE}, **contents}
    wanted: dict[FilePath, bytes] = {}
    found: list[Diagnostic] = []
    for name, data in contents.items():
        file = folder / name
        if file.exists() or file.is_symlink():
            if _differs(file, data):
                found.append(rules.KEPT(file=name, cure=_cure(name)))
            continue
        _check_folders(folder, file)
        wanted[file] = data
    return Started(folder, write_all(wanted), tuple(found))


def _has_project(folder: FilePath) -> bool:
    """Whether the folder itself has a file with a table of ours; raises Unreadable."""
    file = folder / PROJECT
    python = folder / "pyproject.toml"
    of_python = python.is_file() and read_project(python, ("tool", "robot-assistant")) is not None
    return file.exists() or file.is_symlink() or of_python


def _check_folders(folder: FilePath, file: FilePath) -> None:
    """Raises Refused if a link on the way leads out of the folder."""
    if not file.parent.resolve().is_relative_to(folder.resolve()):
        raise Refused(rules.OUTSIDE(file=file), exit_status=2)


def _differs(file: FilePath, data: bytes) -> bool:
    try:
        return read_file(file).replace(b"\r\n", b"\n") != data
    except OSError:
        return True


def _cure(name: str) -> str:
    if name == ".gitignore":
        return f"see that it ignores {IGNORED}"
    return "move it away and run `robot-assistant init` again to have a new one"


def _text(template: str) -> bytes:
    text = resource("templates", f"project/{template}").read_text(encoding="utf-8")
    return text.replace(VERSION, __version__).encode()
