"""`exchange`: poses exchanged with a running program by files; `exchanging.py` carries it out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

import typer

from assistant.cli.on_controllers import CellArgument, YesOption
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format, LengthUnit

exchange: Final = typer.Typer(
    help="Exchange poses with a running program, by files on the controller.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)
PrefixOption = Annotated[str, typer.Option(help="How the names of the files begin.")]
TimeoutOption = Annotated[
    float, typer.Option(help="Seconds for an answer without a motion.", min=0.1)
]
PlainOption = Annotated[
    bool, typer.Option("--plain", help="Plain text files, without numbers and checksums.")
]
FilesOption = Annotated[
    str | None,
    typer.Option(
        "--files",
        help="With --plain: names of the files from the PC, the one that is waited for first.",
        metavar="POSITION,ORIENTATION,CONFIGURATION",
    ),
]
AnswersOption = Annotated[
    str | None,
    typer.Option(
        "--answers",
        help="With --plain: names of the files from the robot.",
        metavar="POSITION,ORIENTATION,CONFIGURATION",
    ),
]


@exchange.command()
def module(
    output: Annotated[
        str, typer.Option("--output", "-o", help="File to write; - prints it.")
    ] = "PoseExchange.mod",
    name: Annotated[str | None, typer.Option(help="Name of the module.")] = None,
    tool: Annotated[str | None, typer.Option(help="Tool that is moved.")] = None,
    tip: Annotated[
        str | None,
        typer.Option(help="x,y,z[,w,x,y,z] of its tip, mm on the flange: declares the tool."),
    ] = None,
    mass: Annotated[float, typer.Option(help="Of that tool, kg.")] = 1.0,
    centre: Annotated[str, typer.Option(help="x,y,z of its centre of gravity, mm.")] = "0,0,50",
    work_object: Annotated[str | None, typer.Option(help="Frame that poses are in.")] = None,
    speed: Annotated[str | None, typer.Option(help="Name of the speed.")] = None,
    zone: Annotated[str | None, typer.Option(help="Name of the zone of poses on the way.")] = None,
    folder: Annotated[str | None, typer.Option(help="Folder of the files there.")] = None,
    prefix: PrefixOption = "exchange",
    longest: Annotated[
        float, typer.Option(help="Seconds without a request after which it ends.")
    ] = 240.0,
    plain: PlainOption = False,
    files: FilesOption = None,
    answers: AnswersOption = None,
) -> None:
    """Write the robot's side: a module that waits for poses, goes there and answers."""
    from assistant.cli.exchanging import plain_files, run_module

    given = {
        "module": name,
        "tool": tool,
        "work_object": work_object,
        "speed": speed,
        "zone": zone,
        "folder": folder,
    }
    named = {key: value for key, value in given.items() if value is not None}
    names = plain_files(plain, files, answers, {"--zone": zone is not None})
    raise typer.Exit(run_module(output, named, prefix, longest, tip, mass, centre, names))


@exchange.command()
def pose(
    cell: CellArgument,
    prefix: PrefixOption = "exchange",
    timeout: TimeoutOption = 10.0,
    plain: PlainOption = False,
    files: FilesOption = None,
    answers: AnswersOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Ask the program where the robot is. Nothing moves."""
    from assistant.cli.exchanging import plain_files, run_pose

    names = plain_files(plain, files, answers, {})
    raise typer.Exit(run_pose(cell, prefix, timeout, names, format))


@exchange.command()
def follow(
    cell: CellArgument,
    trajectory: Annotated[Path, typer.Argument(help="Poses: csv, json, npy, npz, toml.")],
    through: Annotated[
        bool, typer.Option("--through", help="Without standing still at each pose.")
    ] = False,
    record: Annotated[
        Path | None, typer.Option(help="Write what was answered.", metavar="FILE.csv|npz")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw what was answered.", metavar="FILE.png|svg")
    ] = None,
    plot_unit: Annotated[
        LengthUnit, typer.Option("--plot-unit", help="Unit of the positions that are drawn.")
    ] = LengthUnit.MM,
    prefix: PrefixOption = "exchange",
    timeout: TimeoutOption = 10.0,
    longest: Annotated[float, typer.Option(help="Seconds for one motion.", min=0.1)] = 240.0,
    plain: PlainOption = False,
    files: FilesOption = None,
    answers: AnswersOption = None,
    yes: YesOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Send poses one after the other; the arm goes to each. Asks before; Ctrl-C stops it."""
    from assistant.cli.exchanging import FollowOptions, plain_files, run_follow

    names = plain_files(plain, files, answers, {"--through": through})
    options = FollowOptions(
        prefix, timeout, longest, through, record, plot, plot_unit.value, names, yes, format
    )
    raise typer.Exit(run_follow(cell, trajectory, options))


@exchange.command()
def stop(
    cell: CellArgument,
    prefix: PrefixOption = "exchange",
    timeout: TimeoutOption = 10.0,
    format: FormatOption = Format.TEXT,
) -> None:
    """Stop the arm where it is and end the program. Never asks; no emergency stop."""
    from assistant.cli.exchanging import run_stop

    raise typer.Exit(run_stop(cell, prefix, timeout, format))
