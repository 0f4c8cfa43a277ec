"""Rows of paths by the names that the text gives them.

A run of moves through numbered targets is read as one path, in columns, which knows the places of
its rows and not what they are called.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.editing.workspace import Document, Workspace
from assistant.program.geometry import Pose
from assistant.program.motion import Path
from assistant.program.program import walk
from assistant.program.statements import Follow
from assistant.studio.stages import Stage
from assistant.studio.studio import Studio

NUMBERED_NAME: Final = re.compile(r"(.*?)([0-9]{1,9})", re.DOTALL)
SAME_POSE: Final = 1e-6
"""Of mm, and of parts of a quaternion."""


class NamedRows:
    """Names of the rows of the paths of a stage."""

    def __init__(self, studio: Studio, stage: Stage) -> None:
        self._studio, self._stage = studio, stage

    def of(self, follow: Follow) -> list[tuple[str, Pose]]:
        """Name and pose of each row as its text declares them; none where that is not sure."""
        numbers: dict[str, dict[int, str]] = {}
        for name in self._names_at(follow):
            match = NUMBERED_NAME.fullmatch(name)
            if match is not None and name in self._declared:
                numbers.setdefault(match[1], {})[int(match[2])] = name
        for of_stem in numbers.values():
            for first in sorted(of_stem):
                names = [of_stem.get(first + row, "") for row in range(len(follow.path))]
                if all(names) and _match_rows([self._declared[n][1] for n in names], follow.path):
                    return [self._declared[name] for name in names]
        return []

    @cached_property
    def _documents(self) -> tuple[Document, ...]:
        workspace = Workspace(self._studio.folder)
        opened = workspace.open(str(self._studio.place(self._stage.path)), self._stage.text)
        return tuple(workspace.task(opened))

    @cached_property
    def _declared(self) -> Mapping[str, tuple[str, Pose]]:
        """Names in lower case → what is declared by them: the name as it is written, the pose."""
        assert self._stage.loaded is not None
        procedures = self._stage.loaded.program.procedures
        follows = [one for q in procedures for one in walk(q.body) if isinstance(one, Follow)]
        names = {name for one in follows for name in self._names_at(one)}
        found: dict[str, tuple[str, Pose]] = {}
        for document in self._documents:
            speaks = document.spoken
            if speaks is None or speaks.editable is None:
                continue
            wanted = frozenset(map(speaks.editable.folded, names))
            text = document.declared(wanted).source(document.path)
            for name, target in speaks.program(text, (), self._stage.robot).targets.items():
                found.setdefault(name.lower(), (name, target.pose))
        return found

    def _names_at(self, follow: Follow) -> Iterator[str]:
        """Names in lower case on the lines of a statement."""
        place = None if follow.span is None else self._stage.shown.places.of(follow.span)
        if place is None or place.path is None:
            return
        path = self._studio.named(FilePath(place.path))
        for document in self._documents:
            if self._studio.named(FilePath(document.path)) == path:
                last = place.line + place.text.rstrip().count("\n")
                for facts in document.facts[place.line - 1 : last]:
                    yield from map(str.lower, facts.names)


def _match_rows(poses: list[Pose], path: Path) -> bool:
    """Whether poses are those of the rows of a path."""
    positions = np.array([pose.position for pose in poses])
    turns = np.array([pose.quaternion for pose in poses])
    alike = np.abs(np.sum(turns * path.quaternions, axis=1)) > 1.0 - SAME_POSE
    return bool(np.abs(positions - path.positions).max() < SAME_POSE and alike.all())
