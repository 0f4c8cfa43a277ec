"""Declarations of records, as those of plain data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from assistant.languages.rapid.lift.plain.mounted import TOOL
from assistant.languages.rapid.lift.plain.scopes import Datum
from assistant.languages.rapid.lift.plain.spreads import RecordValue
from assistant.languages.rapid.lift.plain.standard import predefined_value
from assistant.languages.rapid.lift.plain.values import Values
from assistant.languages.rapid.tree import syntax as s


def flat_declarations(node: s.Data, datum: Datum, values: Values) -> Iterator[s.Data]:
    """What is declared instead of some data; raises Unsaid for a value that cannot be said."""
    program = values.program
    if not datum.names:
        value = None if node.value is None else values.given(node.value, datum.type)
        yield replace(node, type=program.plain_type(node.type), value=value)
        return
    spread: RecordValue = {}
    if node.value is None and node.name.lower() in program.moving:  # set before anything uses it
        node = replace(node, value=predefined_value("tool0" if datum.type == TOOL else "wobj0"))
    if node.value is not None:
        spread = values.spread(node.value, (datum.type, datum.dimensions))
    if program.stays(node):
        yield node
    for part in program.layouts.parts(datum.type) or ():
        name, value = datum.names[part.path], spread.get(part.path)
        yield replace(node, type=part.type, name=name, value=value)
