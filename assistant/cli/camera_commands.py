"""The commands of cameras, `camera …`; `cameras.py` carries them out."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final

import typer

from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format

camera: Final = typer.Typer(
    help="Calibrate, look through and check cameras; draw what they would see of a cell.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)
CamerasArgument = Annotated[
    Path, typer.Argument(metavar="CAMERAS", help="File of the cameras, .toml.")
]
BoardOption = Annotated[
    str, typer.Option("--board", help="`chessboard 9x6 25` or `charuco 7x5 40 30`: mm.")
]


class MountingChoice(StrEnum):
    """Where a camera is that an arm calibrates."""

    HAND = "hand"
    STAND = "stand"


class DrawnThing(StrEnum):
    """What is shown to drawn cameras."""

    BALL = "ball"
    WAND = "wand"
    BOARD = "board"


@camera.command()
def calibrate(
    pictures: Annotated[
        list[str],
        typer.Argument(metavar="NAME=FOLDER", help="A camera and its pictures of the board."),
    ],
    board: BoardOption,
    output: Annotated[Path, typer.Option("--output", "-o", help="File of the cameras, .toml.")],
    poses: Annotated[
        Path | None,
        typer.Option(help="Table of the poses of the flange, a row a picture: CSV, NPY, JSON."),
    ] = None,
    mounting: Annotated[
        MountingChoice,
        typer.Option(help="With --poses: the first camera is in the hand, or stands."),
    ] = MountingChoice.STAND,
    flange: Annotated[
        str, typer.Option(help="How the cell calls the flange that carries the camera.")
    ] = "flange",
    format: FormatOption = Format.TEXT,
) -> None:
    """Find lenses from pictures of a board, and where the cameras stand."""
    from assistant.cli.cameras import run_calibrate

    raise typer.Exit(run_calibrate(pictures, board, output, poses, mounting.value, flange, format))


@camera.command()
def view(
    cameras: CamerasArgument,
    name: Annotated[str, typer.Argument(help="Of the camera.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write, .png.")],
    source: Annotated[
        str | None, typer.Option(help="Device, stream, file or folder instead of the file's.")
    ] = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Write what a camera sees, with the axes of the frame that it stands in drawn over it."""
    from assistant.cli.cameras import run_view

    raise typer.Exit(run_view(cameras, name, output, source, format))


@camera.command()
def check(
    cameras: CamerasArgument,
    board: Annotated[
        str | None,
        typer.Option("--board", help="A board that all of them see now: whether they agree."),
    ] = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Look whether cameras give pictures that are good enough, and whether they agree."""
    from assistant.cli.cameras import run_check

    raise typer.Exit(run_check(cameras, board, format))


@camera.command()
def draw(
    cameras: CamerasArgument,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder; a folder of pictures each camera.")
    ],
    cell: Annotated[Path | None, typer.Option(help="Cell file of what else is seen.")] = None,
    show: Annotated[DrawnThing, typer.Option(help="What is shown.")] = DrawnThing.WAND,
    at: Annotated[
        Path | None,
        typer.Option(help="Table of the poses at which it is shown, a row a picture."),
    ] = None,
    poses: Annotated[
        Path | None,
        typer.Option(help="Table of poses of the flange that carries cameras, a row a picture."),
    ] = None,
    board: Annotated[
        str, typer.Option("--board", help="With --show board: which one.")
    ] = "charuco 7x5 40 30",
    noise: Annotated[float, typer.Option(help="Grey levels, one sigma.", min=0.0)] = 2.0,
    seed: Annotated[int, typer.Option(help="Of the noise.", min=0)] = 0,
    format: FormatOption = Format.TEXT,
) -> None:
    """Draw what cameras would see: to try all of it without a camera."""
    from assistant.cli.camera_drawing import run_draw

    shown = None if at is None else (show.value, at, board)
    raise typer.Exit(run_draw(cameras, output, cell, shown, poses, noise, seed, format))
