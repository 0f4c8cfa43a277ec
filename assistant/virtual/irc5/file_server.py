"""The FTP server of a virtual IRC5, in a thread of its own."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.diagnostics import Refused, error

NEEDS_PYFTPDLIB = error(
    "VC001",
    "the virtual IRC5 needs pyftpdlib, which is not installed",
    "install it with `pip install 'robot-assistant[virtual]'`",
)
POLL_PERIOD: Final = 0.05
"""Seconds after which the server looks whether it shall stop."""


class FileServer:
    """Serves a folder to one user. place: host and port, 0 for a free one."""

    def __init__(
        self,
        folder: FilePath,
        place: tuple[str, int],
        user: str,
        password: str,
        quota: int | None,
        report: Callable[[str], None],
    ) -> None:
        self.folder, self._place = folder, place
        self._user, self._password = user, password
        self._quota, self._report = quota, report
        self._server: Any = None
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()

    @property
    def port(self) -> int:
        assert self._server is not None, "the server is not started"
        return int(self._server.address[1])

    def start(self) -> None:
        """Listens; raises OSError for the port, Refused if pyftpdlib is missing."""
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

    def _listening(self) -> Any:
        try:
            from pyftpdlib.authorizers import DummyAuthorizer
            from pyftpdlib.ioloop import IOLoop
            from pyftpdlib.servers import FTPServer
        except ImportError:
            raise Refused(NEEDS_PYFTPDLIB()) from None

        from assistant.virtual.irc5.files import Home, Session

        _silence_log()
        authorizer = DummyAuthorizer()
        authorizer.add_user(self._user, self._password, str(self.folder), perm="elrdfmw")
        home = type("Home", (Home,), {"quota": self._quota, "report": staticmethod(self._report)})
        session = type("Session", (Session,), {"authorizer": authorizer, "abstracted_fs": home})
        return FTPServer(self._place, session, ioloop=IOLoop())

    def _serve(self) -> None:
        server = self._server
        try:
            while not self._stopping.is_set():
                server.ioloop.loop(timeout=POLL_PERIOD, blocking=False)
        finally:
            server.close_all()


def _silence_log() -> None:
    """Pyftpdlib writes to standard error where nobody has set up logging."""
    logger = logging.getLogger("pyftpdlib")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
