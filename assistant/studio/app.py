"""The application of the studio: its page, the line to each window, texts, and the guard.

`ROUTES` joins the routes of all subjects. The `Guard` answers only a browser that knows the token
in the address, asked by our own page, under a name of this computer. Nothing of the page comes from
outside. What answers about texts is loaded by the first question.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import tomllib
from collections import Counter
from collections.abc import AsyncIterator, Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path as FilePath
from typing import Any, Final

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from assistant.studio import controller_routes, project_routes, run_routes, scenes
from assistant.studio.route_answers import NOT_FOUND, Answering, Question, asks, changes
from assistant.studio.studio import Studio

MOST_BYTES: Final = 64_000_000
"""Most bytes of a request to the studio."""
_PAGE_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'nonce-{nonce}'; "
    "img-src 'self' data:; connect-src 'self'; frame-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
"""Content policy of the page; nothing comes from outside, and no text of a file is ever run."""
_FORBIDDEN: Final = 403
_POLICY_VIOLATION: Final = 1008


class Guard:
    """Asks every request for the token in its path, the host that it names, and where it is from.

    hosts: what a browser may call this computer, with the port. refused: how often what was
    refused, by its reason.
    """

    def __init__(self, app: ASGIApp, token: str, hosts: Iterable[str], scheme: str) -> None:
        self._app, self._prefix = app, f"/{token}"
        self._hosts = frozenset(hosts)
        self._origins = frozenset(f"{scheme}://{host}" for host in self._hosts)
        self.refused: Counter[str] = Counter()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        reason = self._wrong(scope)
        if reason is not None:
            self.refused[reason] += 1
            await _refuse(scope, receive, send)
            return
        inner = {**scope, "path": scope["path"][len(self._prefix) :], "root_path": ""}
        inner["raw_path"] = inner["path"].encode()
        nonce = secrets.token_urlsafe(12)
        inner["state"] = {**scope.get("state", {}), "nonce": nonce}
        try:
            await self._app(inner, _limited_body(receive), _with_headers(send, nonce))
        except asyncio.CancelledError:
            return  # the studio ends, and whoever asked is not told any more

    def _wrong(self, scope: Scope) -> str | None:
        """Why a request is refused, None if it is not."""
        headers = Headers(scope=scope)
        if headers.get("host", "") not in self._hosts:
            return "host"
        path = scope["path"].encode("utf-8", "surrogatepass")
        wanted = f"{self._prefix}/".encode()
        if not secrets.compare_digest(path[: len(wanted)], wanted):
            return "token"
        origin = headers.get("origin")
        changes = scope["type"] == "websocket" or scope.get("method") not in ("GET", "HEAD")
        if origin is None and changes:
            return "origin"
        if origin is not None and origin not in self._origins:
            return "origin"
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            return "site"
        length = headers.get("content-length", "0")
        if not length.isascii() or not length.isdigit() or int(length) > MOST_BYTES:
            return "size"
        return None


async def _refuse(scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": _POLICY_VIOLATION})
        return
    await PlainTextResponse("not here", _FORBIDDEN)(scope, receive, send)


def _limited_body(receive: Receive) -> Receive:
    """Limit a body without a stated length: end it if it is too long."""
    total = 0

    async def counted() -> Message:
        nonlocal total
        message = await receive()
        total += len(message.get("body", b""))
        return {"type": "http.disconnect"} if total > MOST_BYTES else message

    return counted


def _with_headers(send: Send, nonce: str) -> Send:
    """Add headers to each answer: no caching, and what it may load; an answer's existing headers
    stay.
    """

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = message.setdefault("headers", [])
            own = {name.lower() for name, _ in headers}
            given = {
                b"content-security-policy": _PAGE_POLICY.format(nonce=nonce).encode(),
                b"cache-control": b"no-store",
                b"x-content-type-options": b"nosniff",
                b"referrer-policy": b"no-referrer",
                b"cross-origin-opener-policy": b"same-origin",
                b"cross-origin-resource-policy": b"same-origin",
                b"permissions-policy": b"camera=(), microphone=(), geolocation=()",
            }
            headers.extend((name, value) for name, value in given.items() if name not in own)
        await send(message)

    return sent


_MEDIA_TYPES: Final = {
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}
_PART_FOLDERS: Final = ("", "scripts", "codemirror")
"""Folders of files that the page loads."""
FIRST_LANGUAGE: Final = "en"
"""The language whose words all others are measured by."""


async def page(request: Request) -> Response:
    nonce = request.scope["state"]["nonce"]
    text = _page_text().replace("{{ nonce }}", nonce)
    return Response(text, media_type="text/html; charset=utf-8")


async def _page_part(request: Request) -> Response:
    """Return one of the page's files, by a listed name; no other file can be requested."""
    found = _part_bytes().get(request.path_params["name"])
    if found is None:
        return PlainTextResponse("not here", NOT_FOUND)
    data, kind = found
    return Response(data, media_type=kind)


def words() -> dict[str, dict[str, str]]:
    """Texts of the page by language, each as its table says; a word that it lacks is English."""
    tables = {
        file.name.removesuffix(".toml"): tomllib.loads(file.read_text(encoding="utf-8"))
        for file in _part_folder("words").iterdir()
        if file.name.endswith(".toml")
    }
    first = tables[FIRST_LANGUAGE]
    return {name: first | table for name, table in sorted(tables.items())}


@cache
def _page_text() -> str:
    told = json.dumps(words(), ensure_ascii=False).replace("<", "\\u003c")
    return _part_folder("studio.html").read_text(encoding="utf-8").replace("{{ words }}", told)


@cache
def _part_bytes() -> dict[str, tuple[bytes, str]]:
    found = {}
    for folder in _PART_FOLDERS:
        for file in _part_folder(folder).iterdir():
            suffix = file.name[file.name.rfind(".") :]
            if suffix in _MEDIA_TYPES and file.name != "entry.js":
                name = f"{folder}/{file.name}".lstrip("/")
                found[name] = file.read_bytes(), _MEDIA_TYPES[suffix]
    return found


def _part_folder(name: str) -> Traversable:
    here = files("assistant").joinpath("studio")
    return here.joinpath(name) if name else here


_PAGE_ROUTES: Final = (Route("/", page), Route("/parts/{name:path}", _page_part))


_FILE_LOOK_PERIOD: Final = 1.0
"""Seconds between two looks at the files of the project."""


async def window(line: WebSocket) -> None:
    """One window, from when it opens to when it is gone."""
    studio: Studio = line.app.state.studio
    await line.accept()
    loop = asyncio.get_running_loop()
    news: asyncio.Queue[Mapping[str, Any]] = asyncio.Queue()

    def tell(message: Mapping[str, Any]) -> None:
        if not loop.is_closed():
            loop.call_soon_threadsafe(news.put_nowait, message)

    name = studio.windows.opened(tell)
    tasks = [
        asyncio.create_task(_send_events(line, news)),
        asyncio.create_task(_watch_files(studio, tell)),
    ]
    try:
        async for message in _hear_window(line):
            _hear_beat(studio, name, message)
    finally:
        for task in tasks:
            task.cancel()
        left: list[object] = []
        studio.windows.closed(name, lambda wrote: left.extend(_release_window(studio, name, wrote)))
        await run_sync(studio.finish, left, limiter=line.app.state.urgent)


async def _hear_window(line: WebSocket) -> AsyncIterator[Mapping[str, Any]]:
    """Yield the messages of a window, until it closes or sends an invalid one."""
    while True:
        try:
            message = json.loads(await line.receive_text())
        except WebSocketDisconnect:
            return
        except (KeyError, ValueError, RecursionError):  # bytes, no JSON, JSON without a bottom
            return
        if isinstance(message, dict):
            yield message


def _hear_beat(studio: Studio, name: str, message: Mapping[str, Any]) -> None:
    """Pass the beat of a held key to the arm's control; ignore all other messages."""
    control = studio.live.get("control")
    beat = getattr(control, "beat", None)
    if beat is not None and message.get("kind") == "beat":
        beat(name, message)


def _release_window(studio: Studio, name: str, wrote: bool) -> Sequence[object]:
    """Return what a window controlled, connected or started, to be ended."""
    mine = getattr(studio.live.get("control"), "window", None) == name
    own = ("control",) if mine or wrote else ()
    return studio.taken_off(*own, *(("connection", "run") if wrote else ()))


async def _send_events(line: WebSocket, news: asyncio.Queue[Mapping[str, Any]]) -> None:
    while True:
        await line.send_text(json.dumps(await news.get(), allow_nan=False))


async def _watch_files(studio: Studio, tell: Any) -> None:
    """Report files that were added, removed or changed."""
    from assistant.studio.studio import file_stamps

    before = await run_in_threadpool(file_stamps, studio.folder)
    at: FilePath = studio.folder
    while True:
        await asyncio.sleep(_FILE_LOOK_PERIOD)
        if studio.folder != at:
            at = studio.folder
            before = await run_in_threadpool(file_stamps, at)
            continue
        now = await run_in_threadpool(file_stamps, at)
        changed = sorted(name for name in {*before, *now} if before.get(name) != now.get(name))
        before = now
        if changed:
            tell({"kind": "disk", "files": changed})


_WINDOW_ROUTES: Final = (WebSocketRoute("/window", window),)


def _text_answer(name: str) -> Answering:
    def answer(studio: Studio, asked: Question) -> Any:
        from assistant.studio import text_answers

        return getattr(text_answers, name)(studio, asked)

    return answer


_TEXT_QUESTIONS: Final = (
    *("open_text", "close", "on_disk", "change", "words", "settled", "fixes", "completions"),
    *("hover", "definition", "renameable", "rename", "formatted", "translation"),
)
_TEXT_ROUTES: Final = (
    *(asks(f"/text/{name}", _text_answer(name)) for name in _TEXT_QUESTIONS),
    changes("/text/save", _text_answer("save")),
)


ROUTES: Final[tuple[BaseRoute, ...]] = (
    *_PAGE_ROUTES,
    *_WINDOW_ROUTES,
    *project_routes.PROJECT_ROUTES,
    *run_routes.RUN_ROUTES,
    *controller_routes.CONTROLLER_ROUTES,
    *controller_routes.CONTROL_ROUTES,
    *scenes.SCENE_ROUTES,
    *_TEXT_ROUTES,
)

_URGENT_THREADS: Final = 20
"""Threads for what stops an arm, or lets go of it: other requests cannot use them up."""


def app(studio: Studio) -> Starlette:
    """The application of one studio; a `Guard` stands before it."""
    made = Starlette(routes=list(ROUTES))
    made.state.studio = studio
    made.state.urgent = CapacityLimiter(_URGENT_THREADS)
    return made
