"""The commands of known objects, `see` and `objects …`; `objects.py` carries them out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

import typer

from assistant.cli.options import CellOption, FormatOption, UnitOption
from assistant.cli.presentation import Format

objects: Final = typer.Typer(
    help="Learn objects by their drawings or by showing them; list those of a library.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)
LibraryArgument = Annotated[Path, typer.Argument(metavar="LIBRARY", help="Folder of the library.")]
CamerasOption = Annotated[
    Path | None, typer.Option("--cameras", help="File of the cameras, .toml.")
]
PlaneOption = Annotated[
    float, typer.Option("--plane", help="Height of what objects lie on, mm in the world.")
]
RobotOfCellOption = Annotated[
    str | None, typer.Option("--robot", "-r", help="Its name in the cell, if there are several.")
]


@objects.command()
def add(
    library: LibraryArgument,
    name: Annotated[str, typer.Argument(help="How the object is called.")],
    files: Annotated[
        list[str], typer.Argument(help="Its drawing, .dxf, or pictures: FILE or CAMERA=FILE.")
    ],
    contour: Annotated[
        str | None, typer.Option(help="Layer of the outline; default the one with closed contours.")
    ] = None,
    line: Annotated[
        list[str] | None,
        typer.Option("--line", help="Layer whose curves are ways on the part; repeatable."),
    ] = None,
    width: Annotated[
        float | None, typer.Option(help="mm that the face is wide which fills the first picture.")
    ] = None,
    height: Annotated[
        float | None, typer.Option(help="mm of the face above what the part lies on.", min=0.0)
    ] = None,
    cameras: CamerasOption = None,
    plane: PlaneOption = 0.0,
    solid: Annotated[
        bool, typer.Option("--solid", help="It is not flat: marks in space, by two cameras.")
    ] = False,
    unit: UnitOption = None,
    again: Annotated[bool, typer.Option("--again", help="Replace one of that name.")] = False,
    format: FormatOption = Format.TEXT,
) -> None:
    """Learn an object: by its drawing, by pictures of its face, or as it lies before cameras."""
    from assistant.cli.objects import AddOptions, run_add

    asked = AddOptions(
        *(library, name, tuple(files), contour, tuple(line or ()), width, height),
        *(cameras, plane, solid, unit, again),
    )
    raise typer.Exit(run_add(asked, format))


@objects.command("list")
def list_(library: LibraryArgument, format: FormatOption = Format.TEXT) -> None:
    """List the objects of a library: what they are known by, and what is done on them."""
    from assistant.cli.objects import run_list

    raise typer.Exit(run_list(library, format))


def see(
    cameras: Annotated[Path, typer.Option("--cameras", help="File of the cameras, .toml.")],
    library: Annotated[Path, typer.Option("--objects", help="Folder of the library.")],
    images: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="IMAGES", help="A picture of each camera: FILE or CAMERA=FILE; default theirs."
        ),
    ] = None,
    to: Annotated[
        Path | None, typer.Option("--to", help="Taught targets to write, .toml: what is done.")
    ] = None,
    found: Annotated[
        Path | None, typer.Option("--found", help="File to write, .toml: where objects are.")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option("--draw", help="The picture with what was found, .png.")
    ] = None,
    plane: PlaneOption = 0.0,
    plane_sigma: Annotated[
        float, typer.Option(help="mm, one sigma, that the plane may be off.", min=0.001)
    ] = 0.05,
    cell: CellOption = None,
    robot: RobotOfCellOption = None,
    joints: Annotated[
        str | None,
        typer.Option(help="Where the arm was that carries a camera: degrees with commas."),
    ] = None,
    expect: Annotated[
        list[str] | None, typer.Option(help="An object that has to be there; repeatable.")
    ] = None,
    most_mm: Annotated[
        float, typer.Option(help="mm, one sigma, that an object may be unsure by.", min=0.001)
    ] = 1.0,
    most_deg: Annotated[
        float, typer.Option(help="Degrees, one sigma, that it may be unsure by.", min=0.001)
    ] = 1.0,
    format: FormatOption = Format.TEXT,
) -> None:
    """Find known objects in pictures; what is done on them becomes targets. Nothing moves."""
    from assistant.cli.objects import SeeOptions, run_see

    asked = SeeOptions(
        *(cameras, library, tuple(images or ()), to, found, picture, plane, plane_sigma),
        *(cell, robot, joints, tuple(expect or ()), most_mm, most_deg),
    )
    raise typer.Exit(run_see(asked, format))
