"""Client of a Mitsubishi CR controller by the controller link, over TCP or a serial line."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Final, Self

from assistant.controllers.address import Address
from assistant.controllers.mitsubishi import listing, programs
from assistant.controllers.mitsubishi.programs import LANGUAGES
from assistant.controllers.mitsubishi.session import About, Session
from assistant.controllers.mitsubishi.session import about as identity

__all__ = ["Cr", "identity"]

EVERY_LANGUAGE: Final = tuple(name for names in LANGUAGES.values() for name in names)


class Cr:
    """A session with a CR controller; see `Controller`.

    timeout: seconds for an answer. terminator: what ends a command, None for what the address
    says.
    """

    lists: tuple[str, ...] = ()

    def __init__(
        self, address: Address, *, timeout: float = 10.0, terminator: bytes | None = None
    ) -> None:
        self.address = address
        self.languages: tuple[str, ...] = EVERY_LANGUAGE
        self.session = Session(address, timeout=timeout, terminator=terminator)

    def __repr__(self) -> str:
        return f"Cr({str(self.address)!r})"

    def __enter__(self) -> Self:
        """Connects and opens a session."""
        self.session.open()
        self.languages = LANGUAGES.get(self.identity.suffix, EVERY_LANGUAGE)
        return self

    def __exit__(self, *error: object) -> None:
        self.session.close()

    @property
    def identity(self) -> About:
        """What the controller said of itself when the session was opened."""
        return self.session.about

    def names(self) -> tuple[str, ...]:
        """Names without suffix."""
        return programs.names(self.session)

    def read(self, name: str) -> bytes | None:
        """The listing: steps, then variables, each line with CR LF."""
        return programs.read(self.session, name)

    def write(self, name: str, data: bytes) -> None:
        """Replaces the program; its lines are all looked at before the first is sent."""
        programs.write(self.session, name, data)

    def remove(self, name: str) -> None:
        programs.remove(self.session, name)

    def name_for(self, file_name: str | FilePath) -> str:
        """The file's name without suffix, in capitals."""
        return programs.checked_name(FilePath(file_name).stem.upper())

    def stored(self, data: bytes) -> bytes:
        """As a controller lists it: steps in order, variables by name with two decimals."""
        return listing.listed(data)
