"""Constructs of more than a line: ways through programs, blocks in each other, calls, names."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Final

from benchmarks.growth.construct import Construct, Lines
from benchmarks.growth.melfa_programs import MELFA_BASIC
from benchmarks.growth.pseudo_programs import PSEUDO
from benchmarks.growth.rapid_programs import RAPID
from benchmarks.growth.whole_programs import WHOLE_MELFA_BASIC, WHOLE_RAPID


def _steps(lines: Lines, n: int) -> str:
    return "".join(f"{k} {line}\n" for k, line in enumerate(lines(n), 1))


def _module(lines: Lines, n: int) -> str:
    return "\n".join(("MODULE m", *lines(n), "ENDMODULE", ""))


def _program(lines: Lines, n: int) -> str:
    return "\n".join(("program p", *lines(n), ""))


_KINDS: Final = (
    ("MELFA-BASIC", ".prg", MELFA_BASIC, _steps),
    ("RAPID", ".mod", RAPID, _module),
    ("pseudo", ".pseudo", PSEUDO, _program),
    ("whole MELFA-BASIC", ".prg", WHOLE_MELFA_BASIC, _steps),
    ("whole RAPID", ".mod", WHOLE_RAPID, _module),
)


def flows() -> Iterator[Construct]:
    """All of them."""
    for language, suffix, rows, whole in _KINDS:
        for name, lines in rows.items():
            yield Construct(f"{language}: {name}", suffix, partial(whole, lines))
