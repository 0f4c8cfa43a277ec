"""The commands that serve a virtual controller: `virtual irc5` and `virtual cr`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final, Literal

import typer

from assistant.cli.options import complete_robot

virtual: Final = typer.Typer(
    help="Run a virtual controller on this computer.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)


class Framing(StrEnum):
    """Of a serial line."""

    PLAIN = "plain"
    PROCEDURAL = "procedural"
    DATA_LINK = "data-link"


FRAMINGS: Final[dict[Framing, Literal["plain", "procedural", "data link"]]] = {
    Framing.PLAIN: "plain",
    Framing.PROCEDURAL: "procedural",
    Framing.DATA_LINK: "data link",
}


@virtual.command("irc5")
def virtual_irc5(
    folder: Annotated[Path, typer.Option(help="Folder that is its HOME:.")] = Path("home"),
    port: Annotated[int, typer.Option(help="FTP port here; 0 takes a free one.")] = 2121,
    user: Annotated[str, typer.Option(help="Its user.")] = "robot",
    robot: Annotated[
        str, typer.Option("--robot", "-r", help="Its arm.", autocompletion=complete_robot)
    ] = "irb1200-7-0.7",
    rws_port: Annotated[
        int, typer.Option(help="Port of Robot Web Services 1.0; 0 takes a free one.")
    ] = 0,
    rwss_port: Annotated[
        int, typer.Option(help="Port of Robot Web Services 2.0; 0 takes a free one.")
    ] = 0,
    signal: Annotated[
        list[str] | None,
        typer.Option(help="A signal of its I/O configuration, as do_grip=DO; repeatable."),
    ] = None,
    egm: Annotated[
        list[str] | None,
        typer.Option(
            help="A UdpUc device of EGM and where it sends to, as UCdevice=127.0.0.1:6510;"
            " repeatable."
        ),
    ] = None,
    manual: Annotated[bool, typer.Option("--manual", help="Begin in manual mode.")] = False,
    grant: Annotated[
        bool, typer.Option("--grant", help="Let whoever asks modify in manual mode.")
    ] = False,
    pace: Annotated[float, typer.Option(help="Simulated seconds for each real one.", min=0.01)] = 1,
    delay: Annotated[
        float, typer.Option(help="Seconds before each answer of Robot Web Services.", min=0.0)
    ] = 0.0,
) -> None:
    """A virtual IRC5: FTP and Robot Web Services over a folder, programs that run in real time."""
    from assistant.cli.virtual import run_irc5

    ports = (port, rws_port, rwss_port)
    run_irc5(
        folder,
        user,
        robot,
        ports,
        signal or [],
        egm or [],
        mode="MANR" if manual else "AUTO",
        grants=grant,
        pace=pace,
        delay=delay,
    )


@virtual.command("cr")
def virtual_cr(
    robot: Annotated[
        str, typer.Option("--robot", "-r", help="Its arm.", autocompletion=complete_robot)
    ] = "rv-2aj",
    port: Annotated[
        int,
        typer.Option(
            help="Controller-link port on this computer; 0 takes a free one.", min=0, max=65535
        ),
    ] = 10001,
    folder: Annotated[
        Path | None, typer.Option(help="Folder of its programs; in memory if left out.")
    ] = None,
    data_port: Annotated[
        int,
        typer.Option(
            help="Port of the line OPT11; those of the data link follow, COM2: at the next one. "
            "0 takes free ones.",
            min=0,
            max=65500,
        ),
    ] = 0,
    mxt_port: Annotated[
        int,
        typer.Option(
            help="UDP port of real-time external control; 0 takes a free one.", min=0, max=65535
        ),
    ] = 10000,
    serial: Annotated[
        str | None,
        typer.Option(
            help="A serial port to serve too, `pty` to make a line, or `pty:FILE` to make one that"
            " clients find by that name.",
            metavar="PORT",
        ),
    ] = None,
    framing: Annotated[Framing, typer.Option(help="Of the serial line.")] = Framing.PLAIN,
    line: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=TARGET",
            help="What a line of its programs leads to, as COM1=10003: a port for others to call,"
            " the HOST:PORT of a server, the path of a serial port, or `pty:FILE` to make one;"
            " repeatable.",
        ),
    ] = None,
    pace: Annotated[float, typer.Option(help="Simulated seconds for each real one.", min=0.01)] = 1,
    delay: Annotated[float, typer.Option(help="Seconds before each answer.", min=0.0)] = 0.0,
    broken: Annotated[
        int, typer.Option(help="How many characters apart one comes broken.", min=0)
    ] = 0,
    refuse: Annotated[
        list[str] | None,
        typer.Option(help="A command it refuses, with the error, as SRVON=5600; repeatable."),
    ] = None,
    contact: Annotated[
        str | None,
        typer.Option(help="Input that is on while the arm touches something of --cell."),
    ] = None,
    cell: Annotated[
        Path | None, typer.Option("--cell", help="File of the cell that the arm is in.")
    ] = None,
    log: Annotated[bool, typer.Option("--log", help="Print each command and answer.")] = False,
) -> None:
    """A virtual CR controller: controller link, data link, programs that run in real time."""
    from assistant.cli.virtual import run_cr
    from assistant.virtual.cr import Faults

    faults = Faults(delay=delay, broken=broken)
    run_cr(
        robot,
        faults,
        refuse or [],
        port=port,
        folder=folder,
        data_port=data_port,
        mxt_port=mxt_port,
        serial=serial or False,
        framing=FRAMINGS[framing],
        lines=line or [],
        pace=pace,
        contact=contact,
        cell=cell,
        log=log,
    )
