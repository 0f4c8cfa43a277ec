"""The three programs of a merge, what is wished of it, and what things are called in each."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from assistant.base.diagnostics import Diagnostic, Rule
from assistant.compiler.keeping.made import ContourOrigins, pose_key
from assistant.program.geometry import Target


@dataclass(frozen=True, slots=True)
class MergeChoices:
    """What is decided about edits. overwrite: none is kept. keep, drop: their names.

    keep: the edit stays where the source has changed the same. drop: it does not stay.
    """

    overwrite: bool = False
    keep: frozenset[str] = frozenset()
    drop: frozenset[str] = frozenset()

    @staticmethod
    def of(
        overwrite: bool = False, keep: Collection[str] = (), drop: Collection[str] = ()
    ) -> MergeChoices:
        return MergeChoices(overwrite, _lower_case(keep), _lower_case(drop))


@dataclass(slots=True)
class MergeVersions:
    """base: as it was written. edited: as it is in the file. made: as it is now.

    edits: what is kept, in words. dropped: what is not, as was wished. conflicts: what cannot be.
    names: of all edits, in lower case.
    """

    file: str
    base: ContourOrigins
    edited: ContourOrigins
    made: ContourOrigins
    wishes: MergeChoices
    edits: list[str] = field(default_factory=list)
    dropped: list[str] = field(default_factory=list)
    conflicts: list[Diagnostic] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    contours: Mapping[str, str] = field(default_factory=dict)
    points: set[str] = field(default_factory=set)

    def is_dropped(self, name: str, what: str, of: str | None = None) -> bool:
        """Whether an edit is not to stay. of: the contour or procedure that it is in."""
        called = {name.lower(), *([of.lower()] if of else [])}
        self.names |= called
        if self.wishes.drop.isdisjoint(called):
            return False
        self.dropped.append(what)
        return True

    def is_kept(self, name: str) -> bool:
        return name.lower() in self.wishes.keep

    def refuse(self, rule: Rule, name: str, **told: Any) -> None:
        finding = rule(path=self.file, file=self.file, name=name, **told)
        if finding not in self.conflicts:
            self.conflicts.append(finding)

    def resembles(self, name: str) -> bool:
        """Whether what has this name now is what had it before, but for its place."""
        if not self.base.is_numbered(name):
            return True
        owner = self.base.contour(name)
        if owner is None or self.made.contour(name) != owner:
            return False
        before = self.base.profiles[owner][1:]
        own = (name.removeprefix(owner), pose_key(self.base.program.targets[name].pose))
        others = [one for one in before if one != own]
        there = set(self.made.profiles[owner][1:])
        return 2 * sum(one in there for one in others) > len(others)

    def place_of(self, name: str) -> tuple[str | None, str]:
        """What a target of the old program is called in the new one, or why nobody can tell."""
        was = self.base.program.targets[name]
        made = self.made.program.targets
        if not self.base.is_numbered(name):
            same = name in made and is_same_place(made[name], was)
            return (name, "") if same else (None, f"there is no `{name}` any more")
        owner = self.base.contour(name)
        if owner is not None and owner in self.contours:
            return f"{self.contours[owner]}{name.removeprefix(owner)}", ""
        key = self.base.role(name), pose_key(was.pose)
        twins, there = self.base.places[key], self.made.places.get(key, [])
        if not there:
            return None, "nothing of the kind is at its old place"
        if len(twins) > 1 or len(there) > 1:
            return None, "several are at its old place"
        if there[0] != name and owner is not None:
            return None, f"`{there[0]}` is at its old place, but not the same contour"
        return there[0], ""

    def renamed(self, name: str) -> str:
        """A name that only the file has, after the contour that it is of."""
        owner = self.base.contour(name)
        if owner is None or owner not in self.contours:
            return name
        return f"{self.contours[owner]}{name.removeprefix(owner)}"


def is_same_place(one: Target, other: Target) -> bool:
    """Whether two targets are at one place, whichever branch the arm takes there."""
    return pose_key(one.pose) == pose_key(other.pose)


def _lower_case(names: Collection[str]) -> frozenset[str]:
    return frozenset(name.lower() for name in names)
