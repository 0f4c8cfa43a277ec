"""The line between a window and the studio: who writes, what changed on the disk, and held keys."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any, Final

from anyio.to_thread import run_sync
from starlette.concurrency import run_in_threadpool
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from assistant.studio.studio import Studio

FILE_LOOK_PERIOD: Final = 1.0
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
    """What a window says, until it is gone or says what no page of ours says."""
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
    """A beat of a held key goes to what moves; nothing else is said here."""
    control = studio.live.get("control")
    beat = getattr(control, "beat", None)
    if beat is not None and message.get("kind") == "beat":
        beat(name, message)


def _release_window(studio: Studio, name: str, wrote: bool) -> Sequence[object]:
    """What a window had under control, connected or started, which is to be ended."""
    mine = getattr(studio.live.get("control"), "window", None) == name
    own = ("control",) if mine or wrote else ()
    return studio.taken_off(*own, *(("connection", "run") if wrote else ()))


async def _send_events(line: WebSocket, news: asyncio.Queue[Mapping[str, Any]]) -> None:
    while True:
        await line.send_text(json.dumps(await news.get(), allow_nan=False))


async def _watch_files(studio: Studio, tell: Any) -> None:
    """Tells of files that came, went or changed."""
    from assistant.studio.tree import file_stamps  # readers and languages, after the page is there

    before = await run_in_threadpool(file_stamps, studio.folder)
    at: FilePath = studio.folder
    while True:
        await asyncio.sleep(FILE_LOOK_PERIOD)
        if studio.folder != at:
            at = studio.folder
            before = await run_in_threadpool(file_stamps, at)
            continue
        now = await run_in_threadpool(file_stamps, at)
        changed = sorted(name for name in {*before, *now} if before.get(name) != now.get(name))
        before = now
        if changed:
            tell({"kind": "disk", "files": changed})


WINDOW_ROUTES: Final = (WebSocketRoute("/window", window),)
