"""Client of an ABB IRC5: its file server, by FTP or FTP over TLS.

Listings: MLSD gives exact entries (RFC 3659). Servers without it, vsftpd and that of VxWorks among
them, have LIST, with lines of `ls -l` or DOS. Otherwise names come from NLST, and an entry that can
be entered is a folder.
Long transfers are resumed. Servers differ in REST and STOR: some overwrite in place, pure-ftpd cuts
the file at the offset. So an upload goes on by APPE after the part on the server was read back and
compared; a download goes on only if the file still has its size and time and the same bytes at the
end of the local part.
"""

from __future__ import annotations

import ftplib
import io
import json
import os
import re
import socket
import ssl
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path as FilePath
from typing import BinaryIO, Final, Literal, NoReturn, Self

from assistant.base import file_access
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.file_access import read_text
from assistant.controllers import backup_folder, connection, rules
from assistant.controllers.abb import ftp_connection
from assistant.controllers.abb.files import (
    MOST_ENTRIES,
    MOST_FOLDERS,
    TEMPORARY,
    FileSession,
    checked_name,
    checked_path,
    first_difference,
    free_aside,
    told_name,
)
from assistant.controllers.abb.ftp_connection import (
    BYTE_ENCODING,
    BoundedFtp,
    BoundedFtpTls,
    certificate_of_server,
    cut_line,
    decoded_line,
)
from assistant.controllers.address import Address, Credentials
from assistant.controllers.connection import TransferDeadline, reason_of

_SEARCH_RATE: Final = 50_000.0
"""Bytes a second that a server is granted for looking through a file before it answers."""
_LISTING_TIMEOUTS: Final = 10
"""Time-outs in which a whole listing has to come."""
_PIECE: Final = 65536
"""Bytes that are sent or received at once."""
_FAILURES: Final = (OSError, EOFError, ftplib.Error, OverflowError)
"""Exceptions of ftplib for a lost connection or a senseless answer: no port is that large."""


class Ftp(FileSession):
    """Programs on an IRC5 by FTP, see `Programs`; a context manager.

    The address may say `?mode=active`: the controller connects to this computer for each file then,
    instead of this computer to the controller.

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
            with suppress(*_FAILURES):
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
        # The command before the transfer: passive mode decides how `transfercmd` connects.
        ftp.set_pasv(self.address.option("mode", "passive") == "passive")
        try:
            ftp.connect(self.address.host, self.address.port, timeout=self._timeout)
        except _FAILURES as error:
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
        except _FAILURES as error:
            ftp.close()
            self._unreachable(error)

    def _trust(self) -> ssl.SSLContext:
        """Return the TLS context for the server; fetch its certificate where a file is given."""
        shown = partial(certificate_of_server, self.address.host, self.address.port, self._timeout)
        try:
            return connection.tls_context(self._certificate, shown)
        except connection.BadCertificateFile as error:
            self._untrusted(f"`{self._certificate}`: {error}")
        except ftplib.error_perm as error:
            self._no_tls(error, "nothing that is secret was sent")
        except _FAILURES as error:
            self._unreachable(error)

    def _no_tls(self, error: ftplib.Error, state: str) -> NoReturn:
        """Raise Refused for a server that refused to switch to TLS."""
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
        except _FAILURES as error:
            self._unreachable(error)

    def _keep_private(self, ftp: BoundedFtpTls) -> None:
        """Has the files go over TLS as well as the commands."""
        try:
            ftp.prot_p()
        except ftplib.error_perm as error:
            self._no_tls(error, "no file was sent")

    def _enter_folder(self, ftp: BoundedFtp) -> None:
        try:
            ftp_connection.enter_home_folder(self, ftp)
        except _FAILURES as error:
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
        """Send a file. command: `APPE` to append to an existing file."""
        with self.during(doing, state):
            ftp = self.session
            assert ftp.sock is not None
            # A view: slices of it copy nothing.
            left = memoryview(data)
            with self._transfer(ftp, f"{command} {name}") as (channel, pace):
                while left:
                    sent = channel.send(left[:_PIECE])
                    pace.moved(sent)
                    left = left[sent:]
            # The answer comes after the server has written
            # the file, which takes it longer for a long one.
            ftp.sock.settimeout(self._timeout + len(data) / _SEARCH_RATE)
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
        """Receive a command's data, piece by piece, within its deadline; raises as ftplib does."""
        ftp = self.session
        with self._transfer(ftp, command, kind, start) as (channel, pace):
            while piece := channel.recv(_PIECE):
                pace.moved(len(piece))
                sink(piece)
        ftp.voidresp()

    def lines(self, command: str) -> list[str]:
        """Return the lines of a listing, decoded as UTF-8 or else Latin-1; raises as ftplib does.

        The complete listing must arrive within `_LISTING_TIMEOUTS` time-outs.
        """
        data = bytearray()
        until = time.monotonic() + _LISTING_TIMEOUTS * self._timeout

        def take(piece: bytes) -> None:
            data.extend(piece)
            # Each piece comes in time, but a listing without end would never be over.
            if time.monotonic() > until:
                raise TimeoutError

        self.receive(command, take, kind="TYPE A")
        try:
            text = data.decode(self.session.spelling)
        except UnicodeDecodeError:
            text = data.decode(BYTE_ENCODING)
            # The folder's names are sent back in later commands as the server spelled them.
            self.session.spelling = BYTE_ENCODING  # names go back as they came
        return [line for line in re.split(r"\r?\n", text) if line]

    @contextmanager
    def _transfer(
        self, ftp: BoundedFtp, command: str, kind: str = "TYPE I", start: int = 0
    ) -> Iterator[tuple[socket.socket, TransferDeadline]]:
        """The channel of a transfer, which is cut where it does not keep its pace."""
        ftp.voidcmd(kind)
        with (
            # Without an offset no REST is sent, which not every server takes.
            ftp.transfercmd(command, start or None) as channel,
            TransferDeadline(self._timeout, partial(cut_line, channel)) as pace,
        ):
            yield channel, pace
            # Without the closing message of TLS, a cut transfer would look like its end.
            if isinstance(channel, ssl.SSLSocket):
                channel.unwrap()

    def discard(self, name: str) -> None:
        """Deletes what is left of a transfer; a rest that stays is overwritten by the next."""
        with suppress(*_FAILURES):
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
            # 421 closes the connection: the session is over, whatever was asked.
            if reply.startswith("421"):  # the server says good-bye
                self._hang_up()
                raise rules.Lost(
                    rules.LOST(place=place, doing=doing, reason=reply, state=state)
                ) from None
            raise Refused(
                rules.REFUSED(place=place, doing=doing, reply=reply, state=state)
            ) from None
        except _FAILURES as error:
            # After a lost line the answers of the session are out of step with its commands.
            self._hang_up()
            raise rules.Lost(
                rules.LOST(place=place, doing=doing, reason=self.said(error), state=state)
            ) from None

    def said(self, error: Exception) -> str:
        """Return an error's text; server texts are UTF-8 or Latin-1. See `FileSession.said`."""
        text = reason_of(error)
        if isinstance(error, ftplib.Error):
            text = decoded_line(text)
        return self._credentials.hidden(text)

    def _hang_up(self) -> None:
        if self._ftp is not None:
            self._ftp.close()
            self._ftp = None

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
        return _read_whole(self, name)

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
            # The same reply stands for an existing folder and for a refusal: the listing decides.
            if self._has(name):
                return False
            raise
        return True

    def release(self, name: str) -> None:
        """Remove an empty folder; do nothing if it is missing."""
        if self._has(checked_name(name)):
            with self.during(f"removing the folder `{name}`", f"`{name}` is still there"):
                self.session.rmd(name)

    def is_folder(self, name: str) -> bool:
        """True if there is a folder of that name: the session can enter it."""
        checked_name(name)
        with self.during(f"looking for `{name}`", "nothing was changed by that"):
            # CWD is the one test that every server has; the session returns afterwards.
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
                if not str(error).startswith(_NOT_NOW):
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
                if not str(error).startswith(_NOT_NOW):
                    raise
                return False
        return True

    def size(self, name: str) -> int | None:
        """Return the bytes of a file, None if it is missing or the server does not report them."""
        return _file_size(self, checked_path(name))

    def download(self, name: str, to: str | FilePath, progress: Progress | None = None) -> int:
        """Fetch a file, also out of folders, into one of this computer; return its bytes.

        The file appears there when it is complete. The transfer continues a part that an
        interrupted one left next to it, in `<to>.part`, unless the file has changed on the
        controller meanwhile.
        """
        return download(self, checked_path(name), FilePath(to), progress)

    def upload(self, name: str, data: bytes) -> None:
        """Write a file as `write` does; continue the part left by an interrupted `_upload`.

        The existing part is fetched and compared first: no transferred byte is trusted.
        """
        checked_name(name)
        _upload(self, name, data)
        temporary = TEMPORARY.format(name=name)
        with self._discarding(temporary):
            self.replace(temporary, name)

    def tree(self, folder: str = "") -> tuple[Entry, ...]:
        """All files and folders below a folder, `HOME:` or one of the address for ""."""
        return _folder_tree(self, folder)

    def fetch_folder(self, folder: str, into: str | FilePath) -> tuple[str, ...]:
        """Fetches a whole folder of the controller into a new one; its files, relative to it.

        The new folder appears when all of it is there, with an index as every backup has.
        """
        return _fetch_tree(self, folder, FilePath(into))

    def _has(self, name: str) -> bool:
        """True if a file of that name exists; the controller's disk ignores case."""
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
        # Some servers never rename over a file: put the old one aside, and put it back on failure.
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


Progress = Callable[[int, int | None], None]
"""Receives the bytes transferred and the total, None if the server does not report it."""

_COMPARED_OVERLAP: Final = 4096
"""Bytes at the end of a part that are fetched again and compared."""
_UNTOUCHED: Final = "nothing was changed by that"


def _file_size(session: Ftp, name: str) -> int | None:
    """Bytes of a file; in binary mode, for in ASCII mode servers refuse or count otherwise."""
    told = _status_text(session, f"SIZE {name}")
    return int(told) if told is not None and told.isdecimal() else None


def _read_whole(session: Ftp, name: str) -> bytes:
    """A file with as many bytes as the server says that it has, where it says so."""
    data = session.retrieve(name, _UNTOUCHED)
    length = _file_size(session, name)
    if length not in (None, len(data)):
        raise Refused(rules.SHORT(place=name, name=name, there=length, back=len(data)))
    return data


def download(session: Ftp, name: str, to: FilePath, progress: Progress | None) -> int:
    # The part is made beside the file that a link leads to, so that renaming stays on one disk.
    to = FilePath(os.path.realpath(to))  # a link stays one
    part, note = to.with_name(f"{to.name}.part"), to.with_name(f"{to.name}.part.json")
    stamp = _size_and_time(session, name)
    whole = None if stamp is None else int(stamp[0])
    try:
        start = _partial_size(part, note, stamp)
        if start == 0:
            part.write_bytes(b"")
            # The note tells a later run which version of the file the part belongs to.
            if stamp is not None:
                note.write_text(json.dumps(stamp), encoding="utf-8")
        with part.open("r+b") as file:
            # A part that does not match is fetched from its beginning.
            if not _went_on(session, name, file, start, whole, progress):
                _fetch_rest(session, name, file, 0, whole, progress)
            file.flush()
            # The data must be on the disk before the name
            # is: after a power cut the file would be empty.
            os.fsync(file.fileno())
        length = part.stat().st_size
        # The file may have changed while it was read: its parts would not belong together.
        if stamp != _size_and_time(session, name) or (whole is not None and length != whole):
            part.unlink()
            raise Refused(rules.SHORT(place=name, name=name, there=whole, back=length))
        part.replace(to)
        # The rename lasts only when the folder itself is on the disk.
        file_access.sync_folder(to.parent)
        note.unlink(missing_ok=True)
    except OSError as error:
        reason = error.strerror or str(error)
        raise Refused(rules.NOT_KEPT(path=str(to), name=name, reason=reason)) from None
    return length


def _upload(session: Ftp, name: str, data: bytes) -> None:
    """Puts a file whole under its temporary name."""
    temporary, doing = TEMPORARY.format(name=name), f"storing `{name}`"
    state = f"`{name}` there is as it was"
    there = _file_size(session, temporary) or 0
    begun = 0
    if 0 < there <= len(data) and session.retrieve(temporary, state) == data[:there]:
        begun = there
    if begun:
        try:
            session.store(temporary, data[begun:], doing, state, command="APPE")
        except rules.Lost:
            raise
        except Refused:
            begun = 0  # a server that takes no parts
    if not begun:
        session.store(temporary, data, doing, state)
    # Only the new bytes: the others were compared before.
    back = session.retrieve(temporary, state, start=begun)
    if back != data[begun:] or _file_size(session, temporary) not in (None, len(data)):
        session.discard(temporary)
        raise Refused(
            rules.ALTERED(
                place=name,
                name=name,
                sent=len(data),
                back=begun + len(back),
                at=begun + first_difference(data[begun:], back),
                state=state,
            )
        )


def _went_on(
    session: Ftp,
    name: str,
    file: BinaryIO,
    start: int,
    whole: int | None,
    progress: Progress | None,
) -> bool:
    """True if the rest was fetched and continues the existing part."""
    try:
        return start > 0 and _fetch_rest(session, name, file, start, whole, progress)
    except rules.Lost:
        raise
    except Refused:
        return False  # a server that only sends whole files


def _fetch_rest(
    session: Ftp,
    name: str,
    file: BinaryIO,
    start: int,
    whole: int | None,
    progress: Progress | None,
) -> bool:
    """Fetch into a file from an offset on; False if the existing part no longer matches."""
    begin = max(0, start - _COMPARED_OVERLAP)
    file.seek(begin)
    known = file.read(start - begin)
    file.seek(begin)
    # The transfer writes the compared bytes anew.
    file.truncate()
    seen = bytearray()

    def keep(piece: bytes) -> None:
        if len(seen) < len(known):
            seen.extend(piece)
        file.write(piece)
        if progress is not None:
            progress(file.tell(), whole)

    session.retrieve_into(name, _UNTOUCHED, keep, begin)
    return bytes(seen[: len(known)]) == known


def _partial_size(part: FilePath, note: FilePath, stamp: tuple[str, str] | None) -> int:
    """Bytes that an earlier transfer left of the same file."""
    if stamp is None or not part.is_file() or not note.is_file():
        return 0
    try:
        same = json.loads(read_text(note)) == list(stamp)
    except ValueError:
        return 0
    length = part.stat().st_size
    return length if same and length <= int(stamp[0]) else 0


def _size_and_time(session: Ftp, name: str) -> tuple[str, str] | None:
    """Size and time of a file, None if the server does not tell both."""
    length, changed = _file_size(session, name), _status_text(session, f"MDTM {name}")
    return None if length is None or changed is None else (str(length), changed)


def _status_text(session: Ftp, command: str) -> str | None:
    """Return the text after `213` in the answer to a command, None for another answer."""
    with session.during(f"asking `{command.split()[0]}`", _UNTOUCHED):
        try:
            session.session.voidcmd("TYPE I")
            answer = session.session.sendcmd(command)
        except ftplib.error_perm:
            return None
    return answer[4:].strip() if answer.startswith("213") else None


EntryKind = Literal["file", "folder", "other"]
"""Links and devices are others: they are never followed, for they may lead in circles."""
_FOLDER_KIND: Final = "abb files"
"""Kind in the index of a folder of files: not a backup of a complete controller."""

_UNIX_LINE: Final = re.compile(
    r"(?P<type>[-dlbcps])[-rwxsStTlL]{9}[.+@]?\s+\d+\s+(?:\S+\s+){1,2}(?P<size>\d+)\s+"
    r"(?:[A-Za-z]{3,9}\.?\s+\d{1,2}|\d{1,2}\s+[A-Za-z]{3,9}\.?|\d{4}-\d\d-\d\d)\s+"
    r"(?:\d{1,2}:\d\d(?::\d\d)?|\d{4})\s(?P<name>.+)"
)
"""Line in the form of `ls -l`: mode, links, owner, group, size, date, time or year, name."""
_DOS_LINE: Final = re.compile(
    r"\d\d-\d\d-(?:\d\d|\d{4})\s+\d\d:\d\d(?:[AP]M)?\s+(?:(?P<folder><DIR>)|(?P<size>\d+))\s+"
    r"(?P<name>.+)",
    re.IGNORECASE,
)
_UNIX_TYPES: Final[dict[str, EntryKind]] = {"-": "file", "d": "folder"}
_MLSD_TYPES: Final[dict[str, EntryKind]] = {"file": "file", "dir": "folder"}


@dataclass(frozen=True, slots=True, order=True)
class Entry:
    """path: relative to the requested folder. size: bytes, None if not reported."""

    path: str
    kind: EntryKind
    size: int | None = None


def _folder_tree(session: Ftp, folder: str = "") -> tuple[Entry, ...]:
    """All below a folder, sorted; the session is in its own folder again afterwards."""
    with session.during("asking for the folder", _UNTOUCHED):
        home = session.session.pwd()
    found: list[Entry] = []
    try:
        if folder:
            _enter(session, folder)
        with session.during("asking for the folder", _UNTOUCHED):
            top = session.session.pwd()
        # A name that is no UTF-8 changes the spelling of the session, also for names seen before.
        spelling = session.session.spelling
        _walk(session, top.rstrip("/"), "", 0, found)
        if session.session.spelling != spelling:  # what was read before is spelled anew
            found.clear()
            _enter(session, top)
            _walk(session, top.rstrip("/"), "", 0, found)
    except rules.Lost:
        raise
    except Refused:
        _enter(session, home)
        raise
    _enter(session, home)
    return tuple(sorted(found))


def _fetch_tree(session: Ftp, folder: str, into: FilePath) -> tuple[str, ...]:
    """Fetches all files below a folder into a new one."""
    files = [entry.path for entry in _folder_tree(session, folder) if entry.kind == "file"]
    start = f"{folder.rstrip('/')}/" if folder else ""
    with backup_folder.appearing_folder(into, _FOLDER_KIND) as new:
        for path in files:
            backup_folder.put_file(new, path, _read_whole(session, start + path))
    return tuple(files)


def parse_list(lines: Iterable[str]) -> list[Entry] | None:
    """Parse the lines of LIST, None if one of them has an unknown form."""
    found = []
    for line in lines:
        if re.fullmatch(r"(total \d+)?\s*", line):
            continue
        unix, dos = _UNIX_LINE.fullmatch(line), _DOS_LINE.fullmatch(line)
        if unix is not None:
            kind = _UNIX_TYPES.get(unix["type"], "other")
            # A link is listed with its target, `name -> target`.
            name = unix["name"].split(" -> ")[0] if unix["type"] == "l" else unix["name"]
            found.append(Entry(name, kind, int(unix["size"]) if kind == "file" else None))
        elif dos is not None:
            size = None if dos["folder"] else int(dos["size"])
            found.append(Entry(dos["name"], "folder" if dos["folder"] else "file", size))
        else:
            return None
    return found


def parse_mlsd(lines: Iterable[str]) -> list[Entry] | None:
    """Parse the lines of MLSD: facts, a blank, the name. None if one of them has another form."""
    found = []
    for line in lines:
        facts, blank, name = line.partition(" ")
        # Facts are `name=value;`; their names have no case (RFC 3659, 7.5).
        pairs = dict(fact.lower().partition("=")[::2] for fact in facts.rstrip(";").split(";"))
        if not blank or "type" not in pairs:
            return None
        # The folder itself and the one above it: walking into them would not end.
        if pairs["type"] in ("cdir", "pdir"):
            continue
        size = pairs.get("size", "")
        kind = _MLSD_TYPES.get(pairs["type"], "other")
        found.append(Entry(name, kind, int(size) if size.isdecimal() else None))
    return found


def _walk(session: Ftp, top: str, below: str, depth: int, found: list[Entry]) -> None:
    """Gathers what is in a folder, which the session is in, and in those inside of it."""
    if depth > MOST_FOLDERS:
        reason = f"folders are more than {MOST_FOLDERS} deep"
        raise Refused(rules.FILE_NAME(place=below, name=below, reason=reason))
    if len(found) > MOST_ENTRIES:
        reason = f"there are more than {MOST_ENTRIES} files and folders"
        raise Refused(rules.FILE_NAME(place=below, name=below, reason=reason))
    inner = []
    # The complete listing first: entering a folder changes what the session lists.
    for entry in _entries(session):
        if entry.path in (".", ".."):
            continue
        path = f"{below}{told_name(entry.path)}"
        found.append(Entry(path, entry.kind, entry.size))
        if entry.kind == "folder":
            inner.append(path)
    for path in inner:
        # By the absolute path: the session is deep in another folder by now.
        _enter(session, f"{top}/{path}")
        _walk(session, top, f"{path}/", depth + 1, found)


def _entries(session: Ftp) -> list[Entry]:
    ways: tuple[tuple[str, Callable[[Iterable[str]], list[Entry] | None]], ...] = (
        ("MLSD", parse_mlsd),
        ("LIST", parse_list),
    )
    for command, read in ways:
        try:
            found = read(_listing_lines(session, command))
        except rules.Lost:
            raise
        # This server lacks the command: the next one, down to names alone.
        except Refused:
            continue
        if found is not None:
            return found
    return list(_entries_by_name(session))


def _listing_lines(session: Ftp, command: str) -> list[str]:
    with session.during("listing a folder", _UNTOUCHED):
        return session.lines(command)


def _entries_by_name(session: Ftp) -> Iterator[Entry]:
    """By names alone: what can be entered is a folder."""
    names = [line.rsplit("/", 1)[-1] for line in _listing_lines(session, "NLST")]
    with session.during("asking for the folder", _UNTOUCHED):
        here = session.session.pwd()
    for name in sorted(set(names) - {".", ".."}):
        try:
            _enter(session, told_name(name))
        except rules.Lost:
            raise
        except Refused:
            yield Entry(name, "file")
        else:
            _enter(session, here)
            yield Entry(name, "folder")


def _enter(session: Ftp, folder: str) -> None:
    if re.search(r"[\x00-\x1f\x7f]", folder):
        reason = "it holds a control character"
        raise Refused(rules.FILE_NAME(place=repr(folder), name=repr(folder), reason=reason))
    with session.during(f"entering `{folder}`", _UNTOUCHED):
        session.session.cwd(folder)


_NOT_NOW: Final = ("550", "450")
"""Replies for a file that is missing, or that another client has open (RFC 959, 5.4)."""
