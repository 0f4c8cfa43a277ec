"""Rules of motion instructions: speeds, zones, tools and work objects that they name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from assistant.base.diagnostics import Rule, Severity
from assistant.languages.checks.registry import Found
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.module_view import RuleContext
from assistant.languages.rapid.tables.words import SPEEDS, ZONES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import name_of, option, positional
from assistant.languages.rapid.tree.runs import PLAIN_MOVES

MOVE_WORDS: Final = frozenset(word.lower() for word in (*PLAIN_MOVES, "MoveAbsJ"))
"""The moves that the pseudo-program has words for, lower case."""
PREDEFINED_SETTINGS: Final[Mapping[str, tuple[Mapping[str, Any], Rule]]] = {
    "speeddata": (SPEEDS, rules.UNKNOWN_SPEED),
    "zonedata": (ZONES, rules.UNKNOWN_ZONE),
}
"""By type: the values that every controller knows, and the rule of names that look like them."""


def motion_names(look: RuleContext) -> Found:
    named = {d.name.lower() for d in look.all(s.Data)}
    named |= {p.name.lower() for p in look.all(s.ParameterNode)}
    for call in look.all(s.ProcedureCall):
        plain = positional(call)
        if str(call.name).lower() in MOVE_WORDS and len(plain) >= 4:
            wobj = option(call, "wobj")
            frame = name_of(wobj.value) if wobj else ""
            places = [(name_of(value), value) for value in plain[-3:]]
            yield from _names_of_move(look, named, [*places, (frame, call)])


def _names_of_move(
    look: RuleContext, named: set[str], given: Sequence[tuple[str, s.Node]]
) -> Found:
    """given: names of speed, zone, tool and frame, each with the node to tell of it at."""
    *values, tool, frame = given
    for (name, node), type in zip(values, PREDEFINED_SETTINGS, strict=True):
        if name and name.lower() not in named and not look.find(name):
            yield from unknown_setting(look, node, name, type)
    for (name, node), role, own in ((tool, "tool", "tool0"), (frame, "work object", "wobj0")):
        found = look.find(name) if name and name.lower() != own else None
        if found is not None and found.kind in ("VAR", "CONST"):
            yield look.finding(rules.NOT_PERSISTENT, node, name=name, role=role)


def unknown_setting(look: RuleContext, node: s.Node, name: str, type: str) -> Found:
    """An undeclared name that looks like a predefined speed or zone, and is none."""
    table, rule = PREDEFINED_SETTINGS[type]
    near = "" if name.lower() in table else nearest_predefined(name, table)
    if near:
        severity = Severity.ERROR if look.compiled else Severity.WARNING
        yield look.finding(rule, node, severity=severity, name=name, near=near)


def nearest_predefined(name: str, table: Mapping[str, Any]) -> str:
    """The predefined names around one that looks like them, empty for any other name."""
    letter = "v" if table is SPEEDS else "z"
    if name[:1].lower() != letter or not name[1:].isdigit():
        return ""
    value = int(name[1:])
    sizes = sorted(int(n[1:]) for n in table if n[1:].isdigit())
    below = [n for n in sizes if n < value][-1:]
    above = [n for n in sizes if n > value][:1]
    return " or ".join(f"{letter}{n}" for n in below + above)
