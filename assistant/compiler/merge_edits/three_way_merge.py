"""Three-way merge: edits of a written program, put into the one that its source gives now.

Three versions are compared, all read from texts: as it was written, as it is in the file, and as
the source gives it now. What differs between the first two is an edit. It is kept if the source
has not changed the same, and if the same is known for certain: by its name if people gave that, by
its place if it has a number. All else is refused, with what to do. Statements are merged contour
by contour, in the order in which the source has these now.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import field, replace
from difflib import SequenceMatcher
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule
from assistant.compiler.merge_edits import rules
from assistant.compiler.merge_edits.contour_origins import (
    ContourOrigins,
    names_of,
    paths_of,
    pose_key,
    same_contours,
    unnumbered_name,
)
from assistant.program import expressions as e
from assistant.program.geometry import JointTarget, Target, Tool
from assistant.program.motion import Path
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import rewrite
from assistant.program.statements import Call, Statement


@dataclass(frozen=True, slots=True)
class MergeChoices:
    """Decisions about edits. overwrite: no edit is kept. keep, drop: their names.

    keep: the edit stays although the source has changed the same. drop: the edit is dropped.
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
class Merge:
    """One merge of the edits of a file into a new program.

    base: as it was written. edited: as it is in the file. made: as it is now.

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
        """True if an edit is to be dropped. of: the contour or procedure that it is in."""
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
        """True if the name still means the same target, except for its position."""
        if not self.base.is_numbered(name):
            return True
        owner = self.base.contour(name)
        if owner is None or self.made.contour(name) != owner:
            return False
        before = self.base.profiles[owner][1:]
        own = (name.removeprefix(owner), pose_key(self.base.program.targets[name].pose))
        others = [one for one in before if one != own]
        there = set(self.made.profiles[owner][1:])
        # More than half of the other points of the contour are where they were.
        return 2 * sum(one in there for one in others) > len(others)

    def place_of(self, name: str) -> tuple[str | None, str]:
        """Return the new program's name of a target of the old one, or the reason why it is
        unknown.
        """
        was = self.base.program.targets[name]
        made = self.made.program.targets
        if not self.base.is_numbered(name):
            same = name in made and _is_same_place(made[name], was)
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

    def program(self) -> Program:
        """The new program with the edits."""
        self.contours = same_contours(self.base, self.made)
        edited, moved = self._moved_rows()
        changed: dict[str, Any] = {
            table: self._table(table, kind) for table, kind in _TABLE_WORDS.items()
        }
        for part in _SCALAR_FIELDS:
            changed[part] = self._scalar(part)
        changed["comments"] = self._comments()
        made = tuple(_with_paths(one, moved) for one in self.made.program.procedures)
        changed["procedures"] = self._procedures(edited, made)
        return self._without_unused(replace(self.made.program, **changed))

    def _without_unused(self, program: Program) -> Program:
        """Without targets that are points of a path, unless statements of the file name them."""
        named = {name for one in program.statements() for name in names_of(one)}
        targets = {n: t for n, t in program.targets.items() if n not in self.points or n in named}
        return replace(program, targets=targets)

    # -------------------------------------------------------------------------------------- tables

    def _table(self, table: str, kind: str) -> dict[str, Any]:
        base, edited, made = (
            getattr(one.program, table) for one in (self.base, self.edited, self.made)
        )
        result = dict(made)
        for name in dict.fromkeys((*base, *edited)):
            was, now = base.get(name), edited.get(name)
            if was == now:
                continue
            what = f"{kind} `{name}`"
            point = was is None and self._is_point(name, now)
            if not point and self.is_dropped(name, what, self.base.contour(name)):
                continue
            to = self._name_there(name, was, now, made, what)
            if to is None:
                continue
            if point:
                self.points.add(to)
            else:
                self.edits.append(what if to == name else f"{what}, which is `{to}` now")
            if now is None:
                result.pop(to, None)
            else:
                result[to] = _with_values(now, was, made.get(to))
        return result

    def _is_point(self, name: str, now: Any) -> bool:
        """True if a target only in the file is a point of a path that the file has in pieces."""
        owner = self.base.contour(name)
        rows = self.base.paths.get(owner or "", [])
        number = name.rpartition("_")[2]
        if not isinstance(now, Target) or len(rows) != 1 or not number.isdecimal():
            return False
        row = int(number) - 1
        return row < len(rows[0]) and pose_key(rows[0].pose(row)) == pose_key(now.pose)

    def _name_there(
        self, name: str, was: Any, now: Any, made: Mapping[str, Any], what: str
    ) -> str | None:
        """Return the new program's name of an edited entry; None, with a finding, if unknown."""
        if was is None:
            to = self.renamed(name)
            if to not in made or made[to] == now:
                return to
            self.refuse(
                rules.BOTH_MOVED,
                name,
                what=what,
                was=_MISSING_WORD,
                **_changed_words(now, made[to]),
            )
            return None
        told = {"what": what, "was": _value_text(was, now)}
        if not isinstance(was, Target):
            if made.get(name) in (was, now) or (self.is_kept(name) and name in made):
                return name
            there = _value_text(made[name], was) if name in made else "it is gone"
            self.refuse(rules.BOTH_MOVED, name, **told, now=_value_text(now, was), made=there)
            return None
        found, why = self.place_of(name)
        if found is not None:
            return found
        other = made.get(name) if self.resembles(name) else None
        if other is not None and (self.is_kept(name) or (now and _is_same_place(other, now))):
            return name
        if other is not None and not _is_same_place(other, was):
            there = _value_text(other, was)
            self.refuse(rules.BOTH_MOVED, name, **told, now=_value_text(now, was), made=there)
        else:
            self.refuse(rules.NOWHERE, name, **told, now=_value_text(now, was), reason=why)
        return None

    # -------------------------------------------------------------------------------- rows of paths

    def _moved_rows(self) -> tuple[tuple[Procedure, ...], dict[int, Path]]:
        """Points on the way that were only moved.

        The procedures of the file with these as they were written, and by their `id` the paths of
        the new program with them as they are in the file.
        """
        procedures = []
        changed: dict[tuple[str, int], Path] = {}
        for procedure in self.edited.program.procedures:
            old = self.base.program.procedure(procedure.name)
            known = list(paths_of(old)) if old is not None else []
            own = list(paths_of(procedure))
            back: dict[int, Path] = {}
            if [one.name for one in own] == [one.name for one in known]:
                for path, was in zip(own, known, strict=True):
                    if _rows_moved(path, was):
                        back[id(path)] = was
                        self._move_rows(path, was, changed)
            procedures.append(_with_paths(procedure, back))
        # `rewrite` visits the very objects of the new program, so their identity finds them.
        by_id = {id(self.made.paths[name][which]): path for (name, which), path in changed.items()}
        return tuple(procedures), by_id

    def _move_rows(self, path: Path, was: Path, changed: dict[tuple[str, int], Path]) -> None:
        for row in range(len(path)):
            before, after = was.target(row), path.target(row)
            if pose_key(before.pose) == pose_key(after.pose):
                continue
            name = f"{path.name}_{row + 1}"
            what = f"target `{name}`"
            if self.is_dropped(name, what, path.name):
                continue
            key = unnumbered_name(path.name), int(path.kinds[row]), pose_key(before.pose)
            here, there = self.base.rows.get(key, []), self.made.rows.get(key, [])
            same = self.contours.get(path.name)
            there = [one for one in there if same is None or one[0] == same]
            here = [one for one in here if same is None or one[0] == path.name]
            wrong = ""
            if not there:
                wrong = "nothing of the kind is at its old place"
            elif len(here) > 1 or len(there) > 1:
                wrong = "several are at its old place"
            elif same is None and there[0][0] != path.name:
                wrong = f"`{there[0][0]}` has a point at its old place, but is not the same contour"
            if wrong:
                told = {"was": _value_text(before, after), "now": _value_text(after, before)}
                self.refuse(rules.NOWHERE, name, what=what, **told, reason=wrong)
                continue
            to, which, at = there[0]
            new = changed.get((to, which), self.made.paths[to][which])
            changed[to, which] = _with_row(new, at, after)
            called = f"{to}_{at + 1}"
            self.edits.append(what if called == name else f"{what}, which is `{called}` now")

    # ---------------------------------------------------------------------- procedures and the rest

    def _scalar(self, part: str) -> Any:
        was, now, made = (getattr(one.program, part) for one in (self.base, self.edited, self.made))
        if was == now or self.is_dropped(part, f"the {part} of the program"):
            return made
        if made not in (was, now) and not self.is_kept(part):
            told = {
                "was": _value_text(was, now),
                "now": _value_text(now, was),
                "made": _value_text(made, was),
            }
            self.refuse(rules.BOTH_MOVED, part, what=f"the {part} of the program", **told)
            return made
        self.edits.append(f"the {part} of the program")
        return now

    def _comments(self) -> tuple[str, ...]:
        """Comments above the program, those of its data among them, which begin with a name."""
        was, now = self.base.program.comments, self.edited.program.comments
        result = [one for one in self.made.program.comments if one in now or one not in was]
        if gone := [one for one in was if one not in now]:
            self.edits.append(f"{len(gone)} comments that were taken out")
        for comment in (one for one in now if one not in was):
            name, colon, said = comment.partition(": ")
            what = f"the comment `{said if colon else comment}`"
            if not colon or name not in self.base.program.targets:
                result.append(comment)
            elif self.is_dropped(name, what, self.base.contour(name)):
                continue
            elif (to := self.place_of(name)[0]) is not None:
                result.append(f"{to}: {said}")
            else:
                self.refuse(rules.COMMENT, name, comment=said)
                continue
            self.edits.append(what)
        return tuple(result)

    def _procedures(
        self, edited: tuple[Procedure, ...], made: tuple[Procedure, ...]
    ) -> tuple[Procedure, ...]:
        """edited: of the file. made: of the new program."""
        old = {one.name: one for one in self.base.program.procedures}
        now = {one.name: one for one in edited}
        new = {one.name: one for one in made}
        bodies = _BodyMerge(self)
        for name in dict.fromkeys((*old, *now)):
            to = self.procedure_there(name)
            was, here, there = old.get(name), now.get(name), new.get(to)
            if was == here:
                continue
            if was is not None and here is not None and there is not None:
                body = bodies.merged(was, here, there)
                new[to] = replace(there, body=body, **self._head(was, here, there))
                continue
            what = f"procedure `{name}`"
            if self.is_dropped(name, what):
                continue
            reason = ""
            if was is not None and here is not None:
                reason = "it is gone from the source"
            elif was is not None and there is not None and not bodies.are_same(was, there):
                reason = "the source has changed it"
            elif here is not None and there not in (None, here):
                reason = "the source has such a procedure now"
            if reason:
                self.refuse(rules.STATEMENTS, name, reason=reason)
                continue
            self.edits.append(what)
            new.pop(to, None)
            if here is not None:
                new[to] = bodies.renamed(here)
        return tuple(new.values())

    def procedure_there(self, name: str) -> str:
        """Return the new program's name of a procedure: that of a contour has its number."""
        owner = self.base.procedures.get(name)
        same = None if owner is None else self.contours.get(owner)
        there = (one for one, contour in self.made.procedures.items() if contour == same)
        return name if same is None else next(there, name)

    def _head(self, was: Procedure, here: Procedure, there: Procedure) -> dict[str, Any]:
        """Return the edits of a procedure outside its body."""
        changed: dict[str, Any] = {}
        for part in _PROCEDURE_FIELDS:
            one, two, three = (getattr(side, part) for side in (was, here, there))
            what = f"the {part} of procedure `{was.name}`"
            if one == two or self.is_dropped(was.name, what):
                continue
            if three in (one, two):
                self.edits.append(what)
                changed[part] = two
            else:
                self.refuse(rules.STATEMENTS, was.name, reason=f"the source has changed its {part}")
        return changed


def _is_same_place(one: Target, other: Target) -> bool:
    """True if two targets have the same pose, whatever the configuration of the arm."""
    return pose_key(one.pose) == pose_key(other.pose)


def _lower_case(names: Collection[str]) -> frozenset[str]:
    return frozenset(name.lower() for name in names)


_Body = tuple[Statement, ...]
_BodyPartKey = tuple[str, int]
"""A part of a body: its contour, "" for what is before the first, and which part of that."""
_NO_NAMES: Final[Mapping[str, str]] = MappingProxyType({})


class _UnknownTarget(Exception):
    """A statement names a target of which nobody knows what it is in the new program."""


class _BodyMerge:
    """The bodies of the procedures of a merge."""

    def __init__(self, merge: Merge) -> None:
        self._merge = merge

    def are_same(self, was: Procedure, there: Procedure) -> bool:
        """True if the source defines a procedure as before, positions included."""
        base, made = self._merge.base, self._merge.made
        same = replace(was, body=()) == replace(there, name=was.name, body=())
        return same and _statement_keys(was.body, base) == _statement_keys(there.body, made)

    def renamed(self, procedure: Procedure) -> Procedure:
        """A procedure that only the file has, with the names that things have now."""
        try:
            return replace(procedure, body=self._with_names(procedure.body))
        except _UnknownTarget as unknown:
            reason = f"nobody knows what `{unknown}` is in the new program"
            self._merge.refuse(rules.STATEMENTS, procedure.name, reason=reason)
            return procedure

    def merged(self, was: Procedure, here: Procedure, there: Procedure) -> _Body:
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
        # Parts can be compared one by one only if both have the same contours in the same order.
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
            except _UnknownTarget as unknown:
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

    def _three(self, was: _Body, here: _Body, there: _Body) -> _Body | None:
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
            # Changes of the source before this one shift its statements.
            shift = sum((d - c) - (b - a) for a, b, c, d in theirs if b <= first)
            result += there[at : first + shift]
            result += self._with_names(here[begin:end])
            at = stop + shift
        return (*result, *there[at:])

    def _with_names(self, body: _Body) -> _Body:
        """Statements of the file with the names that things have in the new program."""
        merge = self._merge

        def visit(part: Any) -> Any:
            if isinstance(part, Path):
                owner = merge.contours.get(part.name)
                if owner is None and part.name in merge.made.paths:
                    raise _UnknownTarget(part.name)
                return part if owner is None else replace(part, name=owner)
            if isinstance(part, e.Name) and part.name in merge.base.program.targets:
                found, _ = merge.place_of(part.name)
                if found is None and not merge.base.is_numbered(part.name):
                    found = part.name if part.name in merge.made.program.targets else None
                if found is None:
                    raise _UnknownTarget(part.name)
                return part if found == part.name else replace(part, name=found)
            if isinstance(part, e.Name) and part.name in merge.edited.program.targets:
                found = merge.renamed(part.name)
                return part if found == part.name else replace(part, name=found)
            if isinstance(part, Call) and part.procedure in merge.base.procedures:
                if merge.base.procedures[part.procedure] not in merge.contours:
                    raise _UnknownTarget(part.procedure)
                return replace(part, procedure=merge.procedure_there(part.procedure))
            return part

        return rewrite(body, visit)


_BodyChange = tuple[int, int, int, int]
"""Statements first … stop of one body that are begin … end of another."""


def _changes(old: Sequence[str], new: Sequence[str]) -> list[_BodyChange]:
    """In order, one by one where as many are replaced."""
    found: list[_BodyChange] = []
    for step, i1, i2, j1, j2 in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if step != "equal" and i2 - i1 == j2 - j1:
            found += [(i1 + k, i1 + k + 1, j1 + k, j1 + k + 1) for k in range(i2 - i1)]
        elif step != "equal":
            found.append((i1, i2, j1, j2))
    return found


def _changes_touch(one: _BodyChange, other: _BodyChange) -> bool:
    """True if two changes are of the same statements, or insert next to them."""
    # An insertion has no statements: it touches a change that begins or ends there.
    if one[0] == one[1] or other[0] == other[1]:
        return one[0] <= other[1] and other[0] <= one[1]
    return one[0] < other[1] and other[0] < one[1]


def _body_parts(body: _Body, made: ContourOrigins) -> dict[_BodyPartKey, _Body]:
    """A body contour by contour; as a whole where a statement is of several."""
    owners = [made.owners(statement) for statement in body]
    if any(len(one) > 1 for one in owners):
        return {("", 0): body}
    found: dict[_BodyPartKey, list[Statement]] = {("", 0): []}
    key: _BodyPartKey = ("", 0)
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
    body: _Body, known: ContourOrigins, contours: Mapping[str, str] = _NO_NAMES
) -> list[str]:
    """Return a comparable text of each statement; names numbered by position are replaced by
    descriptions.

    known: the program of the names. contours: names of paths in the other program.
    """
    targets = known.program.targets

    def visit(part: Any) -> Any:
        if isinstance(part, Path):
            return e.Name(_path_digest(part, contours.get(part.name, part.name)))
        if isinstance(part, e.Name) and part.name in targets and known.is_numbered(part.name):
            return e.Name(f"{known.role(part.name)} {pose_key(targets[part.name].pose)}")
        if isinstance(part, Call) and part.procedure in known.procedures:
            # Which contour is called, whatever its number.
            profile = repr(known.profiles[known.procedures[part.procedure]][1:])
            return replace(part, procedure=hashlib.sha256(profile.encode()).hexdigest())
        return part

    return [repr(rewrite(statement, visit)) for statement in body]


def _path_digest(path: Path, name: str) -> str:
    # The sums turn -0.0 into 0.0: their bytes differ.
    columns = (path.kinds, path.positions + 0.0, path.quaternions + 0.0, path.configurations)
    data = b"".join(bytes(column.tobytes()) for column in columns) + path.external.tobytes()
    rows = [
        (path.speeds[s], path.blends[b], path.tools[t], path.frames[f])
        for s, b, t, f in zip(path.speed, path.blend, path.tool, path.frame, strict=True)
    ]
    return f"{name} {hashlib.sha256(data + repr(rows).encode()).hexdigest()}"


_SHOWN_DIGITS: Final = 4
_LONGEST_VALUE: Final = 60


def _value_text(value: Any, beside: Any = None) -> str:
    """Return a value as readable text. beside: another value, to distinguish it from."""
    if value is None:
        return "nothing"
    if isinstance(value, Target):
        told = _numbers_text(value.pose.position)
        if isinstance(beside, Target) and beside.pose.position == value.pose.position:
            told += f" {_numbers_text(value.pose.quaternion)}"
        if isinstance(beside, Target) and beside.pose == value.pose:
            return "another branch of the arm"
        return told
    if isinstance(value, JointTarget):
        return _numbers_text(value.joints)
    if isinstance(value, Tool):
        same = isinstance(beside, Tool) and beside.tip.position == value.tip.position
        tip = _numbers_text(value.tip.position)
        return f"{tip} {_numbers_text(value.tip.quaternion)}" if same else tip
    text = str(value)
    return text if len(text) <= _LONGEST_VALUE else f"{text[:_LONGEST_VALUE]}…"


def _numbers_text(values: Any) -> str:
    """Numbers in brackets, without those at the end that are not used."""
    listed = [float(v) for v in values]
    # Unused axes are NaN, the only number that differs from itself.
    while listed and listed[-1] != listed[-1]:
        listed.pop()
    return f"[{', '.join(f'{round(v, _SHOWN_DIGITS):g}' for v in listed)}]"


_TABLE_WORDS: Final = {
    "tools": "tool",
    "frames": "frame",
    "speeds": "speed",
    "blends": "blend",
    "signals": "signal",
    "targets": "target",
    "joint_targets": "joint target",
    "variables": "variable",
}
_SCALAR_FIELDS: Final = ("name", "entry", "robot", "declarations")
_PROCEDURE_FIELDS: Final = ("parameters", "variables", "result", "unit", "local")
_MISSING_WORD: Final = "nothing"


def _with_paths(procedure: Procedure, paths: Mapping[int, Path]) -> Procedure:
    """A procedure with others in the place of its paths. paths: by the `id` of those."""
    return rewrite(procedure, lambda part: paths.get(id(part), part)) if paths else procedure


def _rows_moved(path: Path, was: Path) -> bool:
    """True if only positions of rows, and the configurations there, differ."""
    if len(path) != len(was) or path == was:
        return False
    as_it_was = replace(
        path,
        positions=was.positions,
        quaternions=was.quaternions,
        configurations=was.configurations,
    )
    return as_it_was == was


def _with_row(path: Path, row: int, target: Target) -> Path:
    positions, quaternions = np.array(path.positions), np.array(path.quaternions)
    positions[row], quaternions[row] = target.pose.position, target.pose.quaternion
    return replace(path, positions=positions, quaternions=quaternions)


def _with_values(now: Any, was: Any, made: Any) -> Any:
    """The edited value; of a target the branch and axes that were not edited are the new ones."""
    if not (isinstance(now, Target) and isinstance(was, Target) and isinstance(made, Target)):
        return now
    stays = now.configuration == was.configuration
    axes = made.external if now.external == was.external else now.external
    return Target(now.pose, made.configuration if stays else now.configuration, axes)


def _changed_words(now: Any, made: Any) -> dict[str, str]:
    return {"now": _value_text(now, made), "made": _value_text(made, now)}
