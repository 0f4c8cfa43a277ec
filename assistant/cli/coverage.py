"""`coverage`: what of a vendor program the pseudo-program says, construct by construct."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.cli.compiling import STANDARD, TWICE, standard_input, working
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.base.source_text import SourceText
    from assistant.languages import Language
    from assistant.languages.coverage import Construct

LANGUAGE_UNCLEAR = error(
    "CL006", "the text does not show which robot language it is in", "name it with --from"
)
COVERAGE_HEADINGS: Final = ("Construct", "Supported", "Partial", "Kept verbatim")


def run_coverage(paths: Sequence[str], language: str | None, format: Format) -> int:
    """0 if every program could be read, 1 if one has syntax errors, 2 if one is unreadable."""
    from assistant.languages.coverage import coverage, total

    if list(paths).count(STANDARD) > 1:
        raise Refused(TWICE(), exit_status=2)
    status, found = 0, []
    wrong: list[Diagnostic] = []
    for path in dict.fromkeys(paths):
        try:
            for name, spoken, source in _programs_to_count(path, language):
                with working(f"reading {name}"):
                    tree = spoken.parse(source)
                    told = [f.within(name) for f in tree.findings]
                    print_findings(told)
                    if has_errors(tree.findings):
                        status = max(status, 1)
                        wrong += told
                        continue
                    found.append(coverage(spoken, [tree]))
        except Refused as refused:
            told = [f.within(str(path)) for f in refused.findings]
            print_findings(told)
            wrong += told
            status = max(status, refused.exit_status)
    _print_coverage(total(found), wrong, format)
    return status


def _programs_to_count(
    path: str, language: str | None
) -> Iterator[tuple[str, Language[Any], SourceText]]:
    """Name, language and text of each program that a path stands for."""
    from assistant.compiler.formatter import read_program
    from assistant.compiler.loader import language_of
    from assistant.compiler.program_files import programs_in

    if path != STANDARD:
        for name in programs_in(path, language):
            yield name, *read_program(name, language)
        return
    text, spoken = standard_input(language)
    if spoken is None:
        raise Refused(LANGUAGE_UNCLEAR(path="standard input"), exit_status=2)
    yield "standard input", language_of(spoken), text


def _print_coverage(rows: Sequence[Construct], wrong: Sequence[Diagnostic], format: Format) -> None:
    """wrong: why programs are not counted, which a list of constructs alone would not tell."""
    if format is Format.JSON:
        from assistant.findings.formats import finding_record

        constructs = [asdict(row) for row in rows]
        findings = [finding_record(finding) for finding in wrong]
        print_json(
            {"ok": False, "constructs": constructs, "findings": findings} if wrong else constructs
        )
        return
    counts = [(row.name, row.supported, row.partial, row.verbatim) for row in rows]
    sums = [sum(column) for column in zip(*(c[1:] for c in counts), strict=True)]
    lines = [COVERAGE_HEADINGS, *counts, ("total", *(sums or (0, 0, 0)))]
    width = max(len(str(line[0])) for line in lines)
    for first, *rest in lines:
        said = f"{first:{width}}" + "".join(f"{value:>15}" for value in rest)
        say(said.rstrip())
