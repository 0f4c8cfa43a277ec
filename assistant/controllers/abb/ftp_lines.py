"""What ftplib is made to do: answers within a time-out, any bytes in names, sessions of TLS."""

from __future__ import annotations

import ftplib
import socket
import ssl
from contextlib import suppress
from functools import partial
from typing import Final

from assistant.controllers.abb import trust
from assistant.controllers.pace import TransferDeadline

BYTE_ENCODING: Final = "latin-1"
"""In which ftplib reads and writes: each character is a byte, so that nothing is ever refused."""


class BoundedFtp(ftplib.FTP):
    """Answers that are whole within the time-out of the socket; ftplib grants it to each byte.

    spelling: how names are spelled in bytes. Servers with names that are no UTF-8 have Latin-1.
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
    """The same, encrypted. Every transfer goes on with the TLS session of the commands.

    By that a server knows that nobody else took the transfer over; vsftpd and proftpd refuse
    others as they are delivered (`require_ssl_reuse=YES`, no `NoSessionReuseRequired`).
    """

    def __init__(self, context: ssl.SSLContext) -> None:
        super().__init__()
        self.context = context
        self.private = False

    def prot_p(self) -> str:
        """Without ftplib's own, which would encrypt transfers as new sessions."""
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
            wrapped = self.context.wrap_socket(channel, server_hostname=self.host, session=session)
        except BaseException:
            channel.close()
            raise
        return wrapped, size


def cut_line(channel: socket.socket) -> None:
    """Ends a line in both directions, below TLS, so that whoever waits for it meets its end."""
    with suppress(OSError):
        socket.socket.shutdown(channel, socket.SHUT_RDWR)


def decoded_line(text: str) -> str:
    """A line as people read it: UTF-8 if it is that, else Latin-1."""
    try:
        return text.encode(BYTE_ENCODING).decode("utf-8")
    except UnicodeError:
        return text


def certificate_of_server(host: str, port: int, timeout: float) -> bytes:
    """The certificate of a file server; raises OSError and what ftplib raises, no SSLError."""
    ftp = BoundedFtpTls(trust.unverified_context())
    try:
        ftp.connect(host, port, timeout=timeout)
        ftp.auth()
        assert isinstance(ftp.sock, ssl.SSLSocket)
        return ftp.sock.getpeercert(binary_form=True) or b""
    except ssl.SSLError as error:
        raise OSError(str(error)) from None
    finally:
        ftp.close()
