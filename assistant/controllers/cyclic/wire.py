"""The socket of a loop: packets with the time at which they arrived in this machine."""

from __future__ import annotations

import contextlib
import select
import socket
import struct
import sys
import time
from typing import Final

from assistant.controllers.cyclic.link import Endpoint

BIGGEST_PACKET: Final = 2048
"""Bytes of a packet that are read; longer ones make no sense here."""
MOST_DROPPED: Final = 1000
SHORTEST_BLOCK: Final = 0.001
"""Seconds for which it is worth while to block."""
_SO_TIMESTAMPNS: Final = 35
"""SO_TIMESTAMPNS of Linux on machines of 64 bits (asm-generic/socket.h): the kernel stamps each
packet as it arrives."""
_TIMESTAMP: Final = struct.Struct("=qq")
_CONTROL_BYTES: Final = 64
"""Bytes for the stamp and its head."""


class PacketSocket:
    """A UDP socket to one controller; a context manager. Raises OSError.

    spin: seconds before a packet is due, `cycle` behind the last one, from which on it is looked
    for without pause until as long after; 0 to block in the kernel all the time, inf never to.
    refused: whether the other side said that nothing listens on that port.
    """

    def __init__(self, endpoint: Endpoint, *, spin: float = 0.0, cycle: float = 0.0) -> None:
        self._endpoint = endpoint
        self._spin, self._cycle = spin, cycle
        self._came = 0.0
        self._host = None if endpoint.host is None else socket.gethostbyname(endpoint.host)
        self.stamped = self.refused = False
        self._open()

    def _open(self) -> None:
        endpoint = self._endpoint
        self._peer: tuple[str, int] | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.bind((endpoint.local_host, endpoint.local_port))
            if sys.platform == "linux" and struct.calcsize("P") == 8:
                self._socket.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
                self.stamped = True
            if self._host is not None:
                self._peer = (self._host, endpoint.port)
                if endpoint.port:
                    self._socket.connect(self._peer)
        except OSError:
            self._socket.close()
            raise
        self._poll = select.poll() if hasattr(select, "poll") else None
        if self._poll is not None:
            self._poll.register(self._socket, select.POLLIN)

    def forget(self) -> None:
        """Hears whoever speaks next, where the one that spoke first is of an earlier run."""
        if not self._endpoint.port:
            self._socket.close()
            self._open()

    def __enter__(self) -> PacketSocket:
        return self

    def __exit__(self, *error: object) -> None:
        self._socket.close()

    @property
    def connected(self) -> bool:
        """Whether it is known whom to send to."""
        return self._peer is not None and self._peer[1] != 0

    def send(self, packet: bytes) -> None:
        try:
            self._socket.send(packet)
        except ConnectionRefusedError:  # what an earlier packet met; this one was not sent
            self.refused = True
            with contextlib.suppress(ConnectionRefusedError):
                self._socket.send(packet)

    def receive(self, seconds: float) -> tuple[bytes, float] | None:
        """The next packet and its arrival by `now`, None if none comes in that time.

        Other senders are not heard. The first one that speaks is the peer where none is known.
        """
        until = time.monotonic() + seconds
        while True:
            try:
                packet, data, sender = self._read()
            except ConnectionRefusedError:
                self.refused = True
            except BlockingIOError:
                now = time.monotonic()
                if now >= until:
                    return None
                self._pause(now, until)
                continue
            else:
                if self._is_heard(sender):
                    self._came = time.monotonic()
                    return packet, self._arrival(data)
            if seconds and time.monotonic() >= until:  # however much others send
                return None

    def hush(self, seconds: float) -> None:
        """Drops what comes until nothing has come for that long, at most `MOST_DROPPED`."""
        for _ in range(MOST_DROPPED):
            if self.receive(seconds) is None:
                return

    def _is_heard(self, sender: tuple[str, int]) -> bool:
        """Whether it is the peer, or becomes it; packets from before it did may wait here still."""
        if self.connected:
            return sender == self._peer
        if self._peer is not None and sender[0] != self._peer[0]:
            return False
        self._peer = sender
        self._socket.connect(sender)
        return True

    def now(self) -> float:
        """Seconds of the clock that arrivals are stamped with."""
        return time.time() if self.stamped else time.perf_counter()

    def _read(self) -> tuple[bytes, list[tuple[int, int, bytes]], tuple[str, int]]:
        if not self.stamped:  # where the system may lack `recvmsg`
            packet, sender = self._socket.recvfrom(BIGGEST_PACKET)
            return packet, [], sender
        packet, data, _, sender = self._socket.recvmsg(BIGGEST_PACKET, _CONTROL_BYTES)
        return packet, data, sender

    def _arrival(self, data: list[tuple[int, int, bytes]]) -> float:
        for level, kind, value in data:
            if (
                level == socket.SOL_SOCKET
                and kind == _SO_TIMESTAMPNS
                and len(value) >= _TIMESTAMP.size
            ):
                seconds, nanoseconds = _TIMESTAMP.unpack_from(value)
                return float(seconds + 1e-9 * nanoseconds)
        return self.now()

    def _pause(self, now: float, until: float) -> None:
        """Blocks until a packet comes or there is a reason to look again."""
        due = self._came + self._cycle
        if now >= due + self._spin:
            self._wait(until - now)
        elif (rest := min(until, due - self._spin) - now) >= SHORTEST_BLOCK:
            self._wait(rest, early=True)

    def _wait(self, seconds: float, *, early: bool = False) -> None:
        """early: not a moment longer; the kernel counts in ms here."""
        if self._poll is not None:
            self._poll.poll(int(1e3 * seconds) if early else max(1.0, 1e3 * seconds))
        else:
            select.select([self._socket], [], [], seconds)
