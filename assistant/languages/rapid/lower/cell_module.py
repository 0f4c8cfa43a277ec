"""A module that declares what the cell file states of names that no module declares.

Data gets the value of the cell; a routine stops where the program comes to it, or does nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.checks.missing_types import TRAP_TYPE
from assistant.languages.rapid.lower.data import NO_LOAD
from assistant.languages.rapid.lower.expressions import RECORDS, bracketed, number, text
from assistant.languages.rapid.tables.constants import CELL_MODULE
from assistant.languages.rapid.tables.equivalents import speed_values, zone_values
from assistant.languages.rapid.tables.predefined import is_handle
from assistant.languages.rapid.text.printer import print_file
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import has_no_value
from assistant.program.geometry import Frame, JointTarget, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.program import identifier
from assistant.program.undeclared_names import (
    CallArgument,
    ChannelLine,
    Plain,
    Supplied,
    SuppliedValue,
    Wanted,
)

_CONSTANT_TYPES: Final = ("speeddata", "zonedata", "robtarget", "jointtarget")
_TYPE_OF_KIND: Final[Mapping[str, str]] = {
    "tool": "tooldata", "frame": "wobjdata", "speed": "speeddata", "blend": "zonedata",
    "position": "robtarget", "joints": "jointtarget",
}  # fmt: skip


def cell_module_text(given: Supplied, taken: Sequence[str]) -> str:
    """The text of a module with a declaration of each name. taken: names of modules, lower case.

    Raises Refused for numbers that RAPID cannot write.
    """
    items = [_declared_item(wanted, value) for wanted, value in given]
    items.sort(key=lambda item: isinstance(item, s.Routine))  # data stands first in a module
    module = s.Module(identifier(CELL_MODULE, set(taken)), (), tuple(items))
    return print_file(s.File((module,)), "\n")


def with_cell_values(trees: Sequence[s.File], given: Supplied) -> tuple[list[s.File], Supplied]:
    """The trees whose persistent data without a value have it, and what is left to be declared."""
    values = {wanted.name.lower(): (wanted, value) for wanted, value in given}
    found: set[str] = set()

    def valued(item: s.Item) -> s.Item:
        if not isinstance(item, s.Data) or not has_no_value(item):
            return item
        wanted, value = values.get(item.name.lower(), (None, None))
        if wanted is None or value is None:
            return item
        found.add(item.name.lower())
        return replace(item, value=_value_node(value))

    made = []
    for tree in trees:
        parts = [
            replace(one, items=tuple(map(valued, one.items))) if isinstance(one, s.Module) else one
            for one in tree.parts
        ]
        made.append(replace(tree, parts=tuple(parts)) if found else tree)
    return made, [one for one in given if one[0].name.lower() not in found]


def _declared_item(wanted: Wanted, value: SuppliedValue | None) -> s.Item:
    if wanted.kind == "routine":
        return _empty_routine(wanted, stops=value != "empty")
    if wanted.kind == "record":
        said = value if isinstance(value, tuple) else ()
        words = (str(one).split() for one in said)
        return s.Record(False, wanted.name, tuple((type, name) for type, name in words))
    type = wanted.type or _TYPE_OF_KIND.get(wanted.kind, "num")
    size = tuple(s.NumberLiteral(str(extent)) for extent in wanted.size)
    if value is None or is_handle(type):
        return s.Data("", "VAR", type, wanted.name, size)
    # The program may assign it, so it must not be a constant.
    fixed = type in _CONSTANT_TYPES and not wanted.assigned
    return s.Data("", "CONST" if fixed else "PERS", type, wanted.name, size, _value_node(value))


def _value_node(value: SuppliedValue) -> s.Expression:
    match value:
        case Tool():
            return bracketed(RECORDS.values(replace(value, load=value.load or NO_LOAD)))
        case Frame() | Target() | JointTarget():
            return bracketed(RECORDS.values(value))
        case Speed():
            return bracketed(RECORDS.rounded(speed_values(value), 3, "a speed"))
        case Blend():
            return bracketed([value.fine, *RECORDS.rounded(zone_values(value), 3, "a zone")])
        case ChannelLine():  # stands in the statements that open it
            return s.BoolLiteral(False)
        case _:
            return _plain_value_node(value)


def _plain_value_node(value: Plain) -> s.Expression:
    match value:
        case bool():
            return s.BoolLiteral(value)
        case str():
            return text(value)
        case tuple():
            return s.AggregateNode(tuple(map(_plain_value_node, value)))
    return number(value)[0]


def _empty_routine(wanted: Wanted, *, stops: bool) -> s.Routine:
    """A routine that stops where the program comes to it, or that does nothing."""
    stop: tuple[s.StatementNode, ...] = (s.ProcedureCall("Stop"),) if stops else ()
    if wanted.type == TRAP_TYPE:
        return s.Routine("TRAP", False, wanted.name, stop)
    parameters = tuple(_parameter_group(at, one) for at, one in enumerate(wanted.arguments, 1))
    if not wanted.type:
        return s.Routine("PROC", False, wanted.name, stop, "", parameters)
    result: s.Expression = (
        _plain_value_node(0.0) if wanted.nothing is None else _plain_value_node(wanted.nothing)
    )
    body = (*stop, s.ReturnFrom(result))
    return s.Routine("FUNC", False, wanted.name, body, wanted.type, parameters)


def _parameter_group(at: int, argument: CallArgument) -> s.ParameterGroup:
    type = argument.type or "num"
    # Signals and handles cannot be passed by value.
    mode = "VAR" if type.startswith("signal") or is_handle(type) else ""
    name = argument.option or f"p{at}"
    node = s.ParameterNode(mode, type, name, argument.dimensions)
    return s.ParameterGroup(bool(argument.option), (node,))
