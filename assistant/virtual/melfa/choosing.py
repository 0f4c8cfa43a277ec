"""Options as a script of a run states them, checked by the types that they have in `Options`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from types import NoneType, UnionType
from typing import Any, Final, Literal, Union, get_args, get_origin, get_type_hints

from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.virtual.melfa.options import Options

NO_OPTION: Final = error("VC208", "there is no option `{name}`", "{cure}")
BAD_OPTION: Final = error("VC209", "the option `{name}` cannot be {value}", "write {allowed}")
SIX_NUMBERS: Final = 6


def choose(given: Mapping[str, object]) -> Options:
    """The options that are given, the others as usual; raises Refused."""
    hints = get_type_hints(Options)
    findings: list[Diagnostic] = []
    taken: dict[str, Any] = {}
    for name, value in given.items():
        if name not in hints:
            near = get_close_matches(name, hints, n=1, cutoff=0.7)
            cure = f"write `{near[0]}`" if near else f"there are {', '.join(hints)}"
            findings.append(NO_OPTION(name=name, cure=cure))
        elif (read := _read_option(hints[name], value)) is None:
            allowed = _allowed_text(hints[name])
            findings.append(BAD_OPTION(name=name, value=repr(value), allowed=allowed))
        else:
            taken[name] = read
    if findings:
        raise Refused(*findings, exit_status=2)
    return replace(Options(), **taken)


def _read_option(hint: object, value: object) -> object | None:
    """The value of an option of a type, None for one that it cannot be."""
    if _is_frames(hint):
        return _read_frames(value)
    for kind in _option_types(hint):
        if get_origin(kind) is Literal:
            if any(value == one and type(value) is type(one) for one in get_args(kind)):
                return value
        elif kind in (bool, int) and type(value) is kind and (value or kind is bool):
            return value
    return None


def _read_frames(value: object) -> object | None:
    """Frames by their numbers: X, Y, Z in mm and A, B, C in degrees."""
    if not isinstance(value, Mapping):
        return None
    found: dict[int, tuple[float, ...]] = {}
    for number, frame in value.items():
        if not str(number).isdecimal() or not isinstance(frame, list) or len(frame) != SIX_NUMBERS:
            return None
        if not all(isinstance(v, int | float) and not isinstance(v, bool) for v in frame):
            return None
        found[int(number)] = tuple(float(v) for v in frame)
    return found


def _allowed_text(hint: object) -> str:
    if _is_frames(hint):
        return "numbers with [X, Y, Z, A, B, C], as { 1 = [0, 0, 100, 0, 0, 0] }"
    words: list[str] = []
    for kind in _option_types(hint):
        if get_origin(kind) is Literal:
            words += [f'"{one}"' if isinstance(one, str) else str(one) for one in get_args(kind)]
        elif kind is bool:
            words += ["true", "false"]
        elif kind is int:
            words.append("a whole number above 0")
    return " or ".join(words)


def _is_frames(hint: object) -> bool:
    return get_origin(hint) is Mapping


def _option_types(hint: object) -> tuple[object, ...]:
    """The types that an option may have; that it may be left open is none of them."""
    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return tuple(part for part in parts if part is not NoneType)
