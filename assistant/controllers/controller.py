"""What every controller's client answers, and how to get one for an address."""

from __future__ import annotations

import importlib
from pathlib import Path as FilePath
from typing import Final, Protocol, Self

from assistant.controllers.address import SCHEMES, Address, parse
from assistant.controllers.credentials import Credentials, Question, find


class Controller(Protocol):
    """A session with a controller that keeps programs; a context manager.

    Entering connects. All methods raise Refused with a finding that says what state the
    controller is in, and `rules.Lost` (a Refused) if there is no connection any more.
    Nothing here ever starts motion.
    """

    @property
    def address(self) -> Address: ...

    languages: tuple[str, ...]
    """Names of the languages whose programs it takes."""
    lists: tuple[str, ...]
    """Suffixes of files that name the files of a program; they go last, when those are there."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *error: object) -> None: ...

    def names(self) -> tuple[str, ...]:
        """The programs on it, sorted."""

    def read(self, name: str) -> bytes | None:
        """A program as the controller gives it back, None if there is none of that name."""

    def write(self, name: str, data: bytes) -> None:
        """Puts a program there, whole or not at all; replaces one of that name."""

    def remove(self, name: str) -> None:
        """Deletes a program; nothing happens if there is none."""

    def name_for(self, file_name: str | FilePath) -> str:
        """The name that a local file gets there; raises Refused if it can have none."""

    def stored(self, data: bytes) -> bytes:
        """The form in which two versions of a program are compared."""


CLIENTS: Final = {
    "ftp": ("assistant.controllers.irc5", "Irc5"),
    "ftps": ("assistant.controllers.irc5", "Irc5"),
    "melfa": ("assistant.controllers.cr", "Cr"),
}
"""Scheme of an address → module and class of its client."""


def connect(
    address: str | Address,
    *,
    user: str | None = None,
    password: str | None = None,
    ask: Question | None = None,
    credentials: Credentials | None = None,
    timeout: float = 30.0,
    certificate: str | FilePath | None = None,
) -> Controller:
    """The client for an address; use it in a `with`, which connects.

    user, password, ask: see `credentials.find`. timeout: seconds to wait for an answer.
    certificate: file of the certificate that an `ftps` controller is trusted by.
    Raises Refused if the address is wrong or no password can be found.
    """
    place = parse(address) if isinstance(address, str) else address
    module, name = CLIENTS[place.scheme]
    client = getattr(importlib.import_module(module), name)
    if not SCHEMES[place.scheme].login:
        return client(place, timeout=timeout)  # type: ignore[no-any-return]
    found = credentials or find(place, user=user, password=password, ask=ask)
    return client(place, found, timeout=timeout, certificate=certificate)  # type: ignore[no-any-return]
