"""Client of an ABB OmniCore: its files by SFTP, which needs the `sftp` extra.

The host's key must be in a file of known hosts or be that of `?fingerprint=SHA256:…` in the
address; another one, or an unknown one, ends the connection before a password is sent.
"""

from __future__ import annotations

import errno
import logging
import stat
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final, NoReturn, Self

from assistant.base.diagnostics import Refused
from assistant.controllers import backup_folder, rules
from assistant.controllers.abb.files import (
    MOST_ENTRIES,
    MOST_FOLDERS,
    FileSession,
    checked_name,
    checked_path,
    told_name,
)
from assistant.controllers.address import Address, Credentials
from assistant.controllers.connection import LEAST_BYTES, TransferDeadline, reason_of

if TYPE_CHECKING:
    from paramiko import PKey, SFTPClient, SSHClient

_KIND: Final = "abb files"
"""Kind in the index of a folder of files: not a backup of a complete controller."""
_LISTING: Final = 10
"""Time-outs in which a whole listing has to come."""
_PIECE: Final = 32768
"""Bytes of a request (draft-ietf-secsh-filexfer-02: what servers take at least)."""
_UNTOUCHED: Final = "nothing was changed by that"


class Sftp(FileSession):
    """Programs on an OmniCore by SFTP; see `Programs`.

    timeout: seconds for an answer. certificate: file of known hosts, None for those of the user.
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
        self._ssh: SSHClient | None = None
        self._files: SFTPClient | None = None

    def __enter__(self) -> Self:
        """Connects, checks the host's key, logs in and goes to the folder of the address."""
        try:
            import paramiko
        except ImportError:
            raise Refused(rules.NEEDS_SFTP(place=str(self.address)), exit_status=2) from None
        _keep_quiet()
        self._ssh = ssh = paramiko.SSHClient()
        # paramiko waits without end for the answer to some messages of the beginning.
        watchdog = threading.Timer(2.0 * self._timeout, ssh.close)
        watchdog.daemon = True
        watchdog.start()
        try:
            self._trust(ssh)
            self._connect(ssh)
            self._enter_folder()
        except BaseException:
            self._hang_up()
            raise
        finally:
            watchdog.cancel()
        return self

    def __exit__(self, *error: object) -> None:
        self._hang_up()

    def names(self) -> tuple[str, ...]:
        with self._during("listing the folder", _UNTOUCHED, _LISTING) as (files, _):
            found = files.listdir(".")
        for name in found:
            if not name.isprintable():
                reason = "it holds a control character"
                raise Refused(rules.FILE_NAME(place=repr(name), name=repr(name), reason=reason))
        return tuple(sorted(found))

    def read(self, name: str) -> bytes | None:
        checked_name(name)
        if name.lower() not in {other.lower() for other in self.names()}:
            return None
        return self.retrieve(name, _UNTOUCHED)

    def look(self, name: str) -> bytes | None:
        """Return a file without asking first whether it exists; None if it is missing."""
        checked_name(name)
        with self._during(f"reading `{name}`", _UNTOUCHED) as (files, pace):
            try:
                return _bytes(files, name, pace)
            except FileNotFoundError:
                return None

    def take_away(self, name: str) -> bool:
        """Delete a file; False, without an effect, if it is missing."""
        checked_name(name)
        with self._during(f"deleting `{name}`", f"`{name}` may still be there") as (files, _):
            try:
                files.remove(name)
            except FileNotFoundError:
                return False
        return True

    def remove(self, name: str) -> None:
        self.take_away(name)

    def delete(self, name: str) -> None:
        with self._during(f"deleting `{name}`", f"`{name}` is still there") as (files, _):
            files.remove(name)

    def claim(self, name: str) -> bool:
        """Makes a folder; False if there is one. Of many clients the server lets one do it."""
        checked_name(name)
        try:
            with self._during(f"making the folder `{name}`", _UNTOUCHED) as (files, _):
                files.mkdir(name)
        except rules.Lost:
            raise
        except Refused:
            if name in self.names():
                return False
            raise
        return True

    def release(self, name: str) -> None:
        """Remove an empty folder; do nothing if it is missing."""
        if checked_name(name) in self.names():
            with self._during(f"removing the folder `{name}`", f"`{name}` is still there") as (
                files,
                _,
            ):
                files.rmdir(name)

    def is_folder(self, name: str) -> bool:
        """True if there is a folder of that name."""
        checked_name(name)
        with self._during(f"looking for `{name}`", _UNTOUCHED) as (files, _):
            try:
                return stat.S_ISDIR(files.stat(name).st_mode or 0)
            except FileNotFoundError:
                return False

    def fetch_folder(self, folder: str, into: str | FilePath) -> tuple[str, ...]:
        """Fetches a whole folder into a new one, which appears when all is there; its files.

        folder: below that of the address, "" for itself. Links are left out.
        """
        start = f"{checked_path(folder)}/" if folder else ""
        entries: dict[str, bool] = {}
        with self._during("listing the folder", _UNTOUCHED, _LISTING) as (files, pace):
            _walk(files, pace, start, "", 0, entries)
        found = sorted(path for path, is_file in entries.items() if is_file)
        with backup_folder.appearing_folder(into, _KIND) as new:
            for path in found:
                backup_folder.put_file(new, path, self.retrieve(start + path, _UNTOUCHED))
        return tuple(found)

    def _trust(self, ssh: SSHClient) -> None:
        """Load the host keys with which the host's key is compared."""
        from paramiko import SSHException

        # The query of an address turns each `+` of the base64 text into a blank.
        fingerprint = self.address.option("fingerprint", "").replace(" ", "+")
        try:
            if fingerprint:
                ssh.set_missing_host_key_policy(_Pinned(fingerprint))
            elif self._certificate:
                ssh.load_host_keys(str(self._certificate))
            else:
                ssh.load_system_host_keys()
        except (OSError, SSHException, ValueError) as error:
            where = self._certificate or "the known hosts"
            self._untrusted(f"`{where}` cannot be read: {reason_of(error)}")

    def _connect(self, ssh: SSHClient) -> None:
        import paramiko

        name = self._credentials.user
        try:
            ssh.connect(
                self.address.host,
                self.address.port,
                username=name,
                password=self._credentials.password,
                timeout=self._timeout,
                banner_timeout=self._timeout,
                auth_timeout=self._timeout,
                channel_timeout=self._timeout,
                allow_agent=False,
                look_for_keys=False,
            )
            self._files = ssh.open_sftp()
            channel = self._files.get_channel()
            assert channel is not None
            # open_sftp() sets no time limit for its channel.
            channel.settimeout(self._timeout)
        except _Unknown as error:
            self._untrusted(f"its key is {error}")
        except paramiko.BadHostKeyException as error:
            self._untrusted(f"its key is {error.key.fingerprint}, another one is known")
        except paramiko.AuthenticationException as error:
            reply = self._credentials.hidden(reason_of(error))
            raise Refused(
                rules.LOGIN(place=str(self.address), address=self.address, user=name, reply=reply),
                exit_status=2,
            ) from None
        except _failures() as error:
            # paramiko has no separate class for an unknown host.
            if "not found in known_hosts" in str(error):
                self._untrusted("its key is not among the known hosts")
            reason = self.said(error)
            raise rules.Lost(
                rules.UNREACHABLE(place=str(self.address), address=self.address, reason=reason)
            ) from None

    def _enter_folder(self) -> None:
        folder = self.address.folder
        with self._during("going to the folder", _UNTOUCHED) as (files, _):
            try:
                files.chdir(folder or ".")
            except OSError as error:
                if not self._alive():
                    raise
                raise Refused(
                    rules.NO_FOLDER(
                        place=str(self.address),
                        address=self.address,
                        folder=folder,
                        reply=self.said(error),
                    ),
                    exit_status=2,
                ) from None

    def _untrusted(self, reason: str) -> NoReturn:
        raise Refused(
            rules.HOST_KEY(place=str(self.address), address=self.address, reason=reason),
            exit_status=2,
        ) from None

    def store(self, name: str, data: bytes, doing: str, state: str) -> None:
        left = memoryview(data)
        with self._during(doing, state) as (files, pace), files.open(name, "wb") as file:
            while left:
                file.write(left[:_PIECE].tobytes())
                pace.moved(len(left[:_PIECE]))
                left = left[_PIECE:]

    def retrieve(self, name: str, state: str) -> bytes:
        with self._during(f"reading `{name}`", state) as (files, pace):
            return _bytes(files, name, pace)

    def replace(self, temporary: str, name: str) -> None:
        """Renames over the old file; where the server never replaces, that is deleted first."""
        doing = f"renaming `{temporary}` to `{name}`"
        unknown = f"`{name}` there is either the old file or the new one, whole"
        with self._during(doing, unknown) as (files, _):
            try:
                # posix-rename@openssh.com replaces; plain SFTP rename never does (draft 02, 6.5).
                files.posix_rename(temporary, name)
            except OSError:
                if not self._alive():
                    raise
            else:
                return
        gone = f"the new file is whole as `{temporary}`, of `{name}` nothing may be left"
        with self._during(doing, gone) as (files, _):
            with suppress(FileNotFoundError):
                files.remove(name)
            files.rename(temporary, name)

    def discard(self, name: str) -> None:
        """Deletes what is left of a transfer; a rest that stays is overwritten by the next."""
        if self._files is not None:
            with suppress(*_failures()):
                self._files.remove(name)

    @contextmanager
    def _during(
        self, doing: str, state: str, times: int = 1
    ) -> Iterator[tuple[SFTPClient, TransferDeadline]]:
        """Turns what goes wrong inside into a finding with the state of the controller.

        times: time-outs in which an answer, or a piece of a transfer, has to come.
        """
        place = str(self.address)
        if self._files is None:
            reason = "there is no session"
            raise rules.Lost(rules.LOST(place=place, doing=doing, reason=reason, state=state))
        assert self._ssh is not None
        try:
            # The time-out of a channel is granted to each byte anew.
            with TransferDeadline(times * self._timeout, self._ssh.close) as pace:
                yield self._files, pace
        except _failures() as error:
            # An OSError of a live session is the server's reply; a TimeoutError is a silent one.
            refused = isinstance(error, OSError) and not isinstance(error, TimeoutError)
            if refused and self._alive():
                reply = self.said(error)
                raise Refused(
                    rules.REFUSED(place=place, doing=doing, reply=reply, state=state)
                ) from None
            self._hang_up()
            reason = self.said(error)
            raise rules.Lost(
                rules.LOST(place=place, doing=doing, reason=reason, state=state)
            ) from None

    def _alive(self) -> bool:
        """True if the connection is alive: the server sent an error instead of falling silent."""
        channel = None if self._files is None else self._files.get_channel()
        transport = None if channel is None else channel.get_transport()
        return bool(channel and not channel.closed and transport and transport.is_active())

    def _hang_up(self) -> None:
        # Emptied first: closing may fail, and must not be tried again.
        ssh, self._ssh, self._files = self._ssh, None, None
        if ssh is not None:
            ssh.close()


class _Unknown(Exception):
    """A host's key that is not the one that is expected."""


class _Pinned:
    """A policy of paramiko that lets only one key through, whatever the known hosts are."""

    def __init__(self, fingerprint: str) -> None:
        self._fingerprint = fingerprint

    # paramiko calls this for every key, since no known hosts are loaded here.
    def missing_host_key(self, _client: SSHClient, _hostname: str, key: PKey) -> None:
        if key.fingerprint != self._fingerprint:
            raise _Unknown(f"{key.fingerprint} and not {self._fingerprint}")


def _failures() -> tuple[type[Exception], ...]:
    """Return the exceptions of paramiko for a server that refuses, is gone, or answers nonsense."""
    from paramiko import SSHException
    from paramiko.sftp import SFTPError

    return (OSError, EOFError, SSHException, SFTPError, struct.error, UnicodeDecodeError)


def _bytes(files: SFTPClient, name: str, pace: TransferDeadline) -> bytes:
    data = bytearray()
    with files.open(name, "rb") as file:
        while piece := file.read(_PIECE):
            pace.moved(len(piece))
            data += piece
            if len(piece) < _PIECE:
                break
    return bytes(data)


def _walk(
    files: SFTPClient,
    pace: TransferDeadline,
    start: str,
    below: str,
    depth: int,
    found: dict[str, bool],
) -> None:
    """Gathers what is in a folder and in those inside of it, with whether it is a file."""
    if depth > MOST_FOLDERS:
        raise OSError(errno.ELOOP, f"folders are more than {MOST_FOLDERS} deep")
    if len(found) > MOST_ENTRIES:
        raise OSError(errno.ELOOP, f"there are more than {MOST_ENTRIES} files and folders")
    entries = files.listdir_attr(start + below or ".")
    pace.moved(LEAST_BYTES)  # each folder has its own time
    for entry in entries:
        path, mode = f"{below}{told_name(entry.filename)}", entry.st_mode or 0
        if stat.S_ISDIR(mode):
            found[path] = False
            _walk(files, pace, start, f"{path}/", depth + 1, found)
        elif stat.S_ISREG(mode):
            found[path] = True


def _keep_quiet() -> None:
    """Keep paramiko from writing tracebacks to standard error where logging is not set up."""
    logger = logging.getLogger("paramiko")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
