"""Options of the interpreter: points that the manuals leave open, and controller parameters.

`choose` reads options as a script of a run states them, checked by the types that they have in
`Options`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from datetime import datetime
from types import NoneType, UnionType
from typing import Any, Final, Literal, Union, get_args, get_origin, get_type_hints

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.base.near_names import near_name
from assistant.virtual.kernel.kernel import CLOCK_START

Frame = tuple[float, float, float, float, float, float]
"""X, Y, Z in mm and A, B, C in degrees, as parameters have them."""


@dataclass(frozen=True, slots=True)
class Options:
    r"""Interpretation of behaviour that manuals leave open. None: such a run ends as `unknown`.

    Numbers.
    truth: the number of a comparison that is true.
    power: `^` with operands that are not integers: as they are (CR1D, table 4-11), or rounded first
    (CR1D 4-151 gives this, too).
    quotients: rounding of `\` with opposite signs, and of `Mod` with it: to 0, or downwards.
    overflow: that of an integer variable: an error, or its bits as far as they fit.
    bits: the width of an integer where its bits show: `<<`, `Hex$`, `Bin$`.
    signed: whether 16 or 32 signals whose highest is on are a negative number.
    digits: significant digits of a non-integer number as text, in `Str$`.
    degrees: components of angles in degrees instead of radian (parameter PRGMDEG).
    slides: whether additional axes slide: their components are mm then, else angles.
    longest_text: characters of a text that a variable takes.

    Names.
    unset: result of reading a number that was never set: error 3700, undefined variable, or 0.
    shared: the same for a number or text of all programs. No manual at hand states either. `M_00`
    to `M_19` exist from the first start and keep their values, and printed programs wait for
    `M_02=0` before anything sets it.
    parameters: how a Function takes those without ByVal and ByRef.
    resets: whether `Reset Err` is allowed (a program that always runs, parameter ALWENA).
    nested: whether functions of several arguments take results of functions (COSIROP: not).

    Flow.
    breaks: whether `Break` leaves loops, too, or only the innermost If or Select.
    bounds: whether the end and the step of `For` are evaluated once, or at each turn.
    calls: whether Spd and Accel apply in a program that CallP calls, and after it (COSIROP: all
    speeds are valid), or each has separate ones (CR1D 4-159: those two are invalid).

    Positions.
    over: the value of `P1/P2`.
    pallets: the posture at a point of a pallet of direction 1 to 3: divided between its corners
    (CR1D 4-189), or that of its start.
    conversions: effect of the tool and the base on JtoP and PtoJ: nothing, or all.

    Lines.
    printed: significant digits of a number that Print# writes.
    places: decimals of positions and joints there.
    columns: the width of the columns that a comma begins (COSIROP: 10).
    early: whether a line interrupts for data that came before `Com On` and was not read.
    prefixed: whether `PRN` precedes data, which distinguishes it from commands to the controller.

    The arm.
    tools, bases: by the numbers of `Tool n` and `Base n` (parameters MEXTLn and WKnCORD).
    bases_are: whether those are seen from the robot's base, or the robot from them.
    joint_turns: whether JRC is enabled (parameter JRCEXE).
    waits_end_corners: whether Dly, Hlt, Wait and Servo make the move before them end at its target.
    pulses: whether the end of a pulse is reported with its beginning, or when its time is over.

    The clock.
    began: date of the simulated clock at 0, for C_Date and C_Time.
    timers: milliseconds that each `M_Timer` shows then; a controller counts from when it is
    switched on.
    """

    truth: Literal[1, -1] = 1
    power: Literal["real", "rounded"] = "real"
    quotients: Literal["zero", "floor"] | None = None
    overflow: Literal["error", "wrap"] | None = None
    bits: Literal[16, 32] | None = None
    signed: bool | None = None
    digits: int | None = None
    degrees: bool = False
    longest_text: int = 127
    slides: bool | None = None
    unset: Literal["error", "zero"] = "error"
    shared: Literal["zero", "error"] = "zero"
    parameters: Literal["ByVal", "ByRef"] = "ByVal"
    resets: bool = False
    nested: bool = True
    breaks: Literal["all blocks", "If and Select"] = "all blocks"
    bounds: Literal["once", "each"] | None = None
    calls: Literal["shared speeds", "own speeds"] = "shared speeds"
    over: Literal["P1*Inv(P2)", "Inv(P2)*P1"] = "P1*Inv(P2)"
    pallets: Literal["divided", "start"] = "divided"
    conversions: Literal["nothing", "all"] | None = None
    printed: int = 7
    places: int = 2
    columns: Literal[10, 14] = 10
    early: bool = True
    prefixed: bool = False
    tools: Mapping[int, Frame] = field(default_factory=dict)
    bases: Mapping[int, Frame] = field(default_factory=dict)
    bases_are: Literal["seen", "seeing"] | None = None
    joint_turns: bool = False
    waits_end_corners: bool = False
    pulses: Literal["at once", "timed"] = "at once"
    began: datetime = CLOCK_START
    timers: int = 0


_NO_OPTION: Final = error("VC208", "there is no option `{name}`", "{cure}")
_BAD_OPTION: Final = error("VC209", "the option `{name}` cannot be {value}", "write {allowed}")
_SIX_NUMBERS: Final = 6
_MOST_DIGITS: Final = 17
"""So many significant digits tell any number of double precision."""
_MOST_NUMBER: Final = 2**31 - 1
_RANGES: Final[Mapping[str, tuple[int, int]]] = {
    "digits": (1, _MOST_DIGITS),
    "printed": (1, _MOST_DIGITS),
    "places": (0, _MOST_DIGITS),
    "longest_text": (1, _MOST_NUMBER),
    "timers": (0, _MOST_NUMBER),
}
"""Least and greatest value of each option that is a plain number."""


def choose(given: Mapping[str, object]) -> Options:
    """The options that are given, the others as usual; raises Refused."""
    hints = get_type_hints(Options)
    findings: list[Diagnostic] = []
    taken: dict[str, Any] = {}
    for name, value in given.items():
        if name not in hints:
            near = near_name(name, hints)
            cure = f"write `{near}`" if near else f"there are {', '.join(hints)}"
            findings.append(_NO_OPTION(name=name, cure=cure))
        elif (read := _read_option(name, hints[name], value)) is None:
            allowed = _allowed_text(name, hints[name])
            findings.append(_BAD_OPTION(name=name, value=repr(value), allowed=allowed))
        else:
            taken[name] = read
    if findings:
        raise Refused(*findings, exit_status=2)
    return replace(Options(), **taken)


def _read_option(name: str, hint: object, value: object) -> object | None:
    """The value of an option of a type, None for one that it cannot be."""
    if _is_frames(hint):
        return _read_frames(value)
    for kind in _option_types(hint):
        if get_origin(kind) is Literal:
            # `True == 1`, so the types have to agree as well.
            if any(value == one and type(value) is type(one) for one in get_args(kind)):
                return value
        elif kind is int and type(value) is int:
            least, most = _RANGES[name]
            return value if least <= value <= most else None
        elif type(value) is kind and getattr(value, "tzinfo", None) is None:
            return value
    return None


def _read_frames(value: object) -> object | None:
    """Frames by their numbers: X, Y, Z in mm and A, B, C in degrees."""
    if not isinstance(value, Mapping):
        return None
    found: dict[int, tuple[float, ...]] = {}
    for number, frame in value.items():
        if not str(number).isdecimal() or not isinstance(frame, list) or len(frame) != _SIX_NUMBERS:
            return None
        if not all(type(v) in (int, float) and abs(v) <= _MOST_NUMBER for v in frame):
            return None
        found[int(number)] = tuple(float(v) for v in frame)
    return found


def _allowed_text(name: str, hint: object) -> str:
    if _is_frames(hint):
        return "numbers with [X, Y, Z, A, B, C], as { 1 = [0, 0, 100, 0, 0, 0] }"
    words: list[str] = []
    for kind in _option_types(hint):
        if get_origin(kind) is Literal:
            words += [f'"{one}"' if isinstance(one, str) else str(one) for one in get_args(kind)]
        elif kind is bool:
            words += ["true", "false"]
        elif kind is int:
            least, most = _RANGES[name]
            words.append(f"a whole number from {least} to {most}")
        elif kind is datetime:
            words.append(f"a date and time without a zone, as {CLOCK_START.isoformat()}")
    return " or ".join(words)


def _is_frames(hint: object) -> bool:
    return get_origin(hint) is Mapping


def _option_types(hint: object) -> tuple[object, ...]:
    """Return the types that an option may have, without the None of an open one."""
    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return tuple(part for part in parts if part is not NoneType)
