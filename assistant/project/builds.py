"""Build and check a project: every program for each target, and what is built already.

Built files go to `build/<target>/`. `.robot-assistant/build.json` holds digests of the inputs and
outputs of each program, so that the next build knows what has not changed. A check writes nothing
into `build/`: programs are made in a folder that is deleted afterwards, and checked on the robot of
their controller.
"""

from __future__ import annotations

import contextlib
import enum
import json
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, field, replace
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from typing import Any, Final

from assistant import __version__
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.base.file_access import read_file
from assistant.base.file_sets import file_in_folder, scratch_folder, write_all, write_files
from assistant.base.near_names import near_name
from assistant.compiler.checker import check_files
from assistant.compiler.merge_edits import WRITTEN, Keeper, Kept, MergeChoices
from assistant.findings.formats import records_of
from assistant.findings.severities import apply_severities
from assistant.program.settings_tables import listed, shown
from assistant.project import rules
from assistant.project.build_jobs import (
    BuildOrder,
    Digests,
    MadeProgram,
    all_unchanged,
    digest_of,
    make_all,
    order_of,
    shown_path,
)
from assistant.project.project_file import (
    BUILD_FOLDER,
    PROJECT_NAME,
    STATE_FOLDER,
    Place,
    Project,
    Recipe,
)

BUILD_FORMAT: Final = 1
BUILD_FILE: Final = "build.json"


@dataclass(frozen=True, slots=True)
class BuildEntry:
    """A program of a target in the build file. wanted: digest of its options. files: digests of the
    written files, by name.

    inputs: see `inputs`; empty if it could not be built, so that it is tried again. origins: see
    `Made`.
    """

    wanted: str
    inputs: Mapping[str, str | None] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    origins: Mapping[str, str] = field(default_factory=dict)


BuildEntries = dict[str, BuildEntry]
"""By target and program, as `cell1/plate`."""


def entry_key(target: str, program: str) -> str:
    return f"{target}/{program}"


def options_digest(project: Project, order: BuildOrder) -> str:
    """The digest of all that is wanted of a program, and of who makes it."""
    options: dict[str, Any] = {"version": __version__, "settings": project.settings}
    for name, value in {**asdict(order.recipe), "taken": order.taken, "arm": order.arm}.items():
        options[name] = _portable_path(project, value)
    return digest_of(json.dumps(options, sort_keys=True).encode("utf-8", "surrogatepass"))


def _portable_path(project: Project, value: object) -> object:
    """A path from the project's folder: the same in each copy of the project."""
    if isinstance(value, str | FilePath) and FilePath(value).is_absolute():
        path = FilePath(value)
        return (
            path.relative_to(project.folder).as_posix()
            if _is_in_project(project, path)
            else str(path)
        )
    return [_portable_path(project, one) for one in value] if isinstance(value, tuple) else value


def _is_in_project(project: Project, path: FilePath) -> bool:
    return path.is_relative_to(project.folder)


def why_stale(
    project: Project, target: str, order: BuildOrder, entry: BuildEntry | None
) -> str | None:
    """Why what was built of a program is not what a build would make now, None if it is."""
    if entry is None or not entry.inputs:
        return "it was never built" if entry is None else "the last build of it failed"
    if entry.wanted != options_digest(project, order):
        return "its options were changed since"
    if not all_unchanged(project.folder, entry.inputs):
        return "a file that it is made of was changed since"
    folder = project.folder / BUILD_FOLDER / target
    for name, digest in entry.files.items():
        try:
            if digest_of(read_file(folder / name)) != digest:
                return f"`{BUILD_FOLDER}/{target}/{name}` was changed by somebody"
        except OSError:
            return f"`{BUILD_FOLDER}/{target}/{name}` is not there"
    return None


def read_build(project: Project) -> BuildEntries:
    """Those of the last build; none if the file is missing or damaged: all is built again then."""
    try:
        content = json.loads(read_file(project.kept / BUILD_FILE))
        if content["format"] != BUILD_FORMAT:
            return {}
        entries = {_checked_key(key): _entry_of_row(row) for key, row in content["built"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}
    return entries


def _checked_key(told: str) -> str:
    # The name becomes a folder below `build`.
    if PROJECT_NAME.fullmatch(told.partition("/")[0]) is None:
        raise ValueError("a name of a target leads elsewhere")
    return told


def _entry_of_row(row: Mapping[str, Any]) -> BuildEntry:
    inputs: Digests = {str(key): value for key, value in row["inputs"].items()}
    files = {str(name): str(digest) for name, digest in row["files"].items()}
    if any(FilePath(name).name != name or name in ("", ".", "..") for name in files):
        raise ValueError("a name of a file leads elsewhere")
    origins = {str(name): str(file) for name, file in row["origins"].items()}
    return BuildEntry(str(row["wanted"]), inputs, files, origins)


def write_build(project: Project, entries: BuildEntries) -> None:
    """Raises Refused (exit status 2) if that cannot be."""
    rows = {key: asdict(entries[key]) for key in sorted(entries)}
    text = json.dumps({"format": BUILD_FORMAT, "built": rows}, indent=1, sort_keys=True) + "\n"
    write_files({BUILD_FILE: text.encode()}, project.folder / STATE_FOLDER)


Progress = Callable[[int], contextlib.AbstractContextManager[None]]
"""Context manager around the build of the given number of programs."""


class State(enum.StrEnum):
    """Result of a build for a program."""

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
    """Result of a build. status: 0, 1 for errors, 2 if it cannot be read or written."""

    programs: tuple[Built, ...]
    findings: tuple[Diagnostic, ...]
    status: int

    @property
    def ok(self) -> bool:
        return all(one.state is not State.FAILED for one in self.programs)


def build_record(done: Build, named: Callable[[FilePath], str]) -> dict[str, Any]:
    """Return a build as plain data; keys are added, never renamed. named: gives a file's name as
    the caller writes it.
    """
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
        "findings": records_of(done.findings),
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
    """Return the recipes of targets chosen by these names of programs and targets; all without a
    name.
    """
    pairs = [(place, recipe) for place in project.places for recipe in place.recipes]
    known = {name for place, recipe in pairs for name in (place.name, recipe.name)}
    unwanted = set(project.programs) - known
    found: list[Diagnostic] = []
    for name in names:
        if name not in known:
            near = near_name(name, sorted(known))
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
        self.entries = read_build(project)
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
        # Each order once, as targets may share a program.
        for order in dict.fromkeys(stale.values()):
            self.findings += [f for f in made[order].findings if f not in told]
            told.update(made[order].findings)
            self.status = max(self.status, 2 if made[order].unreadable else 0)
        self._forget()
        answers = [
            self._answer(*key, made[stale[key]] if key in stale else None) for key in self.orders
        ]
        write_build(self.project, self.entries)
        unknown = Keeper("", wishes=self.wishes, known=self.edits).unknown_names()
        self.findings += unknown
        self.status = 2 if unknown else self.status
        if any(one.state is State.FAILED for one in answers):
            self.status = max(self.status, 1)
        return Build(tuple(answers), tuple(self.findings), self.status)

    def _why_stale(self, key: tuple[str, str], order: BuildOrder) -> str | None:
        entry = self.entries.get(entry_key(*key))
        return why_stale(self.project, key[0], order, entry)

    def _answer(self, target: str, program: str, made: MadeProgram | None) -> Built:
        """Writes a program; None is one that has not changed."""
        folder = self.project.folder / BUILD_FOLDER / target
        name = entry_key(target, program)
        if made is None:
            files = tuple(folder / file for file in sorted(self.entries[name].files))
            return Built(target, program, State.UNCHANGED, files)
        before = self.entries.get(name)
        old = before.files if before is not None else {}
        wanted = options_digest(self.project, self.orders[target, program])
        # Kept with what is there of it, to be taken away when it is built again.
        self.entries[name] = BuildEntry(wanted, {}, old)
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
        # Files of other programs with the same name stay.
        stay = {file.lower() for files in (new, *others.values()) for file in files}
        _remove_built(folder, {file: old[file] for file in old if file.lower() not in stay})
        self.entries[name] = BuildEntry(wanted, made.inputs, new, made.origins)
        return Built(target, program, State.BUILT, tuple(names), made.proof, edited.diffs)

    def _with_edits(self, target: str, order: BuildOrder, made: MadeProgram) -> Kept:
        """Return a built program with the edits of its existing files; without files if that
        fails.
        """
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
        entries = {r.name: self.entries.get(entry_key(target, r.name)) for r in place.recipes}
        return {
            name: entry.files
            for name, entry in entries.items()
            if name != program and entry is not None
        }

    def _forget(self) -> None:
        """Takes away what was built of programs that no target wants any more."""
        wanted = {
            entry_key(place.name, recipe.name): place.name
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
                place = entry_key(target, program)
                found.append(
                    rules.SAME_FILE(
                        place=place, first=first, second=program, file=name, target=target
                    )
                )
    return found


def _remove_built(folder: FilePath, files: Mapping[str, str]) -> None:
    """Remove files of an earlier build by their digests; changed files stay."""
    for name, digest in files.items():
        with contextlib.suppress(OSError):
            if digest_of(read_file(folder / name)) == digest:
                (folder / name).unlink()


@dataclass(frozen=True, slots=True)
class ProjectCheck:
    """Result of a project check. programs: number of them, of all targets. ignored: by comments in
    programs.

    sources: the files that the programs are made of.
    """

    programs: int
    findings: tuple[Diagnostic, ...]
    ignored: tuple[Diagnostic, ...] = ()
    unreadable: bool = False
    sources: tuple[str, ...] = ()


def check(
    project: Project,
    *,
    jobs: int | None = None,
    working: Progress | None = None,
) -> ProjectCheck:
    """Everything that targets want is made and checked, the programs of a target together.

    Nothing of the project is changed. Raises Refused if no folder at all can be written.
    """
    orders = {
        (place.name, recipe.name): order_of(project.folder, place, recipe)
        for place, recipe in chosen_orders(project, ())
    }
    with (working or _no_progress)(len(set(orders.values()))):
        made = make_all(list(orders.values()), jobs)
        found = [finding for order in made for finding in made[order].findings]
        ignored: list[Diagnostic] = []
        unreadable = any(one.unreadable for one in made.values())
        for place in project.places:
            programs = {r.name: orders[place.name, r.name] for r in place.recipes}
            by_name = {name: made[order] for name, order in programs.items()}
            digests = {
                name: {file: digest_of(data) for file, data in one.files.items()}
                for name, one in by_name.items()
            }
            found += name_clashes(place.name, digests)
            arms: dict[str | None, list[str]] = {}
            for name, order in programs.items():
                arms.setdefault(order.arm, []).append(name)
            for arm, names in arms.items():
                one = _check_on_robot(project, place.name, arm, [by_name[name] for name in names])
                found += one.findings
                ignored += one.ignored
                unreadable |= one.unreadable
    return ProjectCheck(
        len(orders),
        tuple(dict.fromkeys(found)),
        tuple(dict.fromkeys(ignored)),
        unreadable,
        tuple(dict.fromkeys(shown_path(order.recipe.source) for order in orders.values())),
    )


@contextlib.contextmanager
def _target_folder(project: Project) -> Iterator[FilePath]:
    """A folder for the programs of a target, which is gone afterwards.

    It is in the project, whose settings hold for them there. Where the project cannot be written it
    is among the temporary files of the computer, with a copy of the project's file.
    """
    with contextlib.ExitStack() as stack:
        try:
            folder = stack.enter_context(scratch_folder(project.kept))
        except OSError:
            folder = FilePath(stack.enter_context(TemporaryDirectory())).resolve()
            shutil.copyfile(project.file, folder / project.file.name)
        yield folder


def _no_progress(_: int) -> contextlib.AbstractContextManager[None]:
    return contextlib.nullcontext()


def _check_on_robot(
    project: Project, target: str, arm: str | None, made: Sequence[MadeProgram]
) -> ProjectCheck:
    """The files of programs for one robot, as they will be on the controller."""
    files = {name: data for one in made for name, data in one.files.items()}
    if not files:
        return ProjectCheck(0, ())
    origins = {name: origin for one in made for name, origin in one.origins.items()}
    told = [finding for one in made if not one.origins for finding in one.findings]
    try:
        with _target_folder(project) as folder:
            paths = _written_names(folder, files)
            checked = check_files(list(paths), robot=arm)
            settled = apply_severities(checked.findings, checked.texts)
    except OSError as error:
        reason = error.strerror or str(error)
        finding = rules.NOT_KEPT(file=error.filename or project.kept, reason=reason)
        raise Refused(finding, exit_status=2) from None
    places = {
        path: shown_path(
            project.folder / origins.get(name, (BUILD_FOLDER / target / name).as_posix())
        )
        for path, name in paths.items()
    }
    whole = {str(folder): shown_path(project.folder / BUILD_FOLDER / target)}

    def placed(findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
        return tuple(
            replace(one, path=_original_path(one.path, {**whole, **places})) for one in findings
        )

    left = [f for f in settled.left if _is_new_finding(f, paths, origins, told)]
    return ProjectCheck(0, placed(left), placed(settled.ignored), checked.unreadable)


def _is_new_finding(
    finding: Diagnostic,
    paths: Mapping[str, str],
    origins: Mapping[str, str],
    told: Sequence[Diagnostic],
) -> bool:
    """True if the build of a program has not reported the finding.

    Notes about generated texts do not matter to users, who cannot change them. Beside files written
    by others, a finding may be about any of them: only an identical one is already reported.
    """
    if paths.get(finding.path or "") in origins:
        return True
    same = (one for one in told if one.code == finding.code)
    if origins:
        same = (one for one in same if one.place == finding.place)
    return finding.severity is not Severity.INFO and not any(same)


def _original_path(path: str | None, places: Mapping[str, str]) -> str | None:
    return places.get(path or "", path)


def _written_names(folder: FilePath, files: Mapping[str, bytes]) -> dict[str, str]:
    """Path of each file that is written into a folder → its name."""
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return {str(folder / name): name for name in files}
