"""Edits of a written program, brought into the one that its source gives now.

Three programs are compared, all read from texts: as it was written, as it is in the file, and as
the source gives it now. What differs between the first two is an edit. It is kept where the source
has not changed the same, and where the same is surely known: by its name if people gave that, by
its place if it has a number. All else is refused, with what to do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from assistant.compiler.keeping import rules
from assistant.compiler.keeping.made import (
    names_of,
    paths_of,
    pose_key,
    same_contours,
    unnumbered_name,
)
from assistant.compiler.keeping.showing import value_text
from assistant.compiler.keeping.sides import MergeVersions, is_same_place
from assistant.compiler.keeping.statements import BodyMerge
from assistant.program.geometry import Target
from assistant.program.motion import Path
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import rewrite

TABLE_WORDS: Final = {
    "tools": "tool",
    "frames": "frame",
    "speeds": "speed",
    "blends": "blend",
    "signals": "signal",
    "targets": "target",
    "joint_targets": "joint target",
    "variables": "variable",
}
SCALAR_FIELDS: Final = ("name", "entry", "robot", "declarations")
PROCEDURE_FIELDS: Final = ("parameters", "variables", "result", "unit", "local")
MISSING_WORD: Final = "nothing"


@dataclass(slots=True)
class Merge(MergeVersions):
    """One merge."""

    def program(self) -> Program:
        """The new program with the edits."""
        self.contours = same_contours(self.base, self.made)
        edited, moved = self._moved_rows()
        changed: dict[str, Any] = {
            table: self._table(table, kind) for table, kind in TABLE_WORDS.items()
        }
        for part in SCALAR_FIELDS:
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
        """Whether a target that only the file has is a point of a path that it has in pieces."""
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
        """What an edited entry is called in the new program; None, and told, if nobody knows."""
        if was is None:
            to = self.renamed(name)
            if to not in made or made[to] == now:
                return to
            self.refuse(
                rules.BOTH_MOVED, name, what=what, was=MISSING_WORD, **_changed_words(now, made[to])
            )
            return None
        told = {"what": what, "was": value_text(was, now)}
        if not isinstance(was, Target):
            if made.get(name) in (was, now) or (self.is_kept(name) and name in made):
                return name
            there = value_text(made[name], was) if name in made else "it is gone"
            self.refuse(rules.BOTH_MOVED, name, **told, now=value_text(now, was), made=there)
            return None
        found, why = self.place_of(name)
        if found is not None:
            return found
        other = made.get(name) if self.resembles(name) else None
        if other is not None and (self.is_kept(name) or (now and is_same_place(other, now))):
            return name
        if other is not None and not is_same_place(other, was):
            there = value_text(other, was)
            self.refuse(rules.BOTH_MOVED, name, **told, now=value_text(now, was), made=there)
        else:
            self.refuse(rules.NOWHERE, name, **told, now=value_text(now, was), reason=why)
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
                told = {"was": value_text(before, after), "now": value_text(after, before)}
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
                "was": value_text(was, now),
                "now": value_text(now, was),
                "made": value_text(made, was),
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
        bodies = BodyMerge(self)
        for name in dict.fromkeys((*old, *now)):
            was, here, there = old.get(name), now.get(name), new.get(name)
            if was == here:
                continue
            if was is not None and here is not None and there is not None:
                body = bodies.merged(was, here, there)
                new[name] = replace(there, body=body, **self._head(was, here, there))
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
            new.pop(name, None)
            if here is not None:
                new[name] = bodies.renamed(here)
        return tuple(new.values())

    def _head(self, was: Procedure, here: Procedure, there: Procedure) -> dict[str, Any]:
        """What was edited of a procedure beside its body."""
        changed: dict[str, Any] = {}
        for part in PROCEDURE_FIELDS:
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


def _with_paths(procedure: Procedure, paths: Mapping[int, Path]) -> Procedure:
    """A procedure with others in the place of its paths. paths: by the `id` of those."""
    return rewrite(procedure, lambda part: paths.get(id(part), part)) if paths else procedure


def _rows_moved(path: Path, was: Path) -> bool:
    """Whether nothing but places of rows, and the branches of the arm there, differ."""
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
    return {"now": value_text(now, made), "made": value_text(made, now)}
