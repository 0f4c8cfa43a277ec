"""Checking from Python: files, folders, programs and what was compiled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import fspath
from pathlib import Path as FilePath

from assistant.base.diagnostics import Diagnostic, FailOn
from assistant.base.source_text import path_of
from assistant.compiler.arms import open_cell
from assistant.compiler.checker import Checked, check_files, check_program
from assistant.compiler.compilation import Compiled
from assistant.compiler.loader import Loaded
from assistant.findings.severities import apply_severities
from assistant.lazy import pictured
from assistant.program.program import Program
from assistant.robots import Robot

Source = str | FilePath | Program | Loaded | Compiled


@dataclass(frozen=True, slots=True, repr=False)
class Check:
    """What a check found.

    findings: as the settings of a project want them. ignored: by comments in programs. files: that
    were looked at. unreadable: something could not be read.
    """

    findings: tuple[Diagnostic, ...]
    ignored: tuple[Diagnostic, ...] = ()
    files: tuple[str, ...] = ()
    unreadable: bool = False

    @property
    def ok(self) -> bool:
        """Whether all was read, and neither an error nor a warning found."""
        return FailOn.WARNING.status(self.findings, unreadable=self.unreadable) == 0

    def __repr__(self) -> str:
        count = len(self.findings)
        return f"<Check {'ok' if self.ok else 'not ok'}: {count} finding{'s' * (count != 1)}>"

    def _repr_html_(self) -> str:
        return pictured(self)


def check(
    source: Source | Sequence[Source],
    *,
    robot: str | Robot | None = None,
    process: str | FilePath | None = None,
    unit: str | None = None,
    cell: str | FilePath | None = None,
    language: str | None = None,
) -> Check:
    """Checks files, folders, and programs that are no files, as the command `check` does.

    source: one or several; of a `Compiled` or a `Loaded`, its program. robot: reach, limits and
    configurations are checked for it; without one for the robot that a program names. process:
    process file of drawings and tables. unit: of length, that drawings are in. cell: file of the
    cell that they run in. language: of robot programs, where neither suffix nor text tell.
    Raises Refused for options that are wrong; what is wrong with a source is a finding.
    """
    several = isinstance(source, Sequence) and not isinstance(source, str | bytes)
    given: list[Source] = list(source) if several else [source]  # type: ignore[arg-type, list-item]
    stands = open_cell(cell, robot)
    checked = Checked(list(stands.findings))
    paths = [fspath(one) for one in given if isinstance(one, str | FilePath)]
    for one in given:
        if isinstance(one, str | FilePath):
            continue
        if not isinstance(one, Program | Loaded | Compiled):
            path_of(one)
        loaded = one if isinstance(one, Loaded) else None
        program = one if isinstance(one, Program) else one.program
        checked.findings += loaded.findings if loaded else ()
        checked.findings += check_program(program, stands, loaded.text if loaded else None)
    if paths:
        more = check_files(paths, process=process, unit=unit, cell=stands, language=language)
        checked.findings += more.findings
        checked.texts |= more.texts
        checked.paths += more.paths
        checked.unreadable |= more.unreadable
    settled = apply_severities(checked.findings, checked.texts)
    return Check(settled.left, settled.ignored, tuple(checked.paths), checked.unreadable)
