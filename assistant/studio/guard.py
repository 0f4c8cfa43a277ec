"""Who gets an answer: a browser that knows the address, asked by our own page, and nobody else."""

from __future__ import annotations

import asyncio
import secrets
from collections import Counter
from collections.abc import Iterable
from typing import Final

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

MOST_BYTES: Final = 64_000_000
"""Of what is sent to the studio at once."""
PAGE_POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'nonce-{nonce}'; "
    "img-src 'self' data:; connect-src 'self'; frame-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
"""Of the page; nothing comes from outside, and nothing that a file says is ever run."""
FORBIDDEN: Final = 403
CONTENT_TOO_LARGE: Final = 413
POLICY_VIOLATION: Final = 1008


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
        await send({"type": "websocket.close", "code": POLICY_VIOLATION})
        return
    await PlainTextResponse("not here", FORBIDDEN)(scope, receive, send)


def _limited_body(receive: Receive) -> Receive:
    """What comes without its length, ended where it is too long."""
    total = 0

    async def counted() -> Message:
        nonlocal total
        message = await receive()
        total += len(message.get("body", b""))
        return {"type": "http.disconnect"} if total > MOST_BYTES else message

    return counted


def _with_headers(send: Send, nonce: str) -> Send:
    """Each answer says that it is kept nowhere and what it may load; one may say so by itself."""

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = message.setdefault("headers", [])
            own = {name.lower() for name, _ in headers}
            given = {
                b"content-security-policy": PAGE_POLICY.format(nonce=nonce).encode(),
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
