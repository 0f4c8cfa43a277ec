"""What a deployment would do: each file with what the controller has of it, and the difference."""

from __future__ import annotations

import difflib
import enum
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.controllers import Address, Programs
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.clashing import check_clashes
from assistant.deploy.comparing import changed
from assistant.deploy.held import NOTHING, Held
from assistant.deploy.identifying import check_meant, of_another
from assistant.deploy.journal import Entry
from assistant.deploy.record import Record
from assistant.deploy.remembering import last_record
from assistant.deploy.site import Site, of_deployments
from assistant.languages import Tree
from assistant.program.diagnostics import Diagnostic, Refused, has_errors
from assistant.program.text import decode, read_bytes

ENCODINGS: Final = ("utf-8", "latin-1")
"""To show a program in; differences are found on its bytes."""


class Change(enum.StrEnum):
    """What a deployment does to one program on the controller."""

    NEW = "new"
    CHANGED = "changed"
    SAME = "same"
    CONFLICT = "conflict"
    """It is not what a deployment left there: nothing is done before somebody decides."""


@dataclass(frozen=True, slots=True)
class PlannedFile:
    """A program to install.

    path: the local file. name: on the controller. data: what is sent. before: what the
    controller has. after: what it is to have. diff: from its file to what is sent. taught: from
    what was loaded to what is in memory now, "" if that is the same. findings: of the language's
    parser, no errors among them.
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

    @property
    def entry(self) -> Entry:
        return Entry(self.name, self.before, self.after)


@dataclass(frozen=True, slots=True)
class Plan:
    """What a deployment would do; nothing has been changed yet.

    identity: of the controller, None where the session cannot tell. record: of the last
    deployment, None if none is known. foreign: what is there and not ours; never touched. left:
    ours of an earlier deployment, and not planned any more; not touched either.
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
    def findings(self) -> tuple[Diagnostic, ...]:
        return (*self.notes, *(finding for file in self.files for finding in file.findings))


EVERY: Final = "*"
"""In place of the names of programs: all of them."""


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
    """Compares local programs with what is on the controller; changes nothing.

    Every file is parsed first: a program with errors is never sent. task: that modules are loaded
    in, "" for the first. load: whether modules that are not loaded yet are to be. replace: names
    of programs that may be replaced although no deployment left them there as they are, `EVERY`
    for all. history: see `journal.place_of`. meant: robot and serial number that the controller has
    to have, as far as they are stated; another one is refused. Raises Refused (Unreadable for files
    that cannot be read) with everything that keeps the files from being deployed.
    """
    if not files:
        raise Refused(rules.NO_FILES())
    data = {str(file): read_bytes(file) for file in files}
    ordered = sorted(data, key=lambda path: path.lower().endswith(controller.lists))
    names = _names(ordered, controller)
    site = Site(controller, task)
    with site:
        identity = site.identity()
        untold = check_meant(identity, meant, str(controller.address)) if meant else ()
        # Only a session knows which version of a language the controller takes.
        notes = _looked_at({path: data[path] for path in ordered}, controller)
        errors = [finding for found in notes.values() if has_errors(found) for finding in found]
        if errors:
            raise Refused(*errors)
        there = [name for name in controller.names() if not of_deployments(name)]
        record, told = last_record(site, history)
        stranger = of_another(identity, record)
        if stranger is not None:
            record, told = None, (*told, stranger)
        look = _Looking(site, record, load, replace)
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


class _Looking:
    """Finds out what a deployment would do to each program."""

    def __init__(
        self, site: Site, record: Record | None, load: bool, replace: Collection[str]
    ) -> None:
        self.site, self.load = site, load
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
        change = self._change(name, before, after)
        diff = "" if change is Change.SAME else difference(name, now.file, wanted.file or b"")
        taught = self._taught(name, before, data)
        return PlannedFile(path, name, change, data, before, after, diff, taught, findings)

    def _change(self, name: str, before: Held, after: Held) -> Change:
        if self.site.same(before, after):
            return Change.SAME
        if before == NOTHING:
            return Change.NEW
        reason = self._not_ours(name, before)
        if reason is None:
            return Change.CHANGED
        if self.replace & {EVERY, name.lower()}:
            self.notes.append(rules.REPLACED(place=name, name=name, reason=reason))
            return Change.CHANGED
        self.notes.append(rules.CONFLICT(place=name, name=name, reason=reason))
        return Change.CONFLICT

    def _not_ours(self, name: str, before: Held) -> str | None:
        """Why a program is not what a deployment left there, None if it is."""
        left = self.known.get(name.lower())
        if left is None or self.record is None:
            return "it was not put there by a deployment that is known here"
        there = self.site.digests(before)
        since = f"since the deployment `{self.record.name}` of {self.record.who}"
        if there.file != left.file:
            return f"its file was changed {since}"
        if there.loaded != left.loaded:
            return f"its module in memory was changed {since}"
        return None

    def _taught(self, name: str, before: Held, data: bytes) -> str:
        """What is in memory otherwise than in the file, or than in what is sent without one."""
        file = before.file if before.file is not None else data
        if before.loaded is None:
            return ""
        labels = (f"{name} (its file)", f"{name} (in memory)")
        return changed(file, before.loaded, self.site.language, labels)


def difference(
    name: str, before: bytes | None, after: bytes, labels: tuple[str, str] | None = None
) -> str:
    """A unified diff of two versions of a program, "" if there is none. labels: of the two."""
    left, right = _shown(before or b""), _shown(after)
    one, other = labels or (f"{name} (on the controller)", f"{name} (to be sent)")
    origin = one if before is not None else "/dev/null"
    lines = difflib.unified_diff(left, right, origin, other, lineterm="")
    return "".join(f"{line}\n" for line in lines)


def _shown(data: bytes) -> list[str]:
    """The lines, with no character in them that a terminal would obey."""
    lines = re.split(r"\r\n|\r|\n", decode(data, None, ENCODINGS).text)
    return [re.sub(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", "�", line) for line in lines if line]


def _names(paths: Sequence[str], controller: Programs) -> dict[str, str]:
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


def _looked_at(data: dict[str, bytes], controller: Programs) -> dict[str, tuple[Diagnostic, ...]]:
    """The findings of each file: of its own language, or that it is not the controller's.

    The language's rules see all files together, as the controller will.
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
    return {path: tuple(dict.fromkeys(notes.get(path, ()))) for path in data}


def _language(path: str, data: bytes, controller: Programs) -> str | Diagnostic | None:
    """Name of the controller's language that a file is in, None for a list of modules."""
    if path.lower().endswith(controller.lists):
        return None
    for name in controller.languages:
        language = languages.get(name)
        if FilePath(path).suffix.lower() in language.suffixes and language.recognises(data):
            return name
    taken = ", ".join(languages.get(name).title for name in controller.languages)
    address, other = controller.address, languages.of_file(path, data)
    if other is None:
        return rules.UNKNOWN_LANGUAGE(path=path, address=address, taken=taken)
    return rules.WRONG_LANGUAGE(path=path, address=address, taken=taken, given=other.title)
