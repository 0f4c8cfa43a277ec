"""A gateway: relays bytes between any program and a controller whose lines carry texts alone.

The requests of a program on the controller, and the answers to it, are texts that end with a
carriage return:

    GATEWAY 1                the same: both speak the words below
    W<hex>                   nothing: send these bytes after those before
    S                        K when they are sent, C if the other end has closed
    A <least> <most> <ms>    B<count> in four hexadecimal digits once at least so many bytes have
                             come, most of them at most; T if that takes more milliseconds than
                             that, 99999000 being for ever; C if the other end has closed before
    G                        D<hex>: the next 50 of these bytes, or fewer
    P                        B<count>: bytes that have come and were not requested

When the controller closes its line, the gateway closes the connection at the other end. If the
other end closes, the line stays open until the program has fetched the earlier bytes and the
gateway has answered `C`.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import field
from typing import Final

from assistant.base.data_classes import dataclass

_GREETING: Final = "GATEWAY 1"
_PIECE: Final = 50
"""Bytes handed over at once: controllers have texts of about 127 characters."""
_FOR_EVER: Final = 99_999_000
"""Milliseconds that stand for no end of a wait."""
_MOST_WAITING: Final = 1 << 16
"""Bytes of the other end that wait for the controller, until the gateway reads no more."""
_MOST_COUNTED: Final = 0xFFFF
"""The largest count of bytes that four hexadecimal digits hold."""
_AGAIN: Final = 0.5
"""Seconds between tries to connect."""
_AT_ONCE: Final = 4096
_LONGEST: Final = 1 << 10
"""Characters of a text of the controller; the longest word has about a hundred."""

Address = tuple[str, int]


@dataclass(slots=True)
class _Other:
    """The other end. come: received bytes that wait for a request. over: whether it sends no
    more.
    """

    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter
    come: bytearray = field(default_factory=bytearray)
    over: bool = False
    changed: asyncio.Condition = field(default_factory=asyncio.Condition)

    async def read(self) -> None:
        """Takes what comes until the other end closes."""
        try:
            while data := await self.reader.read(_AT_ONCE):
                async with self.changed:
                    self.come += data
                    self.changed.notify_all()
                    # No further reading while much waits: the other
                    # end must not fill this computer's memory.
                    await self.changed.wait_for(lambda: len(self.come) < _MOST_WAITING)
        except OSError:
            pass
        async with self.changed:
            self.over = True
            self.changed.notify_all()

    async def take(self, least: int, most: int, wait: int) -> bytes | None:
        """At least so many bytes, None if the other end closes before.

        wait: milliseconds at most, behind which it raises TimeoutError.
        """
        async with self.changed:
            # The condition also ends by the end of the
            # other side, or the wait would never come back.
            enough = self.changed.wait_for(lambda: len(self.come) >= least or self.over)
            await asyncio.wait_for(enough, None if wait >= _FOR_EVER else wait / 1000)
            # Bytes that came before the end are still handed out.
            if len(self.come) < least:
                return None
            taken = bytes(self.come[:most])
            del self.come[:most]
            self.changed.notify_all()
            return taken

    async def send(self, data: bytes) -> bool:
        """Send bytes; True if the other end may have received them."""
        if self.over:
            return False
        try:
            self.writer.write(data)
            await self.writer.drain()
        except OSError:
            return False
        return True


@dataclass(slots=True)
class _Words:
    """Requests of a controller, one after the other. said: bytes for the next `S`. taken: for the
    next `G`.
    """

    other: _Other
    said: bytearray = field(default_factory=bytearray)
    taken: bytes = b""

    async def answer(self, word: str) -> str | None:
        """Return the answer to a word, None for no answer; raises ValueError for an unknown
        word.
        """
        kind, rest = word[:1], word[1:]
        if word == _GREETING:
            return _GREETING
        if kind == "W":
            self.said += bytes.fromhex(rest)
            return None
        if word == "S":
            data, self.said = bytes(self.said), bytearray()
            return "K" if await self.other.send(data) else "C"
        if kind == "A":
            least, most, wait = map(int, rest.split())
            if not (0 <= least <= _MOST_COUNTED and most >= 0):
                raise ValueError(f"no answer can count the bytes of `{word}`")
            try:
                taken = await self.other.take(least, min(most, _MOST_COUNTED), wait)
            except TimeoutError:
                return "T"
            if taken is None:
                return "C"
            self.taken = taken
            return f"B{len(taken):04X}"
        if word == "G":
            piece, self.taken = self.taken[:_PIECE], self.taken[_PIECE:]
            return "D" + piece.hex().upper()
        if word == "P":
            return f"B{min(len(self.other.come), _MOST_COUNTED):04X}"
        raise ValueError(word)


class Gateway:
    """at: address to listen on. to: address that this computer connects to. for_controller: whether
    the controller is the end that connects to this computer. report: receives each event, as a
    sentence.
    """

    def __init__(self, at: Address, to: Address, *, for_controller: bool) -> None:
        self.at, self.to, self.for_controller = at, to, for_controller
        self.report: Callable[[str], None] = lambda _: None
        self._turn = asyncio.Lock()

    async def start(self) -> asyncio.Server:
        """Listens; raises OSError if that cannot be done."""
        server = await asyncio.start_server(self._come, *self.at, limit=_LONGEST)
        self.at = server.sockets[0].getsockname()[:2]
        return server

    async def _come(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One connection after the other: a line of a controller carries one."""
        try:
            async with self._turn:
                await self._serve(reader, writer)
        finally:  # also of one that is cancelled while it waits for its turn
            writer.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.report(f"connected: {writer.get_extra_info('peername')[0]}")
        try:
            there = await self._connect(reader)
            if there is not None:
                ends = (there, (reader, writer))
                line, (source, sink) = reversed(ends) if self.for_controller else ends
                await _led(*line, _Other(source, sink))
        except (OSError, ValueError, asyncio.IncompleteReadError) as error:
            self.report(f"closed: {error}" if str(error) else "closed")
        self.report("closed")

    async def _connect(
        self, waiting: asyncio.StreamReader
    ) -> tuple[asyncio.StreamReader, asyncio.StreamWriter] | None:
        """The end that this computer connects to; None if who waits for it has gone."""
        while not waiting.at_eof():
            try:
                return await asyncio.open_connection(*self.to, limit=_LONGEST)
            except OSError:
                await asyncio.sleep(_AGAIN)
        return None


async def _led(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, other: _Other) -> None:
    """Answers a line until the controller closes it."""
    words, reading = _Words(other), asyncio.create_task(other.read())
    try:
        while text := await _word(reader):
            said = await words.answer(text)
            if said is not None:
                writer.write(f"{said}\r".encode("ascii"))
                await writer.drain()
    finally:
        reading.cancel()
        writer.close()
        other.writer.close()
        for one in (writer, other.writer):
            with suppress(OSError):
                await one.wait_closed()


async def _word(reader: asyncio.StreamReader) -> str:
    """The next text of the controller, empty when it has closed."""
    try:
        data = await reader.readuntil(b"\r")
    except asyncio.IncompleteReadError:
        return ""
    except asyncio.LimitOverrunError:
        raise ValueError("the controller says what no program of ours does") from None
    return data.decode("latin-1").strip()
