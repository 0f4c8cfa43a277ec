"""`learn`: a map from pictures to joints; `learning.py` carries it out."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.options import FormatOption, complete_robot
from assistant.cli.presentation import Format


class ToolHold(StrEnum):
    """How the tool is held in a box; `free` leaves its orientation open."""

    DOWN = "down"
    FORWARD = "forward"
    FREE = "free"


def learn(
    robot: Annotated[
        str,
        typer.Argument(
            help="A robot of the catalogue, or a robot file.", autocompletion=complete_robot
        ),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Map to write, .npz.")],
    steps: Annotated[
        int, typer.Option(help="Targets that are tried.", min=1, max=1_000_000)
    ] = 30_000,
    hold: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT=DEGREES", help="Joint that stays; repeatable."),
    ] = None,
    range: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOINT=LOW:HIGH",
            help="Degrees between which a joint learns; default 25 about its home; repeatable.",
        ),
    ] = None,
    box: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z", help="Targets in a box of the base, mm, each of them LOW:HIGH."
        ),
    ] = None,
    tool: Annotated[
        ToolHold | None,
        typer.Option(
            help="How the tool is held in the box; free: only its place is learnt, and the "
            "posture nearest to the middle of the ranges."
        ),
    ] = None,
    turn: Annotated[
        str, typer.Option(metavar="LOW:HIGH", help="Degrees of the held tool about its axis.")
    ] = "0:0",
    point: Annotated[
        list[str] | None,
        typer.Option(
            metavar="X,Y,Z",
            help="Point of the tool that is seen, mm on the flange; repeatable.",
        ),
    ] = None,
    cameras: Annotated[
        Path | None,
        typer.Option(help="File of cameras that stand about the base; default a pair is put up."),
    ] = None,
    lattice: Annotated[
        str | None, typer.Option(metavar="7x12x4", help="Units along each axis of the lattice.")
    ] = None,
    noise: Annotated[
        float, typer.Option(help="Pixels of noise, one sigma.", min=0.0, max=100.0)
    ] = 0.0,
    seed: Annotated[int, typer.Option(help="Of what is random.", min=0)] = 0,
    go_on: Annotated[
        Path | None, typer.Option("--go-on", help="Map that goes on learning, .npz.")
    ] = None,
    longer: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LENGTH=FACTOR",
            help="Link that is longer than the robot file says; repeatable.",
        ),
    ] = None,
    recorded: Annotated[
        list[Path] | None,
        typer.Option(
            help="Learn from where an arm was: log of `explore`, `servo` or `monitor`; repeatable.",
            metavar="LOG.csv",
        ),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="Draw the lattice at several stages, .png or .svg.")
    ] = None,
    curve: Annotated[
        Path | None, typer.Option(help="Errors over the steps, .csv, .png or .svg.")
    ] = None,
    rivals: Annotated[
        bool, typer.Option("--rivals", help="Beside a calibrated pair of cameras and a regression.")
    ] = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Learn from two cameras which joints reach what they see, on this computer. Nothing moves."""
    from assistant.cli.learning import LearnOutputs, run_learn
    from assistant.cli.learning_words import LearnOptions

    held = "any" if tool is None else tool.value
    options = LearnOptions(
        *(robot, steps, hold or (), range or (), box, held, turn, point or (), cameras),
        *(lattice, noise, seed, go_on, longer or (), rivals, format, recorded or ()),
    )
    raise typer.Exit(run_learn(options, LearnOutputs(output, picture, curve)))
