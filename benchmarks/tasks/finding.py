"""The tasks of a folder of programs whose names hold their paths."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from assistant.compiler.tasks import tasks_of

TO = {"rapid": "melfa-basic-6", "melfa": "rapid"}
"""Folder of a corpus → the language that its programs are translated to."""
LISTS = (".pgf",)
MELFA = "melfa-basic-6"
"""Of a program whose text does not tell its version."""


@dataclass(frozen=True, slots=True)
class Found:
    """A task. name: its repository and path. begins: whether it has a `main`; else a library."""

    name: str
    kind: str
    files: tuple[str, ...]
    begins: bool
    language: str | None


def found(corpus: Path, work: Path, *, alone: bool) -> Iterator[Found]:
    """Tasks of several RAPID files, and MELFA programs. alone: also RAPID modules by themselves.

    work: an empty folder, in which the files get their paths back.
    """
    for kind in TO:
        root = corpus / kind
        for repository in sorted(root.iterdir()) if root.is_dir() else ():
            if repository.is_dir():
                yield from _of(repository, work / kind / repository.name, kind, alone=alone)


def _of(repository: Path, folder: Path, kind: str, *, alone: bool) -> Iterator[Found]:
    files = [str(_restored(file, folder)) for file in sorted(repository.iterdir())]
    for task in tasks_of(files):
        modules = [f for f in task.files if Path(f).suffix.lower() not in LISTS]
        if kind == "rapid" and len(modules) < 2 and not alone:
            continue
        name = f"{repository.name}/{Path(task.name).relative_to(folder)}"
        yield Found(name, kind, task.files, task.begins, task.language)


def _restored(file: Path, folder: Path) -> Path:
    """A copy of the file at the path that its name holds."""
    parts = [part for part in file.name.split("__") if part not in ("", ".", "..")]
    path = folder.joinpath(*(parts or [file.name]))
    if path.is_dir() or any(parent.is_file() for parent in path.parents):
        path = folder / file.name
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, path)
    return path
