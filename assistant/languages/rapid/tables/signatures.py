"""Instructions and functions of RobotWare: their parameters, read from `signatures.txt`.

Source: the RAPID instructions, functions and data types manual of RobotWare 6 (3HAC050917),
compared with the arguments that programs give; instructions of options by their manuals or
by name only. What is not certain is open or has no type, so that nothing is concluded from it.
A routine is a `PROC`, `FUNC` or `TRAP`; the mode of a parameter is `VAR`, `PERS`, `INOUT`, or `REF`
for the mere name of any object.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Final

from assistant.languages.signatures import Parameter, Signature, Slot


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
    return Signature(name, kind, slots, _parameter_type("".join(result)), "..." in parts, option)


def _slot(text: str) -> Slot:
    parts = text.removeprefix("\\").split(" | ")
    return Slot(tuple(map(_parameter, parts)), text.startswith("\\"))


def _parameter(text: str) -> Parameter:
    found = _PARAMETER.fullmatch(text)
    if found is None:
        raise ValueError(f"signatures.txt: {text!r} is no parameter")
    dimensions = -1 if found["array"] else 0
    return Parameter(found["name"], _parameter_type(found["type"]), found["mode"] or "", dimensions)


def _parameter_type(text: str) -> str:
    return "" if text == "?" else text.lower()
