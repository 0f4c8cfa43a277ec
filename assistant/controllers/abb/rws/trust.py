"""Whose certificate is trusted: never nobody's word, and never an unknown one's."""

from __future__ import annotations

import re
import ssl
from pathlib import Path as FilePath
from typing import Final

from assistant.controllers.os_errors_in_words import reason_of

PEM: Final = re.compile(r"-----BEGIN CERTIFICATE-----.+?-----END CERTIFICATE-----", re.DOTALL)


class BadFile(Exception):
    """The file of the certificate cannot be used."""


def context(
    host: str, port: int, certificate: str | FilePath | None, timeout: float
) -> ssl.SSLContext:
    """What connections are checked with; raises BadFile, or OSError where nobody answers.

    certificate: file of an authority, or of the controller's own certificate. Controllers make
    their own with names that are not their address: if the one shown is the very one in the
    file, its key is trusted, and its name is not asked for.
    """
    if certificate is None:
        return ssl.create_default_context()
    try:
        trusted = ssl.create_default_context(cafile=str(certificate))
        text = FilePath(certificate).read_text("ascii", errors="replace")
        known = {ssl.PEM_cert_to_DER_cert(found) for found in PEM.findall(text)}
    except (OSError, ValueError) as error:
        raise BadFile(reason_of(error)) from None
    if _shown(host, port, timeout) in known:
        trusted.check_hostname = False
        trusted.verify_flags &= ~ssl.VERIFY_X509_STRICT  # what controllers make is not strict
        trusted.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    return trusted


def _shown(host: str, port: int, timeout: float) -> bytes:
    """The certificate that a controller shows, unchecked; raises OSError but no ssl.SSLError."""
    try:
        return ssl.PEM_cert_to_DER_cert(ssl.get_server_certificate((host, port), timeout=timeout))
    except ssl.SSLError as error:  # of a line that is cut, or a server without TLS
        raise OSError(reason_of(error)) from None
