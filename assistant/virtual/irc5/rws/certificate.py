"""A self-signed certificate, as controllers are delivered with, for this computer."""

from __future__ import annotations

import ssl
from pathlib import Path as FilePath

from assistant.base import certificate
from assistant.base.diagnostics import Refused, error

NEEDS_PACKAGE = error(
    "VC002",
    "the virtual IRC5 needs {package} for Robot Web Services, which is not installed",
    "install it with `pip install 'robot-assistant[virtual]'`",
)


def certify(host: str, file: FilePath) -> ssl.SSLContext:
    """See `certificate.certify`; raises Refused if a package is missing, OSError for the file."""
    try:
        return certificate.self_signed_context(host, "virtual-irc5", file)
    except ImportError:
        raise Refused(NEEDS_PACKAGE(package="cryptography")) from None
