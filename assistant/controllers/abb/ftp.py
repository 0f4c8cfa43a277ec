"""Client of an ABB IRC5: its file server, by FTP or FTP over TLS."""

from __future__ import annotations

import ftplib
import io
import re
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb import ftp_folders, ftp_resuming
from assistant.controllers.abb.files import (
    TEMPORARY,
    checked_name,
    checked_path,
    first_difference,
    free_aside,
)
from assistant.controllers.abb.ftp_session import FtpSession

__all__ = ["Ftp", "checked_name", "first_difference"]

NOT_NOW: Final = ("550", "450")
"""Replies for a file that is not there, or that somebody else has open (RFC 959, 5.4)."""


class Ftp(FtpSession):
    """Programs on an IRC5 by FTP; see `Programs`.

    The address may say `?mode=active`: the controller connects to this computer for each file then,
    instead of this computer to the controller.
    """

    def names(self) -> tuple[str, ...]:
        found: list[str] = []
        with self.during("listing the folder", "nothing was changed by that"):
            try:
                found = self.lines("NLST")
            except ftplib.error_perm as error:
                # Servers say 550 of an empty folder; anything else is a real refusal.
                if not re.search(r"no (such )?files|not found|empty", str(error), re.IGNORECASE):
                    raise
            # A list that was cut looks whole; that the session goes on tells that it was not.
            with suppress(ftplib.error_perm):
                self.session.voidcmd("NOOP")
        return tuple(sorted({line.rsplit("/", 1)[-1] for line in found} - {".", ".."}))

    def read(self, name: str) -> bytes | None:
        checked_name(name)
        if not self._has(name) and self.size(name) is None:
            return None
        return ftp_resuming.read_whole(self, name)

    def remove(self, name: str) -> None:
        checked_name(name)
        if self._has(name):
            self.delete(name)

    def delete(self, name: str) -> None:
        with self.during(f"deleting `{name}`", f"`{name}` is still there"):
            self.session.delete(name)

    def claim(self, name: str) -> bool:
        """Makes a folder; False if there is one. Of many clients the server lets one do it."""
        checked_name(name)
        try:
            with self.during(f"making the folder `{name}`", "nothing was changed by that"):
                self.session.mkd(name)
        except rules.Lost:
            raise
        except Refused:
            if self._has(name):
                return False
            raise
        return True

    def release(self, name: str) -> None:
        """Removes an empty folder; nothing happens if there is none."""
        if self._has(checked_name(name)):
            with self.during(f"removing the folder `{name}`", f"`{name}` is still there"):
                self.session.rmd(name)

    def is_folder(self, name: str) -> bool:
        """True if there is a folder of that name: the session can enter it."""
        checked_name(name)
        with self.during(f"looking for `{name}`", "nothing was changed by that"):
            home = self.session.pwd()
            try:
                self.session.cwd(name)
            except ftplib.error_perm:
                return False
            self.session.cwd(home)
        return True

    def look(self, name: str) -> bytes | None:
        """A file without asking first whether it is there; None if it cannot be read now."""
        checked_name(name)
        data = io.BytesIO()
        with self.during(f"reading `{name}`", "nothing was changed by that"):
            try:
                self.receive(f"RETR {name}", data.write)
            except (ftplib.error_perm, ftplib.error_temp) as error:
                if not str(error).startswith(NOT_NOW):
                    raise
                return None
        return data.getvalue()

    def take_away(self, name: str) -> bool:
        """Deletes a file without asking first whether it is there; False if it is not."""
        checked_name(name)
        with self.during(f"deleting `{name}`", f"`{name}` may still be there"):
            try:
                self.session.delete(name)
            except (ftplib.error_perm, ftplib.error_temp) as error:
                if not str(error).startswith(NOT_NOW):
                    raise
                return False
        return True

    def size(self, name: str) -> int | None:
        """Bytes of a file, None if there is none or the server does not tell."""
        return ftp_resuming.file_size(self, checked_path(name))

    def download(
        self, name: str, to: str | FilePath, progress: ftp_resuming.Progress | None = None
    ) -> int:
        """Fetches a file, also out of folders, into one of this computer; its bytes.

        It appears there when it is whole. What an interrupted transfer left beside it, in
        `<to>.part`, is gone on with, unless the file has changed on the controller meanwhile.
        """
        return ftp_resuming.download(self, checked_path(name), FilePath(to), progress)

    def upload(self, name: str, data: bytes) -> None:
        """As `write`; goes on with what an interrupted `upload` left on the controller.

        What is there is read and compared first: of the bytes that went through none is trusted.
        """
        checked_name(name)
        ftp_resuming.upload(self, name, data)
        temporary = TEMPORARY.format(name=name)
        with self._discarding(temporary):
            self.replace(temporary, name)

    def tree(self, folder: str = "") -> tuple[ftp_folders.Entry, ...]:
        """All files and folders below a folder, `HOME:` or one of the address for ""."""
        return ftp_folders.folder_tree(self, folder)

    def fetch_folder(self, folder: str, into: str | FilePath) -> tuple[str, ...]:
        """Fetches a whole folder of the controller into a new one; its files, relative to it.

        The new folder appears when all of it is there, with an index as every backup has.
        """
        return ftp_folders.fetch_tree(self, folder, FilePath(into))

    def _has(self, name: str) -> bool:
        """Whether there is a file of that name; the controller's disk ignores case."""
        return name.lower() in {n.lower() for n in self.names()}

    def replace(self, temporary: str, name: str) -> None:
        """Renames over the old file, or, where a server never replaces, past it."""
        unknown = f"`{name}` there is either the old file or the new one, whole"
        session = self.session
        try:
            with self.during(f"renaming `{temporary}` to `{name}`", unknown):
                session.rename(temporary, name)
        except rules.Lost:
            raise
        except Refused:
            there = self.names()
            if name.lower() not in map(str.lower, there):
                raise
        else:
            return
        aside = free_aside(name, there)
        state = f"`{name}` there is as it was"
        with self.during(f"renaming `{name}` to `{aside}`", state):
            session.rename(name, aside)
        try:
            with self.during(f"renaming `{temporary}` to `{name}`", f"the old file is `{aside}`"):
                session.rename(temporary, name)
        except rules.Lost:
            raise
        except Refused:
            with self.during(
                f"renaming `{aside}` back to `{name}`",
                f"there is no `{name}` on the controller now, the old file is `{aside}`",
            ):
                session.rename(aside, name)
            raise
        with self.during(f"deleting `{aside}`", f"`{name}` is the new file"):
            session.delete(aside)
