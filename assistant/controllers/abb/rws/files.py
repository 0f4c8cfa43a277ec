"""Files on the volumes of a controller: modules, configuration, backups.

A file is stored under a temporary name, read back, compared, and only then put in the place of
the one that was there, which waits under another name until the new one is there.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.files import MOST_ENTRIES, asides, first_difference, free_aside
from assistant.controllers.abb.rws.session import NotThere, Session
from assistant.controllers.abilities import Rests

_TEMPORARY: Final = "~{name}"
"""Name of a file until it is whole."""
_DEEPEST: Final = 30
"""Levels of folders after which a volume counts as faulty."""


@dataclass(frozen=True, slots=True)
class Found:
    """Entry of a folder. size: bytes of a file, None if not reported."""

    name: str
    folder: bool
    size: int | None = None


class Files:
    """The file service. Paths begin with a volume, as `HOME:/parts/seam.mod` in RAPID."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def path(self, name: str) -> str:
        """A path as the dialect writes it: `$HOME/parts` or `HOME/parts`."""
        volume, _, rest = name.partition("/")
        # RAPID writes `HOME:`, RWS 1.0 `$HOME`, RWS 2.0 `HOME`.
        place = f"{self._session.dialect.unit}{volume.removesuffix(':').lstrip('$')}"
        return f"{place}/{rest}" if rest else place

    def _at(self, name: str) -> dict[str, str]:
        return {"path": self.path(name)}

    def listing(self, folder: str) -> tuple[Found, ...]:
        """Return the entries of a folder, sorted; raises NotThere."""
        doing = f"listing `{folder}`"
        found: list[Found] = []
        for page in self._session.pages("list folder", doing=doing, at=self._at(folder)):
            for row in page.of("fs-dir", "fs-file"):
                size = row.get("fs-size")
                length = int(size) if size.isdecimal() else None
                found.append(Found(row.title, row.kind.startswith("fs-dir"), length))
        bad = next(
            (f.name for f in found if f.name in ("", ".", "..") or "/" in f.name or "\\" in f.name),
            None,
        )
        # Names of a server become local paths: none may lead out of the folder.
        if bad is not None:
            raise self._session.garbled(doing, f"an entry `{bad}`")
        return tuple(sorted(found, key=lambda one: one.name))

    def tree(self, folder: str) -> Iterator[tuple[str, int | None]]:
        """All files below a folder with their sizes, relative to it."""
        waiting, count = [""], 0
        while waiting:
            below = waiting.pop()
            for found in self.listing(f"{folder}/{below}".rstrip("/")):
                name, count = f"{below}{found.name}", count + 1
                if count > MOST_ENTRIES:
                    raise self._session.garbled(f"listing `{folder}`", f"{count} entries")
                if not found.folder:
                    yield name, found.size
                elif name.count("/") < _DEEPEST:
                    waiting.append(f"{name}/")
                else:
                    raise self._session.garbled(f"listing `{folder}`", f"folders down to `{name}`")

    def read(self, name: str) -> bytes | None:
        """Return the bytes of a file, None if it is missing."""
        doing = f"reading `{name}`"
        try:
            answer = self._session.ask("read file", doing=doing, at=self._at(name))
        except NotThere:
            return None
        # Without a marked end a cut transfer looks complete: the listing tells the size.
        if not answer.framed and len(answer.data) != self._size(name):
            raise self._session.garbled(doing, f"it ends after {len(answer.data)} bytes")
        return answer.data

    def _size(self, name: str) -> int | None:
        """Bytes of a file as its folder has it."""
        folder, _, last = name.rpartition("/")
        return next((f.size for f in self.listing(folder) if f.name.lower() == last.lower()), None)

    def put(self, name: str, data: bytes, state: str) -> None:
        """Write a file, read it back and compare; replaces an existing file."""
        at = self._at(name)
        self._session.ask("write file", doing=f"storing `{name}`", state=state, body=data, at=at)
        back = self._session.ask("read file", doing=f"reading `{name}` back", state=state, at=at)
        if back.data != data:
            raise Refused(
                rules.ALTERED(
                    place=name,
                    name=name,
                    sent=len(data),
                    back=len(back.data),
                    at=first_difference(data, back.data),
                    state=state,
                )
            )

    def write(self, folder: str, name: str, data: bytes) -> None:
        """Puts a file into a folder, whole or not at all."""
        temporary = _TEMPORARY.format(name=name)
        state = f"`{name}` there is as it was"
        try:
            self.put(f"{folder}/{temporary}", data, state)
            self._replace(folder, temporary, name)
        except rules.Lost:
            raise
        except Refused:
            self.discard(f"{folder}/{temporary}")
            raise

    def remove(self, name: str) -> None:
        """Delete a file or folder; do nothing if it is missing."""
        state = f"`{name}` is still there"
        with suppress(NotThere):
            self._session.ask(
                "delete file", doing=f"deleting `{name}`", state=state, at=self._at(name)
            )

    def discard(self, name: str) -> None:
        """Deletes what is only a rest; one that stays is overwritten by the next."""
        try:
            self.remove(name)
        except rules.Lost:
            raise
        except Refused:
            return

    def clear_rests(self, folder: str, known: Rests) -> None:
        """See `abilities.Disk`."""
        there = {found.name.lower(): found.name for found in self.listing(folder)}
        for name, contents in known.items():
            temporary = there.get(_TEMPORARY.format(name=name).lower())
            if temporary is not None:
                self.remove(f"{folder}/{temporary}")
            for aside in asides(name, there.values()):
                if contents is None or self.read(f"{folder}/{aside}") in contents:
                    self.remove(f"{folder}/{aside}")

    def make_folder(self, name: str) -> None:
        """Make a folder, and those above it, if it is missing."""
        parent, _, last = name.rpartition("/")
        # The volume itself has no parent, and is always there.
        if not parent or any(f.folder and f.name == last for f in self._there(parent)):
            return
        self._session.ask(
            "make folder",
            doing=f"making the folder `{name}`",
            form={"fs-newname": last},
            at=self._at(parent),
        )

    def claim(self, parent: str, name: str) -> bool:
        """Makes a folder in one that there is; False if there is one of that name already."""
        try:
            self._session.ask(
                "make folder",
                doing=f"making the folder `{name}`",
                form={"fs-newname": name},
                at=self._at(parent),
            )
        except rules.Lost:
            raise
        except Refused:
            # The refusal may have another reason: only a
            # folder that is there says that it is taken.
            if any(found.name.lower() == name.lower() for found in self.listing(parent)):
                return False
            raise
        return True

    def _there(self, folder: str) -> tuple[Found, ...]:
        try:
            return self.listing(folder)
        except NotThere:
            self.make_folder(folder)
            return ()

    def _rename(self, folder: str, name: str, new: str, state: str) -> None:
        self._session.ask(
            "rename file",
            doing=f"renaming `{name}` to `{new}`",
            state=state,
            form={"fs-newname": new},
            at=self._at(f"{folder}/{name}"),
        )

    def _replace(self, folder: str, temporary: str, name: str) -> None:
        """Puts the new file into the old one's place."""
        there = [found.name for found in self.listing(folder)]
        old = next((found for found in there if found.lower() == name.lower()), None)
        if old is None:
            self._rename(folder, temporary, name, f"there is no `{name}`, or it is the new file")
            return
        # RWS never renames over a file: the old one waits under another name.
        aside = free_aside(name, there)
        state = f"`{name}` there is as it was, or is `{aside}`"
        self._rename(folder, old, aside, state)
        try:
            self._rename(folder, temporary, name, f"the old file is `{aside}`")
        except rules.Lost:
            raise
        except Refused:
            gone = f"there is no `{name}` on the controller now, the old file is `{aside}`"
            self._rename(folder, aside, old, gone)
            raise
        self.remove(f"{folder}/{aside}")
