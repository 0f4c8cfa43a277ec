"""`info`: what is in a drawing, before anything is done with it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, fold, worst
from assistant.cli.compiling import working
from assistant.cli.presentation import Format, print_findings, print_json, say

NOT_DRAWN = error(
    "CL050",
    "`{name}` is no drawing",
    "name a DXF file; `show` prints what programs and tables say",
)


def run_info(drawing: Path, process: Path | None, unit: str | None, format: Format) -> int:
    """0; 1 if something of the drawing is not in order."""
    from assistant.base.length_units import known_unit
    from assistant.findings.severities import apply_severities
    from assistant.report import drawings as report
    from assistant.sources import process_of
    from assistant.sources.drawing.survey import survey
    from assistant.sources.process import NO_PROCESS
    from assistant.sources.process.placement import DRAWING_SUFFIXES

    if drawing.suffix.lower() not in DRAWING_SUFFIXES:
        raise Refused(NOT_DRAWN(path=str(drawing), name=drawing.name), exit_status=2)
    left = list[Diagnostic]()
    try:
        chosen, stated = process_of(drawing, process), "as the process file says"
    except Refused as refused:  # one that is not finished yet; the drawing is there all the same
        if process is not None:
            raise
        chosen, stated, left = NO_PROCESS, "", [*refused.findings]
    if unit is not None:
        chosen, stated = replace(chosen, unit=known_unit(unit)), "as --unit says"
    with working(f"reading {drawing}"):
        found = survey(drawing, chosen, stated)
    told = [finding.within(str(drawing)) for finding in (*left, *chosen.findings, *found.findings)]
    findings = apply_severities(told).left
    if format is Format.JSON:
        from assistant.findings.formats import finding_record

        answer = {"drawing": str(drawing), **report.record(found)}
        print_json(answer | {"findings": [finding_record(finding) for finding in findings]})
    else:
        print_findings(fold(findings), explained=True)
        for line in report.lines(found):
            say(line)
    return 1 if worst(findings) in (Severity.ERROR, Severity.WARNING) else 0
