"""Names that nothing declares, in modules whose header says that they are whole programs.

A module that people wrote may use data and signals of the controller or of other modules; one
that was compiled has everything in it, its signals in the header.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, Final

from assistant.languages.checks.registry import Found
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.module_view import RuleContext, Task
from assistant.languages.rapid.checks.motions import MOVE_WORDS
from assistant.languages.rapid.tables.hands import hand_of
from assistant.languages.rapid.tables.predefined import taken_names
from assistant.languages.rapid.tables.standard import INSTRUCTIONS, OPTION_ROUTINES
from assistant.languages.rapid.tables.statements import STATEMENT_ROWS
from assistant.languages.rapid.text.header import module_header
from assistant.languages.rapid.tree import syntax as s

_UNTRANSLATED: Final = (
    (INSTRUCTIONS | OPTION_ROUTINES) - STATEMENT_ROWS.written - {"tpwrite"} - MOVE_WORDS
)
"""Instructions that the pseudo-program has no word for: their data may be of other modules."""
_MOTION_ARGUMENTS: Final = 3
"""Last arguments of a move: its speed, zone and tool, which have rules of their own."""


def undeclared_names(look: RuleContext) -> Found:
    """The first use of each name that nothing declares; none in a module that people wrote."""
    header = module_header(look.module)
    if not (header.program or header.unit):
        return
    signals = look.task.once(_header_signals)
    seen: set[str] = set()
    for item in look.module.items:
        own = frozenset(look.frame(item).names) if isinstance(item, s.Routine) else frozenset()
        for used in _used_names(item, own):
            low = used.name.lower()
            if low in seen or low in taken_names() or low in signals or hand_of(low):
                continue
            seen.add(low)
            if look.find(low) is None:
                yield look.finding(rules.UNDECLARED, used, name=used.name)


def _header_signals(task: Task) -> set[str]:
    """Signals that the headers of a task's modules name, and the names they are written as."""
    found: set[str] = set()
    for module in task.modules:
        header = module_header(module)
        signals = {name.lower() for name in header.signals}
        found |= signals
        found |= {n for n, original in header.names.items() if original.lower() in signals}
    return found


def _used_names(node: Any, own: frozenset[str]) -> Iterator[s.NameRef]:
    """Names of values in a tree that are not those of its routine or of loops around them."""
    match node:
        case tuple():
            for item in node:
                yield from _used_names(item, own)
        case s.NameRef(name):
            if name.lower() not in own:
                yield node
        case s.ForLoop(variable, first, last, step, body):
            yield from _used_names((first, last, step), own)
            yield from _used_names(body, own | {variable.lower()})
        case s.ProcedureCall(str(name), arguments) if name.lower() in MOVE_WORDS:
            plain = tuple(a for a in arguments if isinstance(a, s.Positional))
            yield from _used_names(plain[:-_MOTION_ARGUMENTS], own)
        case s.ProcedureCall(str(name)) if name.lower() in _UNTRANSLATED:
            pass
        case s.Option(name) if name.lower() in ("tool", "wobj"):
            pass
        case s.Node():
            for f in fields(node):
                yield from _used_names(getattr(node, f.name), own)
