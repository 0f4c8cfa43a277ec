"""What a deployment would do: each file with what the controller has of it, and the difference."""

from __future__ import annotations

import difflib
import enum
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.controllers import Address, Programs
from assistant.deploy import rules
from assistant.languages import Tree
from assistant.program.diagnostics import Diagnostic, Refused, has_errors
from assistant.program.text import decode, read_bytes

ENCODINGS: Final = ("utf-8", "latin-1")
"""To show a program in; differences are found on its bytes."""


class Change(enum.StrEnum):
    """What a deployment does to one file on the controller."""

    NEW = "new"
    CHANGED = "changed"
    SAME = "same"


@dataclass(frozen=True, slots=True)
class PlannedFile:
    """A file to install.

    path: the local file. name: on the controller. data: what is sent. before: what the
    controller has, None if nothing. findings: of the language's parser, no errors among them.
    """

    path: str
    name: str
    change: Change
    data: bytes = field(repr=False)
    before: bytes | None = field(repr=False)
    diff: str = field(repr=False, default="")
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True)
class Plan:
    """What a deployment would do; nothing has been changed yet."""

    address: Address
    files: tuple[PlannedFile, ...]
    controller: Programs = field(repr=False, compare=False)

    @property
    def changes(self) -> tuple[PlannedFile, ...]:
        """The files that would be written."""
        return tuple(file for file in self.files if file.change is not Change.SAME)

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        return tuple(finding for file in self.files for finding in file.findings)


def plan(files: Sequence[str | FilePath], controller: Programs) -> Plan:
    """Compares local programs with what is on the controller; changes nothing.

    Every file is parsed first: a program with errors is never sent. Raises Refused (Unreadable
    for files that cannot be read) with everything that keeps the files from being deployed.
    """
    if not files:
        raise Refused(rules.NO_FILES())
    data = {str(file): read_bytes(file) for file in files}
    ordered = sorted(data, key=lambda path: path.lower().endswith(controller.lists))
    names = _names(ordered, controller)
    with controller:
        # Only a session knows which version of a language the controller takes.
        notes = _looked_at({path: data[path] for path in ordered}, controller)
        errors = [finding for found in notes.values() if has_errors(found) for finding in found]
        if errors:
            raise Refused(*errors)
        planned = tuple(
            _planned(path, names[path], data[path], controller, notes[path]) for path in ordered
        )
    return Plan(controller.address, planned, controller)


def difference(name: str, before: bytes | None, after: bytes) -> str:
    """A unified diff of two versions of a program, "" if there is none."""
    left, right = _shown(before or b""), _shown(after)
    origin = f"{name} (on the controller)" if before is not None else "/dev/null"
    lines = difflib.unified_diff(left, right, origin, f"{name} (to be sent)", lineterm="")
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


def _planned(
    path: str, name: str, data: bytes, controller: Programs, notes: tuple[Diagnostic, ...]
) -> PlannedFile:
    before = controller.read(name)
    there = None if before is None else controller.stored(before)
    wanted = controller.stored(data)
    same = Change.SAME if there == wanted else Change.CHANGED
    change = same if there is not None else Change.NEW
    diff = "" if change is Change.SAME else difference(name, there, wanted)
    return PlannedFile(path, name, change, data, before, diff, notes)
