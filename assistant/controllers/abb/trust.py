"""Whose certificate is trusted: never nobody's word, and never an unknown one's."""

from __future__ import annotations

import re
import ssl
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Final

from assistant.base.file_access import read_text
from assistant.controllers.os_errors_in_words import reason_of

PEM_CERTIFICATE: Final = re.compile(
    r"-----BEGIN CERTIFICATE-----.+?-----END CERTIFICATE-----", re.DOTALL
)


class BadCertificateFile(Exception):
    """The file of the certificate cannot be used."""


def tls_context(certificate: str | FilePath | None, shown: Callable[[], bytes]) -> ssl.SSLContext:
    """What connections are checked with; raises BadFile, and what `shown` raises.

    certificate: file of an authority, or of the controller's own certificate. Controllers make
    their own with names that are not their address: if the one shown is the very one in the
    file, its key is trusted, and its name is not asked for. shown: fetches the one that the
    controller shows, in DER, unchecked.
    """
    if certificate is None:
        return ssl.create_default_context()
    try:
        text = read_text(certificate, "ascii", "replace")  # a pipe would never end
        trusted = ssl.create_default_context(cafile=str(certificate))
        known = {ssl.PEM_cert_to_DER_cert(found) for found in PEM_CERTIFICATE.findall(text)}
    except (OSError, ValueError) as error:
        raise BadCertificateFile(reason_of(error)) from None
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
