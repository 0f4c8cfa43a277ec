"""Why a connection failed, in words."""

from __future__ import annotations

import socket
import ssl


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
