"""Variables of programs and of the controller: `VAL`, `VALS`, `GVALS`, `HOT` (BFP-A4288)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.mitsubishi import values
from assistant.controllers.mitsubishi.answers import BARE_ANSWER
from assistant.controllers.mitsubishi.programs import VT, checked_name, counted, editing
from assistant.controllers.mitsubishi.session import UNCHANGED, Session
from assistant.controllers.mitsubishi.state import running

VARIABLE_CLASSES: Final = "MCPJ"
"""Numbers, texts, positions, joints."""
EXTERNAL_NAME: Final = re.compile(r"[A-Z]_", re.IGNORECASE)
"""How the names of variables begin that belong to no program."""
ACTING_VARIABLE: Final = re.compile(r"M_(?:D?OUT|HND|YDEV|UDEV|TOOL|SVO)[A-Z0-9]*(?:\(.*)?")
"""Status variables that set outputs, open hands or choose a tool: no memory of a program."""
MOST_VARIABLES: Final = 100_000
"""Variables after which a list that never ends is taken for a fault."""


def read_variable(session: Session, name: str, program: str = "", slot: int = 1) -> str:
    """The value, of a program that is named or else of the one in the slot."""
    name = values.checked_variable(name)
    if EXTERNAL_NAME.match(name):
        return _value(session, "GVAL", name, slot)
    if program and checked_name(program) != selected_program(session, slot):
        with editing(session, program, f"reading {name} of `{program}`", UNCHANGED):
            return _value(session, "VAL", name, session.edit_slot)
    return _value(session, "VAL", name, slot)


def write_variable(
    session: Session, name: str, value: str, program: str = "", slot: int = 1
) -> None:
    """Sets a variable and reads it back; while its program runs, numbers only.

    A running program may have changed it by the time that it is read.
    """
    name, value = values.checked_variable(name), values.checked_value(value)
    _carried(session, name, value)
    doing = f"setting {name}"
    state = f"{name} is as it was or as it should be"
    if EXTERNAL_NAME.match(name):
        if ACTING_VARIABLE.fullmatch(name):
            reason = "it acts on what is connected"
            raise values.bad_value(
                name, "a variable to be set", reason, "outputs, or the hand, instead"
            )
        with session.right(doing):
            session.ask(f"EXEC{name}={value}", doing=doing, state=state, shape=BARE_ANSWER)
    else:
        owner = checked_name(program) if program else selected_program(session, slot)
        if not owner:
            raise Refused(session.alarm(5100, doing))
        session.ask(f"HOT{owner};{name}={value}", doing=doing, state=state, shape=BARE_ANSWER)

    def now() -> str:
        try:
            return read_variable(session, name, program, slot)
        except rules.Lost:
            raise
        except Refused:
            return "no value"  # an external one that is being made

    back = values.read_until_settled(
        now, lambda told: values.same_value(told, value) or running(session)
    )
    if not values.same_value(back, value) and not running(session):
        raise Refused(rules.NOT_TAKEN(place=name, what=name, sent=value, back=back))


def write_saved_variables(session: Session, program: str, changed: Mapping[str, str]) -> None:
    """Sets variables of a program as it is kept, in the edit slot; all of them or none."""
    checked_name(program)
    doing = f"setting variables of `{program}`"
    state = f"`{program}` there is as it was"
    slot = session.edit_slot
    wanted = {values.checked_variable(n): values.checked_value(v) for n, v in changed.items()}
    for name, value in wanted.items():
        _carried(session, name, value)
    with editing(session, program, doing, state):
        for name, value in wanted.items():
            command = f"VAL={name}={value}"
            session.ask(command, doing=doing, state=state, slot=slot, shape=BARE_ANSWER)
        session.ask("SAVE", doing=doing, state="they may or may not be set", shape=BARE_ANSWER)
    with editing(session, program, f"reading variables of `{program}`", UNCHANGED):
        for name, value in wanted.items():
            back = _value(session, "VAL", name, slot)
            if not values.same_value(back, value):
                raise Refused(rules.NOT_TAKEN(place=name, what=name, sent=value, back=back))


def _carried(session: Session, name: str, value: str) -> None:
    """Raises Refused for what no command can hold; HOT is the longest, with its program."""
    if not session.carries(f"HOT{'X' * 12};{name}={value}"):
        reason = "the controller link cannot carry it"
        raise values.bad_value(value[:40], name, reason, "less text, of characters that it has")


def selected_program(session: Session, slot: int) -> str:
    """The program in a slot, "" for none."""
    told = session.ask("PRGRD", doing="asking for the program of a slot", slot=slot)
    return told.text.partition(".")[0].strip()


def external_variables(session: Session) -> list[str]:
    """All variables that belong to no program, `name=value` each."""
    return [line for kind in VARIABLE_CLASSES for line in _listed(session, "GVALS", kind, 1)]


def program_variables(session: Session, name: str) -> list[str]:
    """The variables of a program but for positions, which are part of its listing."""
    doing = f"reading the variables of `{name}`"
    with editing(session, name, doing, UNCHANGED):
        slot = session.edit_slot
        return [line for kind in "MCJ" for line in _listed(session, "VALS", kind, slot)]


def _listed(session: Session, command: str, kind: str, slot: int) -> Iterator[str]:
    doing = "listing variables"
    where = "<"
    for _ in range(MOST_VARIABLES):
        text = session.ask(f"{command}{where};{kind}", doing=doing, slot=slot).text
        if not text.strip("; "):
            return
        body, _, more = counted(session, text, doing)
        for item in body.split(VT):
            line = item.strip().removesuffix(";")
            if line and "=" not in line:
                session.garbled(doing, text)
            if line:
                yield line
        if not more:
            return
        where = "+1"


def _value(session: Session, command: str, name: str, slot: int) -> str:
    doing = f"reading {name}"
    text = session.ask(f"{command}{name};{_class_of(name)}", doing=doing, slot=slot).text
    if not text.strip():
        raise Refused(session.alarm(4340, doing))
    told, sign, value = text.partition("=")
    if not sign or told.strip().upper() != name:
        session.garbled(doing, text)
    return value.strip().removesuffix(";")


def _class_of(name: str) -> str:
    """By the first letter, which tells it but for names that a program has declared as numbers."""
    if "$" in name:
        return "C"
    return name[0] if name[0] in VARIABLE_CLASSES else "M"
