"""A controller of few words: literal answers of Robot Web Services, and files that it keeps.

`Rws1` asks for HTTP Digest and speaks XHTML or JSON of RobotWare 6, `Rws2` for Basic over TLS
and speaks HAL. Both write down what they are asked.
"""

import base64
import contextlib
import hashlib
import queue
import re
import secrets
import ssl
import tempfile
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, unquote

import trustme

from assistant.controllers import connect

HEAD = '<?xml version="1.0" encoding="UTF-8"?><html xmlns="http://www.w3.org/1999/xhtml">'


def xhtml(body):
    return (
        f'{HEAD}<head><title>rw</title></head><body><div class="state">{body}</div></body></html>'
    )


def li(kind, title="", /, **values):
    """A row; `fs_size` is written `fs-size`, axes such as `rax_1` stay as they are."""
    named = {k if k[-2] == "_" else k.replace("_", "-"): v for k, v in values.items() if len(k) > 1}
    named |= {k: v for k, v in values.items() if len(k) == 1}
    spans = "".join(f'<span class="{k}">{v}</span>' for k, v in named.items())
    return f'<li class="{kind}" title="{title}">{spans}</li>'


def rows(*items):
    return xhtml(f"<ul>{''.join(items)}</ul>")


def refusal(code, message):
    """An error as both dialects write it (fixtures of ichbinmeraj/abb-rws-client)."""
    spans = (
        f'<span class="code">{code}</span><span class="msg">{message} code:{code} icode:-1</span>'
    )
    return (
        f'{HEAD}<head><title>rw</title></head><body><div class="status">{spans}</div></body></html>'
    )


class Peer:
    """answers: by `METHOD /path?query`, a body, or (status, body), or (status, body, headers).

    A key may leave off the query. files: contents by path behind `/fileservice/`. alter: what it
    makes of a file that it is sent. log: (method, path with query, body) of all requests.
    """

    scheme = "rws"

    def __init__(self, answers=(), files=(), *, alter=None, password="robotics"):
        self.answers = {**self.greetings(), **dict(answers)}
        self.files = dict(files)
        self.alter = alter or (lambda data: data)
        self.password = password
        self.log, self.headers = [], []
        self.sessions, self.held, self.polls = set(), {}, []
        self.events = queue.SimpleQueue()
        self.certificate = None

    def __enter__(self):
        peer = self

        class Handler(_Handler):
            pass

        Handler.peer = peer
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self.port = self._server.server_address[1]
        self.listen()
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.02,))
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def listen(self):
        pass

    def greetings(self):
        return {
            "GET /logout": (204, ""),
            "GET /rw/system": rows(
                li("sys-system-li", "system", major="6", rwversion="6.16.0000", sysid="{57}")
            ),
        }

    def connect(self, **options):
        port, folder = options.pop("port", self.port), options.pop("folder", "")
        address = f"{self.scheme}://Default%20User@127.0.0.1:{port}{folder}"
        password = options.pop("password", self.password)
        timeout = options.pop("timeout", 5)
        return connect(address, password=password, timeout=timeout, **options)

    def forget(self):
        """Sessions and mastership, of a line that was cut for good."""
        self.held.clear()
        self.sessions.clear()

    def asked(self, *methods):
        """What was asked by these methods (writing ones if none is named), but the files."""
        wanted = methods or ("POST", "PUT", "DELETE")
        return [(m, p, b) for m, p, b in self.log if m in wanted and "/fileservice" not in p]


class Rws1(Peer):
    home = "$HOME"

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        self.nonce = secrets.token_hex(8)

    def lets_in(self, method, path, header):
        """RFC 2617, with the quality of protection `auth`."""
        told = dict(re.findall(r'(\w+)="?([^",]+)"?', header or ""))
        if told.get("nonce") != self.nonce or told.get("uri") != path:
            return False
        if not {"nc", "cnonce", "qop", "response"} <= told.keys():
            return False  # a header that was cut
        one = _md5(f"Default User:validusers@robapi.abb:{self.password}")
        two = _md5(f"{method}:{path}")
        parts = (one, told["nonce"], told["nc"], told["cnonce"], told["qop"], two)
        return told["response"] == _md5(":".join(parts))

    def challenge(self):
        return f'Digest realm="validusers@robapi.abb", qop="auth", nonce="{self.nonce}", opaque="x"'


class Rws2(Peer):
    scheme = "rwss"
    home = "HOME"

    def __init__(self, *args, context=None, **options):
        """context: what it shows, a certificate of an authority for this test only if left out."""
        super().__init__(*args, **options)
        self._folder = tempfile.TemporaryDirectory()
        self._context = context or self._own()

    def _own(self):
        authority = trustme.CA()
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        authority.issue_cert("127.0.0.1").configure_cert(context)
        self.certificate = Path(self._folder.name) / "authority.pem"
        authority.cert_pem.write_to_path(self.certificate)
        return context

    def listen(self):
        self._server.socket = self._context.wrap_socket(
            self._server.socket, server_side=True, do_handshake_on_connect=False
        )

    def __exit__(self, *error):
        super().__exit__(*error)
        self._folder.cleanup()

    def greetings(self):
        system = '"_type":"sys-system","_title":"system","rwversion":"7.21.0+229"'
        return {"GET /logout": (204, ""), "GET /rw/system": f'{{"state":[{{{system}}}]}}'}

    def connect(self, **options):
        options.setdefault("certificate", self.certificate)
        return super().connect(**options)

    def lets_in(self, method, path, header):
        wanted = base64.b64encode(f"Default User:{self.password}".encode()).decode()
        return header == f"Basic {wanted}"

    def challenge(self):
        return 'Basic realm="validusers@robapi.abb"'


def framed(data, first=0x81):
    """A frame of a WebSocket; first: its first byte, that of a whole text."""
    return bytes([first, 0x7E]) + len(data).to_bytes(2, "big") + data


def _md5(text):
    return hashlib.md5(text.encode()).hexdigest()


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    wbufsize = -1

    def log_message(self, *args):
        pass

    def setup(self):
        super().setup()
        self.request.settimeout(10)

    def handle(self):
        with contextlib.suppress(OSError):  # a client that has gone
            super().handle()

    def _serve(self):
        peer, path = self.peer, self.path
        body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        polls = path.startswith("/poll/") and self.headers.get("Cookie") in peer.sessions
        if not polls and not peer.lets_in(self.command, path, self.headers.get("Authorization")):
            self._say(401, "", {"WWW-Authenticate": peer.challenge()})
            return
        peer.log.append((self.command, path, body.decode("latin-1")))
        peer.headers.append(dict(self.headers))
        cookie = self.headers.get("Cookie", "")
        if path.startswith("/logout"):
            peer.sessions.discard(cookie)
            peer.held = {domain: who for domain, who in peer.held.items() if who != cookie}
        elif not cookie:
            cookie = f"-http-session-={secrets.token_hex(4)}; ABBCX=7"
            peer.sessions.add(cookie)
        given = peer.answers.get(f"{self.command} {path}")
        if given is None:
            given = peer.answers.get(f"{self.command} {path.partition('?')[0]}")
        if given is None and path.startswith("/rw/mastership/"):
            given = self._mastership(path, cookie)
        if given is None and path.startswith("/poll/"):
            self._poll()
            return
        if given is None and path.startswith("/fileservice/"):
            given = self._files(unquote(path.removeprefix("/fileservice/")), body)
        if given is None:
            given = (404, refusal(-1073414146, "Resource not found"))
        if callable(given):
            given = given(body.decode())
        status, text, headers = (*given, {})[:3] if isinstance(given, tuple) else (200, given, {})
        self._say(status, text, headers, cookie.split("; ") if "Cookie" not in self.headers else ())

    do_GET = do_POST = do_PUT = do_DELETE = _serve

    def _say(self, status, text, headers, cookies=()):
        data = text if isinstance(text, bytes) else text.encode()
        self.send_response(status)
        headers = {"Content-Length": str(len(data)), **headers}
        if status == 204 or headers["Content-Length"] is None:
            del headers["Content-Length"]
            self.close_connection = status != 204
        for name, value in headers.items():
            self.send_header(name, value)
        for cookie in cookies:
            if "=" in cookie:
                self.send_header("Set-Cookie", f"{cookie}; path=/; domain=127.0.0.1; httponly")
        self.end_headers()
        if status != 204:
            self.wfile.write(data)

    def _mastership(self, path, cookie):
        """Of one session at a time, which is told apart by its cookies."""
        domain, action = re.fullmatch(r"/rw/mastership/(\w+)(?:/|\?action=)(\w+)", path).groups()
        holder = self.peer.held.get(domain)
        if holder not in (None, cookie):
            return 403, refusal(-1073445862, "Requested resource is held by someone else")
        if action == "request":
            self.peer.held[domain] = cookie
        elif self.peer.held.pop(domain, None) is None:
            return 403, refusal(-1073445859, "The user does not have required mastership")
        return 204, ""

    def _poll(self):
        """Sends events through a WebSocket until there is None among them: texts, or bare bytes."""
        self.peer.polls.append(self.headers["Sec-WebSocket-Protocol"])
        key = self.headers["Sec-WebSocket-Key"] + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
        self.send_response(101)
        self.send_header("Upgrade", "websocket")
        self.send_header("Connection", "Upgrade")
        accept = base64.b64encode(hashlib.sha1(key.encode()).digest()).decode()
        self.send_header("Sec-WebSocket-Accept", accept)
        self.send_header("Sec-WebSocket-Protocol", self.headers["Sec-WebSocket-Protocol"])
        self.end_headers()
        self.wfile.flush()
        while (event := self.peer.events.get()) is not None:
            self.wfile.write(event if isinstance(event, bytes) else framed(event.encode()))
            self.wfile.flush()
        self.close_connection = True

    def _files(self, path, body):
        """Keeps files: both forms of renaming and making a folder."""
        files, path = self.peer.files, path.partition("?")[0]
        if self.command == "PUT":
            files[path] = self.peer.alter(body)
            return 201, ""
        if self.command == "DELETE":
            gone = [name for name in files if name == path or name.startswith(f"{path}/")]
            for name in gone:
                del files[name]
            return (204, "") if gone else None
        if self.command == "POST":
            form = {k: v[0] for k, v in parse_qs(body.decode()).items()}
            source = path.removesuffix("/rename").removesuffix("/create")
            action = form.get("fs-action") or path.rpartition("/")[2]
            target = f"{source.rpartition('/')[0]}/{form['fs-newname']}"
            if action == "create":
                return 201, ""
            if action != "rename" or source not in files:
                return None
            if target in files:
                return 409, refusal(-1073445879, "the file exists")
            files[target] = files.pop(source)
            return 204, ""
        if path in files:
            return 200, files[path]
        return self._listing(path)

    def _listing(self, path):
        below = {n.removeprefix(f"{path}/") for n in self.peer.files if n.startswith(f"{path}/")}
        if not below and path != self.peer.home:
            return None
        plain = [
            li("fs-file", n, fs_size=len(self.peer.files[f"{path}/{n}"]))
            for n in below
            if "/" not in n
        ]
        folders = [li("fs-dir", n) for n in {n.partition("/")[0] for n in below if "/" in n}]
        return rows(*folders, *plain)
