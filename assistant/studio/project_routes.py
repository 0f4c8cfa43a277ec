"""Routes of the project: its tree, opening, creating, checking, building, and dropped files.

A dropped file goes to the folder of its kind, and the project's file gets an entry for it.
"""

from __future__ import annotations

import re
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.file_access import read_file
from assistant.base.file_sets import write_all
from assistant.base.source_text import is_file
from assistant.program.program import TakenNames, identifier
from assistant.project import project_of
from assistant.project.new_project import PROJECT_FILE, StartedProject, start_project
from assistant.project.project_file import Project
from assistant.resources import resource
from assistant.sources import PROCESS_SUFFIX, READERS
from assistant.sources.process.placement import DRAWING_SUFFIXES
from assistant.studio import rules
from assistant.studio.process_files import project_table, with_values
from assistant.studio.route_answers import Question, asks, changes, finding_records, looks
from assistant.studio.studio import Studio, program_suffixes


def project(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """The tree, and what the project's file says: a project that is wrong has its findings."""
    from assistant.studio.studio import MOST_FILES, file_tree

    files = file_tree(studio.folder)
    return {
        "folder": str(studio.folder),
        "name": studio.folder.name or str(studio.folder),
        "files": files,
        "more": len(files) == MOST_FILES,
        **_project_record(studio),
    }


def _project_record(studio: Studio) -> dict[str, Any]:
    from assistant.project import project_of
    from assistant.project.rules import NO_PROJECT

    nothing: dict[str, Any] = {"there": False, "programs": [], "targets": [], "controllers": []}
    try:
        found = project_of(studio.folder)
    except Refused as refused:
        codes = {finding.code for finding in refused.findings}
        told = [] if codes == {NO_PROJECT.code} else finding_records(refused.findings)
        return nothing | {"there": codes != {NO_PROJECT.code}, "findings": told}
    return {
        "there": True,
        "programs": [
            {"name": one.name, "source": studio.named(one.source)}
            for one in found.programs.values()
        ],
        "targets": [
            {
                "name": place.name,
                "controller": place.controller.name,
                "programs": [one.name for one in place.recipes],
            }
            for place in found.places
        ],
        "controllers": _controller_records(studio),
        "findings": [],
    }


def _controller_records(studio: Studio) -> list[dict[str, Any]]:
    from assistant.controllers import controllers_of

    return [
        {
            "name": one.name,
            "address": str(one.address),
            "virtual": one.virtual,
            "robot": one.robot,
        }
        for one in controllers_of(studio.folder).values()
    ]


def create(studio: Studio, asked: Question) -> dict[str, Any]:
    """Starts a project in the folder: an example, or nothing but its file."""
    from assistant.project.new_project import start_project

    done = _start_empty(studio.folder) if asked.truth("empty") else start_project(studio.folder)
    return {
        "written": [studio.named(file) for file in done.written],
        "findings": finding_records(done.findings),
    }


def _open_folder(studio: Studio, asked: Question) -> dict[str, Any]:
    """Works on another folder; what runs or is connected ends."""
    folder = FilePath(asked.text("folder")).expanduser()
    if not folder.is_absolute():
        folder = studio.folder / folder
    studio.folder_at(folder)  # for one that is not there nothing ends
    with studio.beginning:
        studio.end()
        studio.go_to(folder)
    studio.windows.tell({"kind": "project"})
    return {"folder": str(studio.folder)}


def drop(studio: Studio, asked: Question) -> dict[str, Any]:

    return _drop_file(studio, asked.text("name"), asked.data)


def drawing(studio: Studio, asked: Question) -> dict[str, Any]:
    from assistant.studio.process_files import drawing_layers

    return drawing_layers(studio, asked.text("path"))


def process(studio: Studio, asked: Question) -> dict[str, Any]:
    from assistant.studio.process_files import write_process

    return write_process(studio, asked.text("path"), asked.table("values"))


def check(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Return the findings of `check` for the project."""
    from assistant.project import project_of
    from assistant.project.builds import check as checked

    done = checked(project_of(studio.folder))
    return {"programs": done.programs, "findings": finding_records(done.findings)}


def build(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Compiles the programs of the project for its targets, as `build` does."""
    from assistant.project import build as built
    from assistant.project import project_of
    from assistant.project.builds import build_record

    done = built(project_of(studio.folder))
    return build_record(done, studio.named) | {"findings": finding_records(done.findings)}


PROJECT_ROUTES: Final = (
    looks("/project", project),
    changes("/project/create", create),
    changes("/project/open", _open_folder),
    changes("/project/drop", drop),
    changes("/project/build", build),
    asks("/project/check", check),
    looks("/drawing", drawing),
    changes("/drawing/process", process),
)


_FILE_NAME: Final = re.compile(r"[^\W_][\w .+()-]{0,119}")
"""Pattern of a dropped file's name: no folder, nothing hidden, no control characters for a
terminal.
"""
_DEVICE_NAMES: Final = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9¹²³]) *(\..*)?", re.IGNORECASE)
"""Names that Windows has for devices, whatever their suffix.

https://learn.microsoft.com/windows/win32/fileio/naming-a-file#naming-conventions
"""
_KIND_FOLDERS: Final = {"drawing": "drawings", "program": "programs", "table": "tables"}
_LONGEST_NAME: Final = 60
_PROJECT_ENCODING: Final = "utf-8"
_TARGET_HEADER: Final = "[targets."
"""Text at which the target tables begin in the example's project."""
_PROGRAMS_HEADER: Final = "[programs."


def _start_empty(folder: FilePath) -> StartedProject:
    """Start a project without programs; an existing one stays unchanged."""
    file = folder / PROJECT_FILE
    if not (file.exists() or file.is_symlink()):
        text, _ = _example_project()
        write_all({file: text.encode(_PROJECT_ENCODING)})
    return StartedProject(folder, (file,))


def _drop_file(studio: Studio, name: str, data: bytes) -> dict[str, Any]:
    """Write a file into the project, and add it to the project file where necessary.

    Raises Refused for an invalid name, for a file that is not a source, and for an existing file.
    """
    kind = _dropped_kind(name)
    file = studio.place(f"{_KIND_FOLDERS[kind]}/{name}")
    if not is_file(studio.folder / PROJECT_FILE):
        _start_empty(studio.folder)
    before = read_file(file) if is_file(file) else None
    if before is not None and before != data:
        raise Refused(rules.THERE_ALREADY(path=name, name=name))
    found: list[Diagnostic] = []
    written: list[FilePath] = []
    if kind == "drawing":
        done = _drop_drawing(studio, file, data)
        found += done.findings
        written += done.written
    else:
        written += write_all({file: data})
    _add_program_entry(studio, file)
    main = file.with_suffix(PROCESS_SUFFIX) if kind == "drawing" else file
    return {
        "path": studio.named(file),
        "kind": kind,
        "opens": studio.named(main),
        "written": [studio.named(one) for one in written],
        "findings": finding_records([one for one in found if one.code != _not_added_finding()]),
    }


def _drop_drawing(studio: Studio, file: FilePath, data: bytes) -> StartedProject:
    """The drawing with its process file, as `init FOLDER DRAWING` writes it; both or none."""
    new = not is_file(file)
    write_all({file: data})
    try:
        return start_project(studio.folder, (file,))
    except BaseException:
        if new:
            file.unlink(missing_ok=True)
        raise


def _add_program_entry(studio: Studio, file: FilePath) -> None:
    """[programs.NAME] of a source, and its name in the target of the first controller."""
    project = project_of(studio.folder)
    known = {recipe.source.resolve() for recipe in project.programs.values()}
    if file.resolve() in known:
        return
    name = identifier(file.stem, TakenNames(project.programs))[:_LONGEST_NAME]
    text = read_file(project.file).decode(_PROJECT_ENCODING)
    path = project_table(project)
    text = with_values(
        text, {(*path, "programs", name, "source"): studio.named(file)}, project.file.name
    )
    text = _add_to_target(text, path, project, name)
    write_all({project.file: text.encode(_PROJECT_ENCODING)})
    project_of(studio.folder)


def _add_to_target(text: str, path: tuple[str, ...], project: Project, name: str) -> str:
    from assistant.controllers import controllers_of

    if project.places:
        place = project.places[0]
        programs = [one.name for one in place.recipes]
        at = (*path, "targets", place.name, "programs")
        return with_values(text, {at: [*programs, name]}, project.file.name)
    controllers = controllers_of(project.folder)
    if not controllers or path:
        return text
    first = next(iter(controllers))
    _, target = _example_project()
    if not (
        text.startswith(_example_project()[0]) and target.startswith(f"{_TARGET_HEADER}{first}]")
    ):
        target = f"{_TARGET_HEADER}{first}]\nprograms = []\n"
    text = f"{text.rstrip()}\n\n{target}"
    return with_values(text, {("targets", first, "programs"): [name]}, project.file.name)


def _example_project() -> tuple[str, str]:
    """Return the project file that `init` writes, without its program, and its target tables."""
    text = resource("templates", f"project/{PROJECT_FILE}").read_text(encoding=_PROJECT_ENCODING)
    program, target = text.index(_PROGRAMS_HEADER), text.index(_TARGET_HEADER)
    return text[:program].rstrip() + "\n", text[target:]


def check_file_name(name: str) -> None:
    """Raises Refused for what cannot be the name of a new file here."""
    plain = _FILE_NAME.fullmatch(name) and not _DEVICE_NAMES.fullmatch(name)
    if not plain or name.endswith((" ", ".")) or ".." in name:
        raise Refused(rules.NO_PLAIN_NAME(name=name), exit_status=2)


def _dropped_kind(name: str) -> str:
    """Return drawing, program or table; raise Refused for a bad name, and for any other kind."""
    check_file_name(name)
    suffix = PurePosixPath(name).suffix.lower()
    if suffix in DRAWING_SUFFIXES:
        return "drawing"
    if suffix in program_suffixes():
        return "program"
    if suffix in READERS and suffix not in (".toml", ".json"):
        return "table"
    known = ", ".join(
        sorted({*DRAWING_SUFFIXES, *program_suffixes(), *READERS} - {".toml", ".json"})
    )
    raise Refused(rules.NOT_TAKEN(path=name, name=name, known=known), exit_status=2)


def _not_added_finding() -> str:
    from assistant.project.rules import NOT_ADDED

    return NOT_ADDED.code
