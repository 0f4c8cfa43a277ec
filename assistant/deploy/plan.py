"""Plan of a deployment: local programs compared with those on the controller, without a change.

The files to deploy are gathered and checked, each gets its name on the controller, and the
effect of the deployment on each program is decided: its present content, its owner, its
differences.
"""

from __future__ import annotations

import enum
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.source_text import folders_of, read_bytes
from assistant.base.text_merge import difference, merged, says_the_same
from assistant.controllers import Address, Programs
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.history import Entry, last_record, what_was_left
from assistant.deploy.preconditions import check_clashes
from assistant.deploy.record import NOTHING_INSTALLED, Held, Record, check_meant, of_another
from assistant.deploy.site import Site, difference_since, module_difference, of_deployments
from assistant.languages import Language, Tree


class Change(enum.StrEnum):
    """Change of one program on the controller by a deployment."""

    NEW = "create"
    CHANGED = "replace"
    SAME = "unchanged"
    CONFLICT = "conflict"
    """It is not what a deployment left there: nothing is done before somebody decides."""


@dataclass(frozen=True, slots=True)
class PlannedFile:
    """A program to install.

    path: the local file. name: on the controller. data: bytes to send. before: present content on
    the controller. after: planned content. reason: why it is a conflict, or was one. left: content
    after the last deployment, None if unknown; searched only for a conflict. Unified differences,
    "" without one: diff from its file to the sent data, taught from the loaded module to the one in
    memory now, since from the last deployment to the present content. findings: of the language's
    parser, without errors.
    """

    path: str
    name: str
    change: Change
    data: bytes = field(repr=False)
    before: Held
    after: Held
    diff: str = field(repr=False, default="")
    taught: str = field(repr=False, default="")
    findings: tuple[Diagnostic, ...] = ()
    reason: str = ""
    left: Held | None = None
    since: str = field(repr=False, default="")

    @property
    def entry(self) -> Entry:
        return Entry(self.name, self.before, self.after)


@dataclass(frozen=True, slots=True)
class Plan:
    """Effect of a deployment; nothing has been changed yet.

    identity: of the controller, None where the session cannot read it. record: of the last
    deployment, None if unknown. foreign: programs of other origin; never touched. left: programs of
    an earlier deployment that are not planned any more; not touched either.
    """

    address: Address
    files: tuple[PlannedFile, ...]
    site: Site = field(repr=False, compare=False)
    identity: Identity | None = None
    record: Record | None = None
    foreign: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    notes: tuple[Diagnostic, ...] = ()

    @property
    def changes(self) -> tuple[PlannedFile, ...]:
        """The files that would be written."""
        return tuple(f for f in self.files if f.change in (Change.NEW, Change.CHANGED))

    @property
    def conflicts(self) -> tuple[PlannedFile, ...]:
        return tuple(file for file in self.files if file.change is Change.CONFLICT)

    @property
    def unrecorded(self) -> bool:
        """True if programs on the controller are as planned, but not as the last record lists them.

        The user copied them by hand, or merged a change on the controller into the project. For a
        controller without a record it counts only once this computer has deployed to it.
        """
        if self.record is None and self.site.disk is None:
            return False
        known = {} if self.record is None else self.record.programs
        left = {name.lower(): digests for name, digests in known.items()}
        return any(
            file.change is Change.SAME
            and left.get(file.name.lower()) != self.site.digests(file.after)
            for file in self.files
        )

    @property
    def unseen(self) -> tuple[Diagnostic, ...]:
        """A warning for each program that may have been taught something which is not seen."""
        if not self.site.blind:
            return ()
        there = [f for f in self.files if f.change in (Change.CHANGED, Change.CONFLICT)]
        return tuple(rules.UNSEEN(place=file.name, name=file.name) for file in there)

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        return (*self.notes, *(finding for file in self.files for finding in file.findings))


EVERY: Final = "*"
"""In place of the names of programs: all of them."""


class _Classifier:
    """Judges programs by what a controller has of them. notes: whose they were found to be."""

    def __init__(
        self,
        site: Site,
        record: Record | None,
        load: bool,
        replace: Collection[str],
        history: str | FilePath | None,
    ) -> None:
        self.site, self.load, self.history = site, load, history
        self.replace = {name.lower() for name in replace}
        programs = record.programs if record else {}
        self.known = {name.lower(): left for name, left in programs.items()}
        self.record = record
        self.notes: list[Diagnostic] = []

    def at(
        self, path: str, name: str, data: bytes, findings: tuple[Diagnostic, ...]
    ) -> PlannedFile:
        before = self.site.held(name, data)
        loads = self.site.memory is not None and not self.site.is_list(name)
        in_memory = loads and (self.load or before.loaded is not None)
        after = Held(data, data if in_memory else None)
        now, wanted = self.site.forms(before), self.site.forms(after)
        # A program that is gone, or that is as planned already, is no conflict, whoever changed it.
        reason = (
            "" if before == NOTHING_INSTALLED or now == wanted else self._not_ours(name, before)
        )
        left = None
        if reason and self.record is not None:
            left = what_was_left(self.site, self.record, name, self.history)
        change = self._change(name, before, after, reason, left)
        diff = taught = ""
        if change is not Change.SAME:
            labels = (f"{name} (on the controller)", f"{name} (to be sent)")
            diff = difference(now.file, wanted.file, *labels)
        if before.loaded is not None:
            labels = (f"{name} (its file)", f"{name} (in memory)")
            file = before.file if before.file is not None else data
            taught = module_difference(file, before.loaded, self.site.language, labels)
        return PlannedFile(
            path,
            name,
            change,
            data,
            before,
            after,
            diff,
            taught,
            findings,
            reason,
            left,
            difference_since(self.site, name, left, before),
        )

    def _change(
        self, name: str, before: Held, after: Held, reason: str, left: Held | None
    ) -> Change:
        if self.site.same(before, after):
            return Change.SAME
        if before == NOTHING_INSTALLED:
            return Change.NEW
        if not reason:
            return Change.CHANGED
        if left is not None and self._brought_home(left, before, after):
            self.notes.append(rules.BROUGHT_HOME(place=name, name=name, reason=reason))
            return Change.CHANGED
        if self.replace & {EVERY, name.lower()}:
            self.notes.append(rules.REPLACED(place=name, name=name, reason=reason))
            return Change.CHANGED
        self.notes.append(rules.CONFLICT(place=name, name=name, reason=reason))
        return Change.CONFLICT

    def _not_ours(self, name: str, before: Held) -> str:
        """Why a program is not what a deployment left there, "" if it is."""
        left = self.known.get(name.lower())
        if left is None or self.record is None:
            return "it was not put there by a deployment that is known here"
        there = self.site.digests(before)
        since = f"since the deployment `{self.record.name}` of {self.record.who}"
        if there.file != left.file:
            return f"its file was changed {since}"
        if there.loaded and left.task and left.task != self.site.task:
            return f"it was last deployed to `{left.task}`, not to the memory of `{self.site.task}`"
        if there.loaded != left.loaded:
            return f"its module in memory was changed {since}"
        return ""

    def _brought_home(self, left: Held, before: Held, after: Held) -> bool:
        """True if the planned content includes all changes made on the controller since.

        This is the case after the change was merged into the project, by any user, on any computer.
        """
        forms = [self.site.forms(held) for held in (left, before)]
        files = (left.file, before.file, after.file, self.site.controller.stored, "")
        mark = languages.get(self.site.language).comment_mark  # a memory may not keep comments
        loaded = (left.loaded, before.loaded, after.loaded, self.site.in_memory, mark)
        for same, (base, there, sent, form, comment) in (
            (forms[0].file == forms[1].file, files),
            (forms[0].loaded == forms[1].loaded, loaded),
        ):
            # One part may be as it was left: then only the other one has to be brought home.
            if same:
                continue
            if base is None or there is None or sent is None:
                return False
            both = merged(base, sent, there, form, comment)
            if both is None or not says_the_same(both, sent, form, comment):
                return False
        return True


def gathered(paths: Sequence[str | FilePath], controller: Programs) -> list[str]:
    """The files that are meant: of a folder every program that the controller takes, and the
    modules that a list of them names, from beside it.

    Hidden folders are left aside. Raises Refused and Unreadable.
    """
    spoken = [languages.get(name) for name in controller.languages]
    files: list[str] = []
    for path in map(str, paths):
        if not FilePath(path).is_dir():
            files.append(path)
            continue
        inside = [str(file) for file in _inside(path) if _is_program(file, spoken, controller)]
        if not inside:
            raise Refused(rules.EMPTY_FOLDER(path=path), exit_status=2)
        files += inside
    for path in [file for file in files if file.lower().endswith(controller.lists)]:
        files += _listed_files(path, spoken[0])
    # Two spellings of one file count once; reversed, so that the first spelling stays.
    places = {FilePath(file).absolute(): file for file in reversed(files)}
    return [file for file in dict.fromkeys(files) if places[FilePath(file).absolute()] == file]


def _inside(folder: str) -> Iterator[FilePath]:
    found: list[FilePath] = []
    for inside, inner, names in folders_of(folder):
        inner[:] = [name for name in inner if not name.startswith(".")]
        found += [FilePath(inside, name) for name in names if not name.startswith(".")]
    yield from (file for file in sorted(found) if file.is_file())


def _is_program(file: FilePath, spoken: Sequence[Language[Any]], controller: Programs) -> bool:
    suffix = file.suffix.lower()
    if suffix in controller.lists:
        return True
    if not any(suffix in language.suffixes for language in spoken):
        return False
    return _file_languages(str(file), read_bytes(file, allow_empty=True), spoken) is not None


def _file_languages(
    path: str, data: bytes, spoken: Sequence[Language[Any]]
) -> Language[Any] | None:
    """Which of a controller's languages a file is in, or may be in as it is of an older version."""
    suffix = FilePath(path).suffix.lower()
    taking = [language for language in spoken if suffix in language.suffixes]
    found = next((one for one in taking if one.recognises(data, suffix)), None)
    if found is None and taking and (other := languages.of_file(path, data)) is not None:
        found = next((one for one in taking if other.name in one.older), None)
    return found


def _listed_files(path: str, language: Language[Any]) -> Iterator[str]:
    """The files that a list names; only from its own folder."""
    folder = FilePath(path).parent
    tree = language.parse(language.read(path))
    for name in language.called_files(tree):
        if FilePath(name).name != name or "\\" in name or name in ("", ".", ".."):
            raise Refused(rules.NOT_BESIDE(path=path, name=name))
        named = folder / name
        if not named.is_file():
            raise Refused(rules.NOT_THERE(path=path, name=name))
        yield str(named)


def controller_names(paths: Sequence[str], controller: Programs) -> dict[str, str]:
    """Local file → its name on the controller; no two may be the same there."""
    names: dict[str, str] = {}
    owner: dict[str, str] = {}
    findings: list[Diagnostic] = []
    for path in paths:
        try:
            name = names[path] = controller.name_for(path)
        except Refused as refusal:
            findings += [finding.within(path) for finding in refusal.findings]
            continue
        first = owner.setdefault(name.lower(), path)
        if first != path:
            findings.append(rules.SAME_NAME(path=path, first=first, second=path, name=name))
    if findings:
        raise Refused(*findings)
    return names


def file_findings(
    data: dict[str, bytes], names: Mapping[str, str], controller: Programs
) -> dict[str, tuple[Diagnostic, ...]]:
    """Return the findings of each file: of its language, or that the controller does not accept it.

    names: of the files on the controller, which may split lines differently. The language's rules
    see all files together, as the controller will.
    """
    notes: dict[str, tuple[Diagnostic, ...]] = {}
    trees: dict[str, dict[str, Tree]] = {}
    for path in data:
        name = _language(path, data[path], controller)
        if isinstance(name, Diagnostic):
            notes[path] = (name,)
        elif name is not None:
            language = languages.get(name)
            tree = language.parse(language.decode(data[path], path))
            trees.setdefault(name, {})[path] = tree
            notes[path] = tuple(finding.within(path) for finding in tree.findings)
    for name, files in trees.items():
        if not any(has_errors(notes[path]) for path in files):
            first = next(iter(files))
            for finding in languages.get(name).check(list(files.values())):
                path = finding.path if finding.path in files else first
                notes[path] = (*notes[path], finding)
    for path in data:
        if not has_errors(notes.get(path, ())):
            try:
                controller.check_text(names[path], data[path])
            except Refused as refused:
                unsent = (replace(finding, path=path) for finding in refused.findings)
                notes[path] = (*notes.get(path, ()), *unsent)
    return {path: tuple(dict.fromkeys(notes.get(path, ()))) for path in data}


def _language(path: str, data: bytes, controller: Programs) -> str | Diagnostic | None:
    """Name of the controller's language that a file is in, None for a list of modules."""
    if path.lower().endswith(controller.lists):
        return None
    language = _file_languages(path, data, [languages.get(name) for name in controller.languages])
    if language is not None:
        return language.name
    taken = ", ".join(languages.get(name).title for name in controller.languages)
    address, other = controller.address, languages.of_file(path, data)
    if other is None:
        return rules.UNKNOWN_LANGUAGE(path=path, address=address, taken=taken)
    return rules.WRONG_LANGUAGE(path=path, address=address, taken=taken, given=other.title)


def plan(
    files: Sequence[str | FilePath],
    controller: Programs,
    *,
    task: str = "",
    load: bool = False,
    replace: Collection[str] = (),
    history: str | FilePath | None = None,
    meant: Identity | None = None,
) -> Plan:
    """Compare local programs with the controller; change nothing.

    Every file is parsed first: a program with errors is never sent. task: that modules are loaded
    in, "" for the first. load: whether to load modules that are not loaded yet. replace: names of
    programs that may be replaced although no deployment left them in their present form, `EVERY`
    for all. history: see `history.place_of`. meant: robot and serial number required of the
    controller, as far as they are stated; another one is refused. Raises Refused (Unreadable for
    files that cannot be read) with everything that prevents the files from being deployed.
    """
    if not files:
        raise Refused(rules.NO_FILES())
    data = {str(file): read_bytes(file) for file in files}
    # Lists after the files that they name, which have to be there when a list is stored.
    ordered = sorted(data, key=lambda path: path.lower().endswith(controller.lists))
    names = controller_names(ordered, controller)
    site = Site(controller, task)
    with site:
        identity = site.identity()
        untold = check_meant(identity, meant, str(controller.address)) if meant else ()
        # Only a session knows which version of a language the controller takes.
        notes = file_findings({path: data[path] for path in ordered}, names, controller)
        errors = [finding for found in notes.values() if has_errors(found) for finding in found]
        if errors:
            raise Refused(*errors)
        there = [name for name in controller.names() if not of_deployments(name)]
        record, told = last_record(site, history)
        stranger = of_another(identity, record)
        if stranger is not None:
            record, told = None, (*told, stranger)
        look = _Classifier(site, record, load, replace, history)
        planned = tuple(look.at(path, names[path], data[path], notes[path]) for path in ordered)
        told = (*told, *check_clashes(site, [file.entry for file in planned]))
    ours = {name.lower() for name in (record.programs if record else ())}
    planned_names = {name.lower() for name in names.values()}
    return Plan(
        controller.address,
        planned,
        site,
        identity,
        record,
        tuple(name for name in there if name.lower() not in ours | planned_names),
        tuple(name for name in there if name.lower() in ours - planned_names),
        (*untold, *told, *look.notes),
    )
