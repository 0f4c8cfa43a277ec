"""`studio`: one window for a project, served to the browser until Ctrl-C."""

from __future__ import annotations

import sys
import time
import webbrowser
from pathlib import Path
from threading import Thread
from typing import Annotated, Final

import typer

from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format

LOOKS: Final = 3600.0
"""Seconds between two looks at nothing, while the studio is served."""


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
    from assistant.cli.presentation import print_json, say
    from assistant.program.system.ending import by_hand
    from assistant.studio.server import serving

    try:
        with serving(project, host, port) as served:
            if format is Format.JSON:
                print_json({"folder": str(served.studio.folder), "address": served.address})
            else:
                say(f"studio of {served.studio.folder}, listening on {served.address} until Ctrl-C")
            sys.stdout.flush()
            if opened:  # a browser of the terminal would come back only when it is closed
                Thread(target=webbrowser.open, args=(served.address,), daemon=True).start()
            while True:
                time.sleep(LOOKS)
    except KeyboardInterrupt as caught:
        if not by_hand(caught):
            raise
    return 0
