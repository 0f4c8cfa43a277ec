"""Loading: the pseudo-program of anything that can be read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages, sources
from assistant.program import pseudo
from assistant.program.diagnostics import Diagnostic, Refused, has_errors
from assistant.program.program import Program
from assistant.program.statements import Call
from assistant.program.text import SourceText, decode, read_bytes

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.robots import Robot

PSEUDO_ENCODINGS: Final = ("utf-8-sig", "utf-8")
STANDARD_INPUT: Final = "-"


@dataclass(frozen=True, slots=True)
class Loaded:
    """A pseudo-program, what it was written in (None: no robot language), and the findings."""

    program: Program
    language: str | None = None
    findings: tuple[Diagnostic, ...] = ()


def load(
    path: str | FilePath,
    *,
    process: str | FilePath | None = None,
    robot: Robot | None = None,
    language: str | None = None,
) -> Loaded:
    """The pseudo-program of a drawing, table, `.pseudo` text or vendor program.

    process: process file of a drawing or table. robot: the arm that a vendor program was
    written for, where its own header does not say. language: of a vendor program, if neither
    suffix nor text tell. Other units that a vendor program calls are read from beside it.
    Raises Unreadable or Refused.
    """
    source = FilePath(path)
    if source.suffix.lower() == pseudo.SUFFIX:
        text = decode(read_bytes(source), str(path), PSEUDO_ENCODINGS)
        return Loaded(pseudo.parse(text, side_tables=source.parent))
    data = None if source.suffix.lower() in sources.READERS else read_bytes(source)
    spoken = _spoken(source, data, language)
    if spoken is None:
        reading = sources.read(source, process)
        return Loaded(reading.program, None, reading.findings)
    return lift(spoken, [spoken.read(source)], robot, beside=source.parent)


def load_text(
    text: SourceText, *, robot: Robot | None = None, language: str | None = None
) -> Loaded:
    """The same for a text that is no file: a robot language's if named, else pseudo text."""
    if language is None:
        return Loaded(pseudo.parse(text))
    return lift(languages.get(language), [text], robot)


def lift(
    language: Language[Any],
    texts: Sequence[SourceText],
    robot: Robot | None = None,
    *,
    beside: FilePath | None = None,
) -> Loaded:
    """The pseudo-program of vendor texts; raises Refused if one of them is broken."""
    trees = [language.parse(text) for text in texts]
    findings = [finding for tree in trees for finding in tree.findings]
    if has_errors(findings):
        raise Refused(*findings)
    program = language.lift(trees, robot)
    if beside is not None:
        more = _missing_units(language, program, beside)
        if more:
            return lift(language, [*texts, *more], robot)
    return Loaded(program, language.name, tuple(findings))


def _missing_units(language: Language[Any], program: Program, folder: FilePath) -> list[SourceText]:
    present = {procedure.unit for procedure in program.procedures}
    called = dict.fromkeys(
        statement.unit
        for statement in program.statements()
        if isinstance(statement, Call) and statement.unit and statement.unit not in present
    )
    files = [folder / language.file_name(program, unit) for unit in called]
    return [language.read(file) for file in files if file.is_file()]


def _spoken(source: FilePath, data: bytes | None, named: str | None) -> Language[Any] | None:
    if named is not None:
        return languages.get(named)
    return None if data is None else languages.of_file(source, data)
