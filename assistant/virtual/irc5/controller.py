"""A virtual IRC5: its FTP server, Robot Web Services of both dialects, and its programs.

    with VirtualIrc5("home", robot="irb1200-7-0.7") as controller:
        connect(controller.address, password=controller.password)

The FTP server runs in a thread; its package is loaded when it starts.
"""

from __future__ import annotations

import contextlib
import logging
import secrets
import shutil
import tempfile
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, Self
from urllib.parse import quote

from assistant.base.diagnostics import Refused
from assistant.base.file_access import read_file
from assistant.base.installation import missing_extra
from assistant.virtual.irc5.cabinet import Cabinet, Signal
from assistant.virtual.irc5.panel import Mode
from assistant.virtual.irc5.programs import (
    MODULE_SUFFIXES,
    TWICE,
    Cycle,
    LoadedModule,
    Programs,
    load_module_file,
    read_module,
)
from assistant.virtual.irc5.rws_faults import NEEDS_PACKAGE, Faults

if TYPE_CHECKING:
    from assistant.virtual.irc5.rws_http import Server
    from assistant.virtual.irc5.rws_messages import Sessions
    from assistant.virtual.irc5.rws_service import Service


NEEDS_PYFTPDLIB = missing_extra(
    "VC001",
    "the virtual IRC5 needs pyftpdlib, which is not installed",
    "virtual",
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

        from assistant.virtual.irc5.ftp import Home, Session

        _silence_log()
        authorizer = DummyAuthorizer()
        authorizer.add_user(self._user, self._password, str(self.folder), perm="elrdfmw")
        # pyftpdlib takes classes: each server gets its own, with its folder and user.
        home = type("Home", (Home,), {"quota": self._quota, "report": staticmethod(self._report)})
        session = type("Session", (Session,), {"authorizer": authorizer, "abstracted_fs": home})
        # A loop of its own: the default one is shared by all servers of the process.
        return FTPServer(self._place, session, ioloop=IOLoop())

    def _serve(self) -> None:
        server = self._server
        try:
            while not self._stopping.is_set():
                # Short turns, so that `stop` is seen soon.
                server.ioloop.loop(timeout=POLL_PERIOD, blocking=False)
        finally:
            server.close_all()


def _silence_log() -> None:
    """Silence pyftpdlib, which writes to standard error if logging is not set up."""
    logger = logging.getLogger("pyftpdlib")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())


USER: Final = "engineer"
DEVICES: Final[Mapping[str, tuple[str, int]]] = {"UCdevice": ("127.0.0.1", 6510)}
"""The UdpUc device of the samples of EGM, at its usual port (reference, 4.4)."""
SOMEBODY: Final = "somebody"
"""Who holds what no client does."""


class VirtualIrc5:
    """A controller on 127.0.0.1; a context manager, or `start` and `stop`.

    folder: its HOME:, made if it is missing. port: that of FTP, 0 for any free one. password: None
    for a random one; it is never logged. quota: bytes that HOME: accepts by FTP, None for no limit.
    report: is called with each request and each refusal. robot: that of the catalogue whose arm
    programs move; None for a controller without one. rws, rwss: ports of Robot Web Services 1.0 and
    2.0, 0 for any free ones, None to leave them out. signals: those of the I/O configuration;
    signals that programs use are added to them. devices: UdpUc devices that programs send EGM
    packets to, host and port by name. mode: operating mode. grants: whether the pendant confirms
    every request for the privilege to modify. rate: simulated seconds for each real one.
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
        robot: str | None = "irb1200-7-0.7",
        rws: int | None = 0,
        rwss: int | None = 0,
        signals: Sequence[Signal] = (),
        devices: Mapping[str, tuple[str, int]] = DEVICES,
        mode: Mode = "AUTO",
        grants: bool = False,
        rate: float = 1.0,
    ) -> None:
        self.folder = FilePath(folder).resolve()
        self.host, self.user = host, user
        self.password = password if password is not None else secrets.token_urlsafe(12)
        self._quota, self._report = quota, report or (lambda _: None)
        self._ports = {1: rws, 2: rwss}
        self._devices = devices
        self._given: Mapping[str, Signal] = {one.name: one for one in signals}
        self._robot, self._rate, self._port = robot, rate, port
        self._mode, self._grants = mode, grants
        self._own: FilePath | None = None
        self._files: FileServer | None = None
        self._servers: dict[int, Server] = {}
        self._service: Service | None = None
        self._cabinet: Cabinet | None = None
        self._faults = Faults()

    def __repr__(self) -> str:
        return f"VirtualIrc5({str(self.folder)!r})"

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    # ------------------------------------------------------------------------- addresses

    @property
    def port(self) -> int:
        """Port of FTP."""
        assert self._files is not None, "the controller is not started"
        return self._files.port

    @property
    def address(self) -> str:
        """Address of FTP."""
        return f"ftp://{self.user}@{self.host}:{self.port}"

    @property
    def rws_port(self) -> int:
        return self._servers[1].port

    @property
    def rwss_port(self) -> int:
        return self._servers[2].port

    @property
    def rws_address(self) -> str:
        return f"rws://{quote(self.user)}@{self.host}:{self.rws_port}"

    @property
    def rwss_address(self) -> str:
        return f"rwss://{quote(self.user)}@{self.host}:{self.rwss_port}"

    @property
    def certificate(self) -> FilePath:
        """The file that clients of RWS 2.0 have to trust."""
        assert self._own is not None, "the controller is not started"
        return self._own / "virtual-irc5.pem"

    @property
    def cabinet(self) -> Cabinet:
        """The inside of the controller: programs, panel, signals, event log."""
        assert self._cabinet is not None, "the controller is not started"
        return self._cabinet

    @property
    def faults(self) -> Faults:
        """Deliberate faults in the answers of Robot Web Services."""
        return self._faults

    @property
    def sessions(self) -> Sessions:
        assert self._service is not None, "the controller is not started"
        return self._service.sessions

    # -------------------------------------------------------------------- start and stop

    def start(self) -> None:
        """Listens; raises OSError for port and folder, Refused if a package is missing."""
        self.folder.mkdir(parents=True, exist_ok=True)
        try:
            self._start()
        except (OSError, Refused, RuntimeError):
            self.stop()
            raise

    def _start(self) -> None:
        files = FileServer(
            self.folder,
            (self.host, self._port),
            self.user,
            self.password,
            self._quota,
            self._report,
        )
        files.start()
        self._files = files
        if self._ports == {1: None, 2: None}:
            return
        from assistant import robots

        try:
            from assistant.virtual.irc5 import rws_service
        except ImportError as missing:
            raise Refused(NEEDS_PACKAGE(package=missing.name)) from None

        robot = None if self._robot is None else robots.get(self._robot)
        # Its certificate must be outside of HOME:, which clients can read and write.
        self._own = FilePath(tempfile.mkdtemp(prefix="virtual-irc5-"))
        cabinet = Cabinet(
            self.folder,
            robot=robot,
            given=self._given,
            devices=self._devices,
            rate=self._rate,
        )
        cabinet.panel.mode, cabinet.grants = self._mode, self._grants
        cabinet.start()
        self._cabinet = cabinet
        self._service = rws_service.make_service(cabinet, self.user, self.password)
        for dialect, port in self._ports.items():
            if port is not None:
                secure = self.certificate if dialect == 2 else None
                place = self.host, port
                server = rws_service.make_server(
                    dialect, place, self._service, self._faults, secure
                )
                server.start()
                self._servers[dialect] = server

    def stop(self) -> None:
        """Hangs up on every client, drops what was arriving, and frees the ports."""
        if self._service is not None:
            self._service.subscriptions.close()
        for server in self._servers.values():
            server.close()
        if self._cabinet is not None:
            self._cabinet.stop()
        if self._files is not None:
            self._files.stop()
        if self._own is not None:
            shutil.rmtree(self._own, ignore_errors=True)
        self._servers, self._service, self._cabinet = {}, None, None
        self._files = self._own = None

    # ---------------------------------------------------------------------------- person

    def run_modules(self, *files: str, cycle: Cycle = "once") -> None:
        """Loads modules of HOME: instead of all that there are, switches the motors on and starts.

        Raises OSError for a file, `programs.NotPossible` for what does not load or has no main.
        """
        found = [
            module for file in files for module in read_module(file, read_file(self.folder / file))
        ]

        def start(programs: Programs) -> None:
            # One command: no client sees the controller between these steps.
            programs.stop()
            programs.restore(found)
            programs.reset()
            self.cabinet.panel.set_motors(True)
            programs.start(cycle)

        self.cabinet.do(start)

    def teach(self, module: str, name: str, value: str) -> None:
        """Somebody corrects a position of a loaded module at the pendant (ModPos)."""
        self.cabinet.do(lambda programs: programs.teach(module, name, value))

    def press_emergency_stop(self) -> None:
        self.cabinet.press_emergency_stop()

    def release_emergency_stop(self) -> None:
        self.cabinet.release_emergency_stop()

    def grant(self, allowed: bool = True) -> None:
        """The pendant answers who asks for the privilege to modify in manual mode."""
        self.sessions.answer_requests("modify" if allowed else "denied")

    def hold_mastership(self, *domains: str) -> None:
        """Let another client hold these domains, or all, until `free_mastership`."""
        self.cabinet.mastership.holders.update(
            dict.fromkeys(domains or ("cfg", "motion", "rapid"), SOMEBODY)
        )

    def free_mastership(self) -> None:
        self.cabinet.mastership.give_back(("cfg", "motion", "rapid"), SOMEBODY)

    def hang_up(self) -> None:
        """Cuts every connection of Robot Web Services that there is."""
        for server in self._servers.values():
            with contextlib.suppress(OSError):
                server.hang_up()

    def modules(self) -> tuple[LoadedModule, ...]:
        """The modules in HOME:, by file, each with its findings."""
        files = sorted(f for f in self.folder.rglob("*") if f.suffix.lower() in MODULE_SUFFIXES)
        found: list[LoadedModule] = []
        first: dict[str, str] = {}
        for file in files:
            if not file.is_file():
                continue
            name = file.relative_to(self.folder).as_posix()
            module = load_module_file(name, read_file(file))
            # Two files with one module: a controller would load the one or the other.
            other = first.setdefault(module.name.lower(), name)
            twice = () if other == name else (TWICE(path=name, name=module.name, first=other),)
            found.append(LoadedModule(module.name, name, (*module.findings, *twice)))
        return tuple(found)
