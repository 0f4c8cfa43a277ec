"""The files of a project as the page lists them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Any, Final

from assistant import languages, sources
from assistant.program import pseudo
from assistant.sources import PROCESS_SUFFIX
from assistant.sources.process.placement import DRAWING_SUFFIXES
from assistant.studio.studio import UNLISTED_FOLDERS

MOST_FILES: Final = 5_000
"""That are listed."""
SUFFIX_KINDS: Final[Mapping[str, str]] = {
    **dict.fromkeys(DRAWING_SUFFIXES, "drawing"),
    **dict.fromkeys((".stl", ".obj", ".glb", ".gltf"), "shape"),
    **dict.fromkeys((".png", ".jpg", ".jpeg", ".svg"), "picture"),
    ".toml": "settings",
    ".csv": "table",
}
"""What files of these suffixes are, beside programs."""


def file_tree(folder: FilePath) -> list[dict[str, Any]]:
    """Files with their kinds, in the order of their names."""
    suffixes = program_suffixes()
    return [
        {"path": path, "kind": file_kind(path, suffixes), "size": size}
        for path, (_, size) in sorted(file_stamps(folder).items())
    ]


def file_stamps(folder: FilePath) -> dict[str, tuple[int, int]]:
    """When each file was changed, in ns, and how many bytes it has."""
    found: dict[str, tuple[int, int]] = {}
    for path, entry in _listed_files(folder):
        try:
            facts = entry.stat()
        except OSError:
            continue  # it has just gone
        found[path] = (facts.st_mtime_ns, facts.st_size)
        if len(found) >= MOST_FILES:
            break
    return found


def program_suffixes() -> frozenset[str]:
    """Suffixes of programs, in lower case."""
    theirs = (s for name in languages.names() for s in languages.get(name).suffixes)
    return frozenset({pseudo.SUFFIX, *(suffix.lower() for suffix in theirs)})


def file_kind(path: str, suffixes: frozenset[str]) -> str:
    """drawing, process, program, table, settings, … or file."""
    name = PurePosixPath(path).name.lower()
    suffix = PurePosixPath(name).suffix
    if name.endswith(PROCESS_SUFFIX):
        return "process"
    if name.endswith(".schema.json"):
        return "settings"
    if name == "assistant.toml":
        return "project"
    if suffix in suffixes:
        return "program"
    return SUFFIX_KINDS.get(suffix, "table" if suffix in sources.READERS else "file")


def _listed_files(folder: FilePath) -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Without what is hidden, and without links that lead elsewhere."""
    waiting = [(folder, "")]
    while waiting:
        here, before = waiting.pop()
        try:
            with os.scandir(here) as entries:
                listed = sorted(entries, key=lambda one: one.name)
        except OSError:
            continue  # it may not be read, or has gone
        for entry in listed:
            if entry.name in UNLISTED_FOLDERS or entry.name.startswith(".") or entry.is_symlink():
                continue
            path = f"{before}{entry.name}"
            if entry.is_dir(follow_symlinks=False):
                waiting.append((here / entry.name, f"{path}/"))
            elif entry.is_file(follow_symlinks=False):
                yield path, entry
