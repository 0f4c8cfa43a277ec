"""Check programs, explain findings, and compare two programs by running them.

`check` presents findings as text, JSON, SARIF, JUnit or annotations of GitHub and GitLab, and
exits with 1 if one is as severe as `--fail-on`. `compare` exits with 0 if both programs do the
same, 1 if they differ, 2 if one cannot be run.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, FailOn, Refused, error, fold, fold_files
from assistant.cli.command import argument, command, option
from assistant.cli.options import (
    CellOption,
    DrawingOptions,
    EntryOption,
    FindingFormatOption,
    FormatOption,
    FromLanguage,
    PageOptions,
    PlottedPageOptions,
    RobotOption,
    SharingOptions,
    SightOptions,
    complete_robot,
    with_project_defaults,
)
from assistant.cli.output_files import Outcomes
from assistant.cli.presentation import (
    FindingFormat,
    Format,
    print_findings,
    print_for_programs,
    print_json,
    say,
    working,
)
from assistant.cli.report_pages import page_name, write_page
from assistant.cli.source_input import STANDARD, TWICE, cell_of, standard_input

if TYPE_CHECKING:
    from assistant.compiler.checker import Checked
    from assistant.compiler.comparison import Comparison, Difference
    from assistant.compiler.motion_proof import Proving
    from assistant.compiler.source_map import Place
    from assistant.report.contour_plot import DrawnLine


_CHECKED_AS_STATED = (".dxf", ".csv", ".toml", ".npy", ".npz", ".json", ".pseudo")
"""Sources whose production a project describes; programs are checked with the given options."""


@command
class Check:
    """Check sources and robot programs; with a robot also reach, limits and configurations."""

    sources: tuple[str, ...] = argument(
        "Files, or folders with programs; - for input; none for the project.", default=()
    )
    robot: RobotOption
    reader: DrawingOptions
    cell: CellOption
    from_language: FromLanguage
    sight: SightOptions
    page: PlottedPageOptions
    sharing: SharingOptions
    format: FindingFormatOption
    fail_on: FailOn = option(
        "What exit status 1 is for; never: it stays 0.", default=FailOn.WARNING
    )

    def run(self) -> int:
        from assistant.findings.severities import apply_severities

        if not self.sources:
            return self._check_project()
        page = self.page
        page.check()
        with working(f"checking {', '.join(self.sources)}"):
            checked = _check_sources(self, keep=bool(page))
            settled = apply_severities(checked.findings, checked.texts)
            left = list(settled.left)
            written = _write_check_page(self, checked, left, page) if page else []
        if self.format is not FindingFormat.TEXT:
            print_for_programs(left, settled.ignored, self.format, self.fail_on, checked.paths)
        else:
            print_findings(fold_files(left), explained=True)
            count = len(left)
            ignored = f", {len(settled.ignored)} ignored" if settled.ignored else ""
            say(f"{checked.files} checked, {count} finding{'s' * (count != 1)}{ignored}")
            for path in written:
                say(f"wrote {path}")
        return self.fail_on.status(left, unreadable=checked.unreadable)

    def _check_project(self) -> int:
        from assistant.cli.projects import check_project

        given = {
            "--robot": self.robot,
            "--process": self.reader.process,
            "--unit": self.reader.unit,
            "--place": self.reader.place,
            "--mark": self.reader.marks or None,
            "--cell": self.cell,
            "--from": self.from_language,
            "--seen": self.sight.seen,
            "--ask-at": self.sight.ask_at,
            "--report": self.page.report,
            "--open": self.page.opened or None,
            "--plot": self.page.plot,
            "--on": self.sharing.on,
        }
        return check_project(given, self.format, self.fail_on)


@command
class Explain:
    """Print what a finding means, what to do, and an example."""

    codes: tuple[str, ...] = argument("Codes of findings, such as RA204.")

    def run(self) -> int:
        from assistant.findings.rulebook import explain

        sys.stdout.write(explain(self.codes))
        return 0


def _check_sources(options: Check, keep: bool) -> Checked:
    from assistant.compiler.checker import Checked

    if options.sources.count(STANDARD) > 1:
        raise Refused(TWICE(), exit_status=2)
    alike: dict[Check, list[str]] = {}
    for source in options.sources:
        own = Path(source).suffix.lower() in _CHECKED_AS_STATED
        one = with_project_defaults(source, options) if own else options
        alike.setdefault(one, []).append(source)
    with options.sharing.used() as jobs:
        every = [_check_alike(files, one, keep, jobs) for one, files in alike.items()]
    return Checked(
        list(dict.fromkeys(finding for one in every for finding in one.findings)),
        sum(one.files for one in every),
        {path: text for one in every for path, text in one.texts.items()},
        any(one.unreadable for one in every),
        [path for one in every for path in one.paths],
        [looked for one in every for looked in one.looked or ()],
    )


def _check_alike(sources: Sequence[str], options: Check, keep: bool, jobs: int | None) -> Checked:
    """Sources that are checked with the same options."""
    from assistant.compiler.arms import open_cell
    from assistant.compiler.checker import Checked, check_files, check_text

    checked = Checked()
    # Beside robot programs a cell file may state no more than values.
    programs = any(Path(one).suffix.lower() not in _CHECKED_AS_STATED for one in sources)
    stands = open_cell(options.cell, options.robot, values=programs)
    cell = replace(stands, seeing=options.sight.seeing)
    given: dict[str, Any] = {
        "robot": options.robot,
        "process": options.reader.process,
        "unit": options.reader.unit,
        "cell": cell,
        "keep": keep,
    }
    if STANDARD in sources:
        text, spoken = standard_input(options.from_language)
        checked = check_text(text, language=spoken, **given)
    files = [source for source in sources if source != STANDARD]
    given["placement"] = options.reader.placement
    given["values"] = lambda source: options.cell or cell_of(source)
    more = check_files(files, language=options.from_language, jobs=jobs, **given)
    return Checked(
        [*cell.findings, *checked.findings, *more.findings],
        checked.files + more.files,
        {**checked.texts, **more.texts},
        checked.unreadable or more.unreadable,
        [*checked.paths, *more.paths],
        [*(checked.looked or ()), *(more.looked or ())],
    )


def _write_check_page(
    options: Check,
    checked: Checked,
    findings: list[Diagnostic],
    asked: PageOptions,
) -> Sequence[Path]:
    """Write the page and add its findings to the list."""
    from assistant.cli.report_pages import checked_sheet, drawing_lines, refused_sheets

    def lines(source: str) -> Sequence[DrawnLine]:
        return drawing_lines(source, options.reader)

    left = list(findings if asked.plot else fold(findings))  # a picture marks each place
    sheets = []
    for one in checked.looked or ():
        own = [finding for finding in left if finding.path in (*one.files, None)]
        left = [finding for finding in left if finding not in own]
        drawn = [line for file in one.files for line in lines(file)]
        sheets.append(checked_sheet(one, own, drawn))
    sheets += refused_sheets(left, lines)
    stem = page_name(options.sources[0])
    written, told = write_page(asked, sheets, checked.paths, stem)
    findings += told
    return written


_WITHOUT_PARTNER: Final = error(
    "CL015",
    "there is no program `{name}` in `{folder}`",
    "compare it with another one by naming both files",
)


@command
class Compare:
    """Run two programs and tell what they do otherwise: motions, outputs, waits, shared data."""

    first: str = argument("Program, or folder with programs.")
    second: str = argument("What is to do the same, in any language.")
    robot: str | None = option(
        "Arm of the second one.", "--robot", "-r", completions=complete_robot
    )
    from_robot: str | None = option("Arm of the first one.", completions=complete_robot)
    process: tuple[Path, ...] = option(
        "File with signals, tools, frames of the first; then the other.", "--process", "-p"
    )
    cell: Path | None = option("File of what either uses and does not declare.")
    names: Path | None = option("File of what the second calls signals and data of the first.")
    from_language: FromLanguage
    entry: EntryOption
    signals: Path | None = option("Script of the inputs; default a search for all branches.")
    seed: int = option("Of what the search draws; the same gives the same.", default=0)
    seconds: float = option("Of the processor, that the search may take.", default=10.0, min=0.1)
    text: bool = option("Pair their statements, and run nothing.")
    page: PageOptions
    format: FormatOption

    def run(self) -> int:
        """0 if the programs are equal, 1 if they differ, 2 if they cannot be compared."""
        from assistant.cli.report_pages import compared_page
        from assistant.compiler.comparison import compare, counterparts

        asked = self.page
        asked.check()
        pairs = counterparts(self.first, self.second, self.from_language)
        answers = Outcomes()
        done: list[Comparison] = []
        for one, other in pairs.both:
            with answers.of(one.name), working(f"comparing {one.name}"):
                done.append(
                    compare(
                        one.program(self.from_robot),
                        other.program(self.robot),
                        robot=self.robot,
                        from_robot=self.from_robot,
                        process=self.process,
                        cell=self.cell,
                        names=self.names,
                        language=self.from_language,
                        entry=self.entry,
                        proving=self._proving,
                        text=self.text,
                    )
                )
        lone = [
            _WITHOUT_PARTNER(path=name, name=name, folder=folder) for name, folder in pairs.lone
        ]
        status = max(
            [2 if answers.refusals else 0, int(bool(lone)), *(each.exit_status for each in done)]
        )
        refusals = [*answers.refusals, *lone]
        files: list[Path] = []
        if asked:
            read = [*(part.name for pair in pairs.both for part in pair), *self._read()]
            files, findings = compared_page(asked, done, refusals, read)
            refusals += findings
        if self.format is Format.JSON:
            print_json(
                _comparison_record(done, refusals, status) | {"written": list(map(str, files))}
            )
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

    @property
    def _proving(self) -> Proving:
        from assistant.compiler.motion_proof import Proving

        return Proving(script=self.signals, seed=self.seed, seconds=self.seconds)

    def _read(self) -> list[str]:
        """The files beside the programs."""
        given = (*self.process, self.cell, self.names, self.signals)
        return [str(path) for path in given if path is not None]


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
    from assistant.findings.formats import records_of

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
                "findings": records_of(one.findings),
            }
            for one in done
        ],
        "findings": records_of(refusals),
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
