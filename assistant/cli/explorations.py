"""The commands of explored space, `explore …`; `exploring.py` carries them out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from assistant.cli.options import (
    AccelerationOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    FromRobot,
    ProcessOption,
    Source,
    UnitOption,
)
from assistant.cli.presentation import Format

if TYPE_CHECKING:
    from assistant.compiler.exploring import Asked

explore: Final = typer.Typer(
    help="Chart the space about a robot by where it has been without contact.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
CellArgument = Annotated[
    Path, typer.Argument(metavar="CELL", help="File of the cell, with the robot.")
]
CellOption = Annotated[Path, typer.Option("--cell", help="File of the cell, with the robot.")]
ChartOption = Annotated[
    Path, typer.Option("--chart", "-c", help="The chart, .npz; one that is there is gone on with.")
]
ChartArgument = Annotated[Path, typer.Argument(help="A chart.")]
RobotOption = Annotated[
    str | None, typer.Option("--robot", "-r", help="Its name in the cell, if there are several.")
]
SizeOption = Annotated[
    float | None,
    typer.Option("--size", help="Size of the chart's cells, mm; default 10, or that of the chart."),
]
ThinnerOption = Annotated[
    float,
    typer.Option(help="mm by which the bodies of the robot are rounder than it is, at most."),
]
HiddenOption = Annotated[
    Path | None,
    typer.Option(help="Cell file of what is really there: contacts with that end a run."),
]


@explore.command()
def wander(
    scene: CellArgument,
    chart: ChartOption,
    hidden: HiddenOption = None,
    runs: Annotated[int, typer.Option(help="Random moves, a run each.", min=1)] = 50,
    seed: Annotated[
        int | None,
        typer.Option(help="Of what is random; default another one as the chart grows.", min=0),
    ] = None,
    robot: RobotOption = None,
    size: SizeOption = None,
    thinner: ThinnerOption = 0.0,
    format: FormatOption = Format.TEXT,
) -> None:
    """Move at random in a cell, up to each contact, on this computer. Nothing moves."""
    from assistant.cli.exploring import run_wander

    asked = _asked(scene, chart, robot, size, thinner)
    raise typer.Exit(run_wander(asked, hidden, runs, seed, format))


@explore.command()
def recorded(
    recordings: Annotated[
        list[Path], typer.Argument(help="Joints over time, .csv: logs of `monitor` or `follow`.")
    ],
    cell: CellOption,
    chart: ChartOption,
    contact: Annotated[
        str | None,
        typer.Option(help="Recorded input that is not 0 in contact.", metavar="SIGNAL"),
    ] = None,
    robot: RobotOption = None,
    size: SizeOption = None,
    thinner: ThinnerOption = 0.0,
    format: FormatOption = Format.TEXT,
) -> None:
    """Learn from where an arm has been, by hand or by programs, as a controller recorded it."""
    from assistant.cli.exploring import run_recorded

    asked = _asked(cell, chart, robot, size, thinner)
    raise typer.Exit(run_recorded(asked, recordings, contact, format))


@explore.command()
def program(
    program: Source,
    cell: CellOption,
    chart: ChartOption,
    until: Annotated[
        float | None, typer.Option(help="Seconds of its procedure at which a contact ended it.")
    ] = None,
    hidden: HiddenOption = None,
    robot: RobotOption = None,
    size: SizeOption = None,
    thinner: ThinnerOption = 0.0,
    acceleration: AccelerationOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Learn from a program that has run without contact, or up to one. Nothing moves."""
    from assistant.cli.exploring import run_program
    from assistant.cli.simulating import Options

    asked = _asked(cell, chart, robot, size, thinner)
    options = Options(
        None, process, unit, from_language, from_robot, acceleration, None, entry, None
    )
    raise typer.Exit(run_program(asked, program, options, until, hidden, format))


@explore.command()
def show(
    chart: ChartArgument,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Draw it as well: FILE.png or .svg.", metavar="FILE"),
    ] = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Print what a chart knows, and draw it."""
    from assistant.cli.exploring import run_chart_shown

    raise typer.Exit(run_chart_shown(chart, output, format))


@explore.command()
def merge(
    charts: Annotated[
        list[Path], typer.Argument(help="Charts of one robot and one size of cells.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Chart to write.")],
    format: FormatOption = Format.TEXT,
) -> None:
    """Write what several charts know together; what one has occupied is occupied."""
    from assistant.cli.exploring import run_charts_merged

    raise typer.Exit(run_charts_merged(charts, output, format))


@explore.command()
def compare(
    old: ChartArgument,
    new: Annotated[Path, typer.Argument(help="A later chart.")],
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell what a later chart knows more, and exit with 1 if what was free is occupied."""
    from assistant.cli.exploring import run_charts_compared

    raise typer.Exit(run_charts_compared(old, new, format))


def _asked(cell: Path, chart: Path, robot: str | None, size: float | None, thinner: float) -> Asked:
    from assistant.compiler.exploring import Asked

    return Asked(cell, chart, robot, size, thinner)
