"""Rules of names: declared twice, too long, taken by the language."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import chain
from typing import Any, Final

import numpy as np

from assistant.languages.rapid import rules
from assistant.languages.rapid import syntax as s
from assistant.languages.rapid.checks.scope import Look, declaration
from assistant.languages.rapid.tables import LONGEST_NAME, PREDEFINED_DATA, SPEEDS, ZONES
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]
DECLARING: Final[tuple[Any, ...]] = (s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def duplicates(look: Look) -> Found:
    own: Counter[str] = Counter()
    for item in look.module.items:
        if isinstance(item, s.TargetRunNode):
            yield from _duplicate_rows(look, item)
        elif (declared := declaration(item)) is not None:
            name = declared.name.lower()
            own[name] += 1
            elsewhere = not declared.local and len(look.task.shared.get(name, ())) > 1
            if own[name] > 1 or elsewhere:
                yield look.finding(rules.DUPLICATE, item, name=declared.name)


def _duplicate_rows(look: Look, item: s.TargetRunNode) -> Found:
    names = item.run.names
    order = np.lexsort((names.number, names.stem))
    stem, number = names.stem[order], names.number[order]
    same = np.flatnonzero((stem[1:] == stem[:-1]) & (number[1:] == number[:-1]))
    for row in same[:1]:
        yield look.finding(rules.DUPLICATE, item, name=names.name(int(order[row])))


def spelling(look: Look) -> Found:
    yield from _name(look, look.module, look.module.name)
    for declared in chain.from_iterable(map(look.all, DECLARING)):
        yield from _name(look, declared, declared.name)
    for loop in look.all(s.ForLoop):
        yield from _name(look, loop, loop.variable)
    for mark in look.all(s.LabelMark):
        yield from _name(look, mark, mark.name)


def _name(look: Look, node: s.Node, name: str) -> Found:
    if len(name) > LONGEST_NAME:
        yield look.finding(rules.LONG_NAME, node, name=name, length=len(name))
    own = isinstance(node, s.Data) and name.lower() in PREDEFINED_DATA
    taken = name.lower() in SPEEDS or name.lower() in ZONES
    if isinstance(node, s.Data | s.Routine) and taken and not own:
        yield look.finding(rules.RESERVED_NAME, node, name=name)
