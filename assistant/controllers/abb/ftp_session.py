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

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.abb import ftp_home, trust
from assistant.controllers.abb.files import FileSession
from assistant.controllers.abb.ftp_lines import (
    BYTE_ENCODING,
    BoundedFtp,
    BoundedFtpTls,
    certificate_of_server,
    cut_line,
    decoded_line,
)
from assistant.controllers.address import Address
from assistant.controllers.credentials import Credentials
from assistant.controllers.os_errors_in_words import reason_of
from assistant.controllers.pace import TransferDeadline

SEARCH_RATE: Final = 50_000.0
"""Bytes a second that a server is granted for looking through a file before it answers."""
LISTING_TIMEOUTS: Final = 10
"""Time-outs in which a whole listing has to come."""
PIECE: Final = 65536
"""Bytes that are sent or received at once."""
FAILURES: Final = (OSError, EOFError, ftplib.Error, OverflowError)
"""What ftplib raises where there is no connection any more, or the answer makes no sense: no port
is that large."""


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
        self._ftp: BoundedFtp | None = None
        self.tell: Callable[[Diagnostic], None] = lambda _: None
        """Called with a finding if another folder than that of the address was entered."""

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
    def session(self) -> BoundedFtp:
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

    def _connected(self) -> BoundedFtp:
        secure = self.address.scheme == "ftps"
        ftp = BoundedFtpTls(self._trust()) if secure else BoundedFtp()
        ftp.set_pasv(self.address.option("mode", "passive") == "passive")
        try:
            ftp.connect(self.address.host, self.address.port, timeout=self._timeout)
        except FAILURES as error:
            ftp.close()
            self._unreachable(error)
        if isinstance(ftp, BoundedFtpTls):
            self._encrypt(ftp)
        return ftp

    def _encrypt(self, ftp: BoundedFtpTls) -> None:
        """Goes over to TLS before anything that is secret is sent."""
        try:
            ftp.auth()
        except ssl.SSLError as error:
            ftp.close()
            self._untrusted(reason_of(error))
        except ftplib.error_perm as error:
            ftp.close()
            self._no_tls(error, "nothing that is secret was sent")
        except FAILURES as error:
            ftp.close()
            self._unreachable(error)

    def _trust(self) -> ssl.SSLContext:
        """What the server is checked with; its certificate is looked at where a file is given."""
        shown = partial(certificate_of_server, self.address.host, self.address.port, self._timeout)
        try:
            return trust.tls_context(self._certificate, shown)
        except trust.BadCertificateFile as error:
            self._untrusted(f"`{self._certificate}`: {error}")
        except ftplib.error_perm as error:
            self._no_tls(error, "nothing that is secret was sent")
        except FAILURES as error:
            self._unreachable(error)

    def _no_tls(self, error: ftplib.Error, state: str) -> NoReturn:
        """Of a server that refused to go over to TLS."""
        place, reply = self.address, self.said(error)
        raise Refused(
            rules.NO_TLS(place=str(place), address=place, reply=reply, state=state), exit_status=2
        ) from None

    def _login(self, ftp: BoundedFtp) -> None:
        name = self._credentials.user
        try:
            ftp.login(name, self._credentials.password)
            if isinstance(ftp, BoundedFtpTls):
                self._keep_private(ftp)
        except ftplib.error_perm as error:
            reply = self.said(error)
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

    def _keep_private(self, ftp: BoundedFtpTls) -> None:
        """Has the files go over TLS as well as the commands."""
        try:
            ftp.prot_p()
        except ftplib.error_perm as error:
            self._no_tls(error, "no file was sent")

    def _enter_folder(self, ftp: BoundedFtp) -> None:
        try:
            ftp_home.enter_home_folder(self, ftp)
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
            ftp.sock.settimeout(self._timeout + len(data) / SEARCH_RATE)
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
        until = time.monotonic() + LISTING_TIMEOUTS * self._timeout

        def take(piece: bytes) -> None:
            data.extend(piece)
            if time.monotonic() > until:
                raise TimeoutError

        self.receive(command, take, kind="TYPE A")
        try:
            text = data.decode(self.session.spelling)
        except UnicodeDecodeError:
            text = data.decode(BYTE_ENCODING)
            self.session.spelling = BYTE_ENCODING  # names go back as they came
        return [line for line in re.split(r"\r?\n", text) if line]

    @contextmanager
    def _transfer(
        self, ftp: BoundedFtp, command: str, kind: str = "TYPE I", start: int = 0
    ) -> Iterator[tuple[socket.socket, TransferDeadline]]:
        """The channel of a transfer, which is cut where it does not keep its pace."""
        ftp.voidcmd(kind)
        with (
            ftp.transfercmd(command, start or None) as channel,
            TransferDeadline(self._timeout, partial(cut_line, channel)) as pace,
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

    def said(self, error: Exception) -> str:
        """What a server said is UTF-8 or Latin-1; see `FileSession.said`."""
        text = reason_of(error)
        if isinstance(error, ftplib.Error):
            text = decoded_line(text)
        return self._credentials.hidden(text)

    def _hang_up(self) -> None:
        if self._ftp is not None:
            self._ftp.close()
            self._ftp = None
