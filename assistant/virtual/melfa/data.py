"""Statements on data: texts that are looked for in arrays, and variables that are cleared."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING, Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import expressions
from assistant.virtual.melfa.code import nodes
from assistant.virtual.melfa.memory import Cell, Storage, is_external
from assistant.virtual.melfa.stops import Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import text

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


def _search_array(
    m: Machine, array: s.Expression, sought: s.Expression, found: s.Expression
) -> None:
    """ChrSrch: the first element that is all of a text, whatever element is named; else 0."""
    if not isinstance(array, s.Variable) or not isinstance(found, s.Variable):
        raise Failed(3810, "ChrSrch takes an array of texts and a variable")
    cell = m.memory_of(array.key).place(array.key)
    if not isinstance(cell, Cell) or cell.kind != "text" or len(cell.size) != 1:
        raise Failed(4370, f"{array.name} is no array of texts of one dimension")
    wanted = text(expressions.value(m, sought), "what ChrSrch looks for")
    places = (i for i in range(1, cell.size[0] + 1) if cell.values.get((i,)) == wanted)
    expressions.store(m, found, next(places, 0))


def _clear_variables(m: Machine, kind: s.Expression) -> None:
    """Clr 2 and 3: numbers of the program, or of all programs, are 0 (COSIROP: CLR)."""
    which = expressions.integer(m, kind, "the kind of Clr")
    if which not in range(4):
        raise out_of_range(f"the kind {which} of Clr")
    if which in (0, 1):
        raise Unknown("the pattern that outputs are reset to, which stands in parameters")
    if m.code.functions:
        raise Unknown("Clr in a program of functions")
    for place in _number_variables(m, external=which == EXTERNAL_VARIABLES):
        extents = place.size if isinstance(place, Cell) else ()
        for index in product(*(range(1, n + 1) for n in extents)):
            place.set(0, index)


EXTERNAL_VARIABLES: Final = 3


def _number_variables(m: Machine, external: bool) -> Iterator[Storage]:
    """Numeric variables that stand in the program, or that all programs share."""
    machines = {id(x): x for x in (m, *m.programs.values())}.values() if external else (m,)
    for machine in machines:
        known = {*machine.code.signals, *machine.code.definitions, *machine.code.constants}
        for row in machine.code.rows:
            for node in nodes(row.statement):
                if isinstance(node, s.Variable) and node.key not in known:
                    yield from _number_variable(machine, node, external)


def _number_variable(m: Machine, node: s.Variable, external: bool) -> Iterator[Storage]:
    if expressions.is_status(node.key) or vocabulary.function(node.key) is not None:
        return
    if is_external(node.key) != external:
        return
    place = m.memory_of(node.key).place(node.key)
    if place.kind in expressions.NUMBER_KINDS and isinstance(place, Cell):
        yield place


DATA_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "CHRSRCH": _search_array,
    "CLR": _clear_variables,
}
