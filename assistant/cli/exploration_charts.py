"""Charts of explored space: made without moving an arm, shown, joined and compared.

`explore recorded` and `explore program` learn from where an arm has been; `explore compare` exits
with 1 if free space is occupied.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Final

from assistant.base.diagnostics import Refused, error, has_errors
from assistant.cli.command import Argument, argument, command_of, option
from assistant.cli.exploration import (
    ChartingOptions,
    ChartOption,
    ExploredCellOption,
    HiddenOption,
    chart_lines,
    chart_record,
    check_chart_name,
    prepare_chart,
    report_exploration,
)
from assistant.cli.exploration import explore as explore
from assistant.cli.options import (
    AccelerationOption,
    FormatOption,
    ReaderOptions,
    Source,
    WrittenOptions,
)
from assistant.cli.presentation import print_answer, working
from assistant.cli.source_input import keep_sources

ChartArgument = Annotated[Path, Argument("A chart.")]
NO_UNTIL: Final = error("CL281", "--until is {value:g}", "write seconds above 0")


@command_of(explore)
class Recorded:
    """Learn from where an arm has been, by hand or by programs, as a controller recorded it."""

    recordings: tuple[Path, ...] = argument(
        "Joints over time, .csv: logs of `monitor` or `follow`."
    )
    cell: ExploredCellOption
    chart: ChartOption
    contact: str | None = option("Recorded input that is not 0 in contact.", metavar="SIGNAL")
    charting: ChartingOptions
    format: FormatOption

    def run(self) -> int:
        from assistant.compiler.exploration import explore_by_recordings

        with working("reading what was recorded"):
            begun = prepare_chart(
                self.charting.request(self.cell, self.chart),
                [str(path) for path in self.recordings],
            )
            found = explore_by_recordings(begun, self.recordings, self.contact)
        return report_exploration(begun, found, "runs of each recording", self.format)


@command_of(explore)
class Program:
    """Learn from a program that has run without contact, or up to one. Nothing moves."""

    program: Source
    cell: ExploredCellOption
    chart: ChartOption
    until: float | None = option("Seconds of its procedure at which a contact ended it.")
    hidden: HiddenOption
    charting: ChartingOptions
    acceleration: AccelerationOption
    reader: ReaderOptions
    written: WrittenOptions
    format: FormatOption

    def run(self) -> int:
        """1 if the robot cannot run the program; then the chart stays as it is."""
        from assistant.cli.simulation import report_errors, solved_source
        from assistant.compiler.arms import InCell
        from assistant.compiler.exploration import explore_by_program
        from assistant.robots.timing import simulate

        if self.until is not None and not self.until > 0.0:
            raise Refused(NO_UNTIL(value=self.until), exit_status=2)
        with working(f"going through {self.program}"):
            asked = self.charting.request(self.cell, self.chart)
            begun = prepare_chart(
                asked, [self.program, *([] if self.hidden is None else [str(self.hidden)])]
            )
            explorer = begun.explorer
            named = None if asked.robot is None else explorer.placed.robot
            scene = replace(explorer.scene, runs=asked.robot)
            done = solved_source(
                self.program,
                self.reader,
                written=self.written,
                stands=InCell(scene, named),
            )
            if has_errors(done.findings):
                arm = done.solution.robot
                return report_errors(self.program, arm, done.findings, self.format, "gone through")
            simulation = simulate(done.solution, acceleration=self.acceleration)
            try:
                found = explore_by_program(begun, done.program, simulation, self.until, self.hidden)
            except Refused as caught:
                findings = [
                    done.places.finding(one).within(self.program) for one in caught.findings
                ]
                raise Refused(*findings, exit_status=caught.exit_status) from None
        return report_exploration(begun, found, "runs", self.format)


@command_of(explore)
class Show:
    """Print what a chart knows, and draw it."""

    chart: ChartArgument
    output: Path | None = option(
        "Draw it as well: FILE.png or .svg.", "--output", "-o", metavar="FILE"
    )
    format: FormatOption

    def run(self) -> int:
        """output: a picture of it that is written."""
        from assistant.base.file_sets import write_all
        from assistant.cell.exploration.occupancy import load_map
        from assistant.report.figures import format_of
        from assistant.report.workspace import explored_picture

        kind = "" if self.output is None else format_of(self.output.name)
        occupancy = load_map(self.chart)
        written: list[str] = []
        if self.output is not None:
            keep_sources([str(self.chart)], [self.output])
            written = [
                str(one) for one in write_all({self.output: explored_picture(occupancy, kind)})
            ]
        answer = {"chart": str(self.chart), **chart_record(occupancy)}
        print_answer(self.format, answer, chart_lines(occupancy), written=written)
        return 0


@command_of(explore)
class Merge:
    """Write what several charts know together; what one has occupied is occupied."""

    charts: tuple[Path, ...] = argument("Charts of one robot and one size of cells.")
    output: Path = option("Chart to write.", "--output", "-o")
    format: FormatOption

    def run(self) -> int:
        from assistant.cell.exploration.occupancy import load_map, save_map

        check_chart_name(self.output)
        keep_sources([str(path) for path in self.charts], [self.output])
        merged = load_map(self.charts[0])
        for path in self.charts[1:]:
            other = load_map(path)
            with _at_chart(path):
                merged = merged.merged(other)
        save_map(merged, self.output)
        answer = {"chart": chart_record(merged)}
        print_answer(self.format, answer, chart_lines(merged), written=[self.output])
        return 0


@command_of(explore)
class Compare:
    """Tell what a later chart knows more, and exit with 1 if what was free is occupied."""

    old: ChartArgument
    new: Path = argument("A later chart.")
    format: FormatOption

    def run(self) -> int:
        """1 if what was free is not any more."""
        from assistant.cell.exploration.occupancy import load_map

        before, after = load_map(self.old), load_map(self.new)
        with _at_chart(self.new):
            found = before.compared(after)
        litre = before.size**3 / 1e6
        counts = (
            (found.same, "are known alike"),
            (found.gained, f"are known in {self.new} only"),
            (found.lost, f"are known in {self.old} only"),
            (found.freed, "were occupied and are free"),
            (found.blocked, "were free and are occupied"),
        )
        lines = (f"{count:>12,} cells ({count * litre:.1f} l) {what}" for count, what in counts)
        answer = {"old": str(self.old), "new": str(self.new), **asdict(found)}
        print_answer(self.format, answer, lines)
        return 1 if found.blocked else 0


@contextmanager
def _at_chart(path: Path) -> Iterator[None]:
    """Attach the chart's path to the findings of Refused."""
    try:
        yield
    except Refused as refused:
        findings = [finding.within(str(path)) for finding in refused.findings]
        raise Refused(*findings, exit_status=refused.exit_status) from None
