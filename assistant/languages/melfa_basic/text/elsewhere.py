"""Tools and work coordinates that a program calls by number: what its heading says that they are.

    ' elsewhere: PMEXTL2=(+0.00,+0.00,+120.00,+0.00,+0.00,+0.00)

The name is that of the parameter that holds it, behind the letter of positions.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic.tables.poses import FINE_PLACES
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.tree import syntax as s

_COORDINATE: Final = r"[+-]?[0-9]{1,9}(?:\.[0-9]{1,9})?"
_PARAMETER_VALUE: Final = re.compile(
    rf"(P(?:MEXTL|WK)[0-9]{{1,2}}(?:CORD)?)=\(({_COORDINATE}(?:,{_COORDINATE}){{5}})\)"
)


def parameter_value(name: str, values: tuple[float | None, ...]) -> str:
    """A value as a heading says it. values: x, y, z in mm, a, b, c in degrees."""
    return f"{name}=({','.join(f'{value or 0.0:+.{FINE_PLACES}f}' for value in values)})"


def with_stated_parameters(tree: s.File) -> s.File:
    """The tree with what its heading says of the controller, where it has no value of its own."""
    own = {item.variable.key for item in tree.items if isinstance(item, s.Data)}
    more = tuple(data for data in _stated_positions(tree) if data.variable.key not in own)
    return replace(tree, items=(*tree.items, *more)) if more else tree


def _stated_positions(tree: s.File) -> Iterator[s.Data]:
    for item in tree.code:
        if not isinstance(item, s.Line) or item.statement or item.label or not item.comment:
            return
        text = item.comment.removeprefix("'").strip()
        if text == headers.END:
            return
        found = _PARAMETER_VALUE.fullmatch(text.removeprefix(headers.THERE))
        if found is not None and text.startswith(headers.THERE):
            values = tuple(float(value) for value in found[2].split(","))
            yield s.Data(s.Variable(found[1]), s.Constant(values, (0, 0)))
