"""Files on the disk of an ABB controller: names that are safe, and how a file is stored.

A file is stored under a temporary name, read back, compared, and only then renamed over the
one that was there: a broken transfer leaves that one whole.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.base.source_text import check_sent
from assistant.controllers import rules
from assistant.controllers.abilities import Rests
from assistant.controllers.address import Address, Credentials
from assistant.controllers.connection import reason_of

TEMPORARY: Final = "~{name}"
"""Name of a file until it is whole; keeps the suffix, so that a server may look into it."""
_ASIDE: Final = "{name}~"
"""Name of the old file while a server that never replaces files receives the new one."""
_MOST_ASIDE: Final = 8
"""Number of names `seam.mod~`, `seam.mod~~` … that other users may have taken."""
MOST_FOLDERS: Final = 32
"""Greatest depth of folders that is searched."""
MOST_ENTRIES: Final = 100_000
"""Files and folders after which a tree counts as endless."""

DEVICE: Final = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9])(\..*)?", re.IGNORECASE)
"""Devices of Windows, whatever follows the dot (learn.microsoft.com, "Naming Files")."""


def checked_name(name: str) -> str:
    """The name, if a file of an IRC5 can have it; raises Refused."""
    checks = (
        (not name, "it is empty"),
        (len(name) > 64, "it has more than 64 characters"),
        (name.startswith(("~", ".", "-")), "it must begin with a letter, digit or `_`"),
        (name.endswith(("~", ".", " ")), "it must end with a letter, digit or `_`"),
        (
            re.fullmatch(r"[A-Za-z0-9_. ~-]*", name) is None,
            "only ASCII letters, digits, blanks, `_`, `-` and `.` are safe",
        ),
    )
    for wrong, reason in checks:
        if wrong:
            raise Refused(rules.FILE_NAME(place=name, name=name, reason=reason))
    return name


def free_aside(name: str, there: Iterable[str]) -> str:
    """Return a free name for the old file: an existing one may be another user's. Raises
    Refused.
    """
    # The disk of the controller ignores case.
    taken = {one.lower() for one in there}
    aside = _ASIDE.format(name=name)
    while aside.lower() in taken:
        aside = _ASIDE.format(name=aside)
    if len(aside) > len(name) + _MOST_ASIDE:
        reason = f"the names `{name}~` to `{name}{'~' * _MOST_ASIDE}` are all taken"
        raise Refused(rules.FILE_NAME(place=name, name=name, reason=reason))
    return aside


def asides(name: str, there: Iterable[str]) -> list[str]:
    """The names under which an old file may have been left waiting."""
    return [one for one in there if one.lower().rstrip("~") == name.lower() and one[-1] == "~"]


def first_difference(left: bytes, right: bytes) -> int:
    """Index of the first byte that differs."""
    low, high = 0, min(len(left), len(right))
    while low < high:  # the first `low` bytes are equal, the first `high + 1` are not
        middle = (low + high + 1) // 2
        low, high = (middle, high) if left[:middle] == right[:middle] else (low, middle - 1)
    return low


def checked_path(path: str) -> str:
    """The path of a file or folder below that of the address, `parts/seam.mod`; raises Refused."""
    for part in path.split("/"):
        checked_name(part)
    return path


def told_name(name: str) -> str:
    """A name that a server told, if it is safe as the name of a local file; raises Refused."""
    bad = re.search(r'[\x00-\x1f\x7f/\\:*?"<>|]', name) or DEVICE.fullmatch(name)
    if bad or name in ("", ".", "..") or name.endswith((".", " ")):
        reason = "it cannot be a file of this computer"
        raise Refused(rules.FILE_NAME(place=repr(name), name=repr(name), reason=reason))
    return name


TEXTS: Final = (".mod", ".modx", ".sys", ".sysx", ".prg", ".pgf", ".cfg")
"""Suffixes of what an ABB controller reads as programs and parameters."""
# A byte order mark may stand before MODULE.
MODULE: Final = re.compile(
    rb"^(?:\xef\xbb\xbf)?[ \t]*MODULE\s+([A-Za-z]\w{0,31})\b", re.I | re.M | re.A
)


def module_name(data: bytes) -> str | None:
    """Name of the module that a file's text begins, None if it begins none."""
    found = MODULE.search(data)
    return found[1].decode() if found else None


def only_module(data: bytes) -> str | None:
    """The same of a file that begins no other: of several, only the first would be seen."""
    found = MODULE.findall(data)
    return module_name(data) if len(found) == 1 else None


class RapidFiles:
    """Program functions that all clients of ABB controllers share; programs are files there."""

    languages: tuple[str, ...] = ("rapid",)
    lists: tuple[str, ...] = (".pgf",)
    memory_apart: bool = True

    def name_for(self, file_name: str | FilePath) -> str:
        return checked_name(FilePath(file_name).name)

    def check_text(self, name: str, data: bytes) -> None:
        """Raises Refused; other files than programs and parameters are nobody's lines."""
        if name.lower().endswith(TEXTS):
            check_sent(data, name)

    def stored(self, data: bytes) -> bytes:
        """Controllers keep files byte for byte."""
        return data


class FileSession(RapidFiles, ABC):
    """A session with a file server that stores under temporary names; a context manager."""

    def __init__(
        self,
        address: Address,
        credentials: Credentials,
        *,
        timeout: float = 30.0,
        certificate: str | FilePath | None = None,
    ) -> None:
        self.address = address
        self._credentials = credentials
        self._timeout = timeout
        self._certificate = certificate

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self.address)!r})"

    @abstractmethod
    def store(self, name: str, data: bytes, doing: str, state: str) -> None:
        """Sends a file."""

    @abstractmethod
    def retrieve(self, name: str, state: str) -> bytes:
        """The bytes of a file."""

    @abstractmethod
    def discard(self, name: str) -> None:
        """Deletes what is left of a transfer; a rest that stays is overwritten by the next."""

    @abstractmethod
    def replace(self, temporary: str, name: str) -> None:
        """Renames over the old file."""

    def write(self, name: str, data: bytes, *, as_it_was: bool = False) -> None:
        if not as_it_was:
            self.check_text(name, data)
        self._put(name, data, compared=True)

    def hand_over(self, name: str, data: bytes) -> None:
        """Puts a small file there that appears whole; unlike `write`, it is not read back.

        Its reader has to tell by its text whether it is all there.
        """
        self._put(name, data, compared=False)

    def _put(self, name: str, data: bytes, *, compared: bool) -> None:
        checked_name(name)
        temporary, state = TEMPORARY.format(name=name), f"`{name}` there is as it was"
        # Only for what the server refuses: after a lost line nothing can be deleted.
        with self._discarding(temporary):
            self.store(temporary, data, f"storing `{name}`", state)
            if compared:
                self._compare(name, data, self.retrieve(temporary, state), state)
            self.replace(temporary, name)

    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """The files in the folder, sorted."""

    @abstractmethod
    def delete(self, name: str) -> None:
        """Deletes a file that is there."""

    def clear_rests(self, known: Rests) -> None:
        there = {name.lower(): name for name in self.names()}
        for name, contents in known.items():
            temporary = there.get(TEMPORARY.format(name=checked_name(name)).lower())
            if temporary is not None:
                self.delete(temporary)
            for aside in asides(name, there.values()):
                # An old file that nobody knows may be another
                # user's: only known contents are deleted.
                if contents is None or self.retrieve(aside, f"`{aside}` is there") in contents:
                    self.delete(aside)

    @contextmanager
    def _discarding(self, temporary: str) -> Iterator[None]:
        """Deletes a file whose transfer is refused, as long as there is a connection."""
        try:
            yield
        except rules.Lost:
            raise
        except Refused:
            self.discard(temporary)
            raise

    def _compare(self, name: str, data: bytes, back: bytes, state: str) -> None:
        if back != data:
            raise Refused(
                rules.ALTERED(
                    place=name,
                    name=name,
                    sent=len(data),
                    back=len(back),
                    at=first_difference(data, back),
                    state=state,
                )
            )

    def said(self, error: Exception) -> str:
        """An error in words that do not hold the password."""
        return self._credentials.hidden(reason_of(error))
