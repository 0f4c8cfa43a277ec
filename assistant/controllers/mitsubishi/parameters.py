"""Parameters of a CR controller: reading, writing, and which were changed.

`PNR<name>` answers `name;value[, value…];count`, `PMR=0|1` lists the changed ones,
`PRM=<name>;<value>` writes (BFP-A4288). Most take effect when the power comes on again.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.mitsubishi import values
from assistant.controllers.mitsubishi.answers import BARE_ANSWER
from assistant.controllers.mitsubishi.parameter_files import ParameterKind
from assistant.controllers.mitsubishi.programs import VT
from assistant.controllers.mitsubishi.session import Session

PARAMETER_NAME: Final = re.compile(r"[A-Z][A-Z0-9_]{0,15}")
MOST_LISTS: Final = 10_000
"""Answers after which a list that never ends is taken for a fault."""


def read_parameters(session: Session, names: Sequence[str] = ()) -> dict[str, str]:
    """Values by name, of the changed ones without names."""
    wanted = (
        [checked_parameter_name(name) for name in names] if names else changed_parameters(session)
    )
    return {name: read_parameter(session, name) for name in wanted}


def read_parameter(session: Session, name: str) -> str:
    """The value as the controller writes it, several with commas between."""
    doing = f"reading parameter {name}"
    text = session.ask(f"PNR{name}", doing=doing).text
    told, _, rest = text.partition(";")
    value, separator, count = rest.rpartition(";")
    if told.strip().upper() != name or not separator or not count.strip().isdecimal():
        session.garbled(doing, text)
    return value.strip()


def changed_parameters(session: Session) -> list[str]:
    """Names of the parameters that are not as they were delivered, sorted."""
    doing = "listing the changed parameters"
    found: set[str] = set()
    for index in range(MOST_LISTS):
        text = session.ask(f"PMR={int(index > 0)}", doing=doing).text
        if not text.strip("; "):
            break
        more, _, rest = text.partition(";")
        count, _, names = rest.partition(";")
        if more.strip() not in ("0", "1") or not count.strip().isdecimal():
            session.garbled(doing, text)
        listed = [name.strip(" ;") for name in names.split(VT)]
        found |= {name for name in listed if PARAMETER_NAME.fullmatch(name)}
        if more.strip() == "0":
            break
    return sorted(found)


def write_parameter(
    session: Session, name: str, value: str, kinds: Mapping[str, ParameterKind]
) -> None:
    """Writes a parameter and reads it back; kinds: of parameters that a file tells."""
    checked_parameter_name(name)
    values.checked_text(value, f"parameter {name}", "numbers or text with commas between")
    if name in kinds:
        kinds[name].check(name, value)
    doing = f"writing parameter {name}"
    command = f"PRM={name};{value}"
    if not session.carries(command):
        reason = "the controller link cannot carry it"
        raise values.bad_value(value, name, reason, "less text")
    state = f"{name} is as it was or as it should be"
    session.ask(command, doing=doing, state=state, shape=BARE_ANSWER)
    back = read_parameter(session, name)
    if not values.same_value(back, value):
        raise Refused(rules.NOT_TAKEN(place=name, what=f"parameter {name}", sent=value, back=back))


def checked_parameter_name(name: str) -> str:
    """A name of a parameter; raises Refused."""
    if PARAMETER_NAME.fullmatch(name):
        return name
    reason = "names of parameters have up to 16 capital letters and digits"
    raise values.bad_value(name, "a parameter", reason, "`MEXTL`")
