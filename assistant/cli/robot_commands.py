"""The commands about robots: their list, all of one, and what corrects one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

import typer

from assistant.cli.calibrations import calibrate, poses
from assistant.cli.options import FormatOption, complete_robot
from assistant.cli.presentation import Format, answer_as

robots: Final = typer.Typer(
    help="List the robots there are; `show` tells all of one, `calibrate` corrects one.",
    invoke_without_command=True,
    rich_markup_mode=None,
    add_completion=False,
)


@robots.callback()
def robots_list(context: typer.Context, format: FormatOption = Format.TEXT) -> None:
    """List the robots of the catalogue; `robots show NAME` tells all of one."""
    from assistant.cli.robots import list_robots

    if context.invoked_subcommand is None:
        raise typer.Exit(list_robots(format))


robots.command("calibrate")(calibrate)
robots.command("poses")(poses)


@robots.command("show")
def robots_show(
    context: typer.Context,
    robot: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="A robot of the catalogue, or a robot file.",
            autocompletion=complete_robot,
        ),
    ],
    draw: Annotated[
        Path | None,
        typer.Option(help="Draw the arm as well: FILE.png or FILE.svg.", metavar="FILE"),
    ] = None,
    format: Annotated[
        Format | None, typer.Option("--format", help="For people or for programs.")
    ] = None,
) -> None:
    """Print the data of a robot with their source, and draw it."""
    from assistant.cli.robots import show_robot

    before = context.parent.params["format"] if context.parent else Format.TEXT
    asked = answer_as(format or Format(before))
    raise typer.Exit(show_robot(robot, draw, Format(asked)))
