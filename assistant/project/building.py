"""Building: every program of a project, for each target that wants it, into `build/<target>/`."""

from __future__ import annotations

import contextlib
import enum
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.file_access import read_file
from assistant.base.file_sets import file_in_folder, write_all
from assistant.compiler.merge_edits import WRITTEN, Keeper, Kept, MergeChoices
from assistant.findings.formats import finding_record
from assistant.findings.severities import apply_severities
from assistant.program.settings_tables import listed, nearest, shown
from assistant.project import kept, rules
from assistant.project.inputs import digest_of
from assistant.project.layout import BUILD_FOLDER, Place, Project, Recipe
from assistant.project.making import BuildOrder, MadeProgram, make_all, order_of

Progress = Callable[[int], contextlib.AbstractContextManager[None]]
"""What is around the making of so many programs."""


class State(enum.StrEnum):
    """What a build did with a program."""

    BUILT = "built"
    UNCHANGED = "unchanged"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Built:
    """A program of a target. files: that there are of it now, none if it failed.

    diffs: of files with what was edited in them, from what was compiled, by their paths.
    """

    target: str
    program: str
    state: State
    files: tuple[FilePath, ...] = ()
    proof: tuple[str, ...] = ()
    diffs: Mapping[FilePath, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Build:
    """What a build did. status: 0, 1 if something is wrong, 2 if it cannot be read or written."""

    programs: tuple[Built, ...]
    findings: tuple[Diagnostic, ...]
    status: int

    @property
    def ok(self) -> bool:
        return all(one.state is not State.FAILED for one in self.programs)


def build_record(done: Build, named: Callable[[FilePath], str]) -> dict[str, Any]:
    """Of a build; keys are added, never renamed. named: a file as whoever asks calls it."""
    return {
        "ok": done.ok,
        "programs": [
            {
                "target": one.target,
                "program": one.program,
                "state": str(one.state),
                "files": [named(file) for file in one.files],
                "proof": list(one.proof),
                "edits": {named(file): diff for file, diff in one.diffs.items()},
            }
            for one in done.programs
        ],
        "findings": [finding_record(finding) for finding in done.findings],
    }


def build(
    project: Project,
    names: Sequence[str] = (),
    *,
    jobs: int | None = None,
    anew: bool = False,
    working: Progress | None = None,
    wishes: MergeChoices | None = None,
) -> Build:
    """Builds what has changed; what fails keeps nothing else from being built.

    names: of programs and targets, all without one. jobs: processes at a time. anew: also what
    has not changed. working: around the making of so many. wishes: what becomes of edits of built
    files. Raises Refused for an unknown name.
    """
    return _BuildRun(project, names, wishes or MergeChoices()).done(
        jobs, anew, working or (lambda _: contextlib.nullcontext())
    )


def chosen_orders(project: Project, names: Sequence[str]) -> list[tuple[Place, Recipe]]:
    """What targets want, of these names of programs and targets; all without one."""
    pairs = [(place, recipe) for place in project.places for recipe in place.recipes]
    known = {name for place, recipe in pairs for name in (place.name, recipe.name)}
    unwanted = set(project.programs) - known
    found: list[Diagnostic] = []
    for name in names:
        if name not in known:
            near = nearest(name, sorted(known))
            cure = f"write `{near}`" if near else f"there are: {listed(sorted(known))}"
            if name in unwanted:
                cure = "write it into `programs` of a target"
            kind = "program of a target, or target," if name in unwanted else "program or target"
            found.append(rules.UNKNOWN(place=name, kind=kind, name=shown(name), cure=cure))
    if found:
        raise Refused(*found, exit_status=2)
    return [(p, r) for p, r in pairs if not names or p.name in names or r.name in names]


class _BuildRun:
    """One build. entries: of what is built, those of other targets among them."""

    def __init__(self, project: Project, names: Sequence[str], wishes: MergeChoices) -> None:
        self.project = project
        self.wishes = wishes
        self.edits: set[str] = set()
        self.orders = {
            (place.name, recipe.name): order_of(project.folder, place, recipe)
            for place, recipe in chosen_orders(project, names)
        }
        self.entries = kept.read_build(project)
        self.findings: list[Diagnostic] = []
        self.status = 0

    def done(
        self,
        jobs: int | None,
        anew: bool,
        working: Progress,
    ) -> Build:
        stale = {
            key: order
            for key, order in self.orders.items()
            if anew or self._why_stale(key, order) is not None
        }
        with working(len(set(stale.values()))):
            made = make_all(list(stale.values()), jobs)
        told: set[Diagnostic] = set()
        for order in dict.fromkeys(stale.values()):
            self.findings += [f for f in made[order].findings if f not in told]
            told.update(made[order].findings)
            self.status = max(self.status, 2 if made[order].unreadable else 0)
        self._forget()
        answers = [
            self._answer(*key, made[stale[key]] if key in stale else None) for key in self.orders
        ]
        kept.write_build(self.project, self.entries)
        unknown = Keeper("", wishes=self.wishes, known=self.edits).unknown_names()
        self.findings += unknown
        self.status = 2 if unknown else self.status
        if any(one.state is State.FAILED for one in answers):
            self.status = max(self.status, 1)
        return Build(tuple(answers), tuple(self.findings), self.status)

    def _why_stale(self, key: tuple[str, str], order: BuildOrder) -> str | None:
        entry = self.entries.get(kept.entry_key(*key))
        return kept.why_stale(self.project, key[0], order, entry)

    def _answer(self, target: str, program: str, made: MadeProgram | None) -> Built:
        """Writes a program; None is one that has not changed."""
        folder = self.project.folder / BUILD_FOLDER / target
        name = kept.entry_key(target, program)
        if made is None:
            files = tuple(folder / file for file in sorted(self.entries[name].files))
            return Built(target, program, State.UNCHANGED, files)
        before = self.entries.get(name)
        old = before.files if before is not None else {}
        wanted = kept.options_digest(self.project, self.orders[target, program])
        # Kept with what is there of it, to be taken away when it is built again.
        self.entries[name] = kept.BuildEntry(wanted, {}, old)
        edited = self._with_edits(target, self.orders[target, program], made)
        names = sorted(edited.files, key=lambda path: path.name)
        new = {path.name: digest_of(edited.files[path]) for path in names}
        others = self._others(target, program)
        clashing = name_clashes(target, {**others, program: new})
        self.findings += [one for one in clashing if one not in self.findings]
        if not new or clashing:
            return Built(target, program, State.FAILED)
        try:
            write_all(edited.all)
        except Refused as refused:
            self.findings += refused.findings
            self.status = 2
            return Built(target, program, State.FAILED)
        stay = {file.lower() for files in (new, *others.values()) for file in files}
        _remove_built(folder, {file: old[file] for file in old if file.lower() not in stay})
        self.entries[name] = kept.BuildEntry(wanted, made.inputs, new, made.origins)
        return Built(target, program, State.BUILT, tuple(names), made.proof, edited.diffs)

    def _with_edits(self, target: str, order: BuildOrder, made: MadeProgram) -> Kept:
        """What was made, with what was edited in the files that are there; none if that fails."""
        files = {
            file_in_folder(n, self.project.folder / BUILD_FOLDER / target): d
            for n, d in made.files.items()
        }
        cell = None if order.recipe.cell is None else str(order.recipe.cell)
        keeper = Keeper(made.language, order.arm, cell, self.wishes, self.edits)
        done = keeper.kept(files, self.project.kept / WRITTEN.name / target)
        found = [
            one for one in apply_severities(list(done.findings)).left if one not in self.findings
        ]
        self.findings += found
        return replace(done, files=done.files if done.ok else {}, findings=tuple(found))

    def _others(self, target: str, program: str) -> dict[str, Mapping[str, str]]:
        """Files of the other programs of a target with their digests."""
        place = next(one for one in self.project.places if one.name == target)
        entries = {r.name: self.entries.get(kept.entry_key(target, r.name)) for r in place.recipes}
        return {
            name: entry.files
            for name, entry in entries.items()
            if name != program and entry is not None
        }

    def _forget(self) -> None:
        """Takes away what was built of programs that no target wants any more."""
        wanted = {
            kept.entry_key(place.name, recipe.name): place.name
            for place in self.project.places
            for recipe in place.recipes
        }
        for name in set(self.entries) - set(wanted):
            target = name.partition("/")[0]
            still = {
                file.lower()
                for key, one in self.entries.items()
                if key in wanted and wanted[key] == target
                for file in one.files
            }
            there = self.entries.pop(name).files
            gone = {file: there[file] for file in there if file.lower() not in still}
            _remove_built(self.project.folder / BUILD_FOLDER / target, gone)


def name_clashes(target: str, files: Mapping[str, Mapping[str, str]]) -> list[Diagnostic]:
    """Programs with files of one name on the controller, unless they are the same.

    files: digests by name, of each program.
    """
    seen: dict[str, tuple[str, str]] = {}
    found: list[Diagnostic] = []
    for program, names in files.items():
        for name, digest in names.items():
            first, other = seen.setdefault(name.lower(), (program, digest))
            if other != digest:
                place = kept.entry_key(target, program)
                found.append(
                    rules.SAME_FILE(
                        place=place, first=first, second=program, file=name, target=target
                    )
                )
    return found


def _remove_built(folder: FilePath, files: Mapping[str, str]) -> None:
    """Files of an earlier build by their digests; not if somebody has put others there since."""
    for name, digest in files.items():
        with contextlib.suppress(OSError):
            if digest_of(read_file(folder / name)) == digest:
                (folder / name).unlink()
