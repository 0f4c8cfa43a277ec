"""Open, Print #, Input # and Close as the channels of the pseudo-program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from assistant.languages.melfa_basic.lift.statements.paths import Runs
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import VENDOR_ONLY_NAME, Unliftable
from assistant.languages.melfa_basic.tables.channels import FILE_MODES, FILE_NUMBERS, LINE_NAME
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program import undeclared_names

RECEIVING_FUNCTIONS = {
    "text": "received",
    "number": "received_number",
    "integer": "received_number",
}
"""What reads an item for a variable of a type."""
_PRINTED_TYPES = ("text", "number", "integer")


def channel_name(node: s.Expression | None, lift: Expressions) -> str:
    """The channel of a file's number."""
    value = None if node is None else lift.m.value(node)
    if not isinstance(value, float) or round(value) not in FILE_NUMBERS:
        raise Unliftable
    return undeclared_names.name_of_channel(round(value))


def lift_open(node: s.Open, lift: Expressions) -> list[p.Statement]:
    """A line by its number; a file only with a mode, which says that it is one."""
    channel, mode = channel_name(node.number, lift), FILE_MODES.get(node.mode)
    if isinstance(node.name, s.String) and ":" in node.name.value:
        found = LINE_NAME.fullmatch(node.name.value)
        if found is None or node.mode:
            raise Unliftable
        return [p.Attach(channel, "line", (e.Number(int(found[1])),))]
    if mode is None:
        raise Unliftable
    return [p.Attach(channel, "file", (lift.plain(node.name),), mode)]


def lift_close(node: s.Close, lift: Expressions) -> list[p.Statement]:
    if not node.numbers:
        if not lift.m.telling or lift.m.opened is None:
            raise Unliftable
        return [p.Detach(undeclared_names.name_of_channel(number)) for number in lift.m.opened]
    return [p.Detach(channel_name(number, lift)) for number in node.numbers]


def lift_print(node: s.Print, lift: Expressions) -> list[p.Statement]:
    """Parts that follow each other at once, or behind a comma in the next column."""
    channel = channel_name(node.number, lift)
    goes_on = bool(node.items) and node.items[-1][1] is None
    given = [value for _, value in node.items if value is not None]
    marks = [mark for mark, _ in node.items[1:]]
    columns = any(mark != ";" for mark in marks)
    if columns and (lift.m.goes_on or not lift.m.telling):
        raise Unliftable
    if len(given) + goes_on != len(node.items):
        raise Unliftable
    if any(lift.type_of(value) not in _PRINTED_TYPES for value in given):
        raise Unliftable
    parts = tuple(lift.plain(value) for value in given)
    if columns:
        texts = [lift.type_of(value) == "text" for value in given]
        pairs = zip(parts, texts, strict=True)
        parts = _in_columns(
            [x if is_text else e.Apply("text", (x,)) for x, is_text in pairs], marks
        )
    return [p.Send(channel, "piece" if goes_on else "line", parts)]


PRINT_COLUMN: Final = 10
"""Characters of a column that a comma begins the next one of (COSIROP: PRINT)."""


def _in_columns(parts: Sequence[e.Expression], marks: Sequence[str]) -> tuple[e.Expression, ...]:
    """The parts with blanks up to the next column where a comma is between them."""
    made = list(parts[:1])
    for mark, part in zip(marks, parts[1:], strict=True):
        if mark == ",":
            made = [_padded_to_column(made)]
        made.append(part)
    return tuple(made)


def _padded_to_column(texts: Sequence[e.Expression]) -> e.Expression:
    if all(isinstance(one, e.Text) for one in texts):
        whole = "".join(one.value for one in texts if isinstance(one, e.Text))
        return e.Text(whole + " " * (-len(whole) % PRINT_COLUMN))
    line = texts[0]
    for one in texts[1:]:
        line = e.Binary("+", line, one)
    return e.Apply(VENDOR_ONLY_NAME.format("in_next_column"), (line, e.Number(PRINT_COLUMN)))


def lift_input(node: s.Input, lift: Expressions, runs: Runs) -> list[p.Statement]:
    """One item after the other."""
    channel, made = channel_name(node.number, lift), list[p.Statement]()
    for variable in node.variables:
        function = RECEIVING_FUNCTIONS.get(lift.type_of(variable) or "")
        place = lift.plain(variable)
        if function is None or variable.component or not isinstance(place, e.Name | e.Index):
            raise Unliftable
        made.append(p.Assign(place, e.Apply(function, (e.Text(channel),))))
    runs.previous = None
    return made
