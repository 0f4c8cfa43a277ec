"""Programs that are typed in: texts of the size of real ones, and what damages them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from benchmarks.code import code

ROOT: Final = Path(__file__).parent.parent.parent
DATA: Final = ROOT / "tests" / "languages"
CLOSES: Final = re.compile(
    r"[ \t\d]*(?:end[ \t]?(?:if|for|while|test|select)|next|wend)\b", re.IGNORECASE
)
LINES: Final = (450, 800, 1200)
"""Of those that are made."""


def made() -> dict[str, str]:
    """Text by file name: ordinary code, no two lines alike."""
    found = {}
    for lines in LINES:
        for language, suffix in (
            ("rapid", "mod"),
            ("melfa-basic-5", "mb5"),
            ("melfa-basic-6", "mb6"),
        ):
            (data,) = code(language, lines).values()
            found[f"code{lines}.{suffix}"] = data.decode("ascii")
    return found


def kept() -> dict[str, str]:
    """Those of the samples and of the tests of languages."""
    found = {}
    for folder in (
        *(ROOT / "samples" / "rapid", ROOT / "samples" / "melfa", ROOT / "samples" / "cell"),
        *(DATA / "rapid" / "data", DATA / "melfa_basic" / "data"),
    ):
        for file in sorted(folder.iterdir()):
            if file.suffix in (".mod", ".prg", ".mb4", ".mb5", ".mb6", ".pseudo"):
                found[f"{folder.parent.name}-{file.name}"] = file.read_bytes().decode("utf-8")
    return found


def lines_to_damage(text: str, comment: str) -> list[int]:
    """Three lines of code, spread over a text; from 0."""
    lines = text.splitlines()
    code_lines = [
        number
        for number, line in enumerate(lines)
        if len(line.split()) > 1 and not line.strip().startswith(comment)
    ]
    return [code_lines[len(code_lines) * part // 4] for part in (1, 2, 3)]


def lines_that_close(text: str) -> list[int]:
    """Two lines that end a block, spread over a text; from 0."""
    closing = [number for number, line in enumerate(text.splitlines()) if CLOSES.match(line)]
    return sorted({closing[len(closing) * part // 3] for part in (1, 2)}) if closing else []


def typed(line: str) -> Iterator[str]:
    """What a line is like while somebody mends its end, then types it anew, word by word."""
    bare = line.rstrip("\r\n")
    indent = len(bare) - len(bare.lstrip())
    step = max((len(bare) - indent) // 5, 1)
    yield bare[:-1]
    yield bare + " ("
    yield bare + ' "'
    yield bare
    for end in range(indent, len(bare), step):
        yield bare[:end]
    yield bare
