"""`check` and `explain`: findings as people, pipelines and pull requests want them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from assistant.base.diagnostics import Diagnostic, FailOn, Refused, fold, fold_files
from assistant.cli.compiling import STANDARD, TWICE, standard_input, working
from assistant.cli.pages import NO_PAGE_WANTED, PageRequest, page_name, write_page
from assistant.cli.presentation import FindingFormat, print_findings, print_for_programs, say

if TYPE_CHECKING:
    from assistant.compiler.checker import Checked
    from assistant.report.drawn import DrawnLine
    from assistant.sources.process.placement import DrawingPlacement
    from assistant.sources.sights import Seeing


CHECKED_AS_STATED = (".dxf", ".csv", ".toml", ".npy", ".npz", ".json", ".pseudo")
"""Sources of which a project says how they are made; programs are checked for what is given."""


@dataclass(frozen=True, slots=True)
class CheckOptions:
    """What all sources of one command are checked with."""

    robot: str | None
    process: Path | None
    unit: str | None
    cell: Path | None
    from_language: str | None
    placement: DrawingPlacement | None = None
    seeing: Seeing | None = None


def run_check(
    sources: Sequence[str],
    options: CheckOptions,
    format: FindingFormat,
    fail_on: FailOn,
    asked: PageRequest = NO_PAGE_WANTED,
) -> int:
    from assistant.findings.severities import apply_severities

    asked.only_page()
    with working(f"checking {', '.join(sources)}"):
        checked = _check_sources(sources, options, keep=bool(asked))
        settled = apply_severities(checked.findings, checked.texts)
        left = list(settled.left)
        written = _write_check_page(sources, options, checked, left, asked) if asked else []
    if format is not FindingFormat.TEXT:
        print_for_programs(left, settled.ignored, format, fail_on, checked.paths)
    else:
        print_findings(fold_files(left), explained=True)
        count = len(left)
        ignored = f", {len(settled.ignored)} ignored" if settled.ignored else ""
        say(f"{checked.files} checked, {count} finding{'s' * (count != 1)}{ignored}")
        for path in written:
            say(f"wrote {path}")
    return fail_on.status(left, unreadable=checked.unreadable)


def run_explain(codes: Sequence[str]) -> int:
    from assistant.findings.rulebook import explain

    sys.stdout.write(explain(codes))
    return 0


def _check_sources(sources: Sequence[str], options: CheckOptions, keep: bool) -> Checked:
    from assistant.cli.stating import with_project_defaults
    from assistant.compiler.checker import Checked

    if list(sources).count(STANDARD) > 1:
        raise Refused(TWICE(), exit_status=2)
    alike: dict[CheckOptions, list[str]] = {}
    for source in sources:
        own = Path(source).suffix.lower() in CHECKED_AS_STATED
        alike.setdefault(with_project_defaults(source, options) if own else options, []).append(
            source
        )
    every = [_check_alike(files, one, keep) for one, files in alike.items()]
    return Checked(
        list(dict.fromkeys(finding for one in every for finding in one.findings)),
        sum(one.files for one in every),
        {path: text for one in every for path, text in one.texts.items()},
        any(one.unreadable for one in every),
        [path for one in every for path in one.paths],
        [looked for one in every for looked in one.looked or ()],
    )


def _check_alike(sources: Sequence[str], options: CheckOptions, keep: bool) -> Checked:
    """Sources that are checked with the same options."""
    from assistant.compiler.arms import open_cell
    from assistant.compiler.checker import Checked, check_files, check_text

    checked, cell = Checked(), open_cell(options.cell, options.robot)
    cell = cell if options.seeing is None else replace(cell, seeing=options.seeing)
    given: dict[str, Any] = {
        "robot": options.robot,
        "process": options.process,
        "unit": options.unit,
        "cell": cell,
        "keep": keep,
    }
    if STANDARD in sources:
        text, spoken = standard_input(options.from_language)
        checked = check_text(text, language=spoken, **given)
    files = [source for source in sources if source != STANDARD]
    given["placement"] = options.placement
    more = check_files(files, language=options.from_language, **given)
    return Checked(
        [*cell.findings, *checked.findings, *more.findings],
        checked.files + more.files,
        {**checked.texts, **more.texts},
        checked.unreadable or more.unreadable,
        [*checked.paths, *more.paths],
        [*(checked.looked or ()), *(more.looked or ())],
    )


def _write_check_page(
    sources: Sequence[str],
    options: CheckOptions,
    checked: Checked,
    findings: list[Diagnostic],
    asked: PageRequest,
) -> Sequence[Path]:
    """Writes the page; what is to be said of it is added to the findings."""
    from assistant.cli.sheets import checked_sheet, drawing_lines, refused_sheets

    def lines(source: str) -> Sequence[DrawnLine]:
        return drawing_lines(source, options.process, options.unit, options.placement)

    left = list(findings if asked.plot else fold(findings))  # a picture marks each place
    sheets = []
    for one in checked.looked or ():
        own = [finding for finding in left if finding.path in (*one.files, None)]
        left = [finding for finding in left if finding not in own]
        drawn = [line for file in one.files for line in lines(file)]
        sheets.append(checked_sheet(one, own, drawn))
    sheets += refused_sheets(left, lines)
    stem = page_name(sources[0])
    written, told = write_page(asked, sheets, checked.paths, stem)
    findings += told
    return written
