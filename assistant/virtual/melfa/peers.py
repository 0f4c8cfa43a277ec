"""Lines at whose other ends somebody says the same texts each time that they are opened."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Final

from assistant.virtual.melfa.lines import Wire

GREETING: Final = b"GATEWAY 1"
"""What a program says first to a gateway, and a gateway to it."""
MOST_SENT: Final = 50
"""Bytes that a gateway hands over at once."""
ENDLESS: Final = 99_999_000
"""Milliseconds that stand for no end of a wait."""


class SimulatedClient(Wire):
    """Says its texts at once; to who greets a gateway they are bytes, which are asked for."""

    def __init__(self, texts: Iterable[str]) -> None:
        super().__init__()
        self._texts = [f"{text}\r".encode("latin-1") for text in texts]
        self._left: deque[bytes] = deque()
        self._taken = b""
        self._said = b""
        self._is_gateway = False

    def open(self) -> None:
        self._is_gateway, self._said = False, b""
        self._left = deque(self._texts)
        self.put(b"".join(self._texts))

    def send(self, data: bytes) -> None:
        super().send(data)
        self._said += data
        while b"\r" in self._said:
            line, _, self._said = self._said.partition(b"\r")
            if line == GREETING:
                self.receive()  # what was said before is not for a gateway
                self._is_gateway = True
                self._answer(GREETING)
            elif self._is_gateway:
                self._asked(line)

    def _answer(self, text: bytes) -> None:
        self.put(text + b"\r")

    def _asked(self, line: bytes) -> None:
        """As a gateway answers whose other end says the texts and listens to everything."""
        match line.split():
            case [b"S"]:
                self._answer(b"K")
            case [b"A", least, most, wait]:
                taken = self._bytes(int(least), int(most))
                if taken is not None:
                    self._taken = taken
                    self._answer(b"B%04X" % len(taken))
                elif int(wait) < ENDLESS:
                    self._answer(b"T")
            case [b"G"]:
                piece, self._taken = self._taken[:MOST_SENT], self._taken[MOST_SENT:]
                self._answer(b"D" + piece.hex().upper().encode())
            case [b"P"]:
                self._answer(b"B%04X" % (len(self._left[0]) if self._left else 0))

    def _bytes(self, least: int, most: int) -> bytes | None:
        """A text without its end, or so many bytes of all texts; None if there are not enough."""
        if least < most:
            text = self._left.popleft() if self._left else None
            return None if text is None else text.removesuffix(b"\r")[:most]
        whole = b"".join(self._left)
        if len(whole) < least:
            return None
        self._left = deque([whole[least:]] if len(whole) > least else [])
        return whole[:least]
