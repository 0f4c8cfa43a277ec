"""`lsp`: what editors ask about programs, over the Language Server Protocol."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from assistant.cli.presentation import say


def lsp(
    tcp: Annotated[
        int | None,
        typer.Option(
            "--tcp",
            metavar="PORT",
            min=0,
            max=65535,
            help="Listen for one editor on this computer instead of pipes; 0 takes a free port.",
        ),
    ] = None,
    extension: Annotated[
        Path | None,
        typer.Option(
            "--extension",
            metavar="FILE",
            help="Write the extension for VS Code, FILE.vsix, and end.",
            dir_okay=False,
        ),
    ] = None,
) -> None:
    """Answer an editor over the Language Server Protocol; see docs/editors.md."""
    raise typer.Exit(run_lsp(tcp) if extension is None else run_extension(extension))


def run_lsp(tcp: int | None) -> int:
    """0 when the editor has left. Raises Refused without the library, or for a port in use."""
    from assistant import __version__
    from assistant.base.diagnostics import Refused
    from assistant.editing import symbols

    try:
        from assistant.editing.language_server import serve_line, serve_pipes
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in ("pygls", "lsprotocol"):
            raise
        raise Refused(symbols.NO_LIBRARY(name="pygls"), exit_status=2) from None
    if tcp is None:
        serve_pipes(__version__)
    else:
        serve_line(__version__, tcp, lambda port: say(f"listening on 127.0.0.1:{port}"))
    return 0


def run_extension(file: Path) -> int:
    """0 when the file is there. Raises Refused where it cannot be written."""
    from assistant import __version__
    from assistant.base.file_sets import write_files
    from assistant.editing.vscode.extension import packed

    (path,) = write_files({file.name: packed(__version__)}, file.parent)
    say(f"wrote {path}")
    return 0
