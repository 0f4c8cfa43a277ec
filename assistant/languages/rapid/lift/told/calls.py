"""The one instruction that a kept text of RAPID says, and the statement that a changed one is."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.instructions import NameResolver, lift_instruction
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p

GATEWAY: Final = "gateway"
"""Option that frames a gateway message, see `tables/bytes.txt`."""


def is_vendor_text(record: Any) -> bool:
    return isinstance(record, p.Opaque | e.Verbatim) and record.language == verbatim.LANGUAGE


def instruction_of(node: p.Opaque) -> s.ProcedureCall | None:
    """The one instruction that a text of RAPID says."""
    if is_vendor_text(node):
        match verbatim.understood(verbatim.statements, node.text):
            case (s.ProcedureCall(name=str()) as call,):
                return call
    return None


def is_by_gateway(node: p.Statement) -> bool:
    """True if a statement says something to a gateway, or hears it."""
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    options = () if call is None else (a for a in call.arguments if isinstance(a, s.Option))
    return any(one.name.lower() == GATEWAY for one in options)


def word_of(call: s.ProcedureCall) -> str:
    """The instruction in lower case."""
    return str(call.name).lower()


def lifted_call(
    call: s.ProcedureCall, node: p.Opaque, meaning: NameResolver
) -> Iterator[p.Statement]:
    """The statement that a call is, if there is one, in the place of a text."""
    said = lift_instruction(call, meaning)
    if said is not None:
        yield replace(said, span=node.span)


def without_options(call: s.ProcedureCall, options: Collection[str]) -> s.ProcedureCall:
    """The call without some of its options, whose names are in lower case."""
    rest = tuple(
        one
        for one in call.arguments
        if not (isinstance(one, s.Option) and one.name.lower() in options)
    )
    return replace(call, arguments=rest)
