"""Types, data and routines that every controller knows, and the routines of RobotWare's options.

Read from `predefined.txt` (types and data) and `signatures.txt` (routines with their parameters).
Sources: the instructions, functions and data types of the RobotWare 6 manual (3HAC050917); orders
of components checked against rpiRobotics/abb_motion_program_exec; names of constants as
KnoP-01/rapid-for-vim lists them; parameters compared with the arguments that programs give;
routines of options by their manuals or by name only.

A routine is a `PROC`, `FUNC` or `TRAP`. The mode of a parameter is `VAR`, `PERS`, `INOUT`, or `REF`
for the mere name of any object. An uncertain parameter is open or has no type, so that no rule
concludes anything from it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.languages.signatures import Parameter, Signature, Slot, Type


@cache
def signature(name: str) -> Signature | None:
    """Return the standard routine of that name in any case, None for an unknown name."""
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


def _routine_names(word: str, *, options: bool) -> frozenset[str]:
    lines = rows().items()
    return frozenset(n for n, (line, of) in lines if line.startswith(word) and bool(of) == options)


INSTRUCTIONS: Final = _routine_names("PROC", options=False)
FUNCTIONS: Final = _routine_names("FUNC", options=False)
OPTION_ROUTINES: Final = _routine_names("", options=True)
"""Instructions and functions of RobotWare's options, lower case as all of these."""


def _word_set(words: str) -> frozenset[str]:
    return frozenset(words.lower().split())


MOVING: Final = _word_set(
    """
    TriggAbsJ CyclicBrakeCheck StepBwdPath EGMRunJoint EGMRunPose
    IndAMove IndCMove IndDMove IndRMove
    ArcAdaptC ArcAdaptCEnd ArcAdaptL ArcAdaptLEnd ArcAdaptLStart ArcAdaptRepL ArcRepL
    ArcC1 ArcC1End ArcC1Start ArcC2 ArcC2End ArcC2Start ArcCalcC ArcCalcCEnd
    ArcL1 ArcL1End ArcL1Start ArcL2 ArcL2End ArcL2Start ArcCalcL ArcCalcLEnd ArcCalcLStart
    BECheckTcp BESetupToolJ BETcpExtend BEUpdateTcp DaProcMJ DaProcML DispC DispL
    FCPress1LStart FCPressC FCPressL FCPressLEnd FCPressEnd FCRefStart
    PaintC PaintL PaintLDO PaintLSig CSSDeactMoveL ExecEngine PMgrRunMenu
    CalibJ CalibL Calibrate MeasureWearL NutJ NutL SpotJ SpotL SpotMJ SpotML IndGunMove
    TcDropOffTool TcPickupTool
    """
)
"""Instructions that move an axis, or may, though no speed is known to be given to them.

By the RAPID reference manual and the manuals of the options, lower case as all of these.
"""
WAITING: Final = _word_set("Stop Break SystemStopAction SyncMoveOn SyncMoveOff")
"""Instructions that hold the program without a word of waiting or a time in their parameters."""
JUMPING: Final = _word_set("ExitCycle ErrRaise RaiseToUser StartMoveRetry")
"""Instructions behind which the program does not simply go on."""
CALLING: Final = _word_set("CallByVar")
"""Instructions that call routines whose names they are given as texts,"""
NAMING: Final = _word_set("SetDataVal SetAllDataVal")
"""and that change data of such names."""


_TYPE_KINDS: Final = ("VALUE", "OTHER", "ALIAS", "HANDLE", "DEVICE", "RECORD")
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
    """True if data of a type has no value: it is a VAR without initial value."""
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
        # The other rows begin with the storage of the data that they list.
        if word not in _TYPE_KINDS
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
        elif word in _TYPE_KINDS:
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
    # A line that is indented continues the line before it.
    return tuple((m[1], m[2] or "", m[3]) for m in _LINE.finditer(text.replace("\n    ", " ")))


_FIRST_ERROR: Final = 1001


@cache
def error_numbers() -> Mapping[str, int]:
    """Numbers of errors by lower-case name, which the manuals do not state: counted here."""
    names = (name for name, datum in data().items() if datum.type == "errnum")
    # `errno` is the variable that holds an error, not an error.
    return {name: at for at, name in enumerate(names, _FIRST_ERROR) if name != "errno"}
