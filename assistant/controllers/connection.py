"""Parts that connections to controllers share: deadlines of transfers, TLS trust, failure texts.

The time-out of a socket is granted to each byte anew, so data that arrives byte by byte would never
time out. `TransferDeadline` requires a number of bytes in each time-out, and cuts the line from a
separate thread if they do not arrive.
`tls_context` trusts the system's authorities or the certificate of a file, never an unknown one.
`reason_of` gives the reason of a failed connection in words.
"""

from __future__ import annotations

import re
import socket
import ssl
import threading
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Final, Self

from assistant.base.file_access import read_text

LEAST_BYTES: Final = 1024
"""Bytes that have to go through in each time-out; fewer only at the end."""
_LARGEST_TRANSFER: Final = 1 << 30
"""Bytes after which a transfer counts as garbage."""


class TransferDeadline:
    """A context manager around a transfer, which ends with a TimeoutError once the line was cut.

    seconds: of the time-out. cut: ends the line, so that whoever waits for it meets an error.
    """

    def __init__(self, seconds: float, cut: Callable[[], None]) -> None:
        self._seconds, self._cut = seconds, cut
        self._count = 0
        self._done = threading.Event()
        self._over = threading.Event()
        self._deciding = threading.Lock()
        self._thread = threading.Thread(target=self._watch, name="pace", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, traceback: object) -> None:
        # Under the lock, the watching thread cuts either before this line or not at all.
        with self._deciding:
            self._done.set()
        # Also where the last byte came just before the cut: the line is of no use any more.
        # The last byte may have come just before the cut: the line is of no
        # use any more. Ctrl-C and the like are not hidden by a time-out.
        if (kind is None or issubclass(kind, Exception)) and self._over.is_set():
            raise TimeoutError from None

    def moved(self, count: int) -> None:
        """So many bytes have gone through; raises TimeoutError where they never end."""
        self._count += count
        if self._count > _LARGEST_TRANSFER:
            self._over.set()
            raise TimeoutError

    def _watch(self) -> None:
        seen = 0
        while not self._done.wait(self._seconds):
            count = self._count
            if count - seen < LEAST_BYTES:
                with self._deciding:
                    if self._done.is_set():
                        return
                    self._over.set()
                self._cut()
                return
            seen = count


def reason_of(error: Exception) -> str:
    """One line without the class names and numbers of the operating system."""
    if isinstance(error, ssl.SSLCertVerificationError):
        return error.verify_message
    if isinstance(error, TimeoutError):
        return "no answer in time"
    if isinstance(error, ConnectionRefusedError):
        return "nothing listens on that port"
    if isinstance(error, socket.gaierror):
        return "the host is not known"
    if isinstance(error, (ConnectionError, EOFError)):
        return "the other side closed the connection"
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " / ".join(line.strip() for line in str(text).splitlines() if line.strip())


_PEM_CERTIFICATE: Final = re.compile(
    r"-----BEGIN CERTIFICATE-----.+?-----END CERTIFICATE-----", re.DOTALL
)


class BadCertificateFile(Exception):
    """The file of the certificate cannot be used."""


def tls_context(certificate: str | FilePath | None, shown: Callable[[], bytes]) -> ssl.SSLContext:
    """Return the TLS context for connections; raises BadCertificateFile, and what `shown` raises.

    certificate: file of an authority, or of the controller's certificate. Controllers create
    certificates with names other than their address: if the one shown equals the one in the file,
    its key is trusted, and its name is not checked. shown: fetches the one that the controller
    shows, in DER, unchecked.
    """
    if certificate is None:
        return ssl.create_default_context()
    try:
        text = read_text(certificate, "ascii", "replace")  # a pipe would never end
        trusted = ssl.create_default_context(cafile=str(certificate))
        known = {ssl.PEM_cert_to_DER_cert(found) for found in _PEM_CERTIFICATE.findall(text)}
    except (OSError, ValueError) as error:
        raise BadCertificateFile(reason_of(error)) from None
    # The same certificate as in the file: its key is trusted. Names and forms
    # of certificates that controllers make do not hold to the standards.
    if shown() in known:
        trusted.check_hostname = False
        trusted.verify_flags &= ~ssl.VERIFY_X509_STRICT  # what controllers make is not strict
        trusted.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    return trusted


def unverified_context() -> ssl.SSLContext:
    """For a connection that only looks at the certificate, and over which nothing else goes."""
    anyone = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    anyone.check_hostname = False
    anyone.verify_mode = ssl.CERT_NONE
    return anyone


def certificate_at(host: str, port: int, timeout: float) -> bytes:
    """The certificate of a server that speaks TLS from the start; raises OSError, no SSLError."""
    try:
        return ssl.PEM_cert_to_DER_cert(ssl.get_server_certificate((host, port), timeout=timeout))
    except ssl.SSLError as error:  # of a line that is cut, or a server without TLS
        raise OSError(reason_of(error)) from None
