"""Addresses of controllers: `ftp://user@host:port/folder`, `ftps://…`, `melfa://host:port`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final
from urllib.parse import SplitResult, quote, unquote, urlsplit

from assistant.controllers import rules
from assistant.program.diagnostics import Refused


@dataclass(frozen=True, slots=True)
class Scheme:
    """What an address of one kind may say.

    port: where the controller listens if the address names none. folder: where programs go
    if it names none. login: whether there is a user and a folder at all.
    """

    title: str
    port: int
    folder: str = ""
    login: bool = False


SCHEMES: Final = {
    "ftp": Scheme("ABB IRC5 by FTP", 21, "HOME:", login=True),
    "ftps": Scheme("ABB IRC5 by FTP over TLS", 21, "HOME:", login=True),
    "melfa": Scheme("Mitsubishi CR controller by controller link", 10001),
}
"""Kinds of addresses. Port 10001 is the first controller-link line (parameter CPRCE11 = 0)."""


@dataclass(frozen=True, slots=True)
class Address:
    """Where a controller is; never holds a password."""

    scheme: str
    host: str
    port: int
    user: str | None = None
    folder: str = ""

    def __str__(self) -> str:
        user = f"{quote(self.user, safe='')}@" if self.user else ""
        host = f"[{self.host}]" if ":" in self.host else self.host
        folder = f"/{quote(self.folder, safe=':/')}" if self.folder else ""
        return f"{self.scheme}://{user}{host}:{self.port}{folder}"

    @property
    def label(self) -> str:
        """A name for the controller that is safe as a folder's name."""
        folder = f"_{self.folder}" if SCHEMES[self.scheme].folder != self.folder else ""
        words = re.sub(r"[^A-Za-z0-9.-]+", "_", f"{self.scheme}_{self.host}_{self.port}{folder}")
        return words.strip("_.")


def parse(text: str) -> Address:
    """The address that a text says; raises Refused with what is wrong in it.

    A password in it is refused and never repeated in the finding.
    """
    shown = without_password(text)
    if shown != text:
        raise Refused(rules.PASSWORD_IN_ADDRESS(place=shown))
    if re.search(r"[\x00-\x1f\x7f]", text):
        raise Refused(rules.BAD_ADDRESS(place=repr(shown), reason="it holds a control character"))
    try:
        parts = urlsplit(text)
        port = parts.port
    except ValueError as error:
        raise Refused(rules.BAD_ADDRESS(place=shown, reason=str(error))) from None
    scheme = SCHEMES.get(parts.scheme.lower())
    if scheme is None:
        raise Refused(rules.UNKNOWN_SCHEME(place=shown, given=parts.scheme, known=_known()))
    wrong = _wrong(parts, port, scheme)
    if wrong:
        raise Refused(rules.BAD_ADDRESS(place=shown, reason=wrong))
    folder = unquote(parts.path).strip("/") or scheme.folder
    user = unquote(parts.username) if parts.username else None
    assert parts.hostname is not None
    return Address(parts.scheme.lower(), parts.hostname, port or scheme.port, user, folder)


def _wrong(parts: SplitResult, port: int | None, scheme: Scheme) -> str | None:
    """The first thing wrong with the parts of an address."""
    said = unquote(parts.path + (parts.username or ""))
    checks = (
        (not parts.hostname, "it names no host"),
        (port == 0, "port 0 cannot be connected to"),
        (bool(parts.hostname and re.search(r"[\s%/\\]", parts.hostname)), "the host is no name"),
        (bool(parts.query or parts.fragment), "nothing may follow a `?` or `#`"),
        (bool(re.search(r"[\x00-\x1f\x7f]", said)), "it holds a control character"),
        (".." in unquote(parts.path).split("/"), "the folder must not lead upwards"),
        (not scheme.login and parts.username is not None, "this controller knows no users"),
        (not scheme.login and parts.path not in ("", "/"), "this controller has no folders"),
    )
    return next((reason for wrong, reason in checks if wrong), None)


def without_password(text: str) -> str:
    """The text with `***` for whatever could be a password between `:` and `@`.

    Not left to the URL's syntax: a password with `/`, `?` or `#` would pass for something else.
    """
    return re.sub(r"(//[^/@:]*):.*@", r"\1:***@", text, flags=re.DOTALL)


def _known() -> str:
    return ", ".join(f"`{name}://`" for name in SCHEMES)
