"""A gateway between a line of texts and a socket of bytes: what it answers to each word."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import pytest

from assistant.controllers.gateway import Gateway

HERE = "127.0.0.1"


async def talked(
    words: Sequence[str], says: bytes, *, closes: bool = False
) -> tuple[list[str], bytes]:
    """What a controller is answered whose other end says something, and what that hears.

    The answers end where the gateway closes the line.
    """
    heard = bytearray()
    gone = asyncio.Event()

    async def other(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(says)
        if closes:
            writer.write_eof()
        while data := await reader.read(100):
            heard.extend(data)
        writer.close()
        gone.set()

    server = await asyncio.start_server(other, HERE, 0)
    gateway = Gateway((HERE, 0), server.sockets[0].getsockname()[:2], for_controller=True)
    there = await gateway.start()
    reader, writer = await asyncio.open_connection(*gateway.at)
    answers = []
    for word in words:
        writer.write(f"{word}\r".encode())
        if not word.startswith("W"):
            try:
                answers.append((await reader.readuntil(b"\r")).decode().rstrip())
            except asyncio.IncompleteReadError:
                break
    writer.close()
    await asyncio.wait_for(gone.wait(), 10)
    server.close()
    there.close()
    return answers, bytes(heard)


def test_bytes_are_asked_for_in_pieces() -> None:
    words = ("GATEWAY 1", "A 60 200 99999000", "G", "G", "A 1 5 50")
    answers, _ = asyncio.run(talked(words, bytes(range(60))))
    first, second = bytes(range(50)).hex().upper(), bytes(range(50, 60)).hex().upper()
    assert answers == ["GATEWAY 1", "B003C", f"D{first}", f"D{second}", "T"]


def test_no_more_bytes_are_taken_than_are_wanted() -> None:
    answers, _ = asyncio.run(talked(("A 2 2 5000", "G", "P", "A 1 9 5000", "G"), b"\x00\x0d,z"))
    assert answers == ["B0002", "D000D", "B0002", "B0002", "D2C7A"]


def test_a_count_of_bytes_has_four_digits() -> None:
    answers, _ = asyncio.run(talked(("A 65535 70000 5000", "A 10 70000 5000"), bytes(65545)))
    assert answers == ["BFFFF", "B000A"]


@pytest.mark.parametrize("word", ["A 65536 70000 5000", "A -1 5 5000", "A 0 -1 5000"])
def test_bytes_that_no_answer_could_count_end_the_connection(word: str) -> None:
    answers, _ = asyncio.run(talked(("GATEWAY 1", word, "GATEWAY 1"), bytes(100)))
    assert answers == ["GATEWAY 1"]


def test_bytes_are_sent_together_when_all_are_said() -> None:
    answers, heard = asyncio.run(talked(("W000D", "WFF", "S", "W01", "S"), b""))
    assert answers == ["K", "K"] and heard == b"\x00\x0d\xff\x01"


def test_who_has_closed_is_told_once_all_is_taken() -> None:
    words = ("A 1 10 5000", "G", "A 1 10 5000", "W00", "S")
    answers, _ = asyncio.run(talked(words, b"ab", closes=True))
    assert answers == ["B0002", "D6162", "C", "C"]
