"""What a target is, and what it must not find."""

from __future__ import annotations

import re
import tempfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from assistant.base.budgets import INTERNAL_ERROR
from assistant.base.diagnostics import Diagnostic, Refused

ROOT: Final = Path(__file__).resolve().parents[2]
CASES: Final = Path(__file__).parent / "cases"
_CODE: Final = re.compile(r"[A-Z]{2}\d{3}")


class Broken(AssertionError):
    """A promise that an input broke. what: the promise, the same for all inputs that break it."""

    def __init__(self, what: str, details: object = "") -> None:
        super().__init__(f"{what}: {details}" if details else what)
        self.what: Final = what


@dataclass(frozen=True, slots=True)
class Target:
    """Something that reads bytes from outside.

    run: takes any bytes; returns, or raises for what may not be. seeds: sound inputs, from which
    others are made. words: what is put into them, beside the words that are in them.
    together: lines that belong together. most: bytes of the longest input. seconds: of CPU time
    that an input may take at most. tried: how many changes of the seeds `make test` tries.
    """

    name: str
    run: Callable[[bytes], object]
    seeds: Callable[[], Iterable[bytes]]
    words: Callable[[], Iterable[str]] = tuple
    together: int = 1
    most: int = 3000
    seconds: float = 10.0
    tried: int = 30

    def cases(self) -> list[Path]:
        """Inputs that once failed, made small."""
        folder = CASES / self.name
        return sorted(folder.iterdir()) if folder.is_dir() else []


def one_in(count: int, data: bytes) -> bool:
    """Whether an input is one of those that a slow promise is tried on; always the same ones."""
    return zlib.crc32(data) % count == 0


def promise(kept: bool, what: str, details: object = "") -> None:
    """Raises Broken unless a promise was kept."""
    if not kept:
        raise Broken(what, details)


def sound(findings: Iterable[Diagnostic]) -> None:
    """What every finding promises: it says what is wrong and where, and nothing failed inside."""
    for finding in findings:
        promise(finding.code != INTERNAL_ERROR.code, f"{finding.code} {finding.message}")
        promise(_CODE.fullmatch(finding.code) is not None, "a code of another form", finding)
        promise(bool(finding.message), f"{finding.code} says nothing", finding)
        promise(bool(finding.where()), f"{finding.code} has no place", finding)
        if finding.excerpt is not None and finding.column is not None:
            inside = 1 <= finding.column <= len(finding.excerpt) + 1
            promise(inside, f"{finding.code} points outside of its line", finding)


@contextmanager
def refusing(path: str | None = None) -> Iterator[None]:
    """What is refused inside is well, as long as it is told as it should be.

    path: of the one file that it can be about, which its command names.
    """
    with suppress(Refused):
        try:
            yield
        except Refused as refused:
            promise(bool(refused.findings), "refused without a finding")
            sound(finding.within(path) for finding in refused.findings)
            raise


@cache
def folder() -> Path:
    """An empty folder of this process, in memory where there is such a place."""
    memory = Path("/dev/shm")
    made = tempfile.TemporaryDirectory(prefix="fuzz-", dir=memory if memory.is_dir() else None)
    _FOLDERS.append(made)
    return Path(made.name)


def leave() -> None:
    """Takes the folder of this process away; for one that ends without being asked."""
    for one in _FOLDERS:
        one.cleanup()


_FOLDERS: Final[list[tempfile.TemporaryDirectory[str]]] = []
"""They are there until the process ends."""


def file(name: str, data: bytes) -> Path:
    """A file with these bytes in the folder of this process."""
    path = folder() / name
    path.write_bytes(data)
    return path


def files_of(*patterns: str, most: int = 5000) -> Callable[[], list[bytes]]:
    """The files of this repository that fit the patterns and have at most so many bytes."""

    def read() -> list[bytes]:
        found = {path.read_bytes() for pattern in patterns for path in ROOT.glob(pattern)}
        return sorted((data for data in found if len(data) <= most), key=lambda d: (len(d), d))

    return read
