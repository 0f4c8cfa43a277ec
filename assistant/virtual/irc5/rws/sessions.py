"""Who is logged in: Digest for RWS 1.0, Basic for RWS 2.0, and the sessions of both.

The challenge is the one that controllers send, field by field (captured in the public sources
loupeteam/A3br and others). A session is known by its cookie `-http-session-`; at most 70 are there
at once, and one that is not used for five minutes ends (abb-rws-client, docs/ARCHITECTURE.md).
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import re
import secrets
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Final

REALM: Final = "validusers@robapi.abb"
OPAQUE: Final = "799d5"
MOST_SESSIONS: Final = 70
SESSION_TIMEOUT: Final = 300.0
"""Seconds that a session lasts without a request."""
MOST_NONCES: Final = 1000
COOKIE: Final = "-http-session-"
_DIGEST_FIELD: Final = re.compile(r'(\w+)\s*=\s*(?:"((?:[^"\\]|\\.)*)"|([^\s,]+))')


@dataclass(slots=True, eq=False)
class Session:
    """number: counted from 1. key: of its cookie. privilege: in manual mode, `none`, `pending` or
    `modify`. used: when it was last, of the monotonic clock.
    """

    number: int
    key: str
    user: str
    used: float
    privilege: str = "none"

    @property
    def cookies(self) -> tuple[str, str]:
        return (
            f"{COOKIE}={self.key}; path=/; httponly",
            f"ABBCX={self.number}; path=/",
        )


@dataclass(eq=False)
class Sessions:
    """ended: is told of each session that is over. refuses: whether every login is refused."""

    user: str
    password: str = field(repr=False)
    ended: list[Callable[[Session], None]] = field(default_factory=list)
    refuses: bool = False
    most: int = MOST_SESSIONS

    def __post_init__(self) -> None:
        self._open: dict[str, Session] = {}
        self._nonces: dict[str, None] = {}
        self._count = 0
        self._lock = threading.RLock()

    def __len__(self) -> int:
        return len(self._open)

    def of(self, cookies: str) -> Session | None:
        """The session that a request belongs to, None for a new one."""
        try:
            found = SimpleCookie(cookies).get(COOKIE)
        except CookieError:
            return None
        with self._lock:
            session = None if found is None else self._open.get(found.value)
            if session is None:
                return None
            if time.monotonic() - session.used > SESSION_TIMEOUT:
                self.end(session)
                return None
            session.used = time.monotonic()
            return session

    def begin(self) -> Session | None:
        """A new session, None if there are too many."""
        with self._lock:
            now = time.monotonic()
            for old in [one for one in self._open.values() if now - one.used > SESSION_TIMEOUT]:
                self.end(old)
            if len(self._open) >= self.most:
                return None
            self._count += 1
            key = f"{self._count}::http.session::{secrets.token_hex(16)}"
            session = self._open[key] = Session(self._count, key, self.user, now)
            return session

    def end(self, session: Session) -> None:
        with self._lock:
            if self._open.pop(session.key, None) is None:
                return
        for told in tuple(self.ended):
            told(session)

    def answer_requests(self, answer: str) -> None:
        """The pendant answers all who ask for a privilege."""
        with self._lock:
            for one in self._open.values():
                if one.privilege == "pending":
                    one.privilege = answer

    # ------------------------------------------------------------------------------ login

    def challenge(self, dialect: int, stale: bool = False) -> str:
        if dialect == 2:
            return f'Basic realm="{REALM}"'
        nonce = base64.b64encode(secrets.token_bytes(30)).decode()
        with self._lock:
            self._nonces[nonce] = None
            while len(self._nonces) > MOST_NONCES:
                del self._nonces[next(iter(self._nonces))]
        return (
            f'Digest realm="{REALM}", domain="/", qop="auth", nonce="{nonce}", '
            f'opaque="{OPAQUE}", algorithm="MD5", stale="{"TRUE" if stale else "FALSE"}"'
        )

    def admits(self, dialect: int, header: str, method: str, target: str) -> bool:
        """Whether an `Authorization` header is right. target: as the request line states it."""
        scheme, _, rest = header.partition(" ")
        if self.refuses:
            return False
        if dialect == 2:
            return scheme.lower() == "basic" and self._is_basic(rest)
        return scheme.lower() == "digest" and self._is_digest(rest, method, target)

    def _is_basic(self, rest: str) -> bool:
        try:
            given = base64.b64decode(rest.strip(), validate=True)
        except (binascii.Error, ValueError):
            return False
        return hmac.compare_digest(given, f"{self.user}:{self.password}".encode())

    def _is_digest(self, rest: str, method: str, target: str) -> bool:
        """As RFC 2617 has it, with or without `qop`."""
        given = {name.lower(): quoted or bare for name, quoted, bare in _DIGEST_FIELD.findall(rest)}
        nonce = given.get("nonce", "")
        if nonce not in self._nonces or given.get("username") != self.user:
            return False
        if given.get("realm") != REALM or given.get("uri") != target:
            return False
        one = _md5(f"{self.user}:{REALM}:{self.password}")
        two = _md5(f"{method}:{given['uri']}")
        middle = nonce
        if "qop" in given:
            middle = ":".join((nonce, given.get("nc", ""), given.get("cnonce", ""), given["qop"]))
        wanted = _md5(f"{one}:{middle}:{two}")
        return hmac.compare_digest(wanted.encode(), given.get("response", "").encode())


def _md5(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()
