"""Files of the pose exchange on the controller: requests, answers, and the claim on the exchange.

Each file holds a number, a word, data line by line, `END number`, and a checksum. A file without
the end mark is incomplete; one with another checksum was changed on its way. Numbers have at most
six digits, as many as a RAPID program reads and writes exactly. `templates/pose_exchange.mod` is
the other side. The claim is a folder, which only one client can make.
"""

from __future__ import annotations

import getpass
import json
import math
import os
import re
import secrets
import socket
import sys
import time
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path as FilePath
from typing import Final, Literal, Protocol, Self, runtime_checkable

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.source_text import visible
from assistant.controllers.abb.exchange import rules
from assistant.controllers.abilities import Disk
from assistant.controllers.controller import Programs
from assistant.program.geometry import Pose

Word = Literal["where", "move", "pass"]
"""Kind of a request: report the position; move there and stop; move there on the way to a next
pose.
"""
Configuration = tuple[int, int, int, int]
"""cf1, cf4, cf6, cfx of a robtarget."""

LARGEST_NUMBER: Final = 999_999
_UNUSED: Final = 9e8
"""RAPID writes 9E9 for an external axis that is not there."""
UNREAD: Final = 0
"""Number of the answer to a request whose own number could not be read."""
_NUMBERS: Final = re.compile(r"\[(.*)\]")
_ANSWER_LINES: Final = 8
_SUM: Final = "SUM"
_LONGEST_ANSWER: Final = 4096
"""Bytes of an answer; each of its lines has 80 at most, as a RAPID string has."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer of the robot.

    word: `ok`, `stopped`, or a reason of `rules.REASONS`. pose: of the tool in the work object of
    the module, mm and unit quaternion. external: degrees or mm, NaN for a missing axis. motion:
    seconds that the motion took, as the controller measured them. checked: its checksum is right;
    False for an answer without one, from a module that was written before checksums existed.
    """

    number: int
    word: str
    pose: Pose
    configuration: Configuration
    external: tuple[float, ...]
    motion: float
    checked: bool = False


def request_file(
    number: int, word: Word, pose: Pose | None = None, configuration: Configuration | None = None
) -> bytes:
    """The file of a request; the robot keeps its configuration where none is stated."""
    lines = [str(number), word, "", "", "", f"END {number}"]
    if pose is not None:
        lines[2:4] = _row(pose.position, 6), _row(pose.quaternion, 9)
    if configuration is not None:
        lines[4] = _row(configuration, 0)
    return with_sum("".join(f"{line}\n" for line in lines).encode("ascii"))


def with_sum(text: bytes) -> bytes:
    """Append the line with the checksum of the lines before it."""
    return text + _sum(text) + b"\n"


def _sum(text: bytes) -> bytes:
    """Adler-32 as the two numbers that a RAPID program adds up exactly."""
    value = zlib.adler32(text)
    return f"{_SUM} {value >> 16} {value & 0xFFFF}".encode("ascii")


def stop_request(number: int) -> bytes:
    return f"{number}\nEND {number}\n".encode("ascii")


def is_of(answer: Answer, number: int) -> bool:
    """True if it answers that request; an unreadable request was not executed either."""
    return answer.number == number or (answer.number == UNREAD and answer.word != "ok")


def parse_answer(data: bytes) -> Answer | None:
    """Parse an answer file, None if it is incomplete, altered or not an answer."""
    if len(data) > _LONGEST_ANSWER:
        return None
    # The server may have converted line ends.
    lines = data.decode("latin-1").replace("\r", "").split("\n")
    after, lines = lines[_ANSWER_LINES:], lines[:_ANSWER_LINES]
    # The end mark comes last: without it the file is incomplete.
    if len(lines) < _ANSWER_LINES or lines[-1] != f"END {lines[0]}":
        return None
    text = "".join(f"{line}\n" for line in lines).encode("latin-1")
    # Older modules write no checksum; one that is there has to be right.
    checked = any(after)
    if checked and after[0] != _sum(text).decode("ascii"):
        return None
    try:
        number = int(lines[0])
        position, quaternion, configuration, external = map(_values, lines[2:6], (3, 4, 4, 6))
        motion = float(lines[6])
        length = math.hypot(*quaternion)
        cf1, cf4, cf6, cfx = map(int, configuration)
        x, y, z = position
        w, a, b, c = (part / length for part in quaternion)
    except (ValueError, OverflowError, ZeroDivisionError):
        return None
    if not math.isfinite(motion) or abs(length - 1.0) > 1e-3:
        return None
    axes = tuple(math.nan if abs(value) > _UNUSED else value for value in external)
    pose = Pose((x, y, z), (w, a, b, c))
    return Answer(number, lines[1], pose, (cf1, cf4, cf6, cfx), axes, motion, checked)


def _row(values: Sequence[float], decimals: int) -> str:
    return "[" + ",".join(f"{value + 0.0:.{decimals}f}" for value in values) + "]"


def _values(line: str, count: int) -> tuple[float, ...]:
    """Finite numbers; raises ValueError if there are others or not so many."""
    found = _NUMBERS.fullmatch(line.strip())
    values = tuple(float(part) for part in found[1].split(",")) if found else ()
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ValueError
    return values


_LONGEST_CLAIM: Final = 2000
"""Bytes of the claimant's file that are read."""


@dataclass(frozen=True, slots=True)
class _Claimant:
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
            # The file may be anybody's: only its beginning is read.
            content = json.loads((data or b"")[:_LONGEST_CLAIM])
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
        # Another user's process: it lives.
        except (OSError, OverflowError):
            return False
        return False


@runtime_checkable
class HandsOver(Protocol):
    """A client that has a shorter way for small files than `write` and `read`."""

    def hand_over(self, name: str, data: bytes) -> None:
        """Puts a file there that appears whole; it is not read back."""

    def look(self, name: str) -> bytes | None:
        """Return a file, None if it is missing or cannot be read now."""

    def take_away(self, name: str) -> bool:
        """Delete a file; False, without an effect, if it is missing."""


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
        self._own = _Claimant.here()
        self.held = False

    def take(self) -> None:
        """Raise Refused if another exchange holds it."""
        if self._disk is None or self.held:
            return
        if not self._disk.claim(self._folder):
            holder = self._holder()
            # A process of this computer that has died cannot free its claim.
            if holder.dead:
                self.clear()
            # Others may have claimed in between: only one of them gets the folder.
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
            # An empty key: the file of the claim is missing, as after a cut while it was written.
            if self._holder().key in (self._own.key, ""):
                self.clear()
            self.held = False

    def clear(self) -> None:
        """Remove the claim, whoever holds it; the folder goes last."""
        self.held = False
        if self._disk is not None:
            # The folder last: as long as it is there, no one else can claim.
            self._files.remove(self._file)
            self._disk.release(self._folder)

    def _holder(self) -> _Claimant:
        return _Claimant.parse(self._files.look(self._file))


def _machine() -> str:
    """Name the computer and, where there are such, its name space of processes."""
    space = ""
    with suppress(OSError):
        # A container has process numbers of its own: the same number there is another process.
        space = str(FilePath("/proc/self/ns/pid").readlink())
    return f"{socket.gethostname()} {space}".strip()
