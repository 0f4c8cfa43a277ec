"""The files of an exchange, and the claim on them: a folder that only one client can make."""

from __future__ import annotations

import getpass
import json
import os
import secrets
import socket
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path as FilePath
from typing import Final, Protocol, Self, runtime_checkable

from assistant.base.diagnostics import Refused
from assistant.base.source_text import visible
from assistant.controllers.abb.exchange import rules
from assistant.controllers.abilities import Disk
from assistant.controllers.controller import Programs

LONGEST_CLAIM: Final = 2000
"""Bytes of the claimant's file that are read."""


@dataclass(frozen=True, slots=True)
class Claimant:
    """Who holds the claim. key: random, of one claim. machine, process: where it runs."""

    key: str = ""
    who: str = "another process"
    since: str = "an unknown time"
    machine: str = ""
    process: int = 0

    @classmethod
    def here(cls) -> Self:
        """Describe this process."""
        try:
            user = getpass.getuser()
        except (OSError, KeyError, ImportError):
            user = "unknown"
        since = time.strftime("%Y-%m-%dT%H:%M:%S")
        who = f"{user}@{socket.gethostname()}"
        return cls(secrets.token_hex(8), who, since, _machine(), os.getpid())

    @classmethod
    def parse(cls, data: bytes | None) -> Self:
        """Read a claimant's file; an unknown one where it is missing or damaged."""
        try:
            content = json.loads((data or b"")[:LONGEST_CLAIM])
            key, who, since, machine = (
                visible(str(content[name])[:200]) for name in ("key", "who", "since", "machine")
            )
            return cls(key, who, since, machine, int(content["process"]))
        except (ValueError, KeyError, TypeError, RecursionError, OverflowError):
            return cls()

    @property
    def dead(self) -> bool:
        """True if it was a process of this computer that has ended without freeing its claim."""
        if not self.machine or self.machine != _machine() or sys.platform == "win32":
            return False  # os.kill would end a process there
        try:
            os.kill(self.process, 0)
        except ProcessLookupError:
            return True
        except (OSError, OverflowError):
            return False
        return False


@runtime_checkable
class HandsOver(Protocol):
    """A client that has a shorter way for small files than `write` and `read`."""

    def hand_over(self, name: str, data: bytes) -> None:
        """Puts a file there that appears whole; it is not read back."""

    def look(self, name: str) -> bytes | None:
        """A file, None if there is none that can be read now."""

    def take_away(self, name: str) -> bool:
        """Deletes a file; False, and nothing happens, if there is none."""


class Files:
    """Small files on a controller, by the shortest way that its client has."""

    def __init__(self, programs: Programs) -> None:
        self.programs = programs
        self._hands = programs if isinstance(programs, HandsOver) else None

    def put(self, name: str, data: bytes) -> None:
        if self._hands is not None:
            self._hands.hand_over(name, data)
        else:
            self.programs.write(name, data)

    def look(self, name: str) -> bytes | None:
        return self.programs.read(name) if self._hands is None else self._hands.look(name)

    def remove(self, name: str) -> None:
        if self._hands is not None:
            self._hands.take_away(name)
        else:
            self.programs.remove(name)


class Claim:
    """The claim of one client; clients that keep no folders do without."""

    def __init__(self, files: Files, prefix: str) -> None:
        self._files = files
        self._disk = files.programs if isinstance(files.programs, Disk) else None
        self._folder, self._file = f"{prefix}_claim", f"{prefix}_claimant.txt"
        self._own = Claimant.here()
        self.held = False

    def take(self) -> None:
        """Raise Refused if another exchange holds it."""
        if self._disk is None or self.held:
            return
        if not self._disk.claim(self._folder):
            holder = self._holder()
            if holder.dead:
                self.clear()
            if not holder.dead or not self._disk.claim(self._folder):
                there = self._files.programs.address
                raise Refused(rules.BUSY(place=str(there), who=holder.who, since=holder.since))
        self.held = True
        try:
            content = json.dumps(asdict(self._own)).encode("ascii")
            self._files.put(self._file, content)
        except Refused:
            with suppress(Refused):
                self.clear()
            raise

    def check(self) -> None:
        """Raise Refused if the claim was taken away, as by `exchange stop` of another process."""
        if self.held and self._holder().key != self._own.key:
            self.held = False
            raise Refused(rules.CLAIM_GONE(place=str(self._files.programs.address)))

    def free(self) -> None:
        """Let others exchange poses again."""
        if self.held:
            if self._holder().key in (self._own.key, ""):
                self.clear()
            self.held = False

    def clear(self) -> None:
        """Remove the claim, whoever holds it; the folder goes last."""
        self.held = False
        if self._disk is not None:
            self._files.remove(self._file)
            self._disk.release(self._folder)

    def _holder(self) -> Claimant:
        return Claimant.parse(self._files.look(self._file))


def _machine() -> str:
    """Name the computer and, where there are such, its name space of processes."""
    space = ""
    with suppress(OSError):
        space = str(FilePath("/proc/self/ns/pid").readlink())
    return f"{socket.gethostname()} {space}".strip()
