"""The tasks of a folder of programs whose names hold their paths."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from assistant.compiler.program_files import Task, tasks_of

TO = {"rapid": "melfa-basic-6", "melfa": "rapid"}
"""Folder of a corpus → the language that its programs are translated to."""
LISTS = (".pgf",)


@dataclass(frozen=True, slots=True)
class Found:
    """A task. name: its repository and path. kind: of its language, see TO."""

    name: str
    kind: str
    task: Task

    @property
    def begins(self) -> bool:
        """Whether it has a `main`; else it is a library."""
        return self.task.begins


def found(root: Path, work: Path, part: str, *, alone: bool) -> Iterator[Found]:
    """Tasks of several RAPID files, or MELFA programs. alone: also RAPID modules by themselves.

    root: folder of the repositories of a kind. work: an empty folder, in which the files get their
    paths back. part: of the names of the tasks, in any case.
    """
    for repository in sorted(root.iterdir()) if root.is_dir() else ():
        if repository.is_dir():
            for task in _of(repository, work / repository.name, root.name, part.lower()):
                if part.lower() in task.name.lower() and (alone or _is_whole(task)):
                    yield task


def _is_whole(task: Found) -> bool:
    modules = [file for file in task.task.files if Path(file).suffix.lower() not in LISTS]
    return task.kind != "rapid" or len(modules) > 1


def _of(repository: Path, folder: Path, kind: str, part: str) -> Iterator[Found]:
    """The tasks of a repository, if the name of one of them may have the part."""
    names = [f"{repository.name}/{'/'.join(_parts(file))}" for file in repository.iterdir()]
    if not any(part in name.lower() for name in names):
        return
    files = [str(_restored(file, folder)) for file in sorted(repository.iterdir())]
    for task in tasks_of(files):
        yield Found(f"{repository.name}/{Path(task.name).relative_to(folder)}", kind, task)


def _parts(file: Path) -> list[str]:
    """The path that the name of a file holds."""
    return [part for part in file.name.split("__") if part not in ("", ".", "..")] or [file.name]


def _restored(file: Path, folder: Path) -> Path:
    """A copy of the file at the path that its name holds."""
    path = folder.joinpath(*_parts(file))
    if path.is_dir() or any(parent.is_file() for parent in path.parents):
        path = folder / file.name
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, path)
    return path
