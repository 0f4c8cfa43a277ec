"""An embedded virtual IRC5: a file server over its `HOME:` that refuses modules with errors.

with VirtualIrc5("home") as controller:
connect(controller.address, password=controller.password)
"""

from __future__ import annotations

import logging
import secrets
import threading
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any, Final, Self

from assistant.program.diagnostics import Refused, error
from assistant.virtual.irc5.modules import MODULE_SUFFIXES, TWICE, LoadedModule, load

USER: Final = "engineer"
NEEDS_PYFTPDLIB = error(
    "VC001",
    "the virtual IRC5 needs pyftpdlib, which is not installed",
    "install it with `pip install 'robot-assistant[virtual]'`",
)
POLL: Final = 0.05
"""Seconds after which the server looks whether it shall stop."""


class VirtualIrc5:
    """A controller on 127.0.0.1; a context manager, or `start` and `stop`.

    folder: its HOME:, made if it is missing. port: 0 for any free one. password: None for a
    random one; it is never logged. quota: bytes that HOME: takes, None for no limit.
    report: is told what arrives and what is refused.
    """

    def __init__(
        self,
        folder: str | FilePath,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        user: str = USER,
        password: str | None = None,
        quota: int | None = None,
        report: Callable[[str], None] | None = None,
    ) -> None:
        self.folder = FilePath(folder).resolve()
        self.user = user
        self.password = password if password is not None else secrets.token_urlsafe(12)
        self._place = (host, port)
        self._quota = quota
        self._report = report or (lambda _: None)
        self._server: Any = None
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()

    def __repr__(self) -> str:
        return f"VirtualIrc5({str(self.folder)!r})"

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    @property
    def port(self) -> int:
        assert self._server is not None, "the controller is not started"
        return int(self._server.address[1])

    @property
    def address(self) -> str:
        return f"ftp://{self.user}@{self._place[0]}:{self.port}"

    def start(self) -> None:
        """Listens; raises OSError for port and folder, Refused if pyftpdlib is missing."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self._server = self._listening()
        self._stopping.clear()
        self._thread = threading.Thread(target=self._serve, name="virtual-irc5", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Hangs up on every client, drops what was arriving, and frees the port."""
        if self._thread is None:
            return
        self._stopping.set()
        self._thread.join()
        self._server = self._thread = None

    def modules(self) -> tuple[LoadedModule, ...]:
        """The modules in HOME:, by file, each with its findings."""
        files = sorted(f for f in self.folder.rglob("*") if f.suffix.lower() in MODULE_SUFFIXES)
        found: list[LoadedModule] = []
        first: dict[str, str] = {}
        for file in files:
            if not file.is_file():
                continue
            name = file.relative_to(self.folder).as_posix()
            module = load(name, file.read_bytes())
            other = first.setdefault(module.name.lower(), name)
            twice = () if other == name else (TWICE(path=name, name=module.name, first=other),)
            found.append(LoadedModule(module.name, name, (*module.findings, *twice)))
        return tuple(found)

    def _listening(self) -> Any:
        try:
            from pyftpdlib.authorizers import DummyAuthorizer
            from pyftpdlib.ioloop import IOLoop
            from pyftpdlib.servers import FTPServer
        except ImportError:
            raise Refused(NEEDS_PYFTPDLIB()) from None

        from assistant.virtual.irc5.files import Home, Session

        _keep_quiet()
        authorizer = DummyAuthorizer()
        authorizer.add_user(self.user, self.password, str(self.folder), perm="elrdfmw")
        home = type("Home", (Home,), {"quota": self._quota, "report": staticmethod(self._report)})
        session = type("Session", (Session,), {"authorizer": authorizer, "abstracted_fs": home})
        return FTPServer(self._place, session, ioloop=IOLoop())

    def _serve(self) -> None:
        server = self._server
        try:
            while not self._stopping.is_set():
                server.ioloop.loop(timeout=POLL, blocking=False)
        finally:
            server.close_all()


def _keep_quiet() -> None:
    """Pyftpdlib writes to standard error where nobody has set up logging."""
    logger = logging.getLogger("pyftpdlib")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
