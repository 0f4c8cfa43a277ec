"""What a virtual IRC5 looks for in a file before it takes it in: as a load of it would."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Final
from xml.etree import ElementTree

from assistant import languages
from assistant.program.diagnostics import Diagnostic, Refused, Rule, Severity, has_errors

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


def look(file: str, data: bytes, folder: FilePath, leaving: str = "") -> tuple[Diagnostic, ...]:
    """The findings of a file that is to get that name in a folder; other kinds have none.

    leaving: a file of the folder that goes away by the same act.
    """
    lower = file.lower()
    beside = [f for f in folder.iterdir() if f.name not in (file, leaving) and f.is_file()]
    if lower.endswith(PROGRAM_SUFFIX):
        return _program_findings(file, data, frozenset(f.name for f in beside))
    if not lower.endswith(MODULE_SUFFIXES):
        return ()
    module = load(file, data)
    if has_errors(module.findings):
        return module.findings
    loaded = [f for f in beside if f.suffix.lower() in MODULE_SUFFIXES]
    return (*module.findings, *_rule_findings(file, data, module.name, loaded))


def _rule_findings(
    file: str, data: bytes, name: str, loaded: list[FilePath]
) -> tuple[Diagnostic, ...]:
    """What the language's rules say of a module, but what the others beside it put right.

    HOME: keeps files of many programs, so that two of them may well declare one name.
    """
    rapid = languages.get("rapid")
    trees = [rapid.parse(rapid.decode(data, file))]
    alone = [finding for finding in rapid.check(trees) if finding not in trees[0].findings]
    if not has_errors(alone):
        return tuple(alone)
    for other in loaded:
        text = other.read_bytes()
        module = load(other.name, text)
        if module.name.lower() != name.lower() and not has_errors(module.findings):
            trees.append(rapid.parse(rapid.decode(text, other.name)))
    together = set(rapid.check(trees))
    return tuple(finding for finding in alone if finding in together)


def load(file: str, data: bytes) -> LoadedModule:
    """A module file as the controller's load reads it."""
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
