"""The HTTP server of Robot Web Services: log-in, formats, answers, and faults on purpose."""

from __future__ import annotations

import contextlib
import socket
import ssl
import threading
import time
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Final, Protocol
from urllib.parse import parse_qsl, unquote

from assistant.base.data_classes import dataclass
from assistant.virtual.irc5 import rws_messages
from assistant.virtual.irc5.rws_faults import GARBLED_ANSWER, Faults
from assistant.virtual.irc5.rws_messages import (
    Answer,
    Form,
    Place,
    Rejected,
    Request,
    Session,
    Sessions,
)

_MOST_BODY: Final = 1 << 28
"""Bytes of one request that are held in memory."""
_IDLE: Final = 60.0
"""Seconds after which a connection without a request is closed."""
_FORM_TYPE: Final = "application/x-www-form-urlencoded"
_FILES: Final = "/fileservice"
_FILE_TYPES: Final = ("text/plain;v=2.0", "application/octet-stream;v=2.0")


class Service(Protocol):
    """Handler of requests; it raises Rejected for those that it does not carry out."""

    def __call__(self, request: Request) -> Answer: ...


class Sockets(Protocol):
    """Take over a connection that becomes a WebSocket; False if no resource is at that path."""

    def __call__(self, path: str, connection: Connection, /) -> bool: ...


@dataclass(slots=True, eq=False)
class Site:
    """Contents of a server. dialect: 1 or 2. secure: context for encryption, None for plain
    HTTP.
    """

    dialect: int
    sessions: Sessions
    service: Service
    sockets: Sockets
    faults: Faults
    secure: ssl.SSLContext | None = None


class Server(ThreadingHTTPServer):
    """Server of a site, with one thread for each connection, until `close`."""

    # Threads of hanging clients must not keep the process alive.
    daemon_threads = True
    block_on_close = False
    allow_reuse_address = True
    request_queue_size = 64

    def __init__(self, place: tuple[str, int], site: Site) -> None:
        self.site = site
        self._open: set[socket.socket] = set()
        self._lock = threading.Lock()
        super().__init__(place, Connection)
        self._thread = threading.Thread(
            target=self.serve_forever, args=(0.02,), name=f"rws-{site.dialect}", daemon=True
        )

    @property
    def port(self) -> int:
        return int(self.server_address[1])

    @property
    def address(self) -> str:
        scheme = "http" if self.site.secure is None else "https"
        return f"{scheme}://{self.server_address[0]!s}:{self.port}"

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Hangs up on every client and frees the port."""
        # No new connections, then the port, then those that are open.
        self.shutdown()
        self.server_close()
        self._thread.join()
        self.hang_up()

    def hang_up(self) -> None:
        """Cuts all connections, as a line that breaks."""
        with self._lock:
            for one in tuple(self._open):
                with contextlib.suppress(OSError):
                    one.shutdown(socket.SHUT_RDWR)

    def finish_request(self, request: object, client_address: object) -> None:
        """Encrypt in the thread of the connection, so that a silent client does not block
        others.
        """
        assert isinstance(request, socket.socket)
        with self._lock:
            self._open.add(request)
        secured = request
        try:
            request.settimeout(_IDLE)
            if self.site.secure is not None:
                secured = self.site.secure.wrap_socket(request, server_side=True)
                with self._lock:
                    # Both: `hang_up` has to reach a connection
                    # in the middle of the handshake as well.
                    self._open.add(secured)
            Connection(secured, client_address, self)
        except (OSError, ssl.SSLError, ValueError):
            return  # The client has gone, or speaks no TLS.
        finally:
            with self._lock:
                self._open -= {request, secured}
            with contextlib.suppress(OSError):
                secured.close()

    def handle_error(self, request: object, client_address: object) -> None:
        """A connection that broke is no news."""


class Connection(BaseHTTPRequestHandler):
    """One connection with its requests."""

    protocol_version = "HTTP/1.1"
    server_version = "Rapi"
    sys_version = ""
    disable_nagle_algorithm = True
    server: Server

    @property
    def site(self) -> Site:
        return self.server.site

    def do_GET(self) -> None:
        self._serve()

    do_POST = do_PUT = do_DELETE = do_OPTIONS = do_HEAD = do_GET  # noqa: N815

    def log_message(self, format: str, *args: object) -> None:
        """Nothing is logged: requests may hold what is nobody's business."""

    # -------------------------------------------------------------------------- a request

    def _serve(self) -> None:
        body = self._body()
        if body is None:
            return
        path, _, query = self.path.partition("?")
        session = self._session()
        if session is None:
            return
        if self.headers.get("Upgrade", "").lower() == "websocket":
            if not self.site.sockets(path, self):
                self._send(404, "text/plain", b"")
            self.close_connection = True
            return
        fields = dict(parse_qsl(query, keep_blank_values=True))
        accept = self.headers.get("Accept", "*/*")
        form = self._form(fields, accept)
        try:
            if form is None:
                raise Rejected(rws_messages.UNACCEPTABLE, f"Accept: {accept}")
            self._check_type(path)
            request = Request(
                self.site.dialect,
                self.command,
                path,
                session,
                fields,
                self._fields(body),
                body=body,
                accept=accept,
                host=self.headers.get("Host", ""),
            )
            answer = self.site.service(request)
        except Rejected as wrong:
            self._refuse(wrong, form or self._usual())
            return
        # The client gets an answer, and the error still shows in the thread's output.
        except Exception as wrong:
            self._refuse(
                Rejected(rws_messages.INTERNAL_ERROR, type(wrong).__name__), form or self._usual()
            )
            raise
        assert form is not None
        self._answer(answer, form, path)

    def refuse_socket(self) -> None:
        """An upgrade that names another protocol."""
        self._send(400, "text/plain", b"")

    def _body(self) -> bytes | None:
        """None if the request is not to be answered any more."""
        text = self.headers.get("Content-Length", "0")
        # Without a length the end of the body is unknown; the connection cannot be used further.
        if not text.isdecimal() or "Transfer-Encoding" in self.headers:
            self._send(411, "text/plain", b"")
            self.close_connection = True
            return None
        length = int(text[:12])
        if length > _MOST_BODY:
            self._send(413, "text/plain", b"")
            self.close_connection = True
            return None
        if self.headers.get("Expect", "").lower() == "100-continue":
            self.wfile.flush()
        body = self.rfile.read(length)
        if len(body) < length:  # The client has gone in the middle: nothing happens.
            self.close_connection = True
            return None
        return body

    def _session(self) -> Session | None:
        """Return the session of the request; answers the request if it has no session."""
        sessions, dialect = self.site.sessions, self.site.dialect
        known = sessions.of(self.headers.get("Cookie", ""))
        if known is not None:
            return known
        header = self.headers.get("Authorization", "")
        if not sessions.admits(dialect, header, self.command, self.path):
            challenge = {"WWW-Authenticate": sessions.challenge(dialect)}
            self._send(401, "text/plain", b"Access Error: 401 -- Unauthorized", challenge)
            return None
        begun = sessions.begin()
        if begun is None:
            self._refuse(Rejected(rws_messages.TOO_MANY_REQUESTS), self._usual())
            return None
        self._begun = begun
        return begun

    def _fields(self, body: bytes) -> dict[str, str]:
        """Return the fields of a form; values of fields with the same name are joined with
        commas.
        """
        if not self.headers.get("Content-Type", _FORM_TYPE).startswith(_FORM_TYPE):
            return {}
        found: dict[str, str] = {}
        for name, value in parse_qsl(body.decode("utf-8", "replace"), keep_blank_values=True):
            # A form may repeat a name: controllers join the values.
            found[name] = f"{found[name]},{value}" if name in found else value
        return found

    # ------------------------------------------------------------------------ negotiation

    def _usual(self) -> Form:
        return rws_messages.XHTML_1 if self.site.dialect == 1 else rws_messages.XHTML_2

    def _form(self, query: dict[str, str], accept: str) -> Form | None:
        """Return the format of the answer; None if the client accepts none of the formats."""
        if self.site.dialect == 1:
            return rws_messages.JSON_1 if query.get("json") == "1" else rws_messages.XHTML_1
        for form in (rws_messages.HAL_2, rws_messages.XHTML_2):
            kind, _, _ = form.type.partition(";")
            if f"{kind};v=2." in accept.replace(" ", ""):
                return form
        any_way = self.command != "GET" or self.path.startswith((_FILES, "/logout"))
        return rws_messages.XHTML_2 if any_way else None

    def _check_type(self, path: str) -> None:
        """RWS 2.0 takes only contents whose type states its version."""
        if self.site.dialect == 1 or self.command not in ("POST", "PUT"):
            return
        stated = self.headers.get("Content-Type", "").replace(" ", "")
        if not stated:
            raise Rejected(rws_messages.UNACCEPTABLE, "no Content-Type")
        is_file = self.command == "PUT" and path.startswith(_FILES)
        if stated not in (_FILE_TYPES if is_file else (f"{_FORM_TYPE};v=2.0",)):
            raise Rejected(rws_messages.NOT_THIS_TYPE, stated)

    # ---------------------------------------------------------------------------- answers

    def place(self, path: str = "/") -> Place:
        host = self.headers.get("Host", "") or f"127.0.0.1:{self.server.port}"
        scheme = "http" if self.site.secure is None else "https"
        folder, _, own = path.strip("/").rpartition("/")
        return Place(f"{scheme}://{host}/{folder + '/' * bool(folder)}", unquote(own))

    def _answer(self, answer: Answer, form: Form, path: str) -> None:
        if answer.only_xhtml:
            form = self._usual()
        kind, data = form.type, b""
        if answer.data is not None:
            kind, data = "application/octet-stream", answer.data
        elif answer.status != HTTPStatus.NO_CONTENT:
            data = form.written(answer, self.place(path)).encode()
        self._send(answer.status, kind, data, dict(answer.headers))

    def _refuse(self, wrong: Rejected, form: Form) -> None:
        code = wrong.reason.code
        message = f"{wrong} code:{code} icode:-1".lstrip()
        data = form.refused(code, message, self.place()).encode()
        self._send(wrong.status(self.site.dialect), form.type, data)

    def _send(
        self, status: int, kind: str, data: bytes, headers: dict[str, str] | None = None
    ) -> None:
        rows = [f"HTTP/1.1 {status} {HTTPStatus(status).phrase}"]
        told = {"Content-Type": kind, "Cache-Control": "no-cache", **(headers or {})}
        # 204 has no body, and must not state a length.
        if status != HTTPStatus.NO_CONTENT:
            told["Content-Length"] = str(len(data))
        rows += [f"{name}: {value}" for name, value in told.items()]
        # The cookies go with the first answer of a session only.
        begun: Session | None = self.__dict__.pop("_begun", None)
        if begun is not None:
            rows += [f"Set-Cookie: {cookie}" for cookie in begun.cookies]
        head = "\r\n".join([*rows, "", ""]).encode("latin-1")
        self.transmit(head + (b"" if self.command == "HEAD" else data))

    def transmit(self, data: bytes) -> None:
        fault = self.site.faults.next(self.path)
        if fault is not None:
            time.sleep(fault.seconds)
            match fault.kind:
                case "cut":
                    data = data[: fault.after]
                    self.close_connection = True
                case "garbage":
                    data = GARBLED_ANSWER
                    self.close_connection = True
                case "twice":
                    data = data + data
        self.wfile.write(data)
        self.wfile.flush()
        if fault is not None and fault.kind in ("cut", "garbage"):
            with contextlib.suppress(OSError):
                # Shut down: a client would otherwise wait for the rest of the answer.
                self.connection.shutdown(socket.SHUT_RDWR)
