"""WebSocket that delivers events, read in the thread that requests them.

OpenSSL lets no thread write while another one reads the same connection: the tickets of TLS 1.3
that arrive after the handshake turn such a write into a wait for more of them, and the request to
open the WebSocket never leaves. So it has no separate thread, unlike the library's client.
"""

from __future__ import annotations

import socket
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from ssl import SSLContext
from typing import Any, Final

from websockets.client import ClientProtocol
from websockets.exceptions import WebSocketException
from websockets.frames import Frame, Opcode
from websockets.protocol import State
from websockets.typing import Subprotocol
from websockets.uri import parse_uri

_LARGEST: Final = 1 << 24
"""Bytes of one event after which it counts as garbage."""
_FAREWELL: Final = 1.0
"""Seconds to wait for the other side's good-bye."""
_LEAST: Final = 1e-3
"""Least seconds of a wait: a socket that never waits reports it in other ways."""
_CHUNK: Final = 1 << 12
"""Bytes read at once: the time-out is checked between two chunks."""
_CONTENTS: Final = (Opcode.TEXT, Opcode.BINARY, Opcode.CONT)


class Channel:
    """Channel of received messages that wait to be fetched; made by `opened`."""

    def __init__(self, line: socket.socket, protocol: ClientProtocol) -> None:
        self._line = line
        self._protocol = protocol
        self._part = bytearray()
        self._messages: deque[bytes] = deque()

    def receive(self, timeout: float) -> bytes:
        """The next message; raises TimeoutError after these seconds, OSError if it has ended."""
        self._read_until(lambda: self._messages or not self._is(State.OPEN), timeout)
        if not self._messages:
            self._protocol.receive_eof()
            raise ConnectionError(str(self._protocol.close_exc))
        return self._messages.popleft()

    def shake_hands(self, headers: Mapping[str, str], timeout: float) -> None:
        """Raises OSError if the other side does not take part."""
        request = self._protocol.connect()
        request.headers.update(headers)
        self._protocol.send_request(request)
        self._send()
        protocol = self._protocol
        self._read_until(
            lambda: not self._is(State.CONNECTING) or protocol.handshake_exc is not None, timeout
        )
        if protocol.handshake_exc is not None:
            raise ConnectionError(str(protocol.handshake_exc))

    def say_good_bye(self) -> None:
        with suppress(OSError, WebSocketException):
            # RWS 2.0 hangs up on a client that sends anything else than the farewell.
            if self._is(State.OPEN):
                self._protocol.send_close(1000)
                self._send()
            self._read_until(lambda: not self._is(State.CLOSING), _FAREWELL)

    def _is(self, state: State) -> bool:
        return self._protocol.state is state

    def _send(self) -> None:
        data = b"".join(self._protocol.data_to_send())
        if data:
            self._line.sendall(data)

    def _read_until(self, over: Callable[[], Any], timeout: float) -> None:
        """Raises TimeoutError after these seconds, however much came of what nobody waits for."""
        until = time.monotonic() + timeout
        while not over():
            # A chunk at a time: unwanted data must not keep the loop beyond its time.
            self._read(max(until - time.monotonic(), _LEAST))
            if time.monotonic() > until and not over():
                raise TimeoutError("timed out")

    def _read(self, timeout: float) -> None:
        self._line.settimeout(timeout)
        data = self._line.recv(_CHUNK)
        if data:
            self._protocol.receive_data(data)
        else:
            self._protocol.receive_eof()
        # The protocol answers pings and closings by itself: its answers have to be sent.
        self._send()
        for one in self._protocol.events_received():
            # Messages may come in several frames.
            if isinstance(one, Frame) and one.opcode in _CONTENTS:
                self._part += one.data
                if one.fin:
                    self._messages.append(bytes(self._part))
                    self._part.clear()


@contextmanager
def opened(
    uri: str,
    place: tuple[str, int],
    trust: SSLContext | None,
    subprotocol: str,
    headers: Mapping[str, str],
    timeout: float,
) -> Iterator[Channel]:
    """The WebSocket of an address, by a connection to a place. trust: None for one in plain.

    No redirection is followed: it would take cookies to another host. Raises OSError, ValueError.
    """
    protocol = ClientProtocol(
        parse_uri(uri), subprotocols=[Subprotocol(subprotocol)], max_size=_LARGEST
    )
    with ExitStack() as stack:
        line = stack.enter_context(socket.create_connection(place, timeout=timeout))
        if trust is not None:
            line = stack.enter_context(trust.wrap_socket(line, server_hostname=place[0]))
        channel = Channel(line, protocol)
        channel.shake_hands(headers, timeout)
        try:
            yield channel
        finally:
            channel.say_good_bye()
