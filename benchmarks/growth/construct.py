"""A text that grows with one number, and the commands that read it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

Text = Callable[[int], str]
Lines = Callable[[int], Iterator[str]]

COMMANDS: Final[Mapping[str, Mapping[str, tuple[str, ...]]]] = {
    ".mod": {
        "check": ("check", "{file}"),
        "fmt": ("fmt", "{file}"),
        "show": ("show", "{file}"),
        "translate": ("translate", "{file}", "--to", "melfa-basic-6", "--draft", "-o", "{out}"),
        "compile": ("compile", "{file}", "-l", "rapid", "-o", "{out}"),
    },
    ".prg": {
        "check": ("check", "{file}", "--from", "melfa-basic-6"),
        "fmt": ("fmt", "{file}", "--from", "melfa-basic-6"),
        "show": ("show", "{file}", "--from", "melfa-basic-6"),
        "translate": (
            *("translate", "{file}", "--from", "melfa-basic-6"),
            *("--to", "rapid", "--draft", "-o", "{out}"),
        ),
        "compile": (
            *("compile", "{file}", "--from", "melfa-basic-6"),
            *("-l", "melfa-basic-6", "-o", "{out}"),
        ),
    },
    ".pseudo": {
        "check": ("check", "{file}"),
        "show": ("show", "{file}"),
        "compile to RAPID": ("compile", "{file}", "-l", "rapid", "-o", "{out}"),
        "compile to MELFA-BASIC": ("compile", "{file}", "-l", "melfa-basic-6", "-o", "{out}"),
    },
}
"""By the suffix of a file, the commands as they are typed; a source has those of `.pseudo`."""


@dataclass(frozen=True, slots=True)
class Construct:
    """What grows.

    text: of so many. suffix: of its file. largest: of what cannot be larger, None for any number.
    process: of the process file beside it, by the same number; None if it needs none.
    """

    name: str
    suffix: str
    text: Text
    largest: int | None = None
    process: Text | None = None

    @property
    def commands(self) -> Mapping[str, tuple[str, ...]]:
        return COMMANDS.get(self.suffix, COMMANDS[".pseudo"])
