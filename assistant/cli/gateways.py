"""`gateway`: hands bytes on to a line of a controller until Ctrl-C."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated, Final

import typer

from assistant.base.diagnostics import Refused, error
from assistant.base.termination import is_ctrl_c
from assistant.cli.presentation import say

if TYPE_CHECKING:
    from assistant.controllers.gateway import Gateway

NOT_AN_ADDRESS: Final = error(
    "CL291", "`{text}` is no address with a port", "write it as 192.168.0.20:10003"
)
NOT_STARTED: Final = error(
    "CL292", "the gateway cannot listen at port {port}: {reason}", "name another port"
)
NO_CONNECTION_LINE: Final = error(
    "CL293",
    "the gateway connects to one place, but {named}",
    "name the controller's line, or with `--to` the other end of a line that connects to here",
)
PORTS: Final = range(1, 65536)


def gateway(
    line: Annotated[
        str,
        typer.Argument(
            help="The controller's line that waits for a connection, as 192.168.0.20:11002."
        ),
    ] = "",
    listen: Annotated[
        int,
        typer.Option(
            help="Port here: of the other end, or with --to of the line; 0 for any free one.",
            min=0,
            max=PORTS.stop - 1,
        ),
    ] = 0,
    to: Annotated[
        str,
        typer.Option(
            help="The other end, for a line that connects to this computer.", metavar="HOST:PORT"
        ),
    ] = "",
    host: Annotated[
        str, typer.Option(help="Address of this computer to listen at; default all of them.")
    ] = "",
) -> None:
    """Hand bytes on between a socket and a controller whose lines carry texts alone."""
    if bool(line) == bool(to):
        named = f"`{line}` and `{to}` are named" if line else "none is named"
        raise Refused(NO_CONNECTION_LINE(named=named), exit_status=2)
    raise typer.Exit(run_gateway((host, listen), _host_and_port(line or to), bool(to)))


def _host_and_port(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or int(port) not in PORTS:
        raise Refused(NOT_AN_ADDRESS(text=text), exit_status=2)
    return host, int(port)


def run_gateway(at: tuple[str, int], to: tuple[str, int], for_controller: bool) -> int:
    """at: where it listens. to: what it connects to. for_controller: who connects is one."""
    import asyncio

    from assistant.controllers.gateway import Gateway

    gateway = Gateway(at, to, for_controller=for_controller)
    gateway.report = _print_flushed
    try:
        asyncio.run(_serve_gateway(gateway))
    except OSError as failed:
        reason = failed.strerror or str(failed)
        raise Refused(NOT_STARTED(port=at[1], reason=reason)) from None
    except KeyboardInterrupt as caught:
        say("ended")
        if not is_ctrl_c(caught):
            raise
    return 0


async def _serve_gateway(gateway: Gateway) -> None:
    server = await gateway.start()
    _print_flushed(f"listens at port {gateway.at[1]}; end it with Ctrl-C")
    async with server:
        await server.serve_forever()


def _print_flushed(line: str) -> None:
    say(line)
    sys.stdout.flush()
