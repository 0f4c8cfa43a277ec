"""Signals that kept texts set and wait for, as the instructions in them say what they are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Final

from assistant.languages.rapid.lift.processes import process_signals
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.walk import nodes
from assistant.program import statements as p
from assistant.program.program import Signal

_SIGNAL_TYPES: Final = {
    f"signal{letter}{way[0]}": Signal(kind, way)  # type: ignore[arg-type]
    for letter, kind in (("d", "digital"), ("g", "group"), ("a", "analog"))
    for way in ("input", "output")
}
"""By type of data, what a signal is."""


def signals_in(
    statements: Iterable[p.Statement], known: Callable[[str], bool]
) -> Iterator[tuple[str, Signal]]:
    """The signals that kept texts name. known: whether a lower-case name is other data."""
    for statement in statements:
        if isinstance(statement, p.Opaque) and statement.language == verbatim.LANGUAGE:
            read = verbatim.understood(verbatim.handlers, statement.text) or verbatim.understood(
                verbatim.statements, statement.text
            )
            for node in nodes(read or ()):
                if isinstance(node, s.ProcedureCall):
                    yield from (
                        (n, x) for n, x in _instruction_signals(node) if not known(n.lower())
                    )


def _instruction_signals(call: s.ProcedureCall) -> Iterator[tuple[str, Signal]]:
    found = signature(call.name) if isinstance(call.name, str) else None
    if isinstance(call.name, str) and (known := called(call)) is not None:
        yield from process_signals(known)
    if found is None:
        return
    required = iter(found.required)
    named = {q.name.lower(): q.type for slot in found.slots for q in slot.alternatives}
    for argument in call.arguments:
        types: tuple[str, ...] = ()
        match argument:
            case s.Positional(_, None):
                slot = next(required, None)
                types = tuple(q.type for q in slot.alternatives) if slot else ()
            case s.Positional(_, str(name)) | s.Option(name, _):
                types = (named.get(name.lower(), ""),)
        value = getattr(argument, "value", None)
        if isinstance(value, s.NameRef) and len(types) == 1 and types[0] in _SIGNAL_TYPES:
            yield value.name, _SIGNAL_TYPES[types[0]]
