"""Types and data that every controller knows, read from `predefined.txt`.

Sources: the data types of the RobotWare 6 manual (3HAC050917); component orders checked against
rpiRobotics/abb_motion_program_exec; names of constants as KnoP-01/rapid-for-vim lists them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

from assistant.languages.rapid.tables.standard import FUNCTIONS, INSTRUCTIONS, OPTION_ROUTINES
from assistant.languages.signatures import Type

TYPE_KINDS: Final = ("VALUE", "OTHER", "ALIAS", "HANDLE", "DEVICE", "RECORD")
_LINE: Final = re.compile(r"^([A-Z]+)(?: (\w+))?: (.*)$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Datum:
    """Predefined data. storage: `CONST`, `PERS` or `VAR`."""

    name: str
    storage: str
    type: str


@cache
def types() -> Mapping[str, Type]:
    """Every predefined type by lower-case name.

    Its kind is `VALUE`, `ALIAS`, `RECORD`, `HANDLE` (without a value), `DEVICE` (named in the
    controller's configuration) or `OTHER`.
    """
    return dict(_types())


def is_handle(type: str) -> bool:
    """Whether data of a type has no value: it is a VAR, without an initial one."""
    known = types().get(type.lower())
    return known is not None and known.kind == "HANDLE"


NUMBERED: Final = frozenset(("wztemporary", "wzstationary"))
"""Handles that may be declared with a number in brackets, as backups of controllers do."""


@cache
def data() -> Mapping[str, Datum]:
    """All predefined data by lower-case name."""
    return {
        name.lower(): Datum(name, word, of)
        for word, of, text in _predefined_lines()
        if word not in TYPE_KINDS
        for name in text.split()
    }


@cache
def taken_names() -> frozenset[str]:
    """Lower-case names that mean something on every controller: nothing else may have them."""
    return frozenset((*types(), *data(), *INSTRUCTIONS, *FUNCTIONS, *OPTION_ROUTINES))


def _types() -> Iterator[tuple[str, Type]]:
    for word, of, text in _predefined_lines():
        if word == "RECORD":
            yield of.lower(), Type(of, word, components=_components(text))
        elif word in TYPE_KINDS:
            for name in text.split():
                yield name.lower(), Type(name, word, of)


def _components(text: str) -> Mapping[str, str] | None:
    if text == "...":
        return None
    pairs = (part.split() for part in text.split(", "))
    return {name: type for type, name in pairs}


@cache
def _predefined_lines() -> tuple[tuple[str, str, str], ...]:
    text = files("assistant.languages.rapid.tables").joinpath("predefined.txt").read_text("utf-8")
    return tuple((m[1], m[2] or "", m[3]) for m in _LINE.finditer(text.replace("\n    ", " ")))


FIRST_ERROR: Final = 1001


@cache
def error_numbers() -> Mapping[str, int]:
    """Numbers of errors by lower-case name, which the manuals do not state: counted here."""
    names = (name for name, datum in data().items() if datum.type == "errnum")
    return {name: at for at, name in enumerate(names, FIRST_ERROR) if name != "errno"}
