"""Modules with the values that their persistent data has come to, as a controller saves them."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.controller import Controller
from assistant.virtual.rapid.loading import Loaded
from assistant.virtual.rapid.scopes import Cell
from assistant.virtual.rapid.types import Types
from assistant.virtual.rapid.values import Value
from assistant.virtual.rapid.written import read_value, value_text


def saved(controller: Controller, file: s.File) -> str:
    """The text of a file that a controller has run, with the values that its PERS have now.

    All else stays byte for byte, and so does the value of data that has not changed. Raises
    ValueError if no task of the controller ran the file.
    """
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
    """Where a new value stands in the place of the old one, from start to end."""
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
