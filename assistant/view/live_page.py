"""A page that shows events while it is open: served to this computer alone, read only."""

from __future__ import annotations

import contextlib
import json
import secrets
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any, Final, Self

_LOCAL_HOST: Final = "127.0.0.1"
_HOST_NAMES: Final = (_LOCAL_HOST, "localhost")
"""Names that a browser may use for this computer: a page of another name that leads here gets
nothing.
"""
MOST_PAGES: Final = 16
"""Most pages served at a time."""
_KEEP_ALIVE: Final = 5.0
"""Seconds after which a page without news is sent an empty line, to see whether it is there."""
_SEND_TIMEOUT: Final = 10.0
"""Seconds in which a page must take what it is sent."""


class LivePage:
    """A page at an address that cannot be guessed, and the latest event for all that show it.

    A context manager: entering starts the server; leaving sends the last event, and ends. Entering
    raises OSError if no port is free.
    """

    def __init__(self, text: str) -> None:
        self._text = text.encode()
        self._path = f"/{secrets.token_urlsafe(16)}/"
        self._news = threading.Condition()
        self._event, self._number, self._over = b"", 0, False
        self._pages: set[threading.Thread] = set()

    @property
    def address(self) -> str:
        return f"http://{_LOCAL_HOST}:{self._server.server_address[1]}{self._path}"

    def __enter__(self) -> Self:
        self._server = _Server((_LOCAL_HOST, 0), _handler(self))
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.05,), name="live page", daemon=True
        )
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._news:
            self._over = True
            pages = tuple(self._pages)
            self._news.notify_all()
        for page in pages:
            page.join(1.0)
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def tell(self, kind: str, record: dict[str, Any]) -> None:
        """Send an event to all pages. A slow page receives the latest only."""
        text = json.dumps(record, ensure_ascii=True, allow_nan=False)
        with self._news:
            self._event = f"event: {kind}\ndata: {text}\n\n".encode("ascii")
            self._number += 1
            self._news.notify_all()

    def asked(self, request: BaseHTTPRequestHandler) -> None:
        """Answer a page that requests itself or the events; all other requests are refused."""
        port = self._server.server_address[1]
        hosts = {f"{name}:{port}" for name in _HOST_NAMES}
        if request.headers.get("Host", "") not in hosts:
            request.send_error(HTTPStatus.FORBIDDEN)
        elif request.path == self._path:
            _response_head(request, "text/html; charset=utf-8", len(self._text))
            request.wfile.write(self._text)
        elif request.path == f"{self._path}events":
            self._follow(request)
        else:
            request.send_error(HTTPStatus.NOT_FOUND)

    def _follow(self, request: BaseHTTPRequestHandler) -> None:
        me = threading.current_thread()
        with self._news:
            full = len(self._pages) >= MOST_PAGES
            if not full:
                self._pages.add(me)
        if full:
            request.send_error(HTTPStatus.SERVICE_UNAVAILABLE)
            return
        try:
            _response_head(request, "text/event-stream", None)
            told, over = 0, False
            while not over:
                with self._news:
                    if self._number == told and not self._over:
                        self._news.wait(_KEEP_ALIVE)
                    event = self._event if self._number != told else b"\n"
                    told, over = self._number, self._over
                request.wfile.write(event)
                request.wfile.flush()
        finally:
            with self._news:
                self._pages.discard(me)


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = False

    def handle_error(self, request: object, client_address: object) -> None:
        """A page that was closed is no news."""


def _handler(page: LivePage) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        server_version, sys_version = "robot-assistant", ""
        timeout = _SEND_TIMEOUT

        def do_GET(self) -> None:
            with contextlib.suppress(OSError):  # it has gone
                page.asked(self)

        def log_message(self, format: str, *words: object) -> None:
            """Nobody reads it."""

    return Handler


def _response_head(request: BaseHTTPRequestHandler, kind: str, length: int | None) -> None:
    request.send_response(HTTPStatus.OK)
    request.send_header("Content-Type", kind)
    if length is not None:
        request.send_header("Content-Length", str(length))
    request.send_header("Cache-Control", "no-store")
    request.send_header("X-Content-Type-Options", "nosniff")
    request.send_header("Referrer-Policy", "no-referrer")
    request.end_headers()
