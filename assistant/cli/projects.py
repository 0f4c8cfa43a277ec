"""The commands of a project as a whole: `init` and `build`; `check` without files is one more."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.options import (
    DropEditOption,
    FindingFormatOption,
    KeepEditOption,
    OverwriteOption,
    UnitOption,
)
from assistant.cli.presentation import FindingFormat

JobsOption = Annotated[
    int | None,
    typer.Option("--jobs", "-j", min=1, help="Processes at a time; default one a processor."),
]


def build(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME", help="Programs or targets of assistant.toml."),
    ] = None,
    jobs: JobsOption = None,
    anew: Annotated[
        bool, typer.Option("--anew", help="Also what has not changed since the last build.")
    ] = False,
    overwrite: OverwriteOption = False,
    keep_edit: KeepEditOption = None,
    drop_edit: DropEditOption = None,
    format: FindingFormatOption = FindingFormat.TEXT,
) -> None:
    """Compile the programs of the project for its targets, into build/TARGET/."""
    from assistant.cli.building import run_build
    from assistant.compiler.merge_edits import MergeChoices

    wishes = MergeChoices.of(overwrite, keep_edit or (), drop_edit or ())
    raise typer.Exit(run_build(names or (), jobs, anew, format, wishes))


def init(
    paths: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[FOLDER] [DRAWING]...",
            help="Folder of the project, made if it is missing; drawings that it is to work.",
        ),
    ] = None,
    unit: UnitOption = None,
) -> None:
    """Start a project: an example or your drawings, and files for git, pre-commit and CI."""
    from assistant.cli.building import run_init

    raise typer.Exit(run_init(paths or (), unit))
