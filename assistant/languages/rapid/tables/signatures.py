"""Instructions and functions of RobotWare: their parameters, read from `signatures.txt`.

Source: the RAPID instructions, functions and data types manual of RobotWare 6 (3HAC050917),
compared with the arguments that programs give; instructions of options by their manuals or
by name only. What is not certain is open or has no type, so that nothing is concluded from it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final


@dataclass(frozen=True, slots=True)
class Parameter:
    """type: lower case, empty if it is not known. dimensions: 0 of a single value, -1 any.

    mode: `VAR`, `PERS`, `INOUT`; `REF` for the mere name of any object, empty for a value.
    """

    name: str
    type: str
    mode: str = ""
    dimensions: int = 0


@dataclass(frozen=True, slots=True)
class Slot:
    """One place in a list of parameters: a parameter, or several that exclude each other."""

    alternatives: tuple[Parameter, ...]
    optional: bool = False


@dataclass(frozen=True, slots=True)
class Signature:
    """What a routine is called with.

    kind: `PROC`, `FUNC` or `TRAP`. result: type of a function's value, empty if not known.
    open: whether there may be more parameters than stated.
    option: of RobotWare that brings the routine, empty for every controller.
    """

    name: str
    kind: str
    slots: tuple[Slot, ...] = ()
    result: str = ""
    open: bool = False
    option: str = ""

    @property
    def required(self) -> tuple[Slot, ...]:
        return tuple(slot for slot in self.slots if not slot.optional)

    @property
    def optional(self) -> tuple[Slot, ...]:
        return tuple(slot for slot in self.slots if slot.optional)


@cache
def signature(name: str) -> Signature | None:
    """The standard routine of that name in any case, None if there is none."""
    row = rows().get(name.lower())
    return None if row is None else _signature(*row)


@cache
def rows() -> Mapping[str, tuple[str, str]]:
    """Every standard routine by lower-case name: its line and the option that brings it."""
    text = files("assistant.languages.rapid.tables").joinpath("signatures.txt").read_text("utf-8")
    return dict(_rows(text))


def _rows(text: str) -> Iterator[tuple[str, tuple[str, str]]]:
    option = ""
    for line in text.splitlines():
        if line.startswith("["):
            option = line.strip("[]")
        elif line and not line.startswith("#"):
            head = line.partition("(")[0]
            yield head.rpartition(" ")[2].lower(), (line, option)


_PARAMETER: Final = re.compile(
    r"(?:(?P<mode>VAR|PERS|INOUT|REF) )?(?P<type>[\w?]+) (?P<name>\w+)(?P<array>\{\*\})?"
)


def _signature(line: str, option: str) -> Signature:
    head, _, tail = line.partition("(")
    kind, *result, name = head.split()
    parts = [part for part in tail.removesuffix(")").split(", ") if part]
    slots = tuple(_slot(part) for part in parts if part != "...")
    return Signature(name, kind, slots, _type("".join(result)), "..." in parts, option)


def _slot(text: str) -> Slot:
    parts = text.removeprefix("\\").split(" | ")
    return Slot(tuple(map(_parameter, parts)), text.startswith("\\"))


def _parameter(text: str) -> Parameter:
    found = _PARAMETER.fullmatch(text)
    if found is None:
        raise ValueError(f"signatures.txt: {text!r} is no parameter")
    dimensions = -1 if found["array"] else 0
    return Parameter(found["name"], _type(found["type"]), found["mode"] or "", dimensions)


def _type(text: str) -> str:
    return "" if text == "?" else text.lower()
