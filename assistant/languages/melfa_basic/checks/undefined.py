"""Rules of variables, positions and functions that nothing defines."""

from __future__ import annotations

import re
from typing import Final

from assistant.languages.checks.names import typing_distance
from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.checks.variables_of import given_anywhere, known_variables
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes

_SETTING_COMMANDS: Final = ("Tool", "Base")


def undefined_variables(look: Look) -> Found:
    """Variables that are read, and moves to positions, that nothing gives a value."""
    if look.has_strangers:
        return
    names = look.once(known_variables)
    moved = _plain_move_targets(look)
    seen: set[str] = set()
    for line, use in look.uses:
        variable, key = use.variable, use.variable.key
        if use.role != "read" or key in seen or is_call(look, variable):
            continue
        if key in names.given:
            continue
        seen.add(key)
        if key[1:2] == "_":
            stranger = key not in names.declared and vocabulary.status(key) is None
            if stranger and not near_status(key) and key not in look.calls.once(given_anywhere):
                yield look.at(rules.NO_EXTERNAL, line, variable, name=variable.marked)
        elif variable.arguments is not None:
            if key not in names.dimensioned:
                yield look.at(rules.NO_DIM, line, variable, name=variable.marked)
        elif key in moved or re.fullmatch(r"[PJ][0-9]+", key):
            kind = "joint variable" if key[0] == "J" else "position"
            name = variable.name
            yield look.at(rules.NO_POSITION, line, name, kind=kind, name=name)
        else:
            yield look.at(rules.NO_VALUE, line, variable, name=variable.marked)


def is_call(look: Look, variable: s.Variable) -> bool:
    """Whether a name with or without arguments is a function's."""
    key = variable.key
    if vocabulary.function(key) is not None and variable.arguments is not None:
        return True
    return key in look.functions or key.startswith("FN") or key == "PLT"


def _plain_move_targets(look: Look) -> set[str]:
    """Plain variables that moves, tools and bases name."""
    found: set[str] = set()
    for _, motion in look.all(s.Motion):
        for node in nodes(motion.arguments):
            if isinstance(node, s.Variable) and node.key[0] in "PJ" and not node.component:
                found.add(node.key)
    for _, command in look.all(s.Command):
        if command.keyword in _SETTING_COMMANDS:
            found |= {n.key for n in nodes(command.arguments) if isinstance(n, s.Variable)}
    return found


def undefined_calls(look: Look) -> Found:
    """Functions of MELFA-BASIC VI that are called as a statement and are not there."""
    if look.has_strangers:
        return
    for line, call in look.all(s.Call):
        name = call.function.name
        if not is_call(look, call.function):
            yield look.at(rules.NO_CALL, line, name, name=name)


def near_status(key: str) -> str:
    """The status variable that a name is one slip away from, empty for none."""
    if key[2:].isdigit():
        return ""
    for name, row in vocabulary.variables().items():
        if name[0] == key[0] and abs(len(name) - len(key)) <= 1 and len(name) > SHORT_NAME:
            if typing_distance(name, key, 1) <= 1:
                return row.name
    return ""


SHORT_NAME: Final = 4
"""Names so short that others are near them by chance."""
