"""Present findings and results: for people, with colours on a terminal, and as JSON.

The answer of a command goes to standard output; findings and progress go to standard error.
"""

from __future__ import annotations

import enum
import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from assistant.base.diagnostics import LONGEST_EXCERPT, Diagnostic, FailOn, Severity, notes_last
from assistant.base.source_text import STEERING
from assistant.base.source_text import visible as visible_text

if TYPE_CHECKING:
    from rich.console import Console


class Format(enum.StrEnum):
    """Answer format of a command."""

    TEXT = "text"
    JSON = "json"


class LengthUnit(enum.StrEnum):
    """Unit of positions in plots."""

    MM = "mm"
    M = "m"


class FindingFormat(enum.StrEnum):
    """Answer format of a command that reports findings."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    GITHUB = "github"
    GITLAB = "gitlab"
    JUNIT = "junit"


class TranslationFormat(enum.StrEnum):
    """Answer format of a command that translates."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    GITHUB = "github"
    GITLAB = "gitlab"
    JUNIT = "junit"
    MARKDOWN = "markdown"


class PlanFormat(enum.StrEnum):
    """Answer format of a command that plans."""

    TEXT = "text"
    JSON = "json"
    MARKDOWN = "markdown"


Answer = TypeVar("Answer", Format, FindingFormat, PlanFormat)


def answer_as(format: Answer) -> Answer:
    """Set the answer format of the command, which applies to its refusals as well."""
    _answer_format.set(format)
    return format


_answer_format: Final[ContextVar[Format | FindingFormat | PlanFormat]] = ContextVar(
    "format", default=Format.TEXT
)


class FramesAs(enum.StrEnum):
    """Form of work objects in a language that lacks them."""

    BASE = "base"
    PRODUCT = "product"


class GrammarAs(enum.StrEnum):
    """Part of a long text that lark parses in a proof."""

    SAMPLES = "samples"
    FULL = "full"


_MOST_EXPLAINED: Final = 8
"""Codes that the last line below findings names."""
_STYLES = {Severity.ERROR: "bold red", Severity.WARNING: "yellow", Severity.INFO: "cyan"}


def console() -> Console:
    """Standard error with colours only on a terminal; `NO_COLOR` is honoured."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True, emoji=False, markup=False)


def print_findings(findings: Iterable[Diagnostic], *, explained: bool = False) -> None:
    """Print each finding on standard error: code, place, sentence, source line with a caret, cure.

    Notes come after errors and warnings.

    explained: a last line says where the findings are explained.
    """
    listed = notes_last(findings)
    if not listed:
        return
    from rich.text import Text

    screen = console()
    codes: set[str] = set()
    for finding in listed:
        codes.add(finding.code)
        head = Text(finding.code, style=_STYLES[finding.severity])
        head.append(f" {finding.severity}", style=_STYLES[finding.severity])
        if where := finding.where():
            head.append(f" {visible_on_one_line(where)}", style="bold")
        head.append(f": {visible_on_one_line(finding.message)}", style="default")
        screen.print(head)
        if finding.excerpt is not None and finding.line is not None:
            number = f"{finding.line:>6} | "
            excerpt, column = _excerpt(finding.excerpt, finding.column)
            screen.print(Text(number + visible_on_one_line(excerpt), style="dim"))
            if column is not None:
                width = _excerpt_width(finding, len(excerpt) - column + 1)
                screen.print(" " * (len(number) + column - 1) + "^" * width)
        if finding.cure:
            screen.print(Text(f"       = {visible_on_one_line(finding.cure)}", style="green"))
    if explained:
        some = sorted(codes)[:_MOST_EXPLAINED]
        screen.print(
            f"more about them: robot-assistant explain {' '.join(some)}, or docs/findings.md#"
            f"{some[0].lower()}"
        )


def _excerpt_width(finding: Diagnostic, rest: int) -> int:
    """Characters of the finding's span that are shown. rest: of the line, from its column on."""
    span = finding.span
    return 1 if span is None else max(1, min(span.end - span.start, rest))


def _excerpt(line: str, column: int | None) -> tuple[str, int | None]:
    """The line around a column and where the column is in it: files of one line are shown too."""
    if len(line) <= LONGEST_EXCERPT:
        return line, column
    start = max(0, (column or 1) - 1 - LONGEST_EXCERPT // 2)
    shown = line[start : start + LONGEST_EXCERPT]
    before = "…" if start else ""
    after = "…" if start + LONGEST_EXCERPT < len(line) else ""
    return f"{before}{shown}{after}", None if column is None else column - start + len(before)


def visible_on_one_line(text: str) -> str:
    """The same for where a tab would be more than one character wide."""
    return visible_text(text.replace("\t", " "))


def print_for_programs(
    findings: Sequence[Diagnostic],
    ignored: Sequence[Diagnostic],
    format: FindingFormat,
    fail_on: FailOn = FailOn.ERROR,
    files: Iterable[str] = (),
) -> None:
    """Findings on standard output: JSON, SARIF, JUnit, or what GitHub and GitLab show.

    ignored: those that a comment ignores; only a SARIF log tells them. fail_on: what fails the
    command, and files: all that it looked at; only JUnit tells them.
    """
    from assistant.findings.formats import github_line, gitlab, records_of, sarif

    findings = notes_last(findings)
    if format is FindingFormat.GITHUB:
        for finding in findings:
            say(github_line(finding))
    elif format is FindingFormat.GITLAB:
        print_json(gitlab(findings, Path.cwd()))
    elif format is FindingFormat.JUNIT:
        from assistant.findings.formats import junit_report

        say(junit_report(findings, files, fail_on, "robot-assistant").decode().rstrip())
    elif format is FindingFormat.SARIF:
        print_json(sarif(findings, ignored, Path.cwd()))
    else:
        print_json({"findings": records_of(findings)})


def print_answer(
    format: Format,
    answer: Mapping[str, Any],
    lines: Iterable[str],
    findings: Sequence[Diagnostic] | None = None,
    written: Iterable[Path | str] | None = None,
) -> None:
    """Print an answer: a record with its findings for programs, findings and lines for people.

    findings, written: None for a command whose record has no findings, or that writes no files.
    """
    if format is Format.JSON:
        from assistant.findings.formats import records_of

        record = dict(answer)
        if findings is not None:
            record["findings"] = records_of(findings)
        if written is not None:
            record["written"] = [str(path) for path in written]
        print_json(record)
        return
    print_findings(findings or (), explained=True)
    for line in (*lines, *(f"wrote {path}" for path in written or ())):
        say(line)


def print_refused(findings: Sequence[Diagnostic]) -> None:
    """Print the findings that keep a command from answering, in the requested format."""
    from assistant.findings.formats import records_of

    asked = _answer_format.get()
    if asked == Format.TEXT:
        print_findings(findings)
    elif asked == PlanFormat.MARKDOWN:
        from assistant.report.markdown import findings_markdown

        print_findings(findings)
        say("\n".join(["### Refused", "", *findings_markdown(findings)]))
    elif asked == Format.JSON:
        print_json({"ok": False, "findings": records_of(findings)})
    else:
        print_for_programs(findings, (), FindingFormat(asked))


_NO_CHARACTER: Final = re.compile(f"[{STEERING}]")
"""Printed as JSON escapes it."""


_notes: Final[ContextVar[tuple[tuple[str, Diagnostic], ...]]] = ContextVar("noted", default=())
"""Addresses of controllers, each with a finding about the connection."""


def note(address: str, finding: Diagnostic) -> None:
    """Says something of the way to a controller, once: at once, or in the JSON of the answer."""
    if (address, finding) in _notes.get():
        return
    _notes.set((*_notes.get(), (address, finding)))
    if _answer_format.get() != Format.JSON:
        print_findings([finding])


def print_json(answer: object) -> None:
    say(json.dumps(_with_notes(answer), indent=2, ensure_ascii=False))


def _with_notes(answer: object) -> object:
    """The answer, with what was noted of the controller that it is about."""
    if isinstance(answer, list):
        return [_with_notes(one) for one in answer]
    if not isinstance(answer, dict):
        return answer
    if "controllers" in answer:
        return {**answer, "controllers": _with_notes(answer["controllers"])}
    noted = [finding for address, finding in _notes.get() if address == answer.get("address")]
    if not noted:
        return answer
    from assistant.findings.formats import records_of

    return {**answer, "findings": [*answer.get("findings", []), *records_of(noted)]}


def say(line: str) -> None:
    """A line of the answer itself, on standard output."""
    sys.stdout.write(_NO_CHARACTER.sub(lambda found: json.dumps(found[0])[1:-1], line) + "\n")


@contextmanager
def working(what: str) -> Iterator[None]:
    """A spinner on the terminal while something takes its time; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield
        return
    with console().status(what):
        yield
