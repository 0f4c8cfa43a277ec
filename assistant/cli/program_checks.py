"""Check programs, explain findings, and compare two programs by running them.

`check` presents findings as text, JSON, SARIF, JUnit or annotations of GitHub and GitLab, and
exits with 1 if one is as severe as `--fail-on`. `compare` exits with 0 if both programs do the
same, 1 if they differ, 2 if one cannot be run.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, FailOn, Refused, error, fold, fold_files
from assistant.cli.compilation import STANDARD, TWICE, standard_input, working
from assistant.cli.output_files import Outcomes
from assistant.cli.presentation import (
    FindingFormat,
    Format,
    print_findings,
    print_for_programs,
    print_json,
    say,
)
from assistant.cli.report_pages import NO_PAGE_WANTED, PageRequest, page_name, write_page

if TYPE_CHECKING:
    from assistant.compiler.checker import Checked
    from assistant.compiler.comparison import Comparison, Difference
    from assistant.compiler.motion_proof import Proving
    from assistant.compiler.source_map import Place
    from assistant.report.contour_plot import DrawnLine
    from assistant.sources.process.placement import DrawingPlacement
    from assistant.sources.sights import Seeing


_CHECKED_AS_STATED = (".dxf", ".csv", ".toml", ".npy", ".npz", ".json", ".pseudo")
"""Sources whose production a project describes; programs are checked with the given options."""


@dataclass(frozen=True, slots=True)
class CheckOptions:
    """Options for checking all sources of one command."""

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
    from assistant.cli.options import with_project_defaults
    from assistant.compiler.checker import Checked

    if list(sources).count(STANDARD) > 1:
        raise Refused(TWICE(), exit_status=2)
    alike: dict[CheckOptions, list[str]] = {}
    for source in sources:
        own = Path(source).suffix.lower() in _CHECKED_AS_STATED
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
    """Write the page and add its findings to the list."""
    from assistant.cli.report_pages import checked_sheet, drawing_lines, refused_sheets

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


_WITHOUT_PARTNER: Final = error(
    "CL015",
    "there is no program `{name}` in `{folder}`",
    "compare it with another one by naming both files",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CompareOptions:
    """The options of the command; see `compiler.comparing.compare`."""

    robot: str | None
    from_robot: str | None
    process: tuple[Path, ...]
    cell: Path | None
    names: Path | None
    language: str | None
    entry: str | None
    proving: Proving
    text: bool = False

    def read(self) -> list[str]:
        """The files beside the programs."""
        given = (*self.process, self.cell, self.names, self.proving.script)
        return [str(path) for path in given if path is not None]


def run_compare(
    first: str, second: str, options: CompareOptions, format: Format, asked: PageRequest
) -> int:
    """Return 0 if the programs are equal, 1 if they differ, 2 if they cannot be compared.

    asked: the page with both programs side by side. Raises Refused (exit status 2) for a file name
    that is not a page's.
    """
    from assistant.cli.report_pages import compared_page
    from assistant.compiler.comparison import compare, counterparts

    asked.only_page()
    pairs = counterparts(first, second, options.language)
    answers = Outcomes()
    done: list[Comparison] = []
    for one, other in pairs.both:
        with answers.of(one.name), working(f"comparing {one.name}"):
            done.append(
                compare(
                    one.program(options.from_robot),
                    other.program(options.robot),
                    robot=options.robot,
                    from_robot=options.from_robot,
                    process=options.process,
                    cell=options.cell,
                    names=options.names,
                    language=options.language,
                    entry=options.entry,
                    proving=options.proving,
                    text=options.text,
                )
            )
    lone = [_WITHOUT_PARTNER(path=name, name=name, folder=folder) for name, folder in pairs.lone]
    status = max(
        [2 if answers.refusals else 0, int(bool(lone)), *(each.exit_status for each in done)]
    )
    refusals = [*answers.refusals, *lone]
    files: list[Path] = []
    if asked:
        read = [*(part.name for pair in pairs.both for part in pair), *options.read()]
        files, findings = compared_page(asked, done, refusals, read)
        refusals += findings
    if format is Format.JSON:
        print_json(_comparison_record(done, refusals, status) | {"written": list(map(str, files))})
        return status
    print_findings(refusals)
    for each in done:
        _print_comparison(each)
    if len(pairs.both) > 1:
        equal = sum(each.equal for each in done)
        say(f"{len(pairs.both)} pairs of programs, {equal} of them equal")
    for path in files:
        say(f"wrote {path}")
    return status


def _print_comparison(done: Comparison) -> None:
    """Print the differences with both lines, then what was compared and the answer."""
    from assistant.compiler.comparison import PROGRAMS_DIFFER

    print_findings(one for one in done.findings if one.code != PROGRAMS_DIFFER.code)
    for row in done.rows:
        if not row.alike:
            for sign, name, at in zip("-+", done.names, (row.first, row.second), strict=True):
                if at is not None:
                    say(f"{sign} {_difference_line(name, at)}")
    for one in done.differences:
        for name, place, behind in zip(done.names, one.places, one.behind, strict=True):
            say(_difference_line(name, place))
            if behind is not None and behind != place:
                say(f"  behind line {behind.line}: {behind.text}")
        say(f"  {one.what}; with {one.inputs}")
    say(f"{done.names[0]}, {done.names[1]}: {done.line()}")


def _difference_line(name: str, place: Place | None) -> str:
    if place is None:
        return f"{name}: does nothing there"
    return f"{place.path or name}:{place.line}: {place.text}"


def _comparison_record(
    done: list[Comparison], refusals: list[Diagnostic], status: int
) -> dict[str, Any]:
    from assistant.findings.formats import finding_record

    return {
        "ok": status == 0,
        "comparisons": [
            {
                "first": one.names[0],
                "second": one.names[1],
                "answer": one.answer,
                "differences": list(map(_difference_record, one.differences)),
                "compared": one.motion.record(),
                "names": dict(one.pairs),
                "statements": [
                    {
                        "alike": row.alike,
                        "places": [_place_record(row.first), _place_record(row.second)],
                    }
                    for row in one.rows
                ],
                "findings": list(map(finding_record, one.findings)),
            }
            for one in done
        ],
        "findings": list(map(finding_record, refusals)),
    }


def _difference_record(one: Difference) -> dict[str, Any]:
    return {
        "what": one.what,
        "inputs": one.inputs,
        "places": list(map(_place_record, one.places)),
        "behind": list(map(_place_record, one.behind)),
    }


def _place_record(place: Place | None) -> dict[str, Any] | None:
    return None if place is None else {"path": place.path, "line": place.line, "text": place.text}
