"""`reach`: what an arm reaches, where things stand best; `reach_runs.py` carries it out."""

from __future__ import annotations

from typing import Annotated, Final

import typer

from assistant.cli.options import (
    CellOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    ProcessOption,
    RobotOption,
    Source,
    UnitOption,
)
from assistant.cli.presentation import Format

reach: Final = typer.Typer(
    help="What an arm reaches, where things stand best, which space a program sweeps.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)
RANGE_FORM: Final = "LOW:HIGH:STEP"
TipOption = Annotated[
    str | None,
    typer.Option(help="x,y,z[,w,x,y,z] of the tip on the flange, mm; default the flange itself."),
]
TurnsOption = Annotated[
    int,
    typer.Option(help="Turns of the tool about its z axis that are tried; 1 if its turn counts."),
]
OutputOption = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", help="File to write: .csv, .npz, .png or .svg; repeatable."),
]
PlacesOption = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", help="File to write: .csv, .png or .svg; repeatable."),
]
GoalsArgument = Annotated[
    str | None,
    typer.Argument(help="Program whose targets are to be reached; default locations of bodies."),
]
FewTurnsOption = Annotated[
    int,
    typer.Option(help="Turns of the tool about its z axis that are tried; default its own alone."),
]
MarginOption = Annotated[
    float | None, typer.Option(help="mm to keep from everything; default those of the cell file.")
]
SweptOption = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", help="File: .csv, .npz, .glb, .png or .svg; repeatable."),
]


@reach.command()
def map_reach(
    robot: RobotOption = None,
    cell: CellOption = None,
    x: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm of the world.")] = None,
    y: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm of the world.")] = None,
    z: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm of the world.")] = None,
    direction: Annotated[
        list[str] | None,
        typer.Option(
            help="Of the tool's z axis: down, up, x,y,z, or with /DEGREES a cone; repeatable."
        ),
    ] = None,
    turns: TurnsOption = 12,
    tip: TipOption = None,
    margin: MarginOption = None,
    output: OutputOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell which part of a region an arm reaches, with which directions of its tool."""
    from assistant.cli.reach_runs import ReachTool, run_map

    ranges = {"x": x, "y": y, "z": z}
    tool = ReachTool(robot, cell, tip, turns, margin)
    raise typer.Exit(run_map(tool, ranges, direction or ["down"], output or (), format))


@reach.command()
def base(
    program: GoalsArgument = None,
    robot: RobotOption = None,
    cell: CellOption = None,
    x: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm from where it is.")] = None,
    y: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm from where it is.")] = None,
    z: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm from where it is.")] = None,
    turn: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="Degrees about z.")] = None,
    turns: FewTurnsOption = 1,
    tip: TipOption = None,
    margin: MarginOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    from_language: FromLanguage = None,
    output: PlacesOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Find where the base of a robot stands best, for targets that stay where they are."""
    from assistant.cli.place_runs import PlaceGoals, run_places
    from assistant.cli.reach_runs import ReachTool

    tool = ReachTool(robot, cell, tip, turns, margin)
    goals = PlaceGoals(program, process, unit, from_language)
    ranges = {"x": x, "y": y, "z": z, "turn": turn}
    raise typer.Exit(run_places(None, tool, goals, ranges, output or (), format))


@reach.command()
def place(
    body: Annotated[str, typer.Argument(help="Body of the cell; what stands on it is moved too.")],
    program: GoalsArgument = None,
    robot: RobotOption = None,
    cell: CellOption = None,
    x: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm from where it is.")] = None,
    y: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm from where it is.")] = None,
    z: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="mm from where it is.")] = None,
    turn: Annotated[str | None, typer.Option(metavar=RANGE_FORM, help="Degrees about z.")] = None,
    turns: FewTurnsOption = 1,
    tip: TipOption = None,
    margin: MarginOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    from_language: FromLanguage = None,
    output: PlacesOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Find where a work piece stands best, for targets that move with it."""
    from assistant.cli.place_runs import PlaceGoals, run_places
    from assistant.cli.reach_runs import ReachTool

    tool = ReachTool(robot, cell, tip, turns, margin)
    goals = PlaceGoals(program, process, unit, from_language)
    ranges = {"x": x, "y": y, "z": z, "turn": turn}
    raise typer.Exit(run_places(body, tool, goals, ranges, output or (), format))


@reach.command()
def swept(
    program: Source,
    robot: RobotOption = None,
    cell: CellOption = None,
    size: Annotated[float, typer.Option(help="How wide the cells of the grid are, mm.")] = 20.0,
    process: ProcessOption = None,
    unit: UnitOption = None,
    from_language: FromLanguage = None,
    entry: EntryOption = None,
    output: SweptOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell which space the arm sweeps in a program, with its tool and what it carries."""
    from assistant.cli.simulating import SimulationOptions
    from assistant.cli.swept_runs import run_swept

    options = SimulationOptions(
        robot, process, unit, from_language, None, None, None, entry=entry, cell=cell
    )
    raise typer.Exit(run_swept(program, options, size, output or (), format))
