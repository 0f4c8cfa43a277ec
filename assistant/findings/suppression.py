"""Comments that ignore a finding where it stands.

    MoveL p1,v25,fine,tool0;  ! assistant: ignore RA204
    ! assistant: ignore RA204, RA205: both are declared on the controller
    MoveL p1,v25,z3,tool0;
    ! assistant: ignore-file RA211

A comment behind code ignores findings of its own line, one that stands alone those of the
next line that is no comment as well, `ignore-file` those of the whole file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from assistant.findings.rulebook import is_adjustable
from assistant.program.diagnostics import Diagnostic, Span, info, warning
from assistant.program.text import SourceText, comments

NOTHING_IGNORED: Final = info(
    "FN201", "`{code}` is ignored here, but is not found", "delete the comment"
)
NOT_IGNORED: Final = warning(
    "FN202",
    "`{code}` cannot be ignored: it tells what cannot be read, or why nothing is written",
    "correct what it finds",
)
NO_CODE: Final = warning(
    "FN203",
    "the comment ignores nothing: no code of a finding stands in it",
    "write the codes behind `ignore`, such as `assistant: ignore RA204, RA205`",
)

WORD: Final = re.compile(r"assistant:[ \t]*ignore(-file)?\b", re.IGNORECASE)
CODES: Final = re.compile(r"[ \t]+([A-Z]{2}\d{3}(?:[ \t]*,[ \t]*[A-Z]{2}\d{3})*)\b", re.IGNORECASE)
STEP: Final = re.compile(r"\s*\d*\s*")
"""What may stand before a comment that stands alone: a step number."""


@dataclass(frozen=True, slots=True)
class Sifted:
    """Findings that are left, and those that comments ignore."""

    left: tuple[Diagnostic, ...]
    ignored: tuple[Diagnostic, ...] = ()


def sift(
    findings: Sequence[Diagnostic], source: SourceText, mark: str, *, complete: bool = True
) -> Sifted:
    """The findings of one text without those that its comments ignore.

    mark: begins a comment. complete: all was looked for, so that a comment that ignores
    nothing is a finding itself.
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
            left.append(source.finding(NO_CODE, comment.span))
        elif id(comment) in refused:
            left.append(source.finding(NOT_IGNORED, comment.span, code=comment.code))
        elif complete and not comment.used:
            left.append(source.finding(NOTHING_IGNORED, comment.span, code=comment.code))
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
        if begin is None or text[begin + len(mark) : column - 1].strip():
            continue
        lines: tuple[int, ...] | None = (line,)
        if word[1]:
            lines = None
        elif STEP.fullmatch(text, 0, begin):
            lines = (line, _next_code(source, line, mark))
        codes = CODES.match(source.text, word.end())
        if codes is None:
            yield _Comment(None, lines, Span(*word.span()))
            continue
        for code in re.finditer(r"\w+", codes[1]):
            span = Span(codes.start(1) + code.start(), codes.start(1) + code.end())
            yield _Comment(code[0].upper(), lines, span)


def comment_start(line: str, mark: str) -> int | None:
    """Where a comment begins in a line, strings in double quotes left aside."""
    return next((span.start for span in comments(line, mark)), None)


def _next_code(source: SourceText, line: int, mark: str) -> int:
    """The first line below that is more than a comment, or the line behind the last one."""
    last, _ = source.line_column(len(source.text))
    for number in range(line + 1, last + 1):
        text = source.line_text(number)
        begin = comment_start(text, mark)
        if begin is None or not STEP.fullmatch(text, 0, begin):
            return number
    return last + 1
