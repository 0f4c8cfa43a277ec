"""FTP connection with time-outs for complete answers, any bytes in names, and TLS; and `HOME:`.

`enter_home_folder` finds the folder that RAPID programs know as `HOME:`. A server may name it
`HOME:`, serve the disk of the controller (`/hd0a/<system>/HOME`), or begin in it. An address
without a folder means that folder.
"""

from __future__ import annotations

import ftplib
import socket
import ssl
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Final, Protocol

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import connection, rules
from assistant.controllers.address import SCHEMES, Address
from assistant.controllers.connection import TransferDeadline

BYTE_ENCODING: Final = "latin-1"
"""In which ftplib reads and writes: each character is a byte, so that nothing is ever refused."""


class BoundedFtp(ftplib.FTP):
    """FTP whose answers must be complete within the socket's time-out; ftplib grants it per byte.

    spelling: encoding of names. Servers with names that are not UTF-8 use Latin-1.
    """

    spelling = "utf-8"

    def __init__(self) -> None:
        super().__init__()
        self.encoding = BYTE_ENCODING

    def getmultiline(self) -> str:
        channel = self.sock
        assert channel is not None
        with TransferDeadline(channel.gettimeout() or 0.0, partial(cut_line, channel)):
            return super().getmultiline()

    def putline(self, line: str) -> None:
        try:
            # surrogateescape gives back bytes that were no UTF-8 exactly as they came.
            data = line.encode(self.spelling, "surrogateescape")
        except UnicodeEncodeError:
            data = line.encode("utf-8", "replace")
        super().putline(data.decode(BYTE_ENCODING))

    def ntransfercmd(
        self, cmd: str, rest: int | str | None = None
    ) -> tuple[socket.socket, int | None]:
        try:
            return super().ntransfercmd(cmd, rest)
        except ValueError:  # a number of thousands of digits
            raise OverflowError("a number that makes no sense") from None

    def pwd(self) -> str:
        return super().pwd().encode(BYTE_ENCODING).decode(self.spelling, "surrogateescape")


class BoundedFtpTls(BoundedFtp, ftplib.FTP_TLS):
    """The same, encrypted. Every transfer resumes the TLS session of the commands.

    By that a server knows that no other client took the transfer over; vsftpd and proftpd refuse
    others in their default settings (`require_ssl_reuse=YES`, no `NoSessionReuseRequired`).
    """

    def __init__(self, context: ssl.SSLContext) -> None:
        super().__init__()
        self.context = context
        self.private = False

    def prot_p(self) -> str:
        """Without ftplib's own, which would encrypt transfers as new sessions."""
        # ftplib's own `prot_p` would wrap transfers itself, as new sessions.
        self.voidcmd("PBSZ 0")
        answer = self.voidcmd("PROT P")
        self.private = True
        return answer

    def ntransfercmd(
        self, cmd: str, rest: int | str | None = None
    ) -> tuple[socket.socket, int | None]:
        channel, size = super().ntransfercmd(cmd, rest)
        if not self.private:
            return channel, size
        session = self.sock.session if isinstance(self.sock, ssl.SSLSocket) else None
        try:
            # The session of the commands proves that the same client opens the transfer.
            wrapped = self.context.wrap_socket(channel, server_hostname=self.host, session=session)
        except BaseException:
            channel.close()
            raise
        return wrapped, size


def cut_line(channel: socket.socket) -> None:
    """Ends a line in both directions, below TLS, so that whoever waits for it meets its end."""
    with suppress(OSError):
        # Below TLS: its own closing would wait for the other side.
        socket.socket.shutdown(channel, socket.SHUT_RDWR)


def decoded_line(text: str) -> str:
    """A line as people read it: UTF-8 if it is that, else Latin-1."""
    try:
        return text.encode(BYTE_ENCODING).decode("utf-8")
    except UnicodeError:
        return text


def certificate_of_server(host: str, port: int, timeout: float) -> bytes:
    """The certificate of a file server; raises OSError and what ftplib raises, no SSLError."""
    ftp = BoundedFtpTls(connection.unverified_context())
    try:
        ftp.connect(host, port, timeout=timeout)
        ftp.auth()
        assert isinstance(ftp.sock, ssl.SSLSocket)
        return ftp.sock.getpeercert(binary_form=True) or b""
    except ssl.SSLError as error:
        raise OSError(str(error)) from None
    finally:
        ftp.close()


HOME: Final = "HOME"
_HOME_PLACES: Final = (HOME, "/HOME:", f"/{HOME}")
"""Folders to try on servers without a `HOME:` where the login begins."""
_DISK: Final = "/hd0a"
"""The controller's disk, on which each installed system has a folder with its own `HOME`."""
_MOST_SYSTEMS: Final = 64
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
    # A folder that was stated is entered as it is, from the root at most: no other one is guessed.
    if folder != SCHEMES[address.scheme].folder:
        if not _enters(ftp, f"/{folder}"):
            raise Refused(
                rules.NO_FOLDER(place=str(address), address=address, folder=folder, reply=reply),
                exit_status=2,
            )
        _found(session, f"/{folder}")
        return
    # The login begins in the folder itself.
    if start.rstrip("/").rpartition("/")[2].upper() in (HOME, f"{HOME}:"):
        _found(session, start)
        return
    # From the likeliest to the dearest: each try is a round trip, the disk takes many.
    for place in _HOME_PLACES:
        if _enters(ftp, place):
            _found(session, ftp.pwd() or place)
            return
    homes = _homes_of_systems(session, ftp, start)
    # Several installed systems: only the user knows which one runs.
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
    for disk in dict.fromkeys((_DISK, start)):
        if not _enters(ftp, disk):
            continue
        try:
            names = sorted({line.rsplit("/", 1)[-1] for line in session.lines("NLST")})
        except ftplib.error_perm:  # as servers answer of an empty folder
            names = []
        found = []
        for name in [name for name in names if name not in (".", "..")][:_MOST_SYSTEMS]:
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
