"""What a virtual IRC5 looks for in a file before it takes it in: as a load of it would."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Final
from xml.etree import ElementTree

from assistant import languages
from assistant.program.diagnostics import Diagnostic, Refused, Rule, Severity

MODULE_SUFFIXES: Final = (".mod", ".sys", ".prg")
PROGRAM_SUFFIX: Final = ".pgf"
HEADING: Final = re.compile(r"^[ \t]*MODULE[ \t]+([A-Za-z]\w*)", re.IGNORECASE | re.MULTILINE)

NO_MODULE = Rule(
    "VC101",
    Severity.ERROR,
    "the file holds no module",
    "write `MODULE name … ENDMODULE`",
)
PROGRAM_FILE = Rule(
    "VC102",
    Severity.ERROR,
    "the program file cannot be read: {reason}",
    "write `<Program><Module>name.mod</Module></Program>`",
)
MISSING_MODULE = Rule(
    "VC103",
    Severity.ERROR,
    "the program file names `{name}`, which is not beside it",
    "send the modules before the program file",
)
TWICE = Rule(
    "VC104",
    Severity.WARNING,
    "module `{name}` is in `{first}` as well: only one of the two can be loaded",
    "delete one of the files or rename its module",
)


@dataclass(frozen=True, slots=True)
class LoadedModule:
    """A module of task T_ROB1: its name, the file in HOME: it came from, what is wrong."""

    name: str
    file: str
    findings: tuple[Diagnostic, ...] = ()


def is_looked_at(file: str) -> bool:
    return file.lower().endswith((*MODULE_SUFFIXES, PROGRAM_SUFFIX))


def look(file: str, data: bytes, beside: frozenset[str]) -> tuple[Diagnostic, ...]:
    """The findings of a file of that name; beside: names of the files of its folder.

    Files of other kinds have none.
    """
    lower = file.lower()
    if lower.endswith(PROGRAM_SUFFIX):
        return _program_findings(file, data, beside)
    return load(file, data).findings if lower.endswith(MODULE_SUFFIXES) else ()


def load(file: str, data: bytes) -> LoadedModule:
    """A module file as the controller's load sees it."""
    rapid = languages.get("rapid")
    try:
        source = rapid.decode(data, file)
    except Refused as error:
        return LoadedModule(PurePosixPath(file).stem, file, error.findings)
    findings = tuple(finding.within(file) for finding in rapid.parse(source).findings)
    named = re.search(
        r"^[ \t]*MODULE[ \t]+([A-Za-z]\w*)", source.text, re.IGNORECASE | re.MULTILINE
    )
    if named is None:
        return LoadedModule(PurePosixPath(file).stem, file, (*findings, NO_MODULE(path=file)))
    return LoadedModule(named[1], file, findings)


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
