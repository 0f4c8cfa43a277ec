"""The command `demo`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.presentation import LengthUnit


def demo(
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for what it makes.")
    ] = Path("out/demo"),
    unit: Annotated[
        LengthUnit, typer.Option(help="Unit of the positions that are drawn.")
    ] = LengthUnit.MM,
) -> None:
    """A drawing and a trajectory to programs on two embedded virtual controllers, with a report."""
    from assistant.cli.demo import run_demo

    raise typer.Exit(run_demo(output, unit.value))
