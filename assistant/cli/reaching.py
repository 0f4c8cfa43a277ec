"""`reach`: what an arm reaches, where things stand best; `reach_runs.py` carries it out."""

from __future__ import annotations

from typing import Annotated, Final

import typer

from assistant.cli.options import CellOption, FormatOption, RobotOption
from assistant.cli.presentation import Format

reach: Final = typer.Typer(
    help="What an arm reaches, where things stand best, which space a program sweeps.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
RANGE: Final = "LOW:HIGH:STEP"
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
MarginOption = Annotated[
    float | None, typer.Option(help="mm to keep from everything; default those of the cell file.")
]


@reach.command()
def map(
    robot: RobotOption = None,
    cell: CellOption = None,
    x: Annotated[str | None, typer.Option(metavar=RANGE, help="mm of the world.")] = None,
    y: Annotated[str | None, typer.Option(metavar=RANGE, help="mm of the world.")] = None,
    z: Annotated[str | None, typer.Option(metavar=RANGE, help="mm of the world.")] = None,
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
    from assistant.cli.reach_runs import Tool, run_map

    ranges = {"x": x, "y": y, "z": z}
    tool = Tool(robot, cell, tip, turns, margin)
    raise typer.Exit(run_map(tool, ranges, direction or ["down"], output or (), format))
