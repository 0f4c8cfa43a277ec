"""The commands of `robot-assistant`; each imports what it needs when it runs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Final

import typer

from assistant import __version__
from assistant.cli import (
    deployments,
    on_arms,
    on_blocks,
    on_cells,
    on_controllers,
    on_programs,
    projects,
)
from assistant.cli.answering_sights import answer
from assistant.cli.calibrations import calibrate, poses
from assistant.cli.camera_commands import camera
from assistant.cli.editors import lsp
from assistant.cli.exchanges import exchange
from assistant.cli.explorations import explore
from assistant.cli.gateways import gateway
from assistant.cli.learning_commands import learn
from assistant.cli.object_commands import objects, see
from assistant.cli.options import FormatOption, complete_robot
from assistant.cli.presentation import Format, LengthUnit, answer_as
from assistant.cli.reaching import reach
from assistant.cli.studios import studio
from assistant.cli.virtual_commands import virtual
from assistant.cli.virtual_runs import debug, run

app: Final = typer.Typer(
    help="Drawings, trajectories and robot programs to proven ABB RAPID and MELFA-BASIC.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(virtual, name="virtual")
robots: Final = typer.Typer(
    help="List the robots there are; `show` tells all of one, `calibrate` corrects one.",
    invoke_without_command=True,
    rich_markup_mode=None,
)
app.add_typer(robots, name="robots")
app.add_typer(exchange, name="exchange")
app.add_typer(reach, name="reach")
app.add_typer(explore, name="explore")
app.add_typer(camera, name="camera")
app.add_typer(objects, name="objects")


def _budget(text: str | None) -> None:
    """For this command, and for the processes that it starts."""
    from assistant.program.system.budgets import VARIABLE, factor, factor_of

    if text is not None:
        factor_of(text)
        os.environ[VARIABLE] = text
    factor()  # what the environment states is looked at before anything is done


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"robot-assistant {__version__}")
        raise typer.Exit


@app.callback()
def options(
    _: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
    budget: Annotated[
        str | None,
        typer.Option(
            "--budget",
            metavar="FACTOR",
            help="Times all limits of time, memory and size.",
        ),
    ] = None,
) -> None:
    """Drawings, trajectories and robot programs to proven ABB RAPID and MELFA-BASIC."""
    _budget(budget)


for command in (*on_programs.COMMANDS, *on_cells.COMMANDS, *on_blocks.COMMANDS):
    app.command()(command)
app.command("see")(see)
app.command()(learn)
app.command()(run)
app.command()(debug)
app.command()(lsp)
app.command()(gateway)
app.command()(studio)
app.command()(answer)


for command in (
    *(*projects.COMMANDS, *deployments.COMMANDS),
    *(*on_controllers.COMMANDS, *on_arms.COMMANDS),
):
    minus = {"ignore_unknown_options": True} if command.__name__ in on_arms.NUMBERS else None
    app.command(context_settings=minus)(command)


@robots.callback()
def robots_list(context: typer.Context, format: FormatOption = Format.TEXT) -> None:
    """List the robots of the catalogue; `robots show NAME` tells all of one."""
    from assistant.cli.robots import run_list

    if context.invoked_subcommand is None:
        raise typer.Exit(run_list(format))


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
    from assistant.cli.robots import run_show

    before = context.parent.params["format"] if context.parent else Format.TEXT
    asked = answer_as(format or Format(before))
    raise typer.Exit(run_show(robot, draw, Format(asked)))


@app.command()
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
