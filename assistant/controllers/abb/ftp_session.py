"""A session with an FTP server: connecting, transfers, and what goes wrong with them."""

from __future__ import annotations

import ftplib
import io
import re
import socket
import ssl
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path as FilePath
from typing import Final, NoReturn, Self

from assistant.controllers import rules
from assistant.controllers.abb.files import FileSession
from assistant.controllers.address import Address
from assistant.controllers.credentials import Credentials
from assistant.controllers.os_errors_in_words import reason_of
from assistant.controllers.pace import Pace
from assistant.program.diagnostics import Refused

RATE: Final = 50_000.0
"""Bytes a second that a server is granted for looking through a file before it answers."""
LISTING: Final = 10
"""Time-outs in which a whole listing has to come."""
PIECE: Final = 65536
"""Bytes that are sent or received at once."""
FAILURES: Final = (OSError, EOFError, ftplib.Error, OverflowError, UnicodeDecodeError)
"""What ftplib raises where there is no connection any more, or the answer makes no sense: no port
is that large, no text has those bytes."""


class _InTime(ftplib.FTP):
    """Answers that are whole within the time-out of the socket; ftplib grants it to each byte."""

    def getmultiline(self) -> str:
        channel = self.sock
        assert channel is not None
        with Pace(channel.gettimeout() or 0.0, partial(_cut, channel)):
            return super().getmultiline()


class _TlsInTime(_InTime, ftplib.FTP_TLS):
    """The same, encrypted."""


def _cut(channel: socket.socket) -> None:
    """Ends a line in both directions, below TLS, so that whoever waits for it meets its end."""
    with suppress(OSError):
        socket.socket.shutdown(channel, socket.SHUT_RDWR)


class FtpSession(FileSession):
    """A session with the file server of a controller; a context manager.

    timeout: seconds for an answer; more is granted after a long file.
    certificate: file with the certificate to trust (`ftps`), None for the system's own.
    """

    def __init__(
        self,
        address: Address,
        credentials: Credentials,
        *,
        timeout: float = 30.0,
        certificate: str | FilePath | None = None,
    ) -> None:
        super().__init__(address, credentials, timeout=timeout, certificate=certificate)
        self._ftp: ftplib.FTP | None = None

    def __enter__(self) -> Self:
        """Connects, logs in and goes to the folder of the address."""
        try:
            self._ftp = self._connected()
            self._login(self._ftp)
            self._enter_folder(self._ftp)
        except BaseException:
            self._hang_up()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        if self._ftp is not None:
            with suppress(*FAILURES):
                self._ftp.quit()
        self._hang_up()

    @property
    def session(self) -> ftplib.FTP:
        if self._ftp is None:
            raise rules.Lost(
                rules.LOST(
                    place=str(self.address),
                    doing="waiting",
                    reason="there is no session",
                    state="nothing was changed by that",
                )
            )
        return self._ftp

    def _connected(self) -> ftplib.FTP:
        ftp: ftplib.FTP = _InTime()
        if self.address.scheme == "ftps":
            ftp = _TlsInTime(context=self._trust())
        ftp.set_pasv(self.address.option("mode", "passive") == "passive")
        try:
            ftp.connect(self.address.host, self.address.port, timeout=self._timeout)
        except FAILURES as error:
            ftp.close()
            self._unreachable(error)
        return ftp

    def _trust(self) -> ssl.SSLContext:
        try:
            return ssl.create_default_context(
                cafile=str(self._certificate) if self._certificate else None
            )
        except (OSError, ssl.SSLError) as error:
            self._untrusted(f"`{self._certificate}`: {reason_of(error)}")

    def _login(self, ftp: ftplib.FTP) -> None:
        name = self._credentials.user
        try:
            ftp.login(name, self._credentials.password)
            if isinstance(ftp, ftplib.FTP_TLS):
                ftp.prot_p()
        except ssl.SSLError as error:
            self._untrusted(reason_of(error))
        except UnicodeDecodeError as error:
            self._unreachable(error)
        except ftplib.error_perm as error:
            reply = self._credentials.hidden(str(error))
            raise Refused(
                rules.LOGIN(place=str(self.address), address=self.address, user=name, reply=reply),
                exit_status=2,
            ) from None
        except ValueError:
            # ftplib: a line end in the user or the password would be a second command.
            raise Refused(
                rules.LOGIN(
                    place=str(self.address),
                    address=self.address,
                    user=name,
                    reply="a line end in the user or the password",
                ),
                exit_status=2,
            ) from None
        except FAILURES as error:
            self._unreachable(error)

    def _enter_folder(self, ftp: ftplib.FTP) -> None:
        try:
            ftp.cwd(self.address.folder)
        except ftplib.error_perm as error:
            raise Refused(
                rules.NO_FOLDER(
                    place=str(self.address),
                    address=self.address,
                    folder=self.address.folder,
                    reply=self.said(error),
                ),
                exit_status=2,
            ) from None
        except FAILURES as error:
            self._unreachable(error)

    def _unreachable(self, error: Exception) -> NoReturn:
        reason = self.said(error)
        raise rules.Lost(
            rules.UNREACHABLE(place=str(self.address), address=self.address, reason=reason)
        ) from None

    def _untrusted(self, reason: str) -> NoReturn:
        raise Refused(
            rules.CERTIFICATE(place=str(self.address), address=self.address, reason=reason),
            exit_status=2,
        ) from None

    def store(self, name: str, data: bytes, doing: str, state: str, command: str = "STOR") -> None:
        """Sends a file. command: `APPE` to send what follows on what is there."""
        with self.during(doing, state):
            ftp = self.session
            assert ftp.sock is not None
            left = memoryview(data)
            with self._transfer(ftp, f"{command} {name}") as (channel, pace):
                while left:
                    sent = channel.send(left[:PIECE])
                    pace.moved(sent)
                    left = left[sent:]
            ftp.sock.settimeout(self._timeout + len(data) / RATE)
            try:
                ftp.voidresp()
            finally:
                ftp.sock.settimeout(self._timeout)

    def retrieve(self, name: str, state: str, start: int = 0) -> bytes:
        """The bytes of a file from `start` on."""
        data = io.BytesIO()
        self.retrieve_into(name, state, data.write, start)
        return data.getvalue()

    def retrieve_into(
        self, name: str, state: str, sink: Callable[[bytes], object], start: int = 0
    ) -> None:
        with self.during(f"reading `{name}`", state):
            self.receive(f"RETR {name}", sink, start=start)

    def receive(
        self, command: str, sink: Callable[[bytes], object], *, kind: str = "TYPE I", start: int = 0
    ) -> None:
        """What a command brings, piece by piece, at the pace of `Pace`; raises as ftplib does."""
        ftp = self.session
        with self._transfer(ftp, command, kind, start) as (channel, pace):
            while piece := channel.recv(PIECE):
                pace.moved(len(piece))
                sink(piece)
        ftp.voidresp()

    def lines(self, command: str) -> list[str]:
        """Lines of a listing; bytes that are no UTF-8 are taken for Latin-1. Raises as ftplib does.

        All of it has to come in `LISTING` time-outs.
        """
        data = bytearray()
        until = time.monotonic() + LISTING * self._timeout

        def take(piece: bytes) -> None:
            data.extend(piece)
            if time.monotonic() > until:
                raise TimeoutError

        self.receive(command, take, kind="TYPE A")
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
            self.session.encoding = "latin-1"  # names go back as they came
        return [line for line in re.split(r"\r?\n", text) if line]

    @contextmanager
    def _transfer(
        self, ftp: ftplib.FTP, command: str, kind: str = "TYPE I", start: int = 0
    ) -> Iterator[tuple[socket.socket, Pace]]:
        """The channel of a transfer, which is cut where it does not keep its pace."""
        ftp.voidcmd(kind)
        with (
            ftp.transfercmd(command, start or None) as channel,
            Pace(self._timeout, partial(_cut, channel)) as pace,
        ):
            yield channel, pace
            if isinstance(channel, ssl.SSLSocket):
                channel.unwrap()

    def discard(self, name: str) -> None:
        """Deletes what is left of a transfer; a rest that stays is overwritten by the next."""
        with suppress(*FAILURES):
            if self._ftp is not None:
                self._ftp.delete(name)

    @contextmanager
    def during(self, doing: str, state: str) -> Iterator[None]:
        """Turns what goes wrong inside into a finding with the state of the controller."""
        place = str(self.address)
        try:
            yield
        except (ftplib.error_perm, ftplib.error_temp) as error:
            reply = self.said(error)
            if reply.startswith("421"):  # the server says good-bye
                self._hang_up()
                raise rules.Lost(
                    rules.LOST(place=place, doing=doing, reason=reply, state=state)
                ) from None
            raise Refused(
                rules.REFUSED(place=place, doing=doing, reply=reply, state=state)
            ) from None
        except FAILURES as error:
            self._hang_up()
            raise rules.Lost(
                rules.LOST(place=place, doing=doing, reason=self.said(error), state=state)
            ) from None

    def _hang_up(self) -> None:
        if self._ftp is not None:
            self._ftp.close()
            self._ftp = None
