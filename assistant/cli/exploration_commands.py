"""The commands of explored space, `explore …`; `exploration` carries them out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from assistant.cli.arm_commands import complete_servo_mode
from assistant.cli.controller_commands import YesOption
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
    from assistant.cli.exploration import WatchOptions
    from assistant.compiler.exploration import ExplorationRequest


explore: Final = typer.Typer(
    help="Chart the space about a robot by where it has been without contact.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)
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
ControllerArgument = Annotated[
    str, typer.Argument(help="Name of a controller of the project, or its address.")
]
ContactOption = Annotated[
    str | None,
    typer.Option(help="Input of the controller that is not 0 in contact.", metavar="SIGNAL"),
]
KeyOption = Annotated[
    bool, typer.Option("--key", help="Each key that is pressed is a contact; q ends it.")
]
CameraOption = Annotated[
    Path | None,
    typer.Option(
        help="File of cameras: a picture that differs from the first one is a contact.",
        metavar="CAMERAS.toml",
    ),
]
RegionOption = Annotated[
    str | None,
    typer.Option(help="Part of the pictures, in pixels.", metavar="LEFT,TOP,RIGHT,BOTTOM"),
]
SecondsOption = Annotated[float | None, typer.Option(help="Seconds after which it ends.", min=0.0)]
LogOption = Annotated[
    Path | None,
    typer.Option(help="Write joints, poses and contacts, for `recorded`.", metavar="FILE.csv"),
]
HiddenOption = Annotated[
    Path | None,
    typer.Option(help="Cell file of what is really there: contacts with that end a run."),
]


@explore.command()
def wander(
    where: Annotated[
        str,
        typer.Argument(
            metavar="CELL|CONTROLLER",
            help="File of a cell, in which nothing moves; or with --cell the controller of an arm.",
        ),
    ],
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
    cell: Annotated[
        Path | None,
        typer.Option("--cell", help="File of the cell of an arm that really moves."),
    ] = None,
    contact: ContactOption = None,
    key: KeyOption = False,
    camera: CameraOption = None,
    region: RegionOption = None,
    range: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOINT=LOW:HIGH", help="Degrees between which a joint may move; repeatable."
        ),
    ] = None,
    box: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z", help="Box of the base for the flange, mm, each LOW:HIGH."),
    ] = None,
    speed: Annotated[float, typer.Option(help="mm/s of the flange, at most 250.")] = 50.0,
    by: Annotated[
        str,
        typer.Option(help="Way to lead the arm: see `servo`.", autocompletion=complete_servo_mode),
    ] = "jog",
    port: Annotated[
        int | None, typer.Option(help="UDP port of the way; default the usual one.", min=1)
    ] = None,
    lines: Annotated[
        list[str] | None,
        typer.Option("--line", help="HOST:PORT or serial port of a line; repeatable, in order."),
    ] = None,
    replace: Annotated[
        bool, typer.Option("--replace", help="Our programs replace others of their names.")
    ] = False,
    seconds: SecondsOption = None,
    log: LogOption = None,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Move at random up to each contact: on this computer, or with --cell a real or virtual arm."""
    from assistant.cli.exploration import (
        MotionBounds,
        check_moving,
        check_still,
        run_wander,
        run_wander_arm,
    )
    from assistant.controllers.trajectory_execution import LinkOptions

    if cell is None:
        moved: dict[str, object] = {"--contact": contact, "--key": key, "--camera": camera}
        moved |= {"--region": region, "--range": range, "--box": box, "--seconds": seconds}
        moved |= {"--log": log, "--line": lines, "--port": port, "--replace": replace}
        check_still(where, moved)
        asked = _exploration_options(Path(where), chart, robot, size, thinner)
        raise typer.Exit(run_wander(asked, hidden, runs, seed, format))
    check_moving(hidden)
    asked = _exploration_options(cell, chart, robot, size, thinner)
    wishes = LinkOptions(port, tuple(lines or ()), None, replace)
    bounds = MotionBounds(range or (), box, speed, by, wishes)
    live = _watch_options(contact, key, camera, region, seconds, log, yes, format)
    raise typer.Exit(run_wander_arm(where, asked, bounds, live, runs, seed))


@explore.command()
def manual(
    controller: ControllerArgument,
    cell: CellOption,
    chart: ChartOption,
    contact: ContactOption = None,
    key: KeyOption = False,
    camera: CameraOption = None,
    region: RegionOption = None,
    robot: RobotOption = None,
    size: SizeOption = None,
    thinner: ThinnerOption = 0.0,
    seconds: SecondsOption = None,
    log: LogOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Learn while you jog or lead an arm by hand, until Ctrl-C. This moves nothing."""
    from assistant.cli.exploration import run_manual

    asked = _exploration_options(cell, chart, robot, size, thinner)
    live = _watch_options(contact, key, camera, region, seconds, log, False, format)
    raise typer.Exit(run_manual(controller, asked, live))


@explore.command()
def running(
    controller: ControllerArgument,
    cell: CellOption,
    chart: ChartOption,
    program: Annotated[
        str | None, typer.Option(help="Program of the controller; default what is loaded.")
    ] = None,
    contact: ContactOption = None,
    key: KeyOption = False,
    camera: CameraOption = None,
    region: RegionOption = None,
    override: Annotated[int, typer.Option(help="Percent of its speed.")] = 10,
    robot: RobotOption = None,
    size: SizeOption = None,
    thinner: ThinnerOption = 0.0,
    seconds: SecondsOption = None,
    log: LogOption = None,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Start a program and learn while it moves the arm; a contact stops it. Asks before."""
    from assistant.cli.exploration import run_running

    asked = _exploration_options(cell, chart, robot, size, thinner)
    live = _watch_options(contact, key, camera, region, seconds, log, yes, format)
    raise typer.Exit(run_running(controller, program, asked, live, override))


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
    from assistant.cli.exploration import run_recorded

    asked = _exploration_options(cell, chart, robot, size, thinner)
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
    from assistant.cli.exploration import run_program
    from assistant.cli.simulation import SimulationOptions

    asked = _exploration_options(cell, chart, robot, size, thinner)
    options = SimulationOptions(
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
    from assistant.cli.exploration import run_chart_shown

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
    from assistant.cli.exploration import run_charts_merged

    raise typer.Exit(run_charts_merged(charts, output, format))


@explore.command()
def compare(
    old: ChartArgument,
    new: Annotated[Path, typer.Argument(help="A later chart.")],
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell what a later chart knows more, and exit with 1 if what was free is occupied."""
    from assistant.cli.exploration import run_charts_compared

    raise typer.Exit(run_charts_compared(old, new, format))


def _watch_options(
    signal: str | None,
    key: bool,
    camera: Path | None,
    region: str | None,
    seconds: float | None,
    log: Path | None,
    yes: bool,
    format: Format,
) -> WatchOptions:
    from assistant.cli.exploration import ContactOptions, WatchOptions

    return WatchOptions(ContactOptions(signal, key, camera, region), seconds, log, yes, format)


def _exploration_options(
    cell: Path, chart: Path, robot: str | None, size: float | None, thinner: float
) -> ExplorationRequest:
    from assistant.compiler.exploration import ExplorationRequest

    return ExplorationRequest(cell, chart, robot, size, thinner)
