"""Rules of what is written out in targets, frames, tools and loads: quaternions, `confdata`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import Any, Final, NamedTuple

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Rule, Severity
from assistant.languages.checks.registry import Found, like_it
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks import plain_rules
from assistant.languages.rapid.checks.kinds import Types
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number, literal_target
from assistant.languages.rapid.tree.runs import MOVES

OFF_UNIT: Final = 1e-5
"""Most that the squares of a quaternion may miss 1 by; beyond it NOrient has to mend it."""
USELESS: Final = 1e-3
"""Beyond this it is no rounded quaternion: four decimals are off by 2e-4 at most."""
MOST_TURNS: Final = 127
"""Quadrants are counted in turns of an axis, of which no arm has 32."""
SHAPES: Final = 8
"""Values of cfx of an arm with six axes, from 0."""
CODES: Final = (10, 9999)
"""An arm with seven axes has a code of up to four digits; those of one are as above."""

MOST: Final = 100
"""Targets of one module with the same mistake that are reported one by one."""

Words = Callable[[int], dict[str, Any]]
"""Fields of the finding at a row; `severity` may be one of them."""


class _Fault(NamedTuple):
    """Rows (k,) of a node that have a mistake. node: that is reported, or a run."""

    node: s.Node
    rows: Rows
    words: Words


class _Written(NamedTuple):
    """Targets that are written out: values (n, 17) of a node, and what a row is called."""

    node: s.Node
    values: Floats
    name: Callable[[int], str]


def quaternions(look: Look) -> Found:
    """They have unit length; all zero is a place holder that no robot can move to."""
    types = look.once(Types)
    written = [(one.node, one.values[:, 3:7], one.name) for one in look.once(_targets)]
    for data in look.all(s.Data):
        if isinstance(data.value, s.AggregateNode):
            depth = len(data.dimensions)
            target = data.storage == "CONST" and data.type.lower() == "robtarget"
            for one, numbers in _orientations(types, data.value, data.type, depth):
                if target or any(numbers):
                    written.append((one, np.array([numbers]), _always(data.name)))
    lengths: list[_Fault] = []
    zeros: list[_Fault] = []
    for node, q, name in written:
        off = np.abs((q * q).sum(axis=1) - 1.0)
        zero = ~q.any(axis=1)
        lengths.append(_Fault(node, np.flatnonzero((off > OFF_UNIT) & ~zero), _off(name, off)))
        zeros.append(_Fault(node, np.flatnonzero(zero), _named(name)))

    def place(single: s.Node) -> s.Node:
        """The orientation of a declaration."""
        if not isinstance(single, s.Data) or not isinstance(single.value, s.AggregateNode):
            return _target_of(single)
        return next(node for node, _ in _orientations(types, single.value, single.type, 0))

    yield from _reported(look, rules.NOT_UNIT, lengths, place)
    yield from _reported(look, plain_rules.NO_ORIENTATION, zeros, place)


def configurations(look: Look) -> Found:
    """Quadrants and cfx are whole numbers, and cfx is one that an arm of six axes has."""
    written = list(look.once(_targets))
    for data in look.all(s.Data):
        if data.value is not None and data.type.lower() == "robtarget":
            for node, values in _written_out(data.value):
                written.append(_Written(node, values, _always(data.name)))
    odd: list[_Fault] = []
    unknown: list[_Fault] = []
    for node, values, name in written:
        confdata = values[:, 7:11]
        whole = np.isfinite(confdata) & (confdata == np.round(confdata))
        quadrants = (whole[:, :3] & (np.abs(confdata[:, :3]) <= MOST_TURNS)).all(axis=1)
        cfx = confdata[:, 3]
        known = ((cfx >= 0) & (cfx < SHAPES)) | ((cfx >= CODES[0]) & (cfx <= CODES[1]))
        sound, words = quadrants & whole[:, 3], _numbers(name, confdata)
        odd.append(_Fault(node, np.flatnonzero(~sound), words))
        unknown.append(_Fault(node, np.flatnonzero(sound & ~known), words))
    yield from _reported(look, plain_rules.NO_QUADRANTS, odd, _target_of)
    yield from _reported(look, plain_rules.NO_CFX, unknown, _target_of)


def _targets(look: Look) -> list[_Written]:
    """Targets in runs, and those that moves are given."""
    found = [_Written(n, n.run.values, n.run.names.name) for n in look.all(s.TargetRunNode)]
    for node in look.all(s.MoveRunNode):
        if node.run.values is not None:
            words = [MOVES[kind] for kind in node.run.kinds.tolist()]
            found.append(_Written(node, node.run.values, words.__getitem__))
    for call in look.all(s.ProcedureCall):
        for argument in call.arguments:
            if isinstance(argument, s.Positional):
                of_call = _written_out(argument.value)
                name = _always(str(call.name))
                found += [_Written(node, values, name) for node, values in of_call]
    return found


def _always(name: str) -> Callable[[int], str]:
    return lambda _: name


def _named(name: Callable[[int], str]) -> Words:
    return lambda row: {"name": name(row)}


def _off(name: Callable[[int], str], off: Floats) -> Words:
    """off: (n,) by which the squares of each row miss 1."""

    def words(row: int) -> dict[str, Any]:
        severity = Severity.ERROR if off[row] > USELESS else Severity.WARNING
        return {"name": name(row), "off": float(off[row]), "severity": severity}

    return words


def _numbers(name: Callable[[int], str], confdata: Floats) -> Words:
    """confdata: (n, 4) of the rows."""

    def words(row: int) -> dict[str, Any]:
        numbers = [f"{value:g}" for value in confdata[row]]
        return {"name": name(row), "numbers": ", ".join(numbers), "cfx": numbers[-1]}

    return words


def _written_out(value: s.Expression) -> Iterator[tuple[s.Node, Floats]]:
    """A target, or those of an array, at its own place: (1, 17)."""
    numbers = literal_target(value)
    if numbers is not None:
        yield value, np.array([numbers])
    elif isinstance(value, s.AggregateNode):
        for item in value.items:
            if isinstance(item, s.AggregateNode):
                yield from _written_out(item)


def _target_of(single: s.Node) -> s.Node:
    """The target that a line has."""
    match single:
        case s.ProcedureCall(_, (s.Positional(value), *_)):
            return value
        case s.Data(value=s.AggregateNode() as value):
            return value
    return single


def _reported(
    look: Look, rule: Rule, faults: Sequence[_Fault], place: Callable[[s.Node], s.Node]
) -> Found:
    """The rule's findings in the order of the text, the first MOST of them one by one.

    place: of a line of a run that is read alone, the node that is reported.
    """
    listed = [fault for fault in faults if len(fault.rows)]
    listed.sort(key=lambda fault: fault.node.span.start if fault.node.span else 0)
    count = sum(len(fault.rows) for fault in listed)
    each = ((fault, int(row)) for fault in listed for row in fault.rows)
    for number, (fault, row) in enumerate(islice(each, MOST), 1):
        node = fault.node
        if isinstance(node, s.RunNode):
            node = place(look.single(node, row))
        more = like_it(count - MOST if number == MOST else 0)
        yield look.finding(rule, node, more=more, **fault.words(row))


def _orientations(
    types: Types, value: s.AggregateNode, type: str, depth: int
) -> Iterator[tuple[s.AggregateNode, list[float]]]:
    """Every orientation that is written out in a value of a type, arrays `depth` levels deep."""
    base = types.base(type) or ""
    if depth:
        inner = [(part, type, depth - 1) for part in value.items]
    elif base == "orient":
        numbers = [literal_number(item) for item in value.items]
        known = [float(n) for n in numbers if n is not None]
        if len(known) == len(numbers) == 4:
            yield value, known
        return
    else:
        components = types.components(base) or {}
        if len(components) != len(value.items):
            return
        inner = [(part, of, 0) for part, of in zip(value.items, components.values(), strict=True)]
    for part, of, left in inner:
        if isinstance(part, s.AggregateNode):
            yield from _orientations(types, part, of, left)
