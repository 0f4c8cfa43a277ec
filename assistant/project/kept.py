"""What the last build left: `.robot-assistant/build.json`.

For each program of each target the digests of what it was made of and of what came out, so that
the next build knows what has not changed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import __version__
from assistant.base.file_access import read_file
from assistant.base.file_sets import write_files
from assistant.project.inputs import Digests, all_unchanged, digest_of
from assistant.project.layout import BUILD_FOLDER, STATE_FOLDER, Project
from assistant.project.making import BuildOrder
from assistant.project.tables import PROJECT_NAME

BUILD_FORMAT: Final = 1
BUILD_FILE: Final = "build.json"


@dataclass(frozen=True, slots=True)
class BuildEntry:
    """A program of a target. wanted: digest of its options. files: of what was written, by name.

    inputs: see `inputs`; empty if it could not be built, so that it is tried again. origins: see
    `Made`.
    """

    wanted: str
    inputs: Mapping[str, str | None] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    origins: Mapping[str, str] = field(default_factory=dict)


BuildEntries = dict[str, BuildEntry]
"""By target and program, as `cell1/plate`."""


def entry_key(target: str, program: str) -> str:
    return f"{target}/{program}"


def options_digest(project: Project, order: BuildOrder) -> str:
    """The digest of all that is wanted of a program, and of who makes it."""
    options: dict[str, Any] = {"version": __version__, "settings": project.settings}
    for name, value in {**asdict(order.recipe), "taken": order.taken, "arm": order.arm}.items():
        options[name] = _portable_path(project, value)
    return digest_of(json.dumps(options, sort_keys=True).encode("utf-8", "surrogatepass"))


def _portable_path(project: Project, value: object) -> object:
    """A path from the project's folder: the same in each copy of the project."""
    if isinstance(value, str | FilePath) and FilePath(value).is_absolute():
        path = FilePath(value)
        return (
            path.relative_to(project.folder).as_posix()
            if _is_in_project(project, path)
            else str(path)
        )
    return [_portable_path(project, one) for one in value] if isinstance(value, tuple) else value


def _is_in_project(project: Project, path: FilePath) -> bool:
    return path.is_relative_to(project.folder)


def why_stale(
    project: Project, target: str, order: BuildOrder, entry: BuildEntry | None
) -> str | None:
    """Why what was built of a program is not what a build would make now, None if it is."""
    if entry is None or not entry.inputs:
        return "it was never built" if entry is None else "the last build of it failed"
    if entry.wanted != options_digest(project, order):
        return "its options were changed since"
    if not all_unchanged(project.folder, entry.inputs):
        return "a file that it is made of was changed since"
    folder = project.folder / BUILD_FOLDER / target
    for name, digest in entry.files.items():
        try:
            if digest_of(read_file(folder / name)) != digest:
                return f"`{BUILD_FOLDER}/{target}/{name}` was changed by somebody"
        except OSError:
            return f"`{BUILD_FOLDER}/{target}/{name}` is not there"
    return None


def read_build(project: Project) -> BuildEntries:
    """Those of the last build; none if the file is missing or damaged: all is built again then."""
    try:
        content = json.loads(read_file(project.kept / BUILD_FILE))
        if content["format"] != BUILD_FORMAT:
            return {}
        entries = {_checked_key(key): _entry_of_row(row) for key, row in content["built"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}
    return entries


def _checked_key(told: str) -> str:
    if PROJECT_NAME.fullmatch(told.partition("/")[0]) is None:
        raise ValueError("a name of a target leads elsewhere")
    return told


def _entry_of_row(row: Mapping[str, Any]) -> BuildEntry:
    inputs: Digests = {str(key): value for key, value in row["inputs"].items()}
    files = {str(name): str(digest) for name, digest in row["files"].items()}
    if any(FilePath(name).name != name or name in ("", ".", "..") for name in files):
        raise ValueError("a name of a file leads elsewhere")
    origins = {str(name): str(file) for name, file in row["origins"].items()}
    return BuildEntry(str(row["wanted"]), inputs, files, origins)


def write_build(project: Project, entries: BuildEntries) -> None:
    """Raises Refused (exit status 2) if that cannot be."""
    rows = {key: asdict(entries[key]) for key in sorted(entries)}
    text = json.dumps({"format": BUILD_FORMAT, "built": rows}, indent=1, sort_keys=True) + "\n"
    write_files({BUILD_FILE: text.encode()}, project.folder / STATE_FOLDER)
