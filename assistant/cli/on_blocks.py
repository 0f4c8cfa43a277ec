"""The commands that write code and blocks for models of other tools; other files carry them out."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.options import (
    AccelerationOption,
    CellOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    FromRobot,
    ProcessOption,
    RobotOption,
    UnitOption,
    complete_robot,
)
from assistant.cli.presentation import Format


class SourceLanguage(enum.StrEnum):
    C = "c"
    PYTHON = "python"


class FmuKind(enum.StrEnum):
    ARM = "arm"
    PROGRAM = "program"
    LIVE = "live"


def kinematics(
    robot: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT",
            help="A robot of the catalogue, or a robot file.",
            autocompletion=complete_robot,
        ),
    ],
    language: Annotated[
        SourceLanguage, typer.Option("--language", "-l", help="Of the source.")
    ] = SourceLanguage.C,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the source.")] = Path(
        "out"
    ),
    format: FormatOption = Format.TEXT,
) -> None:
    """Write the kinematics of an arm as source that needs nothing else, with a check of it."""
    from assistant.cli.generating import run_kinematics

    raise typer.Exit(run_kinematics(robot, language.value, output, format))


def fmu(
    source: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT|PROGRAM",
            help="Arm to simulate, of the catalogue or by its file, or a program.",
            autocompletion=complete_robot,
        ),
    ],
    robot: RobotOption = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.fmu", help="Default out/NAME.fmu."),
    ] = None,
    kind: Annotated[
        FmuKind | None, typer.Option(help="What it is of; default what the source tells.")
    ] = None,
    lag: Annotated[
        float,
        typer.Option(min=0.0, max=3600.0, help="Of an arm: seconds by which its joints follow."),
    ] = 0.0,
    period: Annotated[
        float | None,
        typer.Option(help="Of a program: seconds between rows; default 0.002, or what fits."),
    ] = None,
    cycle: Annotated[
        float | None,
        typer.Option(help="Of a live controller: seconds; default those of the arm's controller."),
    ] = None,
    all_platforms: Annotated[
        bool, typer.Option("--all-platforms", help="Also for systems that a compiler is here for.")
    ] = False,
    acceleration: AccelerationOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    cell: CellOption = None,
    from_language: FromLanguage = None,
    from_robot: FromRobot = None,
    entry: EntryOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Write an arm, a program's motion or a live controller as an FMU for Simulink and others."""
    from assistant.cli.generating import FmuOptions, run_fmu
    from assistant.cli.simulating import SimulationOptions

    given = (robot, process, unit, from_language, from_robot, acceleration, period, entry, cell)
    named = None if kind is None else kind.value
    wanted = FmuOptions(source, output, named, lag, cycle, all_platforms, SimulationOptions(*given))
    raise typer.Exit(run_fmu(wanted, format))
