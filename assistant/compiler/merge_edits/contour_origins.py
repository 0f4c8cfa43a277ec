"""Origins of contours and locations: which part of a program came from which place of its source.

Contours are numbered in the order in which they are worked, which a new drawing may change. So
what has a number is known by its place: the poses that it was compiled with. What people have
named is known by its name.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from functools import cached_property
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program.geometry import Pose
from assistant.program.motion import Path
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import rewrite
from assistant.program.statements import Statement

_CONTOUR_PART_NAME: Final = re.compile(r"(.+_[0-9]+)_[A-Za-z][A-Za-z_]*")
"""A target of a contour: the name of that, and what it is of it, as `glue_1` and `start`."""
_NUMBERED_NAME: Final = re.compile(r"(.+)_[0-9]+_pass_[0-9]+|(.+)_[0-9]+")
_FIRST_ROUND: Final = "_pass_1"
"""End of the name of the first path of a contour that is followed several times."""

PoseKey = tuple[float, ...]
PlaceProfile = tuple[Any, ...]
RowKey = tuple[str, int, int]
"""A row of a path: the name of that, which one of them, and which row of it."""


def pose_key(pose: Pose) -> PoseKey:
    """A pose as numbers that are equal where it is the same: mm and a quaternion."""
    return tuple(round(v, 9) + 0.0 for v in (*pose.position, *pose.quaternion))


def unnumbered_name(name: str) -> str:
    """Return a name without its trailing number, which contours of one layer have in common."""
    found = _NUMBERED_NAME.fullmatch(name)
    return name if found is None else found[1] or found[2]


class ContourOrigins:
    """A program with what its names stand for."""

    def __init__(self, program: Program) -> None:
        self.program = program

    @cached_property
    def paths(self) -> dict[str, list[Path]]:
        """Its paths by their names."""
        found: dict[str, list[Path]] = {}
        for procedure in self.program.procedures:
            for path in paths_of(procedure):
                found.setdefault(path.name, []).append(path)
        return found

    @cached_property
    def contours(self) -> frozenset[str]:
        """Names of what has several places: of paths, and those that their parts begin with."""
        parts = (_CONTOUR_PART_NAME.fullmatch(name) for name in self.program.targets)
        return frozenset({*self.paths, *(found[1] for found in parts if found)})

    def contour(self, name: str) -> str | None:
        """The contour that a target or a path is of."""
        while name:
            if name in self.contours:
                return name
            name = name.rpartition("_")[0]
        return None

    @cached_property
    def profiles(self) -> dict[str, PlaceProfile]:
        """Profile of positions of each contour, which distinguishes it from all others."""
        parts: dict[str, list[Any]] = {name: [unnumbered_name(name)] for name in self.contours}
        for name, target in sorted(self.program.targets.items()):
            if (owner := self.contour(name)) is not None:
                parts[owner].append((name.removeprefix(owner), pose_key(target.pose)))
        for name, paths in self.paths.items():
            parts[name] += [(bytes(one.kinds), *_row_poses(one)) for one in paths]
        return {name: tuple(found) for name, found in parts.items()}

    @cached_property
    def procedures(self) -> dict[str, str]:
        """The procedures of single contours, each with the first path of its contour."""
        found = {}
        for procedure in self.program.procedures:
            for name in (procedure.name, procedure.name + _FIRST_ROUND):
                if name in self.contours:
                    found[procedure.name] = name
        return found

    @cached_property
    def counts(self) -> Counter[PlaceProfile]:
        """Return the number of contours of each profile."""
        return Counter(self.profiles.values())

    @cached_property
    def places(self) -> dict[tuple[str, PoseKey], list[str]]:
        """Names of targets by what they are and where."""
        found: dict[tuple[str, PoseKey], list[str]] = {}
        for name, target in self.program.targets.items():
            found.setdefault((self.role(name), pose_key(target.pose)), []).append(name)
        return found

    @cached_property
    def rows(self) -> dict[tuple[str, int, PoseKey], list[RowKey]]:
        """Rows of paths by the layer of the path, how they are reached, and where they are."""
        found: dict[tuple[str, int, PoseKey], list[RowKey]] = {}
        for name, paths in self.paths.items():
            for which, path in enumerate(paths):
                for row, at in enumerate(_row_poses(path)):
                    key = unnumbered_name(name), int(path.kinds[row]), at
                    found.setdefault(key, []).append((name, which, row))
        return found

    def role(self, name: str) -> str:
        """Return the role of a target, whatever its number; its name if it has no number."""
        owner = self.contour(name)
        return (
            unnumbered_name(name)
            if owner is None
            else f"{unnumbered_name(owner)} {name.removeprefix(owner)}"
        )

    def is_numbered(self, name: str) -> bool:
        """True if the name of a target follows from its order, and was not given by people."""
        return self.contour(name) is not None or _NUMBERED_NAME.fullmatch(name) is not None

    def owners(self, statement: Statement) -> set[str]:
        """The contours that a statement is of."""
        known = {*self.program.targets, *self.paths}
        found = (self.contour(name) for name in names_of(statement) if name in known)
        return {owner for owner in found if owner is not None}


def same_contours(old: ContourOrigins, new: ContourOrigins) -> dict[str, str]:
    """Contours of a program by what they are called in another one: those that are whole there."""
    there = {profile: name for name, profile in new.profiles.items()}
    same = {
        name: there[profile]
        for name, profile in old.profiles.items()
        if old.counts[profile] == new.counts[profile] == 1
    }
    # A contour whose name begins otherwise now: its place alone tells what it is.
    placed, others = (
        _by_place(one, known) for one, known in ((old, set(same)), (new, set(same.values())))
    )
    return same | {
        names[0]: others[place][0]
        for place, names in placed.items()
        if len(names) == len(others.get(place, ())) == 1
    }


def _by_place(origins: ContourOrigins, known: set[str]) -> dict[PlaceProfile, list[str]]:
    """Contours but for known ones, by their profiles without the name."""
    found: dict[PlaceProfile, list[str]] = {}
    for name, profile in origins.profiles.items():
        if name not in known:
            found.setdefault(profile[1:], []).append(name)
    return found


def names_of(statement: Statement) -> Iterator[str]:
    """Names that a statement says, with those of paths, and of what it holds."""
    found: list[str] = []

    def visit(part: Any) -> Any:
        if isinstance(part, e.Name | Path):
            found.append(part.name)
        return part

    rewrite(statement, visit)
    yield from found


def paths_of(procedure: Procedure) -> Iterator[Path]:
    """The paths of a procedure, in order of the text."""
    found: list[Path] = []

    def visit(part: Any) -> Any:
        if isinstance(part, Path):
            found.append(part)
        return part

    rewrite(procedure.body, visit)
    yield from found


def _row_poses(path: Path) -> Iterator[PoseKey]:
    return (pose_key(path.pose(row)) for row in range(len(path)))
