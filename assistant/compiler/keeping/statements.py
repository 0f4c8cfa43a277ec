"""Edited statements: merged contour by contour, in the order in which the source has these now."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from types import MappingProxyType
from typing import Any, Final

from assistant.compiler.keeping import rules
from assistant.compiler.keeping.made import ContourOrigins, pose_key
from assistant.compiler.keeping.sides import MergeVersions
from assistant.program import expressions as e
from assistant.program.motion import Path
from assistant.program.program import Procedure
from assistant.program.rewriting import rewrite
from assistant.program.statements import Statement

Body = tuple[Statement, ...]
BodyPartKey = tuple[str, int]
"""A part of a body: its contour, "" for what is before the first, and which part of that."""
_NO_NAMES: Final[Mapping[str, str]] = MappingProxyType({})


class UnknownTarget(Exception):
    """A statement names a target of which nobody knows what it is in the new program."""


class BodyMerge:
    """The bodies of the procedures of a merge."""

    def __init__(self, merge: MergeVersions) -> None:
        self._merge = merge

    def are_same(self, was: Procedure, there: Procedure) -> bool:
        """Whether the source says the same of a procedure as before, places and all."""
        base, made = self._merge.base, self._merge.made
        same = replace(was, body=()) == replace(there, body=())
        return same and _statement_keys(was.body, base) == _statement_keys(there.body, made)

    def renamed(self, procedure: Procedure) -> Procedure:
        """A procedure that only the file has, with the names that things have now."""
        try:
            return replace(procedure, body=self._with_names(procedure.body))
        except UnknownTarget as unknown:
            reason = f"nobody knows what `{unknown}` is in the new program"
            self._merge.refuse(rules.STATEMENTS, procedure.name, reason=reason)
            return procedure

    def merged(self, was: Procedure, here: Procedure, there: Procedure) -> Body:
        """The body that the source gives now with the edits of the file."""
        base, made = self._merge.base, self._merge.made
        if here.body == there.body or _statement_keys(was.body, base) == _statement_keys(
            here.body, base
        ):
            return there.body
        old, edited, new = (
            _body_parts(body, one)
            for body, one in ((was.body, base), (here.body, base), (there.body, made))
        )
        name = there.name
        if list(old) != list(edited):
            what = f"statements of `{name}`"
            if self._merge.is_dropped(name, what):
                return there.body
            if self.are_same(was, there):
                self._merge.edits.append(what)
                return here.body
            reason = "the source has changed them: contours were moved about or taken out by hand"
            self._merge.refuse(rules.STATEMENTS, name, reason=reason)
            return there.body
        for key, part in edited.items():
            before = old[key]
            if _statement_keys(before, base) == _statement_keys(part, base):
                continue
            owner, number = key
            called = owner or name
            what = f"statements of `{called}`"
            if self._merge.is_dropped(called, what, name):
                continue
            to = (self._merge.contours.get(owner, "") if owner else "", number)
            if to not in new or (owner and not to[0]):
                reason = "nothing of the new program is surely the same contour"
                self._merge.refuse(rules.STATEMENTS, called, reason=reason)
                continue
            try:
                both = self._three(before, part, new[to])
            except UnknownTarget as unknown:
                reason = f"nobody knows what `{unknown}` is in the new program"
                self._merge.refuse(rules.STATEMENTS, called, reason=reason)
                continue
            if both is None:
                reason = "the source has changed the same ones"
                self._merge.refuse(rules.STATEMENTS, called, reason=reason)
                continue
            self._merge.edits.append(what)
            new[to] = both
        return tuple(statement for part in new.values() for statement in part)

    def _three(self, was: Body, here: Body, there: Body) -> Body | None:
        """A part with the edits of both sides, None where they are of the same statements."""
        base, made = self._merge.base, self._merge.made
        old = _statement_keys(was, base, self._merge.contours)
        mine = _statement_keys(here, base, self._merge.contours)
        new = _statement_keys(there, made)
        ours, theirs = _changes(old, mine), _changes(old, new)
        if any(_changes_touch(one, other) for one in ours for other in theirs):
            return None
        result: list[Statement] = []
        at = shift = 0
        for first, stop, begin, end in ours:
            shift = sum((d - c) - (b - a) for a, b, c, d in theirs if b <= first)
            result += there[at : first + shift]
            result += self._with_names(here[begin:end])
            at = stop + shift
        return (*result, *there[at:])

    def _with_names(self, body: Body) -> Body:
        """Statements of the file with the names that things have in the new program."""
        merge = self._merge

        def visit(part: Any) -> Any:
            if isinstance(part, Path):
                owner = merge.contours.get(part.name)
                if owner is None and part.name in merge.made.paths:
                    raise UnknownTarget(part.name)
                return part if owner is None else replace(part, name=owner)
            if isinstance(part, e.Name) and part.name in merge.base.program.targets:
                found, _ = merge.place_of(part.name)
                if found is None and not merge.base.is_numbered(part.name):
                    found = part.name if part.name in merge.made.program.targets else None
                if found is None:
                    raise UnknownTarget(part.name)
                return part if found == part.name else replace(part, name=found)
            if isinstance(part, e.Name) and part.name in merge.edited.program.targets:
                found = merge.renamed(part.name)
                return part if found == part.name else replace(part, name=found)
            return part

        return rewrite(body, visit)


BodyChange = tuple[int, int, int, int]
"""Statements first … stop of one body that are begin … end of another."""


def _changes(old: Sequence[str], new: Sequence[str]) -> list[BodyChange]:
    """In order, one by one where as many are replaced."""
    found: list[BodyChange] = []
    for step, i1, i2, j1, j2 in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if step != "equal" and i2 - i1 == j2 - j1:
            found += [(i1 + k, i1 + k + 1, j1 + k, j1 + k + 1) for k in range(i2 - i1)]
        elif step != "equal":
            found.append((i1, i2, j1, j2))
    return found


def _changes_touch(one: BodyChange, other: BodyChange) -> bool:
    """Whether two changes are of the same statements, or put some in beside such."""
    if one[0] == one[1] or other[0] == other[1]:
        return one[0] <= other[1] and other[0] <= one[1]
    return one[0] < other[1] and other[0] < one[1]


def _body_parts(body: Body, made: ContourOrigins) -> dict[BodyPartKey, Body]:
    """A body contour by contour; as a whole where a statement is of several."""
    owners = [made.owners(statement) for statement in body]
    if any(len(one) > 1 for one in owners):
        return {("", 0): body}
    found: dict[BodyPartKey, list[Statement]] = {("", 0): []}
    key: BodyPartKey = ("", 0)
    seen: dict[str, int] = {}
    for statement, some in zip(body, owners, strict=True):
        owner = next(iter(some), key[0])
        if owner != key[0]:
            key = owner, seen.get(owner, 0)
            seen[owner] = key[1] + 1
            found[key] = []
        found[key].append(statement)
    return {key: tuple(part) for key, part in found.items()}


def _statement_keys(
    body: Body, known: ContourOrigins, contours: Mapping[str, str] = _NO_NAMES
) -> list[str]:
    """What each statement says; what has a number by its place, in words that can be compared.

    known: whose names they are. contours: what paths are called in the other program.
    """
    targets = known.program.targets

    def visit(part: Any) -> Any:
        if isinstance(part, Path):
            return e.Name(_path_digest(part, contours.get(part.name, part.name)))
        if isinstance(part, e.Name) and part.name in targets and known.is_numbered(part.name):
            return e.Name(f"{known.role(part.name)} {pose_key(targets[part.name].pose)}")
        return part

    return [repr(rewrite(statement, visit)) for statement in body]


def _path_digest(path: Path, name: str) -> str:
    columns = (path.kinds, path.positions + 0.0, path.quaternions + 0.0, path.configurations)
    data = b"".join(bytes(column.tobytes()) for column in columns) + path.external.tobytes()
    rows = [
        (path.speeds[s], path.blends[b], path.tools[t], path.frames[f])
        for s, b, t, f in zip(path.speed, path.blend, path.tool, path.frame, strict=True)
    ]
    return f"{name} {hashlib.sha256(data + repr(rows).encode()).hexdigest()}"
