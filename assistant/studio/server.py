"""Server of the studio: it listens on this computer alone, unless another address is given."""

from __future__ import annotations

import contextlib
import os
import secrets
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path as FilePath
from types import ModuleType
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.studio import rules

if TYPE_CHECKING:
    from starlette.types import ASGIApp

    from assistant.studio.app import Guard
    from assistant.studio.studio import Studio

_HERE: Final = "127.0.0.1"
_NAMES: Final = (_HERE, "localhost")
"""Names that a browser may use for this computer."""
CERTIFICATE: Final = FilePath(".robot-assistant", "studio", "certificate.pem")
"""Below the project's folder: of a studio that others may open."""
_BEGINNING: Final = 20.0
"""Seconds in which it must be there."""
ENDING: Final = 5.0
"""Seconds that windows have to go."""


@dataclass(frozen=True, slots=True)
class Served:
    """A running server of the studio.

    address: opens it, with a token that cannot be guessed. guard: counts its refusals.
    """

    address: str
    studio: Studio
    guard: Guard


@contextlib.contextmanager
def serving(folder: FilePath, host: str | None = None, port: int = 0) -> Iterator[Served]:
    """Serve a studio of a folder for as long as the context, and make it the working folder.

    host: an address of this computer by which others reach it; then only by TLS, with its
    certificate. None for this computer alone. port: 0 for any free one. Raises Refused.
    """
    uvicorn, applied, guarded = _libraries()
    from assistant.studio.studio import Studio

    with contextlib.ExitStack() as left:
        left.callback(os.chdir, FilePath.cwd())  # out of the folder again, whichever it is then
        studio = Studio(folder)
        studio.go_to(folder)
        listening = left.enter_context(contextlib.closing(_listening(host or _HERE, port)))
        number = listening.getsockname()[1]
        scheme = "http" if host is None else "https"
        names = [f"{_bracketed(one)}:{number}" for one in (_NAMES if host is None else (host,))]
        token = secrets.token_urlsafe(24)
        guard = guarded(applied(studio), token, names, scheme)
        config = uvicorn.Config(
            guard,
            log_config=None,
            log_level="error",  # strangers that speak no HTTP fill no log
            access_log=False,
            lifespan="off",
            ws="websockets-sansio",
            ws_max_size=1_000_000,
            server_header=False,
            proxy_headers=False,
            timeout_graceful_shutdown=1,
        )
        if host is not None:
            _encrypt(config, host, studio.folder)
        server = uvicorn.Server(config)
        thread = threading.Thread(
            target=server.run, kwargs={"sockets": [listening]}, name="studio", daemon=True
        )
        thread.start()
        try:
            _wait(server, thread, host or _HERE)
            yield Served(f"{scheme}://{names[0]}/{token}/", studio, guard)
        finally:
            studio.end()
            server.should_exit = True
            thread.join(ENDING)


def _libraries() -> tuple[ModuleType, Callable[[Studio], ASGIApp], type[Guard]]:
    try:
        import uvicorn
        import websockets  # noqa: F401

        from assistant.studio.app import Guard, app
    except ImportError as missing:
        name = (missing.name or "starlette").partition(".")[0]
        raise Refused(rules.NO_LIBRARY(name=name), exit_status=2) from None
    return uvicorn, app, Guard


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)  # asyncio looks at it
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((host, port))
        found.listen(64)
    except (OSError, OverflowError) as wrong:
        found.close()
        reason = getattr(wrong, "strerror", None) or str(wrong)
        raise Refused(
            rules.NOT_SERVED(where=f"{host}:{port}", reason=reason), exit_status=2
        ) from None
    return found


def _encrypt(config: object, host: str, folder: FilePath) -> None:
    from assistant.base.certificate import self_signed_context
    from assistant.project.project_file import path_inside

    file = path_inside(folder, CERTIFICATE.as_posix())
    if file is None:  # a folder from elsewhere may hold a link to where it likes
        reason = f"`{CERTIFICATE.parent}` leads out of the project"
        raise Refused(rules.NOT_SERVED(where=host, reason=reason), exit_status=2)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        context = self_signed_context(host, "robot-assistant studio", file)
    except ImportError:
        raise Refused(rules.NO_LIBRARY(name="cryptography"), exit_status=2) from None
    except OSError as wrong:
        reason = wrong.strerror or str(wrong)
        raise Refused(rules.NOT_SERVED(where=host, reason=reason), exit_status=2) from None
    config.ssl_context_factory = lambda _config, _default: context  # type: ignore[attr-defined]


def _wait(server: object, thread: threading.Thread, host: str) -> None:
    end = time.monotonic() + _BEGINNING
    while not server.started:  # type: ignore[attr-defined]
        if not thread.is_alive() or time.monotonic() > end:
            raise Refused(rules.NOT_SERVED(where=host, reason="it did not begin"), exit_status=2)
        time.sleep(0.005)


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
