"""Speeds and zones that a program gives one value only, as constants of that value.

`VAR speeddata slow;` with `slow := v100;` in a routine becomes `CONST speeddata slow := v100;`:
other languages write the values of a move where it stands. Without a first value nothing else can
be in force, as a move at no speed at all is none. A zone without a first value needs a speed beside
it that is set in the same run of assignments, and that all moves with the zone have.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import RecordLayouts
from assistant.languages.rapid.lift.plain.unread import OMISSION_MARK
from assistant.languages.rapid.tables.words import SPEEDS, ZONES
from assistant.languages.rapid.text.printer import expression as printed
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import inner_names, lists, nodes
from assistant.program.rewriting import rewrite

_MOVES: Final = frozenset(("movej", "movel", "moveabsj", "movec"))
_SPEED_OPTIONS: Final = frozenset("tv")
"""Options that say how fast a move is in the place of its speed."""
_WRITES_BY_TEXT: Final = frozenset(("setdataval", "setalldataval"))
"""Instructions that change data whose names are worked out."""
_PREDEFINED: Final = {"speeddata": SPEEDS, "zonedata": ZONES}


@dataclass(slots=True)
class _Setting:
    """A speed or zone. values: what it is assigned, printed. uses: as an argument of a move.
    beside: data in lower case that each such move has beside it. runs: names that are assigned
    along with it, in each run of assignments.
    """

    node: s.Data
    values: dict[str, s.Expression] = field(default_factory=dict)
    uses: int = 0
    assigned: int = 0
    beside: list[frozenset[str]] = field(default_factory=list)
    runs: list[frozenset[str]] = field(default_factory=list)


def with_constant_speeds(
    modules: Sequence[s.Module], layouts: RecordLayouts, kept: Collection[int]
) -> list[s.Module]:
    """The modules with such constants; the assignments become comments `LEFT_OUT` and the name.

    kept: statements that stay as they are written, by `id`.
    """
    found = _single_valued(modules, layouts)
    if found and kept:
        whole = [node for node in nodes(tuple(modules)) if id(node) in kept]
        text = {one.name.lower() for one in nodes(tuple(whole)) if isinstance(one, s.NameRef)}
        found = {name: one for name, one in found.items() if name not in text}
    if not found:
        return list(modules)

    def visit(node: Any) -> Any:
        match node:
            case s.Data(name=name) if (one := found.get(name.lower())) is not None:
                (value,) = one.values.values()
                return replace(node, storage="CONST", value=value)
            case s.Assignment(s.NameRef(name)) if name.lower() in found:
                return s.CommentLine(f"{OMISSION_MARK}{name}", span=node.span)
        return node

    return [rewrite(module, visit, ()) for module in modules]


def _single_valued(modules: Sequence[s.Module], layouts: RecordLayouts) -> Mapping[str, _Setting]:
    """By lower-case name."""
    items = [item for module in modules for item in module.items]
    routines = [item for item in items if isinstance(item, s.Routine)]
    names = Counter(item.name.lower() for item in items if isinstance(item, s.Data))
    inner = {name.lower() for name in inner_names(routines)}
    every = {
        item.name.lower(): _Setting(item)
        for item in items
        if isinstance(item, s.Data) and item.storage == "VAR" and not item.dimensions
        and layouts.base(item.type) in _PREDEFINED
        and names[item.name.lower()] == 1 and item.name.lower() not in inner
    }  # fmt: skip
    if not every:
        return {}
    own = {routine.name.lower() for routine in routines}
    said: Counter[str] = Counter()
    for node in nodes(tuple(modules)):
        match node:
            case s.NameRef(name):
                said[name.lower()] += 1
            case s.ProcedureCall(str(name)) if name.lower() in _WRITES_BY_TEXT:
                return {}
            case s.MoveRunNode(run):
                for how in run.motions.table:
                    pair = [name.lower() for name in (how.speed, how.zone) if name]
                    _count_uses(every, pair)
                    said.update(pair)
            case s.ProcedureCall(str(name), given) if name.lower() in _MOVES - own:
                if any(isinstance(a, s.Option) and a.name.lower() in _SPEED_OPTIONS for a in given):
                    continue
                plain = [a.value for a in given if isinstance(a, s.Positional)]
                _count_uses(every, [v.name.lower() for v in plain if isinstance(v, s.NameRef)])
    for body in (body for routine in routines for body in lists(routine)):
        for row in _assignment_runs(body):
            together = frozenset(name for name, _ in row)
            for name, value in row:
                if (one := every.get(name)) is not None:
                    one.values[printed(value).lower()] = value
                    one.assigned += 1
                    one.runs.append(together)
    steady = {
        name: one
        for name, one in every.items()
        if one.assigned and len(one.values) == 1 and said[name] == one.uses + one.assigned
        and _is_constant_value(next(iter(one.values.values())), layouts.base(one.node.type))
        and (one.node.value is None or printed(one.node.value).lower() in one.values)
    }  # fmt: skip
    return {name: one for name, one in steady.items() if _holds_throughout(one, steady, layouts)}


def _count_uses(every: Mapping[str, _Setting], names: Sequence[str]) -> None:
    for name in names:
        if (one := every.get(name)) is not None:
            one.uses += 1
            one.beside.append(frozenset(names))


def _assignment_runs(body: Sequence[s.StatementNode]) -> Iterator[list[tuple[str, s.Expression]]]:
    """Assignments to whole data that follow one another: names in lower case and values."""
    run: list[tuple[str, s.Expression]] = []
    for node in (*body, None):
        match node:
            case s.CommentLine():
                continue
            case s.Assignment(s.NameRef(name), value):
                run.append((name.lower(), value))
            case _:
                yield run
                run = []


def _is_constant_value(value: s.Expression, type: str) -> bool:
    match value:
        case s.NameRef(name):
            return name.lower() in _PREDEFINED[type]
        case s.AggregateNode(items):
            return all(isinstance(i, s.BoolLiteral) or literal_number(i) is not None for i in items)
    return False


def _holds_throughout(
    one: _Setting, steady: Mapping[str, _Setting], layouts: RecordLayouts
) -> bool:
    """Whether no move can meet another value; without a speed nothing moves."""
    if one.node.value is not None or layouts.base(one.node.type) == "speeddata":
        return True
    speeds = {
        name
        for name, other in steady.items()
        if other.node.value is None and layouts.base(other.node.type) == "speeddata"
        and all(name in run for run in one.runs)
        and all(one.node.name.lower() in run for run in other.runs)
    }  # fmt: skip
    return all(beside & speeds for beside in one.beside)
