"""Channels as Open, Print #, Input # and Close."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assistant.languages.melfa_basic.lower.channel_numbers import channel_number
from assistant.languages.melfa_basic.lower.unsayable import Unsayable
from assistant.languages.melfa_basic.tables.channels import FILE_MODE_WORDS, line_name
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.writer import Writer


def write_open(w: Writer, node: p.Attach) -> None:
    match node.kind, node.place:
        case "line", (e.Number(line),):
            w.add(s.Open(s.String(line_name(int(line))), "", _file_number(w, node.channel)))
        case "file", (place,) if node.mode in FILE_MODE_WORDS:
            name = w.expressions.of(place)
            w.add(s.Open(name, FILE_MODE_WORDS[node.mode], _file_number(w, node.channel)))
        case _:
            raise Unsayable(f"such a channel as `{node.channel}`", "open a line or a file")


def write_close(w: Writer, node: p.Detach) -> None:
    w.add(s.Close((_file_number(w, node.channel),)))


def write_print(w: Writer, node: p.Send) -> None:
    """The first part stands behind a comma, the others behind semicolons, which add nothing."""
    marks = (",", *(";" for _ in node.parts))
    values: list[s.Expression | None] = [w.expressions.of(part) for part in node.parts]
    if node.kind == "piece":
        if not values:
            return
        values.append(None)
    w.add(s.Print(_file_number(w, node.channel), tuple(zip(marks, values, strict=False))))


def write_input(w: Writer, target: e.Expression, channel: str) -> None:
    """An item into a variable."""
    w.add(s.Input(_file_number(w, channel), (w.expressions.place(target),)))
    w.previous = None


def _file_number(w: Writer, channel: str) -> s.Number:
    return s.Number(channel_number(w.names, channel))
