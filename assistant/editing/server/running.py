"""The language server over pipes, or for one editor over a line of this computer."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable
from typing import Final

from pygls.io_ import run_async

from assistant.base.diagnostics import Refused
from assistant.editing import rules
from assistant.editing.server.features import server_with_features

LOOPBACK: Final = "127.0.0.1"
_BEGIN: Final = b"Content-"
"""What every message of the protocol begins with; a browser's request does not."""


def serve_pipes(version: str) -> None:
    """Until the editor says exit or closes the pipes."""
    server_with_features(version).start_io()


def serve_line(version: str, port: int, listening: Callable[[int], None]) -> None:
    """One editor that connects to a port of this computer; 0 takes a free one.

    listening: is told the port. Raises Refused where it cannot be listened on.
    """
    asyncio.run(_serve_line(version, port, listening))


async def _serve_line(version: str, port: int, listening: Callable[[int], None]) -> None:
    server, left = server_with_features(version), asyncio.Event()
    stop = threading.Event()
    taken = False

    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal taken
        if taken:
            writer.close()
            return
        try:
            first = await reader.readexactly(len(_BEGIN))
        except (asyncio.IncompleteReadError, OSError):
            writer.close()
            return
        if first != _BEGIN or taken:
            writer.close()
            return
        taken = True
        server.protocol.set_writer(writer)
        try:
            await run_async(
                stop_event=stop,
                reader=_Begun(first, reader),
                protocol=server.protocol,
                logger=logging.getLogger(__name__),
                error_handler=server.report_server_error,
            )
        finally:
            left.set()

    try:
        listener = await asyncio.start_server(connected, LOOPBACK, port)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Refused(rules.NOT_BOUND(port=port, reason=reason), exit_status=2) from None
    async with listener:
        listening(listener.sockets[0].getsockname()[1])
        await left.wait()


class _Begun:
    """A stream of which the first bytes were read."""

    def __init__(self, first: bytes, rest: asyncio.StreamReader) -> None:
        self._first, self._rest = first, rest

    async def readline(self) -> bytes:
        first, self._first = self._first, b""
        return first + await self._rest.readline()

    async def readexactly(self, n: int) -> bytes:
        return await self._rest.readexactly(n)
