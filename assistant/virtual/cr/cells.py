"""Variables of programs that run as the lines of a listing, and back."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import Final

from assistant.virtual.cr.store import CrProgram
from assistant.virtual.melfa.memory import Cell, Memory
from assistant.virtual.melfa.values import Elements, Joints, Position, Value, eight

VARIABLE_LINE: Final = re.compile(r"\(([^()]*)\)(?:\(([^()]*)\))?")
VARIABLE_NAME: Final = re.compile(r"([A-Z]\w*)[$%&!#]?(?:\(([\d,]+)\))?", re.ASCII)


def listed_variables(memory: Memory) -> Iterator[tuple[str, str]]:
    """Name and value, as a controller lists them, of each variable that has one."""
    for name, place in memory.places.items():
        if not isinstance(place, Cell):
            continue
        mark = "$" if place.kind == "text" else ""
        for index, value in sorted(place.values.items()):
            at = f"({','.join(map(str, index))})" if index else ""
            yield f"{name}{mark}{at}", value_text(value)


def value_text(value: Value) -> str:
    """`+3`, `"a text"`, `(+1.00,…)(7,0)`."""
    match value:
        case str():
            return f'"{value}"'
        case Position(values=values, flags=flags):
            return f"{_elements_text(values)}({flags[0] or 0},{flags[1] or 0})"
        case Joints(values=values):
            return _elements_text(values)
        case int() | float():
            return f"{float(value):+.10g}"
    return _elements_text(value.values)


def _elements_text(values: Elements) -> str:
    count = max([6, *(i + 1 for i, v in enumerate(values) if v is not None)])
    return "(" + ",".join("" if v is None else f"{v + 0.0:+.2f}" for v in values[:count]) + ")"


def listed_value(text: str) -> Value:
    """The value that a line of a listing tells behind its `=`."""
    if text.startswith('"'):
        return text[1:-1]
    place = VARIABLE_LINE.fullmatch(text)
    if place is None:
        number = float(text)
        return int(number) if number.is_integer() else number
    values = eight(tuple(float(v) if v.strip() else None for v in place[1].split(",")))
    if place[2] is None:
        return Joints(values)
    one, _, two = place[2].partition(",")
    return Position(values, (int(one or 0), int(two or 0)))


def set_variable(memory: Memory, name: str, value: str) -> None:
    """Sets a variable; raises Failed where it does not take the value."""
    found = VARIABLE_NAME.fullmatch(name.upper())
    assert found is not None, name
    index = tuple(int(part) for part in found[2].split(",")) if found[2] else ()
    memory.place(found[1]).set(listed_value(value), index)


def with_values(program: CrProgram, memory: Memory) -> CrProgram:
    """A program with the values that its variables have by now."""
    made = program.copy()
    made.protected = set()
    for name, value in listed_variables(memory):
        made.keep(name, value)
    made.protected = set(program.protected)
    return made


def give_variables(program: CrProgram, memory: Memory, names: Collection[str]) -> None:
    """Gives a memory the variables of some names that a program has; raises Failed."""
    for line in (program.variables | program.values).values():
        name, _, value = line.partition("=")
        if _base_name(name) in names:
            set_variable(memory, name, value)


def take_back_variables(program: CrProgram, memory: Memory, names: Collection[str]) -> None:
    """Gives a program the variables of some names as they are by now."""
    for name, value in listed_variables(memory):
        if _base_name(name) in names and "q" not in program.protected:
            program.keep(name, value)


def _base_name(name: str) -> str:
    """Without its mark and its subscripts."""
    found = VARIABLE_NAME.fullmatch(name.upper())
    return found[1] if found else name
