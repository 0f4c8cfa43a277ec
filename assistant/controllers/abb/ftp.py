"""Client of an ABB IRC5: its file server, by FTP or FTP over TLS.

A file is stored under a temporary name, read back, compared, and only then renamed over the
one that was there: a broken transfer leaves that one whole.
"""

from __future__ import annotations

import ftplib
import io
import re
import ssl
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from typing import Final, NoReturn, Self

from assistant.controllers import rules
from assistant.controllers.address import Address
from assistant.controllers.credentials import Credentials
from assistant.controllers.os_errors_in_words import reason_of
from assistant.program.diagnostics import Refused

TEMPORARY: Final = "~{name}"
"""Name of a file until it is whole; keeps the suffix, so that a server may look into it."""
ASIDE: Final = "{name}~"
"""Where the old file waits while a server that never replaces gets the new one."""
NOT_NOW: Final = ("550", "450")
"""Replies for a file that is not there, or that somebody else has open (RFC 959, 5.4)."""
RATE: Final = 50_000.0
"""Bytes a second that a server is granted for looking through a file before it answers."""


class Ftp:
    """A session with the file server of an IRC5; see `Controller`.

    timeout: seconds for an answer; more is granted after a long file.
    certificate: file with the certificate to trust (`ftps`), None for the system's own.
    """

    languages = ("rapid",)
    lists = (".pgf",)

    def __init__(
        self,
        address: Address,
        credentials: Credentials,
        *,
        timeout: float = 30.0,
        certificate: str | FilePath | None = None,
    ) -> None:
        self.address = address
        self._credentials = credentials
        self._timeout = timeout
        self._certificate = certificate
        self._ftp: ftplib.FTP | None = None

    def __repr__(self) -> str:
        return f"Ftp({str(self.address)!r})"

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
            with suppress(OSError, EOFError, ftplib.Error):
                self._ftp.quit()
        self._hang_up()

    def names(self) -> tuple[str, ...]:
        found: list[str] = []
        with self._during("listing the folder", "nothing was changed by that"):
            try:
                self._session.retrlines("NLST", found.append)
            except ftplib.error_perm as error:
                # Servers say 550 of an empty folder; anything else is a real refusal.
                if not re.search(r"no (such )?files|not found|empty", str(error), re.IGNORECASE):
                    raise
        return tuple(sorted(line.rsplit("/", 1)[-1] for line in found))

    def read(self, name: str) -> bytes | None:
        checked_name(name)
        if not self._has(name):
            return None
        return self._retrieve(name, "nothing was changed by that")

    def write(self, name: str, data: bytes) -> None:
        checked_name(name)
        temporary = TEMPORARY.format(name=name)
        state = f"`{name}` there is as it was"
        try:
            self._store(temporary, data, f"storing `{name}`", state)
            back = self._retrieve(temporary, state)
            if back != data:
                raise Refused(
                    rules.ALTERED(
                        place=name,
                        name=name,
                        sent=len(data),
                        back=len(back),
                        at=first_difference(data, back),
                        state=state,
                    )
                )
            self._replace(temporary, name)
        except rules.Lost:
            raise
        except Refused:
            self._discard(temporary)
            raise

    def remove(self, name: str) -> None:
        checked_name(name)
        if self._has(name):
            with self._during(f"deleting `{name}`", f"`{name}` is still there"):
                self._session.delete(name)

    def hand_over(self, name: str, data: bytes) -> None:
        """Puts a small file there that appears whole; unlike `write`, it is not read back.

        Its reader has to tell by its text whether it is all there.
        """
        checked_name(name)
        temporary, doing = TEMPORARY.format(name=name), f"storing `{name}`"
        self._store(temporary, data, doing, f"`{name}` there is as it was")
        try:
            self._replace(temporary, name)
        except rules.Lost:
            raise
        except Refused:
            self._discard(temporary)
            raise

    def look(self, name: str) -> bytes | None:
        """A file without asking first whether it is there; None if it cannot be read now."""
        checked_name(name)
        data = io.BytesIO()
        with self._during(f"reading `{name}`", "nothing was changed by that"):
            try:
                self._session.retrbinary(f"RETR {name}", data.write)
            except (ftplib.error_perm, ftplib.error_temp) as error:
                if not str(error).startswith(NOT_NOW):
                    raise
                return None
        return data.getvalue()

    def take_away(self, name: str) -> None:
        """Deletes a file without asking first whether it is there."""
        checked_name(name)
        with self._during(f"deleting `{name}`", f"`{name}` may still be there"):
            try:
                self._session.delete(name)
            except (ftplib.error_perm, ftplib.error_temp) as error:
                if not str(error).startswith(NOT_NOW):
                    raise

    def name_for(self, file_name: str | FilePath) -> str:
        return checked_name(FilePath(file_name).name)

    def stored(self, data: bytes) -> bytes:
        """An IRC5 keeps files byte for byte."""
        return data

    @property
    def _session(self) -> ftplib.FTP:
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
        ftp: ftplib.FTP = ftplib.FTP()  # noqa: S321 - what the controller speaks
        if self.address.scheme == "ftps":
            ftp = ftplib.FTP_TLS(context=self._trust())  # noqa: S321 - the same, encrypted
        try:
            ftp.connect(self.address.host, self.address.port, timeout=self._timeout)
        except (OSError, EOFError, ftplib.Error) as error:
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
        except (OSError, EOFError, ftplib.Error) as error:
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
                    reply=self._said(error),
                ),
                exit_status=2,
            ) from None
        except (OSError, EOFError, ftplib.Error) as error:
            self._unreachable(error)

    def _unreachable(self, error: Exception) -> NoReturn:
        reason = self._said(error)
        raise rules.Lost(
            rules.UNREACHABLE(place=str(self.address), address=self.address, reason=reason)
        ) from None

    def _untrusted(self, reason: str) -> NoReturn:
        raise Refused(
            rules.CERTIFICATE(place=str(self.address), address=self.address, reason=reason),
            exit_status=2,
        ) from None

    def _has(self, name: str) -> bool:
        """Whether there is a file of that name; the controller's disk ignores case."""
        return name.lower() in {n.lower() for n in self.names()}

    def _store(self, name: str, data: bytes, doing: str, state: str) -> None:
        with self._during(doing, state):
            ftp = self._session
            assert ftp.sock is not None
            ftp.voidcmd("TYPE I")
            with ftp.transfercmd(f"STOR {name}") as channel:
                channel.sendall(data)
                if isinstance(channel, ssl.SSLSocket):
                    channel.unwrap()
            ftp.sock.settimeout(self._timeout + len(data) / RATE)
            try:
                ftp.voidresp()
            finally:
                ftp.sock.settimeout(self._timeout)

    def _retrieve(self, name: str, state: str) -> bytes:
        data = io.BytesIO()
        with self._during(f"reading `{name}`", state):
            self._session.retrbinary(f"RETR {name}", data.write)
        return data.getvalue()

    def _replace(self, temporary: str, name: str) -> None:
        """Renames over the old file, or, where a server never replaces, past it."""
        unknown = f"`{name}` there is either the old file or the new one, whole"
        session = self._session
        try:
            with self._during(f"renaming `{temporary}` to `{name}`", unknown):
                session.rename(temporary, name)
        except rules.Lost:
            raise
        except Refused:
            if not self._has(name):
                raise
        else:
            return
        aside = ASIDE.format(name=name)
        state = f"`{name}` there is as it was"
        with self._during(f"renaming `{name}` to `{aside}`", state):
            session.rename(name, aside)
        try:
            with self._during(f"renaming `{temporary}` to `{name}`", f"the old file is `{aside}`"):
                session.rename(temporary, name)
        except rules.Lost:
            raise
        except Refused:
            with self._during(
                f"renaming `{aside}` back to `{name}`",
                f"there is no `{name}` on the controller now, the old file is `{aside}`",
            ):
                session.rename(aside, name)
            raise
        with self._during(f"deleting `{aside}`", f"`{name}` is the new file"):
            session.delete(aside)

    def _discard(self, name: str) -> None:
        """Deletes what is left of a transfer; a rest that stays is overwritten by the next."""
        with suppress(OSError, EOFError, ftplib.Error):
            if self._ftp is not None:
                self._ftp.delete(name)

    @contextmanager
    def _during(self, doing: str, state: str) -> Iterator[None]:
        """Turns what goes wrong inside into a finding with the state of the controller."""
        place = str(self.address)
        try:
            yield
        except (ftplib.error_perm, ftplib.error_temp) as error:
            reply = self._said(error)
            if reply.startswith("421"):  # the server says good-bye
                self._hang_up()
                raise rules.Lost(
                    rules.LOST(place=place, doing=doing, reason=reply, state=state)
                ) from None
            raise Refused(
                rules.REFUSED(place=place, doing=doing, reply=reply, state=state)
            ) from None
        except (OSError, EOFError, ftplib.Error) as error:
            self._hang_up()
            raise rules.Lost(
                rules.LOST(place=place, doing=doing, reason=self._said(error), state=state)
            ) from None

    def _said(self, error: Exception) -> str:
        return self._credentials.hidden(reason_of(error))

    def _hang_up(self) -> None:
        if self._ftp is not None:
            self._ftp.close()
            self._ftp = None


def checked_name(name: str) -> str:
    """The name, if a file of an IRC5 can have it; raises Refused."""
    checks = (
        (not name, "it is empty"),
        (len(name) > 64, "it has more than 64 characters"),
        (name.startswith(("~", ".", "-")), "it must begin with a letter, digit or `_`"),
        (name.endswith(("~", ".", " ")), "it must end with a letter, digit or `_`"),
        (
            re.fullmatch(r"[A-Za-z0-9_. ~-]*", name) is None,
            "only ASCII letters, digits, blanks, `_`, `-` and `.` are safe",
        ),
    )
    for wrong, reason in checks:
        if wrong:
            raise Refused(rules.FILE_NAME(place=name, name=name, reason=reason))
    return name


def first_difference(left: bytes, right: bytes) -> int:
    """Index of the first byte that differs."""
    low, high = 0, min(len(left), len(right))
    while low < high:  # the first `low` bytes are equal, the first `high + 1` are not
        middle = (low + high + 1) // 2
        low, high = (middle, high) if left[:middle] == right[:middle] else (low, middle - 1)
    return low
