"""The FTP session of a virtual IRC5 over a folder that is its `HOME:` unit.

A file is held back until it is complete and checked; the answer at the end of the transfer says
whether it was accepted. A refused file replaces nothing.
"""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Callable, Iterable
from pathlib import Path as FilePath
from typing import Any, Final

from pyftpdlib.exceptions import FilesystemError
from pyftpdlib.filesystems import AbstractedFS
from pyftpdlib.handlers import DTPHandler, FTPHandler

from assistant.base.diagnostics import Diagnostic, Severity
from assistant.base.file_access import UNFINISHED, read_file, write_whole
from assistant.virtual.irc5.programs import check_file, is_checked

_UNIT: Final = "HOME:"
_MOST_ARRIVING: Final = 1 << 30
"""Bytes of one file that are held in memory."""
_MOST_SAID: Final = 20
"""Findings that one answer repeats."""


class _NotTaken(FilesystemError):  # type: ignore[misc] # pyftpdlib has no types
    """A file that is not taken in; `reply` is the whole FTP answer, code and lines."""

    def __init__(self, code: int, lines: Iterable[str]) -> None:
        said = [_plain_text(line) for line in lines]
        super().__init__(" / ".join(said))
        middle = [f"{code}-{line}" for line in said[:-1]]
        self.reply = "\r\n".join([*middle, f"{code} {said[-1]}"])


class Home(AbstractedFS):  # type: ignore[misc]
    """The folder as the unit `HOME:`, which is also where a session starts."""

    quota: int | None = None
    """Bytes that fit, None for as many as the disk takes."""
    report: Callable[[str], None]

    def ftpnorm(self, ftppath: str) -> str:
        """The path with or without the unit in front."""
        # With the unit or without it, before and after normalising.
        path = str(super().ftpnorm(re.sub(rf"^/*{_UNIT}(?=/|$)", "/", ftppath, flags=re.I)))
        return re.sub(rf"^/{_UNIT}(?=/|$)", "", path, flags=re.I) or "/"

    def validpath(self, path: str) -> bool:
        """True if a path is inside the folder; a NUL in its name is invalid."""
        return "\0" not in path and bool(super().validpath(path))

    def chdir(self, path: str) -> None:
        """Enter a folder in this session only: the folder of the process is shared by threads."""
        with os.scandir(path):  # refuses what cannot be entered
            self.cwd = self.fs2ftp(path)

    def open(self, filename: str, mode: str) -> Any:
        if "r" in mode and "+" not in mode:
            return super().open(filename, mode)
        # Parts cannot be checked; the file is looked at as one.
        if "w" not in mode:
            raise FilesystemError("a file is sent whole, not in parts")
        path = FilePath(filename)
        if path.is_dir() or not path.parent.is_dir():
            raise FilesystemError("there is no such folder, or a folder of that name")
        return _Arrival(self, path)

    def rename(self, src: str, dst: str) -> None:
        """Rename a file; one that becomes a module by its new name is checked then."""
        source, target = FilePath(src), FilePath(dst)
        if source.is_file() and is_checked(target.name):
            self.look(target, read_file(source), leaving=source.name)
        if target.is_dir():
            raise FilesystemError("there is a folder of that name")
        source.replace(target)
        self.report(f"renamed {source.name} to {target.name}")

    def listdir(self, path: str) -> list[str]:
        return [name for name in super().listdir(path) if not name.startswith(UNFINISHED)]

    listdirinfo = listdir

    def look(self, path: FilePath, data: bytes, leaving: str = "") -> None:
        """Raises NotTaken if a file of that name and content would not load.

        leaving: a file that goes away by the same act.
        """
        findings = check_file(path.name, data, path.parent, leaving)
        errors = [finding for finding in findings if finding.severity is Severity.ERROR]
        if errors:
            self.report(f"refused {path.name}: {len(errors)} errors")
            raise _NotTaken(550, _refusal(path.name, errors))

    def room_for(self, path: FilePath, size: int) -> bool:
        if self.quota is None:
            return True
        files = [file for file in FilePath(self.root).rglob("*") if file.is_file()]
        return sum(f.stat().st_size for f in files if f != path) + size <= self.quota


class _Arrival:
    """A file on its way in; nothing is on the disk until `take_in`."""

    def __init__(self, home: Home, path: FilePath) -> None:
        self._home = home
        self._path = path
        self._parts: list[bytes] = []
        self._size = 0
        self.name = str(path)
        self.closed = False

    def write(self, data: bytes) -> None:
        # Counted beyond what is held, so that `take_in` can refuse the file.
        self._size += len(data)
        if self._size <= _MOST_ARRIVING:
            self._parts.append(data)

    def close(self) -> None:
        self.closed = True

    def take_in(self) -> None:
        """Looks at the whole file and puts it in its place; raises NotTaken."""
        data = b"".join(self._parts)
        if self._size > _MOST_ARRIVING or not self._home.room_for(self._path, self._size):
            raise _NotTaken(552, ["the disk is full, nothing was stored"])
        self._home.look(self._path, data)
        try:
            write_whole(self._path, data)
        except OSError as error:
            raise _NotTaken(452, [f"not stored: {error.strerror}"]) from None
        self._home.report(f"stored {self._path.name} ({len(data)} bytes)")


class _Transfer(DTPHandler):  # type: ignore[misc]
    """A data connection whose upload is taken in before it is answered."""

    def handle_close(self) -> None:
        if self._closed or not self.receive:
            super().handle_close()
            return
        # Until it is taken in, the transfer has not succeeded.
        self.transfer_finished = False
        self._resp = ("451 The virtual controller failed; nothing was stored.", self.log)
        try:
            if self._client_is_gone():
                self._resp = ("426 Connection closed; nothing was stored.", self.log)
            else:
                self.file_obj.take_in()
                self.transfer_finished = True
                self._resp = ("226 Transfer complete.", self.log)
        except _NotTaken as error:
            self._resp = (error.reply, self.log)
        finally:
            self.close()

    def _client_is_gone(self) -> bool:
        """A client that died leaves half a file, and its end looks like that of a whole one."""
        try:
            return bool(self.cmd_channel.socket.recv(1, socket.MSG_PEEK) == b"")
        except BlockingIOError:
            return False
        except OSError:
            return True


class Session(FTPHandler):  # type: ignore[misc]
    """A control connection; `VirtualIrc5` fills in the folder and the user."""

    banner = "virtual IRC5 ready"
    dtp_handler = _Transfer
    auth_failed_timeout = 0.2
    use_sendfile = False

    def add_channel(self, map: Any = None, events: Any = None) -> None:
        """Listens again, after a failed login was kept waiting, unless the client has gone.

        The number of its socket may be that of another client by then, who would never be heard.
        """
        if not getattr(self, "_closed", False):
            super().add_channel(map, events)


def _refusal(name: str, errors: list[Diagnostic]) -> list[str]:
    """The lines of an answer: that it was refused, and each finding with its place."""
    rest = len(errors) - _MOST_SAID
    lines = [f"{name} was not loaded:"]
    lines += [f"{e.where() or name} {e.code} {e.message}" for e in errors[:_MOST_SAID]]
    return [*lines, f"and {rest} more"] if rest > 0 else lines


def _plain_text(line: str) -> str:
    """A line that is safe in an answer: no line end, no control character."""
    return re.sub(r"[\x00-\x1f\x7f]", " ", line)
