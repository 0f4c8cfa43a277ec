"""Values as text: what StrToVal reads, and persistent data as it is written into its module.

`saved` gives a module with the present values of its persistent data, as a controller saves it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.controller import Controller, Loaded
from assistant.virtual.rapid.scopes import Cell, Types
from assistant.virtual.rapid.values import NUMBERS, Array, Double, Record, Shape, Value, fitted

_WORD: Final = re.compile(
    r"""\s*(?:
        (?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
      | "(?P<text>(?:[^"]++|"")*+)"
      | (?P<word>[A-Za-z]+)
      | (?P<sign>[][,])
    )\s*""",
    re.VERBOSE,
)


def read_value(text: str, shape: Shape, types: Types) -> Value | None:
    """Return the value of a text, None if it is not a value of that type."""
    words: list[re.Match[str]] = []
    at = 0
    while at < len(text):
        found = _WORD.match(text, at)
        if found is None:
            return None
        words.append(found)
        at = found.end()
    try:
        value, rest = _read_words(words, shape, types)
    except (ValueError, LookupError):
        return None
    return None if rest else value


_Words = list[re.Match[str]]


def _read_words(words: _Words, shape: Shape, types: Types) -> tuple[Value, _Words]:
    """Return the value at the beginning of the words, and the words after it; raises ValueError if
    there is no value.
    """
    first, rest = words[0], words[1:]
    if shape.sizes:
        items: list[Value] = []
        for i in range(shape.sizes[0]):
            item, rest = _read_words(
                _text_after(rest if i else words, "," if i else "["), shape.element, types
            )
            items.append(item)
        return Array(items), _text_after(rest, "]")
    if shape.type in NUMBERS:
        # float("x") raises the ValueError for a word of another kind.
        number = float(first["number"] or "x")
        # A num beyond its range becomes infinite.
        fits = fitted(number, shape)
        if isinstance(fits, float) and not math.isfinite(fits):
            raise ValueError(f"{number:g} is beyond a {shape.type}")
        return fits, rest
    if shape.type == "bool":
        return {"TRUE": True, "FALSE": False}[(first["word"] or "").upper()], rest
    if shape.type == "string":
        if first["text"] is None:
            raise ValueError
        return first["text"].replace('""', '"'), rest
    record = types.first(shape)
    if not isinstance(record, Record):
        raise ValueError  # noqa: TRY004 - a text that is no value of this type
    rest = words
    for i, name in enumerate(record.parts):
        part = types.component(shape.type, name)
        assert part is not None
        behind = _text_after(rest, "," if i else "[")
        record.parts[name], rest = _read_words(behind, part, types)
    return record, _text_after(rest, "]")


def _text_after(words: _Words, sign: str) -> _Words:
    if words[0]["sign"] != sign:
        raise ValueError
    return words[1:]


def value_text(value: Value, shape: Shape, types: Types) -> str:
    """An expression of literals that is the very value; raises ValueError if it has none."""
    match value:
        case bool():
            return "TRUE" if value else "FALSE"
        case float():
            return _number_text(value)
        case str():
            return '"' + "".join(map(_character_text, value)) + '"'
        case Array(items):
            return "[" + ",".join(value_text(item, shape.element, types) for item in items) + "]"
        case Record(type, parts):
            said = []
            for name, part in parts.items():
                # A function may have put unrounded numbers into the record.
                of = types.component(type, name)
                assert of is not None
                said.append(value_text(fitted(part, of), of, types))
            return "[" + ",".join(said) + "]"
    raise ValueError(f"data of type {shape.type} has no value")


def _number_text(value: float) -> str:
    """The shortest text that reads back the same: of a num nine digits, of a dnum 17 at most."""
    if not math.isfinite(value):
        raise ValueError("a number that is not known, as the speed of `vmax` without a robot")
    if isinstance(value, Double):
        return _plain_digits(repr(float(value)))
    # Nine digits tell every num from its neighbours.
    for digits in range(1, 10):
        text = f"{value:.{digits}G}"
        if fitted(float(text), Shape("num")) == value:
            return _plain_digits(text)
    return _plain_digits(repr(value))


def _plain_digits(text: str) -> str:
    """`9E9` for `9E+09`, and whole numbers without a point."""
    mantissa, e, exponent = text.upper().partition("E")
    mantissa = mantissa.removesuffix(".0")
    power = int(exponent or 0)
    # RAPID writes numbers of these sizes without an exponent.
    if -5 < power < 7 or not e:
        return mantissa if not e else _shifted_point(mantissa, power)
    return f"{mantissa}E{power}"


def _shifted_point(mantissa: str, power: int) -> str:
    """`1.5E3` written out."""
    text = f"{float(f'{mantissa}E{power}'):.17f}".rstrip("0").rstrip(".")
    # 17 places may not hold a very small number.
    return text if float(text) == float(f"{mantissa}E{power}") else f"{mantissa}E{power}"


def _character_text(character: str) -> str:
    if character in '"\\':
        return character * 2
    return character if character >= " " else f"\\{ord(character):02X}"


def saved(controller: Controller, file: s.File) -> str:
    """The text of a file that a controller has run, with the values that its PERS have now.

    All else stays byte for byte, and so does the value of data that has not changed. Raises
    ValueError if no task of the controller ran the file.
    """
    # By identity: equal texts may be loaded twice with other data.
    running = (p for p in controller.programs if any(one is file for one in p[0].files))
    program = next(running, None)
    if program is None or file.source is None:
        raise ValueError("this file was not run")
    loaded, types = program
    text = file.source.text
    found, at = [], 0
    for start, end, value in _value_changes(file, loaded, types, text):
        found += [text[at:start], value]
        at = end
    return "".join((*found, text[at:]))


def _value_changes(
    file: s.File, loaded: Loaded, types: Types, text: str
) -> Iterator[tuple[int, int, str]]:
    """Changes of a text: the start and end of an old value, and the new one."""
    for module in file.modules:
        unit = loaded.units[module.name.lower()]
        for node in module.items:
            if not isinstance(node, s.Data) or node.storage != "PERS" or node.span is None:
                continue
            cell = unit.names.get(node.name.lower()) or loaded.named.get(node.name.lower())
            if not isinstance(cell, Cell) or cell.value is None:
                continue
            value = value_text(cell.value, cell.shape, types)
            first = _first_values(node, cell, types, text)
            # Texts are compared, since `1.0` in the file is the 1 in memory.
            if first is not None and value == value_text(first, cell.shape, types):
                continue
            if node.value is not None and node.value.span is not None:
                yield node.value.span.start, node.value.span.end, value
            else:
                end = text.rindex(";", node.span.start, node.span.end)
                yield end, end, f" := {value}"


def _first_values(node: s.Data, cell: Cell, types: Types, text: str) -> Value | None:
    """The value that a declaration states, None if that is not known."""
    if node.value is None:
        return types.first(cell.shape)
    if node.value.span is None:
        return None
    stated = text[node.value.span.start : node.value.span.end]
    value = read_value(stated, cell.shape, types)
    return cell.first if value is None else value
