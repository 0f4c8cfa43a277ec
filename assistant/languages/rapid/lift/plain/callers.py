"""What stands for tools, frames, signals and devices that callers give which were not read.

A routine of a library is called by programs that are not there. Where nothing in it calls
`PROC pick(PERS tooldata t)`, `t` is a tool of the program, which those that call `pick` set first;
a signal is asked for in the cell file, and so is the line of a socket.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Final

from assistant.languages.rapid.lift.plain.layouts import RecordLayouts
from assistant.languages.rapid.tables.signal_types import SIGNALS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.program import TakenNames, identifier


def _aggregate(*values: s.Expression | float) -> s.AggregateNode:
    """Values in brackets."""
    return s.AggregateNode(
        tuple(s.NumberLiteral(f"{v:g}") if isinstance(v, float | int) else v for v in values)
    )


_ZERO_POSE: Final = _aggregate(_aggregate(0, 0, 0), _aggregate(1, 0, 0, 0))
_TRUE, _FALSE = s.BoolLiteral(True), s.BoolLiteral(False)
_LEAST_LOAD: Final = _aggregate(0.001, _aggregate(0, 0, 0.001), _aggregate(1, 0, 0, 0), 0, 0, 0)
INITIAL_VALUES: Final = {
    "tooldata": _aggregate(_TRUE, _ZERO_POSE, _LEAST_LOAD),
    "wobjdata": _aggregate(_FALSE, _TRUE, s.StringLiteral(""), _ZERO_POSE, _ZERO_POSE),
}
"""The flange, and the base: what a tool and a work object are before a caller sets them."""


class UnreadCallers:
    """What callers give that nobody knows: one for all parameters of a type and a name.

    data: what is declared for it, by the routine in lower case that first has it.
    """

    def __init__(self, items: Sequence[s.Item], layouts: RecordLayouts, taken: TakenNames) -> None:
        self._layouts, self._taken = layouts, taken
        self._items = items
        self._given: dict[tuple[str, str], s.NameRef] = {}
        self.data: dict[str, list[s.Data]] = {}

    @cached_property
    def _declared(self) -> frozenset[str]:
        """Names in lower case that mean something else somewhere."""
        found: set[str] = set()
        for node in nodes(tuple(self._items)):
            match node:
                case s.Data() | s.Routine() | s.Record() | s.Alias():
                    found.add(node.name.lower())
                case s.ForLoop(variable=name):
                    found.add(name.lower())
                case s.TargetRunNode(run=run):
                    found.update(run.names.name(row).lower() for row in range(len(run)))
        return frozenset(found)

    def of(self, routine: s.Routine, one: s.ParameterNode, optional: bool) -> s.NameRef | None:
        """What stands for a parameter; None where it is taken for not given."""
        type = self._layouts.base(one.type)
        if optional and type not in INITIAL_VALUES:
            return None
        key = type, one.name.lower()
        if key not in self._given:
            name = one.name
            if name.lower() in self._declared or any(name.lower() == n for _, n in self._given):
                name = identifier(name, self._taken)
                self._taken.add(name)
            self._given[key] = s.NameRef(name)
            if type not in SIGNALS:
                start = INITIAL_VALUES.get(type)
                storage = "VAR" if start is None else "PERS"
                data = s.Data("", storage, type, name, value=start, span=one.span)
                self.data.setdefault(routine.name.lower(), []).append(data)
        return self._given[key]
