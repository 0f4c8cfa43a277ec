"""`studio`: one window for a project, served to the browser until Ctrl-C."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Annotated

import typer

from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format

if TYPE_CHECKING:
    from assistant.studio.studio import Studio


def studio(
    project: Annotated[
        Path, typer.Argument(metavar="[PROJECT]", help="Its folder; default this one.")
    ] = Path(),
    host: Annotated[
        str | None,
        typer.Option(help="Address by which others open it, encrypted; default nobody else can."),
    ] = None,
    port: Annotated[
        int, typer.Option(help="Port; default one that is free.", min=0, max=65535)
    ] = 0,
    open: Annotated[bool, typer.Option("--open/--no-open", help="Open the browser.")] = True,
    format: FormatOption = Format.TEXT,
) -> None:
    """Open the studio: drawing, program, cell and controller in one window of the browser."""
    raise typer.Exit(run_studio(project, host, port, open, format))


def run_studio(project: Path, host: str | None, port: int, opened: bool, format: Format) -> int:
    from assistant.base.termination import is_ctrl_c, raise_on_termination, wait_for_termination
    from assistant.cli.presentation import print_findings, print_json, say
    from assistant.studio.server import serving

    studio: Studio | None = None
    try:
        with raise_on_termination() as ending, serving(project, host, port) as served:
            studio = served.studio
            if format is Format.JSON:
                print_json({"folder": str(served.studio.folder), "address": served.address})
            else:
                say(f"studio of {served.studio.folder}, listening on {served.address} until Ctrl-C")
            sys.stdout.flush()
            if opened:  # a browser of the terminal would come back only when it is closed
                Thread(target=webbrowser.open, args=(served.address,), daemon=True).start()
            try:
                wait_for_termination()
            finally:
                ending.hold()  # an arm is let go of, whatever else comes
    except KeyboardInterrupt as caught:
        left_on = () if studio is None else studio.left_on
        print_findings(left_on)
        if not is_ctrl_c(caught):
            raise
        return 1 if left_on else 0
    return 0
