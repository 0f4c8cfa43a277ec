"""What a virtual IRC5 looks for in a file before it takes it in: as a load of it would."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Final
from xml.etree import ElementTree

from assistant import languages
from assistant.base.budgets import STORED, within
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, has_errors, warning
from assistant.base.file_access import read_file
from assistant.languages import Tree
from assistant.languages.rapid import rules

MODULE_SUFFIXES: Final = (".mod", ".sys", ".prg")
PROGRAM_SUFFIX: Final = ".pgf"
PROGRAM_HEADING: Final = re.compile(
    r"^[ \t]*MODULE[ \t]+([A-Za-z]\w*)", re.IGNORECASE | re.MULTILINE
)

NO_MODULE = error("VC101", "the file holds no module", "write `MODULE name … ENDMODULE`")
PROGRAM_FILE = error(
    "VC102",
    "the program file cannot be read: {reason}",
    "write `<Program><Module>name.mod</Module></Program>`",
)
MISSING_MODULE = error(
    "VC103",
    "the program file names `{name}`, which is not beside it",
    "send the modules before the program file",
)
TWICE = warning(
    "VC104",
    "module `{name}` is in `{first}` as well: only one of the two can be loaded",
    "delete one of the files or rename its module",
)


@dataclass(frozen=True, slots=True)
class LoadedModule:
    """A module of task T_ROB1: its name, the file in HOME: it came from, what is wrong."""

    name: str
    file: str
    findings: tuple[Diagnostic, ...] = ()


def is_checked(file: str) -> bool:
    return file.lower().endswith((*MODULE_SUFFIXES, PROGRAM_SUFFIX))


def check_file(
    file: str, data: bytes, folder: FilePath, leaving: str = ""
) -> tuple[Diagnostic, ...]:
    """The findings of a file that is to get that name in a folder; other kinds have none.

    leaving: a file of the folder that goes away by the same act.
    """
    lower = file.lower()
    beside = [f for f in folder.iterdir() if f.name not in (file, leaving) and f.is_file()]
    if lower.endswith(PROGRAM_SUFFIX):
        return _program_findings(file, data, frozenset(f.name for f in beside))
    if not lower.endswith(MODULE_SUFFIXES):
        return ()
    module, tree = _read_file(file, data)
    if tree is None or has_errors(module.findings):
        return module.findings
    loaded = [f for f in beside if f.suffix.lower() in MODULE_SUFFIXES]
    try:
        with within(STORED, file, len(data)):
            found = _rule_findings(module, tree, loaded)
    except Refused as error:
        found = error.findings
    return (*module.findings, *found)


def load_module_file(file: str, data: bytes) -> LoadedModule:
    """A module file as the controller's load reads it."""
    return _read_file(file, data)[0]


def _read_file(file: str, data: bytes) -> tuple[LoadedModule, Tree | None]:
    """The module with its tree, None for what is no text or no module."""
    rapid = languages.get("rapid")
    stem = PurePosixPath(file).stem
    try:
        source = rapid.decode(data, file)
    except Refused as error:
        return LoadedModule(stem, file, error.findings), None
    try:
        with within(STORED, file, len(data)):
            tree = rapid.parse(source)
    except Refused as error:
        return LoadedModule(stem, file, error.findings), None
    findings = tuple(finding.within(file) for finding in tree.findings)
    named = PROGRAM_HEADING.search(source.text)
    if named is None:
        return LoadedModule(stem, file, (*findings, NO_MODULE(path=file))), None
    return LoadedModule(named[1], file, findings), tree


def _rule_findings(
    module: LoadedModule, tree: Tree, loaded: list[FilePath]
) -> tuple[Diagnostic, ...]:
    """What the language's rules say of a module, but what the others beside it put right.

    HOME: keeps files of many programs, so that two of them may well declare one name.
    """
    rapid = languages.get("rapid")
    alone = [
        finding for finding in _refused_finding(rapid.check([tree])) if finding not in tree.findings
    ]
    if not has_errors(alone):
        return tuple(alone)
    trees = [tree]
    for file in loaded:
        other, other_tree = _read_file(file.name, read_file(file))
        if other_tree is None or has_errors(other.findings):
            continue
        if other.name.lower() != module.name.lower():  # else it is this one's own old self
            trees.append(other_tree)
    together = set(_refused_finding(rapid.check(trees)))
    return tuple(finding for finding in alone if finding in together)


UNDECLARED: Final = frozenset({rules.UNKNOWN_SPEED.code, rules.UNKNOWN_ZONE.code})
"""Names that other modules may declare, but none does: here all that is loaded is known."""


def _refused_finding(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """The findings as severe as they are where no module is missing."""
    return [
        replace(finding, severity=Severity.ERROR) if finding.code in UNDECLARED else finding
        for finding in findings
    ]


def _program_findings(file: str, data: bytes, beside: frozenset[str]) -> tuple[Diagnostic, ...]:
    if b"<!" in data.replace(b"<!--", b""):  # no entity of a stranger is ever expanded
        return (PROGRAM_FILE(path=file, reason="it declares a document type"),)
    try:
        root = ElementTree.fromstring(data)  # noqa: S314 - without document type, see above
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        return (PROGRAM_FILE(path=file, reason=str(error)),)
    named = [(element.text or "").strip() for element in root.iter("Module")]
    if root.tag != "Program" or not named:
        return (PROGRAM_FILE(path=file, reason="it names no modules"),)
    there = {name.lower() for name in beside}
    return tuple(
        MISSING_MODULE(path=file, name=name) for name in named if name.lower() not in there
    )
