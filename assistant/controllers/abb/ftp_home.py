"""Find the folder that RAPID programs know as `HOME:`, wherever the FTP server has its root.

A server may name it `HOME:`, serve the disk of the controller (`/hd0a/<system>/HOME`), or begin in
it. An address without a folder means that folder.
"""

from __future__ import annotations

import ftplib
from collections.abc import Callable
from typing import Final, Protocol

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.abb.ftp_lines import BoundedFtp
from assistant.controllers.address import SCHEMES, Address

HOME: Final = "HOME"
HOME_PLACES: Final = (HOME, "/HOME:", f"/{HOME}")
"""Folders to try on servers without a `HOME:` where the login begins."""
DISK: Final = "/hd0a"
"""The controller's disk, on which each installed system has a folder with its own `HOME`."""
MOST_SYSTEMS: Final = 64
"""Most folders of a disk that are tried."""


class FolderSession(Protocol):
    """The part of a session that finding the folder needs."""

    address: Address
    tell: Callable[[Diagnostic], None]

    def said(self, error: Exception) -> str: ...

    def lines(self, command: str) -> list[str]: ...


def enter_home_folder(session: FolderSession, ftp: BoundedFtp) -> None:
    """Enter the folder of the address; raise Refused if it is missing, or one of several.

    `session.tell` gets a finding where another folder than that of the address was entered. Raises
    ftplib's errors for all but a refused folder.
    """
    address = session.address
    folder = address.folder
    try:
        ftp.cwd(folder)
    except ftplib.error_perm as error:
        reply = session.said(error)
    else:
        return
    start = ftp.pwd() or "/"
    if folder != SCHEMES[address.scheme].folder:
        if not _enters(ftp, f"/{folder}"):
            raise Refused(
                rules.NO_FOLDER(place=str(address), address=address, folder=folder, reply=reply),
                exit_status=2,
            )
        _found(session, f"/{folder}")
        return
    if start.rstrip("/").rpartition("/")[2].upper() in (HOME, f"{HOME}:"):
        _found(session, start)
        return
    for place in HOME_PLACES:
        if _enters(ftp, place):
            _found(session, ftp.pwd() or place)
            return
    homes = _homes_of_systems(session, ftp, start)
    if len(homes) > 1:
        listed = ", ".join(f"`{home}`" for home in homes)
        first = homes[0].lstrip("/")
        finding = rules.SEVERAL_FOLDERS(
            place=str(address), address=address, listed=listed, first=first
        )
        raise Refused(finding, exit_status=2)
    if homes:
        ftp.cwd(homes[0])
        _found(session, homes[0])
        return
    ftp.cwd(start)
    session.tell(rules.LOGIN_FOLDER(place=str(address), address=address, folder=start))


def _homes_of_systems(session: FolderSession, ftp: BoundedFtp, start: str) -> list[str]:
    """Folders `HOME` of the systems on the disk, or else below the folder of the login."""
    for disk in dict.fromkeys((DISK, start)):
        if not _enters(ftp, disk):
            continue
        try:
            names = sorted({line.rsplit("/", 1)[-1] for line in session.lines("NLST")})
        except ftplib.error_perm:  # as servers answer of an empty folder
            names = []
        found = []
        for name in [name for name in names if name not in (".", "..")][:MOST_SYSTEMS]:
            home = f"{disk.rstrip('/')}/{name}/{HOME}"
            if _enters(ftp, home):
                found.append(home)
        if found:
            return found
    return []


def _enters(ftp: BoundedFtp, folder: str) -> bool:
    """Enter a folder; False if the server refuses it."""
    try:
        ftp.cwd(folder)
    except ftplib.error_perm:
        return False
    return True


def _found(session: FolderSession, folder: str) -> None:
    """Report the folder that was entered in place of that of the address."""
    address = session.address
    finding = rules.FOUND_FOLDER(
        place=str(address), address=address, wanted=address.folder, folder=folder
    )
    session.tell(finding)
