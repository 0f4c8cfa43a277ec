"""Addresses of controllers, and the user and password that belong to them.

An address is `ftp://user@host:port/folder`, `melfa://host:port`, a serial line, …; `SCHEMES` lists
the kinds. Addresses never contain a password. User and password come from arguments, the address,
the environment (`ROBOT_ASSISTANT_CELL1_PASSWORD`), the keyring of the system, or a question.
`clear_text_finding` reports an address whose traffic goes over the network unencrypted.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import field
from ipaddress import ip_address
from typing import Final
from urllib.parse import SplitResult, parse_qsl, quote, unquote, urlencode, urlsplit

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.worker_processes import VARIABLE_PREFIX
from assistant.controllers import rules


@dataclass(frozen=True, slots=True)
class _Scheme:
    """Permitted parts of an address of one kind.

    port: where the controller listens if the address names none. folder: for programs if the
    address names none. login: whether the address has a user and a folder at all. device: whether
    it names a serial line of this computer instead of a host. options: may follow a `?`, each with
    a pattern of its values.
    """

    title: str
    port: int
    folder: str = ""
    login: bool = False
    device: bool = False
    options: Mapping[str, str] = field(default_factory=dict)


_END_OPTION: Final = {"end": "cr|crlf|none"}
"""End of a command of the controller link."""
_SERIAL_OPTIONS: Final = {
    **_END_OPTION,
    "baud": "[1-9][0-9]{2,5}",
    "bits": "7|8",
    "parity": "even|odd|none",
    "stop": "1|2",
    "framing": "plain|procedural",
}
_FTP_OPTIONS: Final = {"mode": "passive|active"}
"""Who connects for a transfer: the client, or the controller."""
_SFTP_OPTIONS: Final = {"fingerprint": "SHA256:[A-Za-z0-9+/ ]{43}"}
"""Fingerprint of the host's key; an unquoted `+` is decoded as a blank."""
_SERIAL_DEVICE: Final = re.compile(r"/(?:[\w.+:-]+/)*[\w.+:-]+|COM[1-9]\d{0,2}", re.ASCII)
"""A file of a serial line, or its name in Windows."""

SCHEMES: Final = {
    "ftp": _Scheme("ABB IRC5 by FTP", 21, "HOME:", login=True, options=_FTP_OPTIONS),
    "ftps": _Scheme("ABB IRC5 by FTP over TLS", 21, "HOME:", login=True, options=_FTP_OPTIONS),
    "sftp": _Scheme("ABB OmniCore by SFTP", 22, login=True, options=_SFTP_OPTIONS),
    "rws": _Scheme("ABB IRC5 by Robot Web Services 1.0", 80, "HOME:", login=True),
    "rwss": _Scheme("ABB OmniCore by Robot Web Services 2.0", 443, "HOME:", login=True),
    "melfa": _Scheme("Mitsubishi CR controller by controller link", 10001, options=_END_OPTION),
    "melfa-serial": _Scheme(
        "Mitsubishi CR controller by controller link on a serial line",
        0,
        device=True,
        options=_SERIAL_OPTIONS,
    ),
}
"""Kinds of addresses. Port 10001 is the first controller-link line (parameter CPRCE11 = 0)."""


@dataclass(frozen=True, slots=True)
class Address:
    """Address of a controller; never holds a password.

    host: the file or name of a serial line, whose port is 0. options: name and value each. name: of
    a controller whose port changes each time, for users and histories; otherwise "".
    """

    scheme: str
    host: str
    port: int
    user: str | None = None
    folder: str = ""
    options: tuple[tuple[str, str], ...] = ()
    name: str = ""

    def __str__(self) -> str:
        if self.name:
            return self.name
        options = f"?{urlencode(self.options)}" if self.options else ""
        if SCHEMES[self.scheme].device:
            return f"{self.scheme}://{self.host}{options}"
        user = f"{quote(self.user, safe='')}@" if self.user else ""
        host = f"[{self.host}]" if ":" in self.host else self.host
        named = self.folder not in ("", SCHEMES[self.scheme].folder)
        folder = f"/{quote(self.folder, safe=':/')}" if named else ""
        return f"{self.scheme}://{user}{host}:{self.port}{folder}{options}"

    def option(self, name: str, default: str) -> str:
        return dict(self.options).get(name, default)

    @property
    def label(self) -> str:
        """A name for the controller that is safe as a folder's name."""
        if self.name:
            return self.name
        folder = f"_{self.folder}" if SCHEMES[self.scheme].folder != self.folder else ""
        port = f"_{self.port}" if self.port else ""
        words = re.sub(r"[^A-Za-z0-9.-]+", "_", f"{self.scheme}_{self.host}{port}{folder}")
        return words.strip("_.")


def parse(text: str) -> Address:
    """The address that a text says; raises Refused, of exit status 2, with what is wrong in it.

    A password in it is refused and never repeated in the finding, however mistyped it is.
    """
    shown = without_password(text)
    # Before all else: every later message shows parts of the text.
    if holds_password(text):
        raise Refused(rules.PASSWORD_IN_ADDRESS(place=shown), exit_status=2)
    if re.search(r"[\x00-\x1f\x7f]", text):
        raise _bad(repr(shown), "it holds a control character")
    try:
        parts = urlsplit(text)
    except ValueError:  # which would be said with what may be a password
        raise _bad(shown, "the host is no name") from None
    scheme = SCHEMES.get(parts.scheme.lower())
    if scheme is None:
        raise Refused(_without_scheme(text, shown, parts.scheme), exit_status=2)
    try:
        port = parts.port
    except ValueError:
        raise _bad(shown, "the port is no number from 1 to 65535") from None
    wrong = _wrong_device(parts) if scheme.device else _wrong(parts, port, scheme)
    wrong = wrong or _wrong_options(parts, scheme)
    if wrong:
        raise _bad(shown, wrong)
    options = tuple(sorted(parse_qsl(parts.query)))
    if scheme.device:
        return Address(parts.scheme.lower(), parts.netloc + parts.path, 0, options=options)
    folder = unquote(parts.path).strip("/") or scheme.folder
    user = unquote(parts.username) if parts.username else None
    assert parts.hostname is not None
    return Address(parts.scheme.lower(), parts.hostname, port or scheme.port, user, folder, options)


VIRTUAL: Final[Mapping[str, Address]] = {
    "irc5": Address("rws", "127.0.0.1", 0, "engineer", "HOME:"),
    "cr": Address("melfa", "127.0.0.1", 0),
}
"""Words after `virtual:` in an address of a project → address of that controller."""
VIRTUALLY: Final = "virtual:"


def _without_scheme(text: str, shown: str, scheme: str) -> Diagnostic:
    """Why a text is no address of a controller, and what it may mean."""
    virtual = [f"`{VIRTUALLY}{name}`" for name in VIRTUAL]
    if not text.strip():
        return rules.BAD_ADDRESS(reason="it is empty")
    if text.lower() in [f"{VIRTUALLY}{name}" for name in VIRTUAL]:
        shown = text
    if text.lower().startswith(VIRTUALLY):
        return rules.VIRTUAL_ADDRESS(place=shown, known=" and ".join(virtual))
    if "://" not in text and shown == text and _HOST.fullmatch(text):
        return rules.NO_SCHEME(place=shown, host=text)
    known = ", ".join([*(f"`{name}://`" for name in SCHEMES), *virtual])
    given = f"{scheme}://" if "://" in text else shown
    return rules.UNKNOWN_SCHEME(place=shown, given=given, known=known)


def _bad(shown: str, reason: str) -> Refused:
    return Refused(rules.BAD_ADDRESS(place=shown, reason=reason), exit_status=2)


def _wrong(parts: SplitResult, port: int | None, scheme: _Scheme) -> str | None:
    """The first thing wrong with the parts of an address."""
    said = unquote(parts.path + (parts.username or ""))
    checks = (
        (not parts.hostname, "it names no host"),
        (port == 0, "port 0 cannot be connected to"),
        ("@" in parts.path + (parts.username or ""), "one `@` may stand there, others are `%40`"),
        # A second @ usually belongs to a password.
        (bool(parts.hostname and re.search(r"[\s%/\\]", parts.hostname)), "the host is no name"),
        (bool(re.search(r"[\x00-\x1f\x7f]", said)), "it holds a control character"),
        # `..` is looked for after decoding: `%2e%2e` would pass otherwise.
        (".." in unquote(parts.path).split("/"), "the folder must not lead upwards"),
        (not scheme.login and parts.username is not None, "this controller knows no users"),
        (not scheme.login and parts.path not in ("", "/"), "this controller has no folders"),
    )
    return next((reason for wrong, reason in checks if wrong), None)


def _wrong_device(parts: SplitResult) -> str | None:
    """The first thing wrong with the name of a serial line."""
    name = parts.netloc + parts.path
    if not _SERIAL_DEVICE.fullmatch(name) or ".." in name.split("/"):
        return "a serial line is a file such as `/dev/ttyS0`, or `COM3`"
    return None


def _wrong_options(parts: SplitResult, scheme: _Scheme) -> str | None:
    """The first thing wrong with what follows the `?`."""
    if parts.fragment:
        return "nothing may follow a `#`"
    known = " ".join(f"{name}={values}" for name, values in scheme.options.items())
    if parts.query and not known:
        return "nothing may follow a `?`"
    try:
        pairs = parse_qsl(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query))
    except ValueError:
        return f"what follows the `?` must be of {known}"
    for name, value in pairs:
        # `(?!)` matches nothing: an unknown option is refused whatever its value.
        if not re.fullmatch(scheme.options.get(name, "(?!)"), value):
            return f"what follows the `?` must be of {known}"
    return None if len(dict(pairs)) == len(pairs) else "an option stands twice"


_HOST: Final = re.compile(r"(?=.*[.:])[\w.-]+(?::\d{1,5})?", re.ASCII)
"""An IP or a host with or without a port, alone."""
_BEGINNING: Final = re.compile(
    rf"(?:(?:{'|'.join(sorted(SCHEMES, key=len, reverse=True))}|https?):?"
    r"|[a-z][a-z0-9+.-]*:(?=//))?[/\\]*",
    re.IGNORECASE,
)
"""Beginning of an address, also one whose `://` is mistyped. Not a word with a `:` alone: that may
be a user with a password.
"""
_SECRET_IN_ADDRESS: Final = re.compile(r"[^/@:]*:.*@", re.DOTALL)
"""A user and a password, with whatever a password may hold."""
_HARMLESS: Final = re.compile(
    r"(?:\[[0-9A-Fa-f:.]*\]|[^:=\s\[\]]*)(?::[0-9]{0,5}(?=/|$))?(?:/[^:]*(?:\bHOME:[^:]*)?)?",
    re.IGNORECASE,
)
"""Host, port and folder: nothing after a `:` but a port, and the beginning of a folder."""


def holds_password(text: str) -> bool:
    """True if the text is an address, well-formed or not, in which a password may be written.

    Not left to the URL's syntax: a password with `/`, `?` or `#` would pass for something else. No
    user name has a `:`, not even as `%3A`, because it could not be distinguished from a user with a
    password. RFC 7617 has the same rule for HTTP.
    """
    rest = text[_beginning(text) :]
    # `/`, `?` and `#` may belong to a password: both ways of reading the text are tried.
    inside = re.split(r"[/?#]", rest, maxsplit=1)[0]
    user = inside.rpartition("@")[0]
    return bool(
        _SECRET_IN_ADDRESS.match(rest)
        or _SECRET_IN_ADDRESS.match(_plain(inside))
        or ":" in _plain(user)
    )


def without_password(text: str) -> str:
    """An address as it may be shown, with `***` for all in it that could be a password.

    That is all before the last `@`, unless nothing is wrong with it; all that follows a `?` or a
    `#`; and where no host, port and folder are left, all after the first word. Percent signs hide
    nothing.
    """
    if not holds_password(text) and _is_plain(text):
        return text
    start = _beginning(text)
    place, *options = re.split(r"[?#]", text[start:], maxsplit=1)
    # Quoted characters are decoded first: `%40` hides an @.
    _, at, rest = _plain(place).rpartition("@")
    mark = "?***" if options else ""
    if not _HARMLESS.fullmatch(rest):
        rest, mark = re.split(r"[:=\s]", rest, maxsplit=1)[0] + ":***", ""
    return f"{text[:start]}{'***@' if at else ''}{rest}{mark}"


def _is_plain(text: str) -> bool:
    """True if nothing in it can be secret: all its parts are of an address, and none is a
    password.
    """
    try:
        parts = urlsplit(text)
        port = parts.port
    except ValueError:
        return False
    scheme = SCHEMES.get(parts.scheme.lower())
    if scheme is None or not text.lower().startswith(f"{parts.scheme.lower()}://"):
        return False
    wrong = _wrong_device(parts) if scheme.device else _wrong(parts, port, scheme)
    return not wrong and not _wrong_options(parts, scheme)


def _beginning(text: str) -> int:
    found = _BEGINNING.match(text)
    return found.end() if found else 0


def _plain(text: str) -> str:
    """The text without any `%` that stands for a character, however often it was quoted."""
    # Quoting may be nested: decode until nothing changes.
    while (once := unquote(text)) != text:
        text = once
    return text


_CLEAR_TEXT_CURES: Final = {
    "rws": "an OmniCore speaks `rwss://`, which is encrypted",
    "melfa": "the controller link knows neither encryption nor a login: let nobody else reach it",
}
"""Scheme without a password in clear text (Robot Web Services 1.0 have Digest) → what to do."""


def clear_text_finding(address: Address) -> Diagnostic | None:
    """The finding of an address that is not encrypted; None if it is, or on this computer."""
    if _is_this_computer(address.host):
        return None
    if address.scheme == "ftp":
        return rules.CLEAR_LOGIN(place=str(address), address=address)
    if address.scheme in _CLEAR_TEXT_CURES:
        return rules.CLEAR(
            place=str(address), address=address, cure=_CLEAR_TEXT_CURES[address.scheme]
        )
    return None


def _is_this_computer(host: str) -> bool:
    """True if data for this host never leaves this computer."""
    # A name may resolve to anything; only `localhost` is known to stay here.
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


USER_VARIABLE: Final = "ROBOT_ASSISTANT_USER"
PASSWORD_VARIABLE: Final = "ROBOT_ASSISTANT_PASSWORD"  # noqa: S105 - the name of a variable
_KEYRING_SERVICE: Final = "robot-assistant"
"""Service name in the keyring; the entry is `user@host`."""

Question = Callable[[str], str | None]
"""Asks the user for a secret with this prompt; None or "" if there is no answer."""


@dataclass(frozen=True, slots=True)
class Credentials:
    user: str
    password: str = field(repr=False)

    def __str__(self) -> str:
        return self.user

    def hidden(self, text: str) -> str:
        """The text without the password, for replies that repeat what was sent."""
        return text.replace(self.password, "***") if self.password else text


def password_variable(controller: str, what: str) -> str:
    """The environment variable of one controller: `ROBOT_ASSISTANT_CELL1_PASSWORD`.

    what: USER or PASSWORD.
    """
    return f"{VARIABLE_PREFIX}{controller.upper().replace('-', '_')}_{what}"


def find_credentials(
    address: Address,
    *,
    controller: str = "",
    user: str | None = None,
    password: str | None = None,
    ask: Question | None = None,
    environment: Mapping[str, str] = os.environ,
) -> Credentials:
    """Return the first user and password stated: arguments, address, environment, keyring, prompt.

    controller: its name in the project; a variable for this controller precedes the one for all.
    Raises Refused if they are missing.
    """

    def stated(what: str, of_all: str) -> str | None:
        own = environment.get(password_variable(controller, what)) if controller else None
        return environment.get(of_all) if own is None else own

    name = user or address.user or stated("USER", USER_VARIABLE)
    if not name:
        raise Refused(rules.NO_USER(place=str(address), address=address), exit_status=2)
    if ":" in name:
        raise Refused(rules.USER_AND_PASSWORD(place=str(address), address=address), exit_status=2)
    sources: tuple[Callable[[], str | None], ...] = (
        lambda: password,
        lambda: stated("PASSWORD", PASSWORD_VARIABLE),
        lambda: _from_keyring(f"{name}@{address.host}"),
        lambda: ask(f"Password of {name} on {address.host}: ") if ask else None,
    )
    # In this order, and lazily: the user is only asked if nothing else states it.
    secret = next((found for source in sources if (found := source()) is not None), None)
    if secret is None:
        missing = rules.NO_PASSWORD(place=str(address), address=address, user=name)
        raise Refused(missing, exit_status=2)
    return Credentials(name, secret)


def _from_keyring(entry: str) -> str | None:
    """Return the password in the system's keyring, None without a password or a keyring."""
    try:
        import keyring
        import keyring.errors
    except ImportError:
        return None
    try:
        found: str | None = keyring.get_password(_KEYRING_SERVICE, entry)
    except keyring.errors.KeyringError:
        return None  # locked or without a backend: the next source is asked
    return found
