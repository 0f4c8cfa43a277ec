"""Files of both sides: a number, a word, data line by line, `END number`, a checksum.

A file without the end mark is not whole; one with another checksum was changed on its way. Numbers
have at most six digits, as many as a RAPID program reads and writes exactly.
`templates/pose_exchange.mod` is the other side.
"""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from assistant.program.geometry import Pose

Word = Literal["where", "move", "pass"]
"""What is asked: where the robot is; go there and stand still; go there, on the way to a next one.
"""
Configuration = tuple[int, int, int, int]
"""cf1, cf4, cf6, cfx of a robtarget."""

LARGEST_NUMBER: Final = 999_999
UNUSED: Final = 9e8
"""RAPID writes 9E9 for an external axis that is not there."""
UNREAD: Final = 0
"""Number of the answer to a request whose own number could not be read."""
_NUMBERS: Final = re.compile(r"\[(.*)\]")
_ANSWER_LINES: Final = 8
_SUM: Final = "SUM"
LONGEST_ANSWER: Final = 4096
"""Bytes of an answer; each of its lines has 80 at most, as a RAPID string has."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What the robot says.

    word: `ok`, `stopped`, or a reason of `rules.REASONS`. pose: of the tool in the work object of
    the module, mm and unit quaternion. external: degrees or mm, NaN for an axis that is not there.
    motion: seconds that the motion took, as the controller measured them. checked: its checksum
    is right; False for an answer without one, from a module that was written before there was one.
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
    """Whether it answers that request; what could not be read has not been carried out either."""
    return answer.number == number or (answer.number == UNREAD and answer.word != "ok")


def parse_answer(data: bytes) -> Answer | None:
    """The answer that a file is, None for one that is not whole, was changed or is none."""
    if len(data) > LONGEST_ANSWER:
        return None
    lines = data.decode("latin-1").replace("\r", "").split("\n")
    after, lines = lines[_ANSWER_LINES:], lines[:_ANSWER_LINES]
    if len(lines) < _ANSWER_LINES or lines[-1] != f"END {lines[0]}":
        return None
    text = "".join(f"{line}\n" for line in lines).encode("latin-1")
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
    axes = tuple(math.nan if abs(value) > UNUSED else value for value in external)
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
