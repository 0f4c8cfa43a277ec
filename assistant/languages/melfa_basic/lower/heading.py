"""The comment lines above a unit: what its code cannot say, see header."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.languages.melfa_basic.lower.unit import Unit
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.program import Parameter, ValueType, Variable
from assistant.program.timers import timers

NO_LETTER: Final[tuple[ValueType, ...]] = ("truth", "integer", "pose")
"""Types whose letter is that of another one."""


def heading(unit: Unit) -> list[s.Item]:
    """The lines; the unit's code has been written already."""
    head, names, program = headers.Header(), unit.names, unit.program
    first, others = unit.procedures()
    head.program, head.robot, head.unit = program.name, program.robot, unit.unit
    if unit.unit is None:
        head.entry = first.name if first else "-"
        units = dict.fromkeys(p.unit for p in program.procedures if p.unit is not None)
        head.names["unit"] = {names.units[u]: u for u in units}
        head.names["first"] = {
            names.units[u]: next(p.name for p in program.procedures if p.unit == u) for u in units
        }
    elif first is not None:
        head.names["first"] = {names.units[unit.unit]: first.name}
    for procedure in others:
        short = names.procedures[procedure.name.lower()]
        head.names["procedure"][short] = procedure.name
        if procedure.result in NO_LETTER and unit.writer.functions:
            head.names["result"][short] = procedure.result
    head.names["timer"] = {
        str(names.timers[t.lower()]): t for t in timers(program) if t.lower() in names.timers
    }
    _name_labels(unit, head)
    for kind, table, given in named(unit):
        head.names[kind] = {table[n.lower()]: n for n in given}
    for owner, name, variable in unit.variables():
        short = names.variables[owner, name.lower()]
        head.variables[short] = _declared(unit, owner, name, variable)
    head.signals = dict(program.signals)
    head.products = names.products
    inline = unit.writer.expressions.inline
    head.paths = [(k, k + len(p) - 1, p.name) for k, p in unit.writer.paths if len(p)]
    numbers = [f"P{k}" for k, _ in inline.positions] + [f"J{k}" for k, _ in inline.joints]
    head.inline = dict.fromkeys(numbers)
    above = program.comments if unit.unit is None else ()
    texts = [*above, *headers.lines(head, unit.dialect.name)]
    return [s.Line(comment="' " + text if text else "'") for text in texts]


def named(unit: Unit) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Kind, names and members of the declared things that this unit holds."""
    p, n, used = unit.program, unit.names, unit.writer.used
    for kind, table, given in (
        ("target", n.targets, p.targets),
        ("joints", n.joints, p.joint_targets),
        ("tool", n.tools, p.tools),
        ("frame", n.frames, p.frames),
    ):
        yield kind, table, [m for m in given if unit.unit is None or table[m.lower()] in used]


def _declared(
    unit: Unit, owner: str, name: str, variable: Variable | Parameter
) -> headers.Declared:
    whose = next((p.name for p in unit.program.procedures if p.name.lower() == owner), "")
    if isinstance(variable, Parameter):
        extents = (0,) * variable.dimensions
        return headers.Declared(name, variable.type, "parameter", whose, size=extents)
    return headers.Declared(
        name, variable.type, variable.storage, whose,
        variable.local, variable.initial is not None, variable.size,
    )  # fmt: skip


def _name_labels(unit: Unit, head: headers.Header) -> None:
    mine = {p.name.lower() for p in unit.program.procedures if p.unit == unit.unit}
    for (owner, _), short in unit.names.labels.items():
        original = unit.names.original_labels[short]
        if owner in mine and short != original:
            head.names["label"][short] = original
    for (owner, _), short in unit.names.loops.items():
        if owner in mine:
            head.names["loop"][short] = unit.names.original_loops[short]
