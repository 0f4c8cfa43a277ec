"""The commands that write code and blocks for models of other tools; other files carry them out."""

from __future__ import annotations

import enum
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Final

import typer

from assistant.cli.options import FormatOption, complete_robot
from assistant.cli.presentation import Format


class SourceLanguage(enum.StrEnum):
    C = "c"
    PYTHON = "python"


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


COMMANDS: Final[tuple[Callable[..., None], ...]] = (kinematics,)
"""In the order of the help."""
