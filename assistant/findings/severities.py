"""Severities that a project gives to findings, and comments that ignore findings.

[tool.robot-assistant.severity]     # in pyproject.toml; `[severity]` in assistant.toml
RA211 = "warning"                   # one finding
RA4 = "off"                         # all whose code begins so

    MoveL p1,v25,fine,tool0;  ! assistant: ignore RA204
    ! assistant: ignore RA204, RA205: both are declared on the controller
    MoveL p1,v25,z3,tool0;
    ! assistant: ignore-file RA211

A comment after code ignores findings of its line. A comment alone on its line ignores findings of
its line and of the next line that is not a comment. `ignore-file` ignores those of the complete
file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Severity,
    Span,
    error,
    has_errors,
    info,
    warning,
)
from assistant.base.source_text import SourceText, comments
from assistant.compiler.checker import CheckedText
from assistant.findings import rulebook
from assistant.findings.rulebook import is_adjustable
from assistant.program.project_file import (
    CONTROLLERS,
    DEPLOY,
    PROGRAMS,
    STYLE,
    TARGETS,
    Project,
    project_of,
)

TABLE: Final = "severity"
OFF: Final = "off"
LEVELS: Final = (OFF, *(str(s) for s in reversed(Severity)))

_UNKNOWN_KEY: Final = warning("FN101", "`{key}` is no setting", "write a table `{table}`")
_NO_SUCH_CODE: Final = warning(
    "FN102",
    "no finding has a code that begins with `{code}`",
    "write a code as findings show it, such as RA204, or how several begin, such as RA2",
)
_NOT_LOWERED: Final = warning(
    "FN103",
    "`{code}` stays an error: it tells what cannot be read, or why nothing is written",
    "correct what it finds; errors of a language's own check of a program can be turned down",
)
_NO_LEVEL: Final = error("FN104", "`{value}` is no severity", "write one of {levels}")
_NO_TABLE: Final = error(
    "FN105", "`{key}` is no table", 'write lines such as RA204 = "warning" in it'
)


@dataclass(frozen=True, slots=True)
class Severities:
    """Severities that a project sets for findings.

    levels: severity by code or by beginning of codes, None for off. findings: faults of the
    settings, each once.
    """

    levels: Mapping[str, Severity | None] = field(default_factory=dict)
    findings: tuple[Diagnostic, ...] = ()

    def of(self, finding: Diagnostic) -> Diagnostic | None:
        """The finding as the project wants it, None if it is off."""
        # The longest beginning wins: RA211 before RA2.
        beginnings = (finding.code[:n] for n in range(len(finding.code), 0, -1))
        chosen = next((b for b in beginnings if b in self.levels), None)
        if chosen is None:
            return finding
        level = self.levels[chosen]
        # Only adjustable findings may be lowered; raising is always allowed.
        if _is_lower(level, finding.severity) and not rulebook.is_adjustable(finding):
            return finding
        return None if level is None else replace(finding, severity=level)


AS_THEY_ARE: Final = Severities()


def _is_lower(level: Severity | None, than: Severity) -> bool:
    order = list(Severity)
    return level is None or order.index(level) > order.index(than)


def severities_for(folder: FilePath) -> Severities:
    """The settings of a folder: those of the nearest file there or above it.

    Raises Unreadable or Refused, both of exit status 2, if that file is broken.
    """
    project = project_of(folder)
    if project is None:
        return AS_THEY_ARE
    found = _Page(project).severities(project.content)
    if has_errors(found.findings):
        raise Refused(*found.findings, exit_status=2)
    return found


@dataclass(slots=True)
class _Page:
    project: Project
    findings: list[Diagnostic] = field(default_factory=list)

    def severities(self, content: object) -> Severities:
        levels: dict[str, Severity | None] = {}
        if not isinstance(content, Mapping):
            self.say(_NO_TABLE, (), key=".".join(self.project.table))
            return Severities(findings=tuple(self.findings))
        wanted = content.get(TABLE, {})
        table = ".".join((*self.project.table, TABLE))
        for key in content.keys() - {TABLE, *_tables()}:
            self.say(_UNKNOWN_KEY, (key,), key=key, table=table)
        if not isinstance(wanted, Mapping):
            self.say(_NO_TABLE, (TABLE,), key=".".join((*self.project.table, TABLE)))
            wanted = {}
        for code, value in wanted.items():
            if value not in LEVELS:
                self.say(_NO_LEVEL, (TABLE, code), value=value, levels=", ".join(LEVELS))
                continue
            levels[code.upper()] = None if value == OFF else Severity(value)
        self.look_up(levels, {code.upper(): code for code in wanted})
        self.findings.sort(key=lambda f: f.line or 0)
        return Severities(levels, tuple(self.findings))

    def look_up(self, levels: Mapping[str, Severity | None], written: Mapping[str, str]) -> None:
        """Says which codes there are not, and which cannot be turned down."""
        for code, level in levels.items():
            at = (TABLE, written[code])
            if not code or not any(known.startswith(code) for known in rulebook.codes()):
                self.say(_NO_SUCH_CODE, at, code=written[code])
            elif (rule := rulebook.rule_of(code)) and _is_lower(level, rule.severity):
                if not rulebook.adjustable(rule):
                    self.say(_NOT_LOWERED, at, code=code)

    def say(self, rule: Rule, at: tuple[str, ...], /, **fields: object) -> None:
        self.findings.append(self.project.finding(rule, at, **fields))


def _tables() -> set[str]:
    """Other tables of a project's file: of languages, controllers, programs and deployments."""
    of_languages = {language.table for language in map(languages.get, languages.names())} - {""}
    return {*of_languages, CONTROLLERS, PROGRAMS, TARGETS, DEPLOY, STYLE}


def _adjusted(findings: Iterable[Diagnostic], severities: Severities) -> list[Diagnostic]:
    """The findings as the project wants them, without those that are off."""
    wanted = (severities.of(finding) for finding in findings)
    return [finding for finding in wanted if finding is not None]


_NOTHING_IGNORED: Final = info(
    "FN201", "`{code}` is ignored here, but is not found", "delete the comment"
)
_NOT_IGNORED: Final = warning(
    "FN202",
    "`{code}` cannot be ignored: it tells what cannot be read, or why nothing is written",
    "correct what it finds",
)
_NO_CODE: Final = warning(
    "FN203",
    "the comment ignores nothing: no code of a finding stands in it",
    "write the codes behind `ignore`, such as `assistant: ignore RA204, RA205`",
)

WORD: Final = re.compile(r"assistant:[ \t]*ignore(-file)?\b", re.IGNORECASE)
_CODES: Final = re.compile(r"[ \t]+([A-Z]{2}\d{3}(?:[ \t]*,[ \t]*[A-Z]{2}\d{3})*)\b", re.IGNORECASE)
STEP: Final = re.compile(r"\s*\d*\s*")
"""Text allowed before a comment that is alone on its line: a step number."""


@dataclass(frozen=True, slots=True)
class Sifted:
    """Findings that are left, and those that comments ignore."""

    left: tuple[Diagnostic, ...]
    ignored: tuple[Diagnostic, ...] = ()


def sift(
    findings: Sequence[Diagnostic], source: SourceText, mark: str, *, complete: bool = True
) -> Sifted:
    """Return the findings of one text without those that its comments ignore.

    mark: begins a comment. complete: all checks ran, so that a comment that ignores nothing is a
    finding itself.
    """
    ignoring = list(_ignoring(source, mark))
    if not ignoring:
        return Sifted(tuple(findings))
    left: list[Diagnostic] = []
    ignored: list[Diagnostic] = []
    refused: set[int] = set()
    for finding in findings:
        fitting = [c for c in ignoring if c.fits(finding)]
        for comment in fitting:
            comment.used = True
        if fitting and not is_adjustable(finding):
            refused.update(map(id, fitting))
            left.append(finding)
        else:
            (ignored if fitting else left).append(finding)
    for comment in ignoring:
        if comment.code is None:
            left.append(source.finding(_NO_CODE, comment.span))
        elif id(comment) in refused:
            left.append(source.finding(_NOT_IGNORED, comment.span, code=comment.code))
        elif complete and not comment.used:
            left.append(source.finding(_NOTHING_IGNORED, comment.span, code=comment.code))
    return Sifted(tuple(left), tuple(ignored))


@dataclass(slots=True)
class _Comment:
    """One code of a comment. lines: those it counts for, None for all. span: of the code."""

    code: str | None
    lines: tuple[int, ...] | None
    span: Span
    used: bool = field(default=False)

    def fits(self, finding: Diagnostic) -> bool:
        if finding.code != self.code:
            return False
        return self.lines is None or finding.line in self.lines


def _ignoring(source: SourceText, mark: str) -> Iterator[_Comment]:
    for word in WORD.finditer(source.text):
        line, column = source.line_column(word.start())
        text = source.line_text(line)
        begin = comment_start(text, mark)
        # Only a comment that begins with the word ignores anything.
        if begin is None or text[begin + len(mark) : column - 1].strip():
            continue
        lines: tuple[int, ...] | None = (line,)
        if word[1]:
            lines = None
        elif STEP.fullmatch(text, 0, begin):
            lines = (line, _next_code(source, line, mark))
        codes = _CODES.match(source.text, word.end())
        if codes is None:
            yield _Comment(None, lines, Span(*word.span()))
            continue
        for code in re.finditer(r"\w+", codes[1]):
            span = Span(codes.start(1) + code.start(), codes.start(1) + code.end())
            yield _Comment(code[0].upper(), lines, span)


def comment_start(line: str, mark: str) -> int | None:
    """Return the position at which a comment begins in a line, outside strings in double quotes."""
    return next((span.start for span in comments(line, mark)), None)


def _next_code(source: SourceText, line: int, mark: str) -> int:
    """Return the first line below that contains more than a comment, or the line after the last
    one.
    """
    last, _ = source.line_column(len(source.text))
    for number in range(line + 1, last + 1):
        text = source.line_text(number)
        begin = comment_start(text, mark)
        if begin is None or not STEP.fullmatch(text, 0, begin):
            return number
    return last + 1


def apply_severities(
    findings: Sequence[Diagnostic], texts: Mapping[str, CheckedText] | None = None
) -> Sifted:
    """The findings as the project wants them, in their order, and the ignored ones.

    texts: of the checked programs by path. Raises Unreadable or Refused for broken settings.
    """
    by_path: dict[str, list[Diagnostic]] = {path: [] for path in texts or ()}
    for finding in findings:
        by_path.setdefault(finding.path or "", []).append(finding)
    wanted: dict[FilePath, Severities] = {}
    left: list[Diagnostic] = []
    ignored: list[Diagnostic] = []
    for path, found in by_path.items():
        text = (texts or {}).get(path)
        sifted = Sifted(tuple(found))
        if text is not None:
            sifted = sift(found, text.source, text.mark, complete=text.complete)
        folder = FilePath(path).absolute().parent
        if folder not in wanted:
            wanted[folder] = severities_for(folder)
        left += _adjusted(sifted.left, wanted[folder])
        ignored += _adjusted(sifted.ignored, wanted[folder])
    odd = dict.fromkeys(f for severities in wanted.values() for f in severities.findings)
    return Sifted((*odd, *left), tuple(ignored))
