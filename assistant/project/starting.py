"""Starting a project: a working example, and what a repository needs around it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Final

from assistant import __version__
from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.base.file_access import read_file
from assistant.base.file_sets import write_all
from assistant.base.length_units import known_unit
from assistant.base.source_text import read_bytes
from assistant.program.program import TakenNames, identifier
from assistant.project import rules
from assistant.project.drafting import process_text, program_text, toml_quoted
from assistant.project.layout import project_of
from assistant.project.schema import SCHEMA_FILE, schema_text
from assistant.resources import resource
from assistant.sources import PROCESS_SUFFIX
from assistant.sources.drawing.survey import survey
from assistant.sources.process import NO_PROCESS
from assistant.sources.project_file import read_project

PROJECT_FILE: Final = "assistant.toml"
EXAMPLE_DRAWING: Final[Mapping[str, str]] = {
    "drawings/plate.dxf": "drawings/plate.dxf",
    "drawings/plate.process.toml": "drawings/plate.process.toml",
}
"""Files of the example's drawing → their templates."""
EXAMPLE_FILES: Final = (*EXAMPLE_DRAWING, PROJECT_FILE)
"""Files of the example; written where there is no project yet and no drawing is given.

The project is the last: who is killed before it begins anew.
"""
EXAMPLE_PROGRAM: Final = """\
[programs.plate]
source = "drawings/plate.dxf"     # with drawings/plate.process.toml beside it
"""
EXAMPLE_NAMES: Final = '["plate"]'
"""What the example's project says of its program."""
DRAWINGS_FOLDER: Final = "drawings"
"""Folder of drawings that are copied into a project."""
REPOSITORY_FILES: Final[Mapping[str, str]] = {
    ".gitignore": "gitignore",
    ".pre-commit-config.yaml": "pre-commit-config.yaml",
    ".github/workflows/robot.yml": "github.yml",
    ".gitlab-ci.yml": "gitlab-ci.yml",
}
"""What a repository needs; each written unless it is there."""
IGNORED_FOLDERS: Final = "/build/ and .robot-assistant/"
VERSION_MARK: Final = "{{ version }}"
NAMES_WIDTH: Final = 22
"""Columns before the comment behind the names."""
LONGEST_NAME: Final = 60


@dataclass(frozen=True, slots=True)
class StartedProject:
    """written, in their order. findings: what was there already, and what drawings have. blank:
    process files in which something has to be filled in.
    """

    folder: FilePath
    written: tuple[FilePath, ...]
    findings: tuple[Diagnostic, ...] = ()
    blank: tuple[FilePath, ...] = ()


def start_project(
    folder: FilePath, drawings: Sequence[FilePath] = (), unit: str | None = None
) -> StartedProject:
    """Writes what is missing of a project into a folder; overwrites nothing.

    drawings: programs of the project, each with a process file to be filled in; without any a new
    project has an example. One that is not in the folder is copied. unit: that they are in,
    whatever they say. Raises Unreadable or Refused for drawings that cannot be used, Refused
    (exit status 2) if a file cannot be written.
    """
    drawn = [_add_drawing(folder, drawing, unit) for drawing in dict.fromkeys(drawings)]
    contents = {name: _template_bytes(template) for name, template in REPOSITORY_FILES.items()}
    contents[SCHEMA_FILE] = schema_text().encode()
    found = [finding for one in drawn for finding in one.findings]
    of_drawings = {name: data for one in drawn for name, data in one.files.items()}
    programs = _program_names([one.source for one in drawn])
    if _has_project_table(folder):
        found += _missing_entries(folder, programs)
        contents = {**of_drawings, **contents}
    elif drawn:
        contents = {
            **of_drawings,
            PROJECT_FILE: _project_text(program_text(programs), programs),
            **contents,
        }
    else:
        example = {name: _template_bytes(template) for name, template in EXAMPLE_DRAWING.items()}
        contents = {**example, PROJECT_FILE: _template_bytes(PROJECT_FILE), **contents}
    wanted: dict[FilePath, bytes] = {}
    for name, data in contents.items():
        file = folder / name
        if file.exists() or file.is_symlink():
            if _differs_on_disk(file, data):
                found.append(rules.KEPT(file=name, cure=_replacement_cure(name)))
            continue
        _refuse_link_folders(folder, file)
        wanted[file] = data
    blank = tuple(file for file in wanted if file.name.endswith(PROCESS_SUFFIX) and drawn)
    return StartedProject(folder, write_all(wanted), tuple(found), blank)


@dataclass(frozen=True, slots=True)
class _AddedDrawing:
    """source: from the folder. files: of the project that it needs, by name."""

    source: str
    files: Mapping[str, bytes]
    findings: tuple[Diagnostic, ...]


def _add_drawing(folder: FilePath, drawing: FilePath, unit: str | None) -> _AddedDrawing:
    """A drawing of the project, with its process file. Raises Unreadable or Refused."""
    chosen = NO_PROCESS if unit is None else replace(NO_PROCESS, unit=known_unit(unit))
    found = survey(drawing, chosen, "as was stated")
    files: dict[str, bytes] = {}
    here = drawing.resolve()
    if here.is_relative_to(folder.resolve()):
        source = here.relative_to(folder.resolve()).as_posix()
    else:
        source = f"{DRAWINGS_FOLDER}/{drawing.name}"
        data = read_bytes(drawing)
        if (folder / source).exists() and _differs_on_disk(folder / source, data):
            raise Refused(rules.OTHER_DRAWING(path=str(drawing), file=source), exit_status=2)
        files[source] = data
    process = FilePath(source).with_suffix(PROCESS_SUFFIX).as_posix()
    files[process] = process_text(drawing.name, found).encode("utf-8", "replace")
    told = tuple(finding.within(str(drawing)) for finding in found.findings)
    return _AddedDrawing(source, files, tuple(f for f in told if f.severity is not Severity.INFO))


def _program_names(sources: Sequence[str]) -> dict[str, str]:
    """Names of programs → their sources."""
    taken = TakenNames(())
    names: dict[str, str] = {}
    for source in sources:
        name = identifier(FilePath(source).stem, taken)[:LONGEST_NAME]
        taken.add(name)
        names[name] = source
    return names


def _project_text(programs: str, names: Iterable[str]) -> bytes:
    """The example's, with these programs instead of its own."""
    listed = "[" + ", ".join(f'"{name}"' for name in names) + "]"
    text = _template_bytes(PROJECT_FILE).decode().replace(EXAMPLE_PROGRAM, programs)
    return text.replace(f"{EXAMPLE_NAMES:{NAMES_WIDTH}}", f"{listed:{NAMES_WIDTH}}").encode()


def _missing_entries(folder: FilePath, programs: Mapping[str, str]) -> Iterator[Diagnostic]:
    """What a project that is there has to say of the drawings. Raises Unreadable or Refused."""
    known = {recipe.source.resolve() for recipe in project_of(folder).programs.values()}
    for name, source in programs.items():
        if (folder / source).resolve() not in known:
            table = f"[programs.{name}] with source = {toml_quoted(source)}"
            yield rules.NOT_ADDED(name=name, source=source, table=table)


def _has_project_table(folder: FilePath) -> bool:
    """Whether the folder itself has a file with a table of ours; raises Unreadable."""
    file = folder / PROJECT_FILE
    python = folder / "pyproject.toml"
    of_python = python.is_file() and read_project(python, ("tool", "robot-assistant")) is not None
    return file.exists() or file.is_symlink() or of_python


def _refuse_link_folders(folder: FilePath, file: FilePath) -> None:
    """Raises Refused if a link on the way leads out of the folder."""
    if not file.parent.resolve().is_relative_to(folder.resolve()):
        raise Refused(rules.OUTSIDE(file=file), exit_status=2)


def _differs_on_disk(file: FilePath, data: bytes) -> bool:
    try:
        return read_file(file).replace(b"\r\n", b"\n") != data
    except OSError:
        return True


def _replacement_cure(name: str) -> str:
    if name == ".gitignore":
        return f"see that it ignores {IGNORED_FOLDERS}"
    return "move it away and run `robot-assistant init` again to have a new one"


def _template_bytes(template: str) -> bytes:
    text = resource("templates", f"project/{template}").read_text(encoding="utf-8")
    return text.replace(VERSION_MARK, __version__).encode()
