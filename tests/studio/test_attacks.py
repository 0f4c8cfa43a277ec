"""What strangers try on a studio: other pages, windows and computers, and hostile files."""

from __future__ import annotations

import ast
import contextlib
import http.client
import inspect
import json
import socket
import ssl
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, Final
from urllib.error import URLError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

import pytest
from starlette.routing import Route, WebSocketRoute
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from assistant import studio
from assistant.studio.app import MOST_BYTES, ROUTES
from assistant.studio.server import CERTIFICATE, serving
from tests.studio.serving import Answer, Page, answered, served

SECRET: Final = "4711-of-nobody-else"
ELSEWHERE: Final = "http://elsewhere.example"
REFUSED: Final = 403
ASKED: Final = [
    (method, route.path)
    for route in ROUTES
    if isinstance(route, Route)
    for method in sorted(route.methods or ())
    if method != "HEAD"
]
"""Every route that there is, whoever wrote it."""
WRITING: Final = [
    route.path
    for route in ROUTES
    if isinstance(route, Route)
    and inspect.getclosurevars(route.endpoint).nonlocals.get("writes") is True
]
LINES: Final = [route.path for route in ROUTES if isinstance(route, WebSocketRoute)]
ANY_FOLDER: Final = "/project/open"
"""The one that may be told any folder of this computer, as the command is."""
PATHS: Final = (
    *("../outside/secret.mod", "linked/secret.mod", "{outside}/secret.mod", ".git/secret.mod"),
    *("..\\outside\\secret.mod", "a/../../outside/secret.mod", "secret.mod", "/etc/passwd"),
    *("file://{outside}/secret.mod", "C:\\secret.mod", "\\\\server\\share\\secret.mod"),
    *(".robot-assistant/secret.mod", "../outside", "..", "", "a\0b.mod"),
)
JUNK: Final[tuple[Any, ...]] = (
    None,
    True,
    -1,
    10**400,
    [],
    [[1]],
    {"a": {"b": []}},
    "\ud800",
    "x" * 10_000,
)


def named_values() -> list[str]:
    """All that any route asks for by name, as its source tells."""
    found: set[str] = set()
    for file in Path(studio.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                whose = ast.unparse(node.func.value)
                if whose in ("asked", "asked.values") and node.args:
                    found |= {
                        str(one.value) for one in node.args[:1] if isinstance(one, ast.Constant)
                    }
    return sorted(found)


class Stranger:
    """Asks with whatever headers it likes, and is not led by what a client would add."""

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        assert parts.hostname
        self.host, self.token = parts.netloc, parts.path.strip("/")
        self.origin = f"{parts.scheme}://{parts.netloc}"
        self._line = http.client.HTTPConnection(parts.hostname, parts.port, timeout=30)

    def close(self) -> None:
        self._line.close()

    def ask(self, method: str, path: str, headers: Mapping[str, str], body: bytes = b"{}") -> int:
        self._line.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in headers.items():
            self._line.putheader(name, value)
        if method == "POST":
            self._line.putheader("Content-Length", str(len(body)))
        self._line.endheaders(body if method == "POST" else None)
        answer = self._line.getresponse()
        answer.read()
        return answer.status

    def attacks(self, path: str, method: str) -> Iterator[tuple[str, str, dict[str, str]]]:
        """Why each is to be refused, the path, and its headers."""
        good = {"Host": self.host, "Origin": self.origin}
        port = self.host.rpartition(":")[2]
        for host in ("", "elsewhere.example", f"elsewhere.example:{port}", "127.0.0.1", "0"):
            yield "host", f"/{self.token}{path}", good | {"Host": host}
        token = self.token
        for wrong in ("", token[:-1], token[:-1] + "%00", token.swapcase(), "x" * len(token)):
            yield "token", f"/{wrong}{path}", good
        for origin in (ELSEWHERE, "null", f"http://127.0.0.1:{int(port) - 1}", f"{self.origin}."):
            yield "origin", f"/{token}{path}", good | {"Origin": origin}
        for site in ("cross-site", "same-site", "none, cross-site"):
            yield "site", f"/{token}{path}", good | {"Sec-Fetch-Site": site}
        if method == "POST":
            yield "origin", f"/{token}{path}", {"Host": self.host}


@pytest.fixture
def stranger(address: str) -> Iterator[Stranger]:
    with contextlib.closing(Stranger(address)) as found:
        yield found


@pytest.fixture
def project(page: Page, folder: Path) -> Path:
    """One with a program, a link that leads out of it, and secrets beside it."""
    outside = folder.parent / "outside"
    outside.mkdir()
    (outside / "secret.mod").write_text(f"MODULE secret\n! {SECRET}\nENDMODULE\n", "utf-8")
    for hidden in (".robot-assistant", ".git"):
        (folder / hidden).mkdir()
        (folder / hidden / "secret.mod").write_text(f"! {SECRET}\n", "utf-8")
    (folder / "linked").symlink_to(outside)
    (folder / "secret.mod").symlink_to(outside / "secret.mod")
    (folder / "seam.mod").write_text("MODULE seam\nPROC main()\nENDPROC\nENDMODULE\n", "utf-8")
    assert page.post("project/create", empty=True).status == 200
    return folder


def test_whoever_is_not_our_page_is_refused_by_every_route(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tell: Callable[[str], None]
) -> None:
    monkeypatch.chdir(tmp_path)  # the studio goes to its folder
    with serving(tmp_path) as ours, contextlib.closing(Stranger(ours.address)) as stranger:
        tried: Counter[str] = Counter()
        for method, path in ASKED:
            asked = stranger.attacks(path.replace("{name:path}", "x"), method)
            for reason, address, headers in asked:
                assert stranger.ask(method, address, headers) == REFUSED, (reason, address, headers)
                tried[reason] += 1
        assert ours.guard.refused == tried
        assert len(ASKED) > 40 and tried.total() > 17 * len(ASKED) - 1
        assert list(tmp_path.iterdir()) == []
    counts = ", ".join(f"{count} by {reason}" for reason, count in tried.items())
    tell(f"studio: {tried.total()} of {tried.total()} strangers refused, {counts}")


def test_a_form_of_another_page_does_nothing(
    stranger: Stranger, folder: Path, tell: Callable[[str], None]
) -> None:
    """Even with the token, the browser says where the form stands; without the window it ends."""
    kinds = ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x")
    for kind, path in product(kinds, WRITING):
        headers = {"Host": stranger.host, "Content-Type": kind, "Cookie": "a=b"}
        address = f"/{stranger.token}{path}"
        theirs = headers | {"Origin": ELSEWHERE}
        assert stranger.ask("POST", address, theirs, b'{"empty": true}') == REFUSED
        assert stranger.ask("POST", address, headers | {"Origin": "null"}) == REFUSED
        ours = headers | {"Origin": stranger.origin}
        assert stranger.ask("POST", address, ours) == 422  # ST010: it has no window
    assert list(folder.iterdir()) == []
    tell(f"studio: {3 * len(kinds) * len(WRITING)} posts of forms changed nothing")


def test_no_other_page_has_a_line(address: str) -> None:
    parts = urlsplit(address)
    origin = f"{parts.scheme}://{parts.netloc}"
    there = f"ws://{parts.netloc}"
    wrong: list[tuple[str, dict[str, str]]] = [
        (path, headers)
        for path in LINES
        for path, headers in (
            (f"{parts.path}{path[1:]}", {}),
            (f"{parts.path}{path[1:]}", {"Origin": ELSEWHERE}),
            (f"{parts.path}{path[1:]}", {"Origin": "null"}),
            (f"{parts.path}{path[1:]}", {"Origin": origin, "Sec-Fetch-Site": "cross-site"}),
            (f"/x{path}", {"Origin": origin}),
            (path, {"Origin": origin}),
        )
    ]
    for path, headers in wrong:
        with pytest.raises(InvalidStatus), connect(there + path, additional_headers=headers):
            pass
    assert len(wrong) == 6 * len(LINES) > 0


def test_a_second_window_changes_nothing(
    page: Page, project: Path, tell: Callable[[str], None]
) -> None:
    before = {file: file.stat().st_mtime_ns for file in project.iterdir()}
    second = Page(page.address)
    with second.line():
        for path in WRITING:
            for window in (second.window, "", "x", page.window[:-1], "\xff"):
                told = Page(page.address, window).post(path[1:], path="seam.mod", empty=True)
                assert (told.status, told.value["findings"][0]["code"]) == (422, "ST010"), path
    assert len(WRITING) > 15
    assert {file: file.stat().st_mtime_ns for file in project.iterdir()} == before
    tell(f"studio: {5 * len(WRITING)} writes of second windows refused")


def test_the_next_window_writes_when_the_first_is_closed(address: str) -> None:
    first, second = Page(address), Page(address)
    with first.line() as line:
        while not first.writes:
            first.hear(line)
        with second.line() as other:
            assert second.post("project/create", empty=True).status == 422
            line.close()
            while not second.writes:
                second.hear(other)
            assert first.post("project/create", empty=True).status == 422
            assert second.post("project/create", empty=True).status == 200


def told(page: Page, method: str, path: str, values: Mapping[str, Any]) -> Answer:
    """What a route answers; by GET each value as its text."""
    if method == "POST":
        return page.post(path[1:], **values)
    texts = {k: str(v).encode("utf-8", "replace").decode() for k, v in values.items()}
    return page.get(path[1:], **{k: v[:2000] for k, v in texts.items()})


NOTHING_YET = {"/run/compared": (404,)}
"""What routes answer as long as there is nothing that they could show."""


@pytest.mark.parametrize("paths", [PATHS[:2], pytest.param(PATHS[2:], marks=pytest.mark.slow)])
def test_no_route_is_led_out_of_the_project(
    page: Page, project: Path, paths: tuple[str, ...], tell: Callable[[str], None]
) -> None:
    """Each value of each route is a path that leads out, alone and with all others."""
    outside = project.parent / "outside"
    keys = named_values()
    tried = 0
    routes = [one for one in ASKED if one[1] != ANY_FOLDER and "{" not in one[1]]
    for (method, path), text in product(routes, paths):
        hostile = text.format(outside=outside)
        together = dict.fromkeys(keys, hostile)
        several = {key: [hostile] for key in keys}
        path_only = {"path": hostile, "text": "x", "version": 0, "name": "cell1x", "stamp": ""}
        for values in (together, several, path_only):
            answer = told(page, method, path, values)
            tried += 1
            where = (path, text, answer.value)
            assert answer.status in (200, 422, *NOTHING_YET.get(path, ())), where
            assert SECRET not in json.dumps(answer.value), where
            assert "CL900" not in json.dumps(answer.value), where
    assert tried == 3 * len(paths) * len(routes) > 300
    assert [one.name for one in outside.iterdir()] == ["secret.mod"]
    assert SECRET in (outside / "secret.mod").read_text("utf-8")
    assert {one.name for one in project.parent.iterdir()} == {"cell", "outside"}
    tell(f"studio: {tried} paths led out of no project")


@pytest.mark.slow
def test_no_route_fails_by_what_it_is_given(page: Page, project: Path) -> None:
    keys = named_values()
    routes = [one for one in ASKED if "{" not in one[1]]
    for (method, path), value in product(routes, JUNK):
        answer = told(page, method, path, dict.fromkeys(keys, value))
        expected = (200, 422, 500, *NOTHING_YET.get(path, ()))
        assert answer.status in expected, (path, value, answer.value)
        assert "CL900" not in json.dumps(answer.value), (path, value)


@pytest.mark.slow
def test_a_body_that_is_no_question_is_told(page: Page, stranger: Stranger) -> None:
    good = {"Host": stranger.host, "Origin": stranger.origin, "X-Window": page.window}
    bodies = (b"[" * 100_000, b"\xff", b"[]", b"1" * 5000, b'{"a": NaN}', b'{"a": 1e999}', b'{"a":')
    for (method, path), body in product(ASKED, bodies):
        if method == "POST" and path not in (ANY_FOLDER, "/project/create", "/project/build"):
            status = stranger.ask(method, f"/{stranger.token}{path}", good, body)
            assert status in (200, 422), (path, body[:20])


def test_bodies_without_end_are_ended(page: Page, stranger: Stranger) -> None:
    good = {"Host": stranger.host, "Origin": stranger.origin, "X-Window": page.window}
    for length in (str(MOST_BYTES + 1), "1e3", "-1", "9" * 30):
        told = b"".join(f"{k}: {v}\r\n".encode() for k, v in good.items())
        head = f"POST /{stranger.token}/project/drop HTTP/1.1\r\nContent-Length: {length}\r\n"
        with socket.create_connection(_place(page), 30) as line:
            line.sendall(head.encode() + told + b"\r\n")
            assert b" 40" in line.recv(1000), length  # 403, or 400 of a length that is none
    with socket.create_connection(_place(page), 30) as line:
        head = f"POST /{stranger.token}/project/drop HTTP/1.1\r\nTransfer-Encoding: chunked\r\n"
        told = b"".join(f"{k}: {v}\r\n".encode() for k, v in good.items())
        line.sendall(head.encode() + told + b"\r\n")
        with contextlib.suppress(ConnectionError):
            for _ in range(MOST_BYTES // 1_000_000 + 2):
                line.sendall(b"f4240\r\n" + b"x" * 1_000_000 + b"\r\n")
        line.settimeout(5.0)
        with contextlib.suppress(OSError):
            assert b" 200 " not in line.recv(1000)
    with page.line() as line, pytest.raises(ConnectionClosed):
        line.send("x" * 2_000_000)
        while True:
            line.recv(10.0)
    assert page.get("project").status == 200


def test_lines_that_say_nonsense_end_alone(page: Page, address: str) -> None:
    for said in ("", "[", "[" * 100_000, "[]", "3", '{"kind": "beat"}', '{"kind": []}', "\0"):
        second = Page(address)
        with second.line() as line, contextlib.suppress(ConnectionClosed):
            line.send(said)
            line.send(b"\xff\x00")
            while True:  # until it is closed
                line.recv(10.0)
    assert page.post("project/create", empty=True).status == 200


def test_connections_that_say_nothing_hold_up_nobody(page: Page) -> None:
    parts = urlsplit(page.address)
    get = f"GET {parts.path}{{}} HTTP/1.1\r\nHost: {parts.netloc}\r\n"
    post = (
        f"POST {parts.path}project/drop HTTP/1.1\r\nHost: {parts.netloc}\r\n"
        f"Origin: {page.origin}\r\nX-Window: {page.window}\r\nContent-Length: 100\r\n\r\nx"
    )
    begun = ("", "GET ", get.format(""), get.format("window") + "Upgrade: websocket\r\n", post)
    with contextlib.ExitStack() as open_:
        for i in range(200):
            line = open_.enter_context(socket.create_connection(_place(page), 10))
            line.sendall(begun[i % len(begun)].encode())
        assert page.get("project").status == 200
        assert page.post("project/create", empty=True).status == 200


def test_only_parts_of_the_page_are_given(address: str) -> None:
    names = (
        *("../server.py", "..%2fserver.py", "%2e%2e/server.py", "....//server.py", "/etc/passwd"),
        *("scripts/../../server.py", "server.py", "scripts", "", "words/en.toml", "studio.css%00"),
        *("STUDIO.CSS", "scripts\\start.js", "scripts//start.js"),
    )
    for name in names:
        assert answered(Request(f"{address}parts/{name}")).status in (403, 404), name
    assert answered(Request(f"{address}parts/studio.css")).status == 200


def test_every_answer_says_that_it_may_load_nothing_else(page: Page, project: Path) -> None:
    for method, path in ASKED:
        if method == "GET":
            with contextlib.suppress(URLError):
                got = urlopen(Request(page.address + path[1:] + "?path=seam.mod"), timeout=30)
                policy = got.headers["Content-Security-Policy"]
                assert "default-src 'none'" in policy, path
                assert "unsafe-eval" not in policy
                assert not any(one in policy for one in ("http:", "https:", "*")), path
                assert got.headers["X-Content-Type-Options"] == "nosniff"
                assert got.headers["Cache-Control"] == "no-store"


def _place(page: Page) -> tuple[str, int]:
    parts = urlsplit(page.address)
    assert parts.hostname and parts.port
    return parts.hostname, parts.port


def test_others_open_it_only_by_tls_and_with_the_token(folder: Path) -> None:
    with served(folder, "--host", "127.0.0.1") as address:
        parts = urlsplit(address)
        assert parts.scheme == "https"
        pinned = ssl.create_default_context(cafile=str(folder / CERTIFICATE))
        with urlopen(address, timeout=10, context=pinned) as page:
            assert page.status == 200
        assert "PRIVATE" not in (folder / CERTIFICATE).read_text("utf-8")
        with pytest.raises(URLError, match="CERTIFICATE_VERIFY_FAILED"):
            urlopen(address, timeout=10)
        with pytest.raises((URLError, OSError)):  # nothing is said without encryption
            urlopen(address.replace("https", "http", 1), timeout=10)
        for wrong in (f"https://{parts.netloc}/", f"{address[:-2]}/", f"{address[:-1]}"):
            with pytest.raises(URLError, match="403"):
                urlopen(wrong, timeout=10, context=pinned)
        line = address.replace("https", "wss", 1) + "window"
        origin = {"Origin": f"https://{parts.netloc}"}
        with connect(line, ssl=pinned, additional_headers=origin) as opened:
            assert json.loads(opened.recv(10.0))["kind"] == "window"
        upgrade = {
            "Origin": f"http://{parts.netloc}",
            "Connection": "Upgrade",
            "Upgrade": "websocket",
            "Sec-WebSocket-Version": "13",
            "Sec-WebSocket-Key": "c2l4dGVlbiBieXRlcyBoZQ==",
        }
        asking = http.client.HTTPSConnection(parts.netloc, timeout=10, context=pinned)
        with contextlib.closing(asking):
            asking.request("GET", f"{parts.path}window", headers=upgrade)
            assert asking.getresponse().status == 403


def test_a_certificate_is_written_into_no_folder_from_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    project, outside = tmp_path / "cell", tmp_path / "outside"
    project.mkdir()
    outside.mkdir()
    (project / ".robot-assistant").symlink_to(outside)
    from assistant.base.diagnostics import Refused

    with pytest.raises(Refused, match="leads out"), serving(project, "127.0.0.1"):
        pass
    assert list(outside.iterdir()) == []
