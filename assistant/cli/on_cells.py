"""The commands that show programs, drawings and cells; other files carry them out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.options import (
    AccelerationOption,
    AskAtOption,
    CellOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    FromRobot,
    MarkOption,
    OpenOption,
    PageOption,
    PlaceOption,
    ProcessOption,
    RobotOption,
    SeenOption,
    Source,
    UnitOption,
    placement_of,
)
from assistant.cli.presentation import Format


def simulate(
    program: Source,
    robot: RobotOption = None,
    output: Annotated[
        list[str] | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder for all files, or a .csv, .npz, .png or .svg; repeatable.",
        ),
    ] = None,
    acceleration: AccelerationOption = None,
    period: Annotated[
        float | None, typer.Option(help="Seconds between samples; default 0.01, or what fits.")
    ] = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    cell: CellOption = None,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    seen: SeenOption = None,
    ask_at: AskAtOption = None,
    report: PageOption = None,
    opened: OpenOption = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell how long a program takes on a robot, and write its motion over time. Nothing moves."""
    from assistant.cli.pages import PageRequest
    from assistant.cli.sheets import simulated_page
    from assistant.cli.simulating import SimulationOptions, run_simulate
    from assistant.sources.sights import seeing

    options = SimulationOptions(
        robot,
        process,
        unit,
        from_language,
        from_robot,
        acceleration,
        period,
        entry,
        cell,
        placement_of(place, marks),
        seeing(seen, ask_at),
    )
    page = simulated_page(PageRequest(report, opened))
    raise typer.Exit(run_simulate(program, options, output or (), format, page))


def view(
    program: Source,
    robot: RobotOption = None,
    cell: CellOption = None,
    html: Annotated[
        Path | None,
        typer.Option(help="File for the page, which needs no other; default it is opened."),
    ] = None,
    live: Annotated[
        str | None,
        typer.Option(
            help="Controller that the page follows until Ctrl-C; it is only looked at.",
            metavar="CONTROLLER",
        ),
    ] = None,
    acceleration: AccelerationOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    place: PlaceOption = None,
    marks: MarkOption = None,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Show a program in its cell: arm, bodies, path and contacts over time. Nothing moves."""
    from assistant.cli.simulating import SimulationOptions
    from assistant.cli.viewing import run_view

    options = SimulationOptions(
        robot,
        process,
        unit,
        from_language,
        from_robot,
        acceleration,
        None,
        entry,
        cell,
        placement_of(place, marks),
    )
    raise typer.Exit(run_view(program, options, html, format, live))


def info(
    drawing: Annotated[Path, typer.Argument(help="A DXF drawing.")],
    process: ProcessOption = None,
    unit: UnitOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell what is in a drawing: unit, size, layers, contours, blocks, and what would be used."""
    from assistant.cli.drawings import run_info

    raise typer.Exit(run_info(drawing, process, unit, format))


def scene(
    file: Annotated[Path, typer.Argument(help="Cell file, or a drawing of the cell.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Cell file (.toml) or glTF (.glb) to write instead."),
    ] = None,
    unit: UnitOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell what stands in a cell, body by body, or write it as another file."""
    from assistant.cli.scenes import run_scene

    raise typer.Exit(run_scene(file, unit, output, format))
