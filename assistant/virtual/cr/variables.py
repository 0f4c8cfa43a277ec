"""Commands about variables: of a program, and of all programs."""

from __future__ import annotations

import re
from typing import Final

from assistant.virtual.cr.command import VT, Command, at_once, parts, place
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import CrProgram, CrRefusal, checked_name, class_of, listed_values

VARIABLE_NAME: Final = re.compile(r"([A-Z]\w*)([$%&!#]?)((?:\(\d+(?:,\d+){0,2}\))?)", re.ASCII)
EXTERNAL_NAME: Final = re.compile(r"[A-Z]_")
NUMBER_TEXT: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?", re.ASCII | re.IGNORECASE)
STRING_TEXT: Final = re.compile(r'"[^"]*"')
POSITION_TEXT: Final = re.compile(r"(\([^()]*\))(\([^()]*\))?")
VARIABLE_CLASSES: Final = "MCPJ"


def _write_variable(session: CrSession, argument: str) -> str:
    """A variable of the program that is open for editing."""
    name, value = assignment(argument)
    if EXTERNAL_NAME.match(name):
        session.state.set_variable(None, name, value)
    else:
        session.edit.keep(name, value)
        session.changed = True
    return ""


def _write_program_variable(session: CrSession, argument: str) -> str:
    """A variable of a program, which may run."""
    program, rest = parts(argument, 2)
    program = checked_name(program)
    if program not in session.state.store:
        raise CrRefusal(4140)
    name, value = assignment(rest)
    session.state.set_variable(None if EXTERNAL_NAME.match(name) else program, name, value)
    return ""


def assignment(text: str) -> tuple[str, str]:
    """`name=value` with the value as a controller lists it; raises CrRefusal."""
    name, sign, value = text.partition("=")
    name, value = re.sub(r"\s", "", name).upper(), value.strip()
    found = VARIABLE_NAME.fullmatch(name)
    if not sign or found is None:
        raise CrRefusal(4220)
    kind, made = found[1][0], ""
    if NUMBER_TEXT.fullmatch(value):
        made = shown_number(float(value))
    elif STRING_TEXT.fullmatch(value):
        made = value
    elif place := POSITION_TEXT.fullmatch(value):
        try:
            made = listed_values(place[1]) + re.sub(r"\s", "", place[2] or "")
        except ValueError:
            raise CrRefusal(4220) from None
    if not made:
        raise CrRefusal(4220)
    given = class_of(f"{name}={made}")
    if given == "J" and kind == "P":
        made += "(0,0)"
        given = "P"
    if (kind in VARIABLE_CLASSES or found[2] == "$") and given != (
        "C" if found[2] == "$" else kind
    ):
        raise CrRefusal(4390)
    return name, made


def shown_number(value: float) -> str:
    """As a controller lists it: `+3`, `-0.25`."""
    return f"{value:+.10g}"


def _variable_type(session: CrSession, argument: str) -> str:
    """M, C, P or J of a variable that has a value or stands in a line of the program."""
    name = argument.strip().upper()
    program = session.edit
    lines = program.variables | program.values
    if name in lines:
        return class_of(lines[name])
    used = re.compile(rf"(?<![\w.]){re.escape(name)}(?![\w$%&!#(])", re.IGNORECASE | re.ASCII)
    if not VARIABLE_NAME.fullmatch(name) or not any(used.search(s) for s in program.steps.values()):
        return ""
    return "C" if name.endswith("$") else name[0] if name[0] in "PJ" else "M"


def _read_variable(session: CrSession, argument: str) -> str:
    lines, at, key = _requested_variables(session, argument, shared=False)
    session.following[key] = min(at + 1, len(lines))
    return lines[at] if at < len(lines) else ""


def _read_variables(session: CrSession, argument: str) -> str:
    return _listed_together(session, *_requested_variables(session, argument, shared=False))


def _read_shared_variable(session: CrSession, argument: str) -> str:
    lines, at, key = _requested_variables(session, argument, shared=True)
    session.following[key] = min(at + 1, len(lines))
    return lines[at] if at < len(lines) else ""


def _read_shared_variables(session: CrSession, argument: str) -> str:
    return _listed_together(session, *_requested_variables(session, argument, shared=True))


def _requested_variables(
    session: CrSession, argument: str, *, shared: bool
) -> tuple[list[str], int, str]:
    """The variables of the class that is asked for, the index of the first wanted, and the name
    of the listing. `<` is the first, `>` the last; a class may miss behind a name.
    """
    where, _, kind = argument.partition(";")
    kind = kind or VARIABLE_CLASSES
    if any(letter not in VARIABLE_CLASSES for letter in kind):
        raise CrRefusal(4460)
    key = f"{'shared' if shared else 'own'} {kind}"
    lines = (_shared_program(session) if shared else _program_of_slot(session)).valued(kind)
    names = [line.partition("=")[0].upper() for line in lines]
    at = place(where, session.following.get(key, 0), names, top="<", end=">")
    return lines, at, key


def _listed_together(session: CrSession, lines: list[str], at: int, key: str) -> str:
    listed = at_once(lines[at:], f";{VT}")
    behind = session.following[key] = at + len(listed)
    if not listed:
        return ""
    return f"{f';{VT}'.join(listed)};{len(listed)};{int(behind < len(lines))}"


def _shared_program(session: CrSession) -> CrProgram:
    return session.state.machinery.shared_now()


def _program_of_slot(session: CrSession) -> CrProgram:
    """The program of the slot; where it has none, and in the edit slot, the one that is open."""
    state = session.state
    name = state.selected.get(session.slot) if session.slot <= TASKMAX else None
    if name is None or name not in state.store:
        return session.edit
    return state.program_now(name)


VARIABLE_COMMANDS: Final = {
    "VAL=": Command(_write_variable),
    "HOT": Command(_write_program_variable),
    "VTYPRD": Command(_variable_type),
    "VAL": Command(_read_variable),
    "VALS": Command(_read_variables),
    "GVAL": Command(_read_shared_variable),
    "GVALS": Command(_read_shared_variables),
}
