"""The comment lines above a unit: what its code cannot say, see header."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.languages.melfa_basic.lower.names import counted
from assistant.languages.melfa_basic.lower.writer import Writer
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import PARAMETERS, parameter_position
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.text.elsewhere import parameter_value
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.program import Parameter, ValueType, Variable
from assistant.program.undeclared_names import interrupt_names, timers

TYPES_WITHOUT_LETTER: Final[tuple[ValueType, ...]] = ("truth", "integer", "pose")
"""Types whose letter is that of another one."""


def heading(w: Writer) -> list[s.Item]:
    """The lines; the unit's code has been written already."""
    head, names, program = headers.Header(), w.names, w.program
    first, others = w.procedures()
    head.program, head.robot, head.unit = program.name, program.robot, w.unit
    if w.unit is None:
        head.entry = first.name if first else "-"
        units = dict.fromkeys(p.unit for p in program.procedures if p.unit is not None)
        head.names["unit"] = {names.units[u]: u for u in units}
        head.names["first"] = {
            names.units[u]: next(p.name for p in program.procedures if p.unit == u) for u in units
        }
    elif first is not None:
        head.names["first"] = {names.units[w.unit]: first.name}
    for procedure in others:
        short = names.procedures[procedure.name.lower()]
        head.names["procedure"][short] = procedure.name
        if procedure.result in TYPES_WITHOUT_LETTER and w.functions:
            head.names["result"][short] = procedure.result
    head.names["timer"] = {
        str(names.timers[t.lower()]): t for t in timers(program) if t.lower() in names.timers
    }
    if w.unit is None:
        head.names["interrupt"] = interrupt_names(program, names.interrupts)
    _note_labels(w, head)
    for kind, table, given in named_members(w):
        head.names[kind] = {table[n.lower()]: n for n in given}
    for word, _, number, name in counted(program, w.dialect, names.products):
        short = parameter_position(PARAMETERS[word].format(number=number))
        tool = word == "Tool"
        pose = program.tools[name].tip if tool else program.frames[name].pose
        head.there.append(parameter_value(short, poses.plain_values(pose)))
    for owner, name, variable in w.variables():
        short = names.variables[owner, name.lower()]
        head.variables[short] = _declared_variable(w, owner, name, variable)
    head.signals = dict(program.signals)
    head.products = names.products
    inline = w.expressions.inline
    head.paths = [(k, k + len(p) - 1, p.name) for k, p in w.paths if len(p)]
    numbers = [f"P{k}" for k, _ in inline.positions] + [f"J{k}" for k, _ in inline.joints]
    head.inline = dict.fromkeys(numbers)
    above = program.comments if w.unit is None else ()
    texts = [*above, *headers.header_lines(head, w.dialect.name)]
    return [s.Line(comment="' " + text if text else "'") for text in texts]


def named_members(w: Writer) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Kind, names and members of the declared things that this unit holds."""
    p, n, used = w.program, w.names, w.used
    for kind, table, given in (
        ("target", n.targets, p.targets),
        ("joints", n.joints, p.joint_targets),
        ("tool", n.tools, p.tools),
        ("frame", n.frames, p.frames),
    ):
        yield kind, table, [m for m in given if w.unit is None or table[m.lower()] in used]


def _declared_variable(
    w: Writer, owner: str, name: str, variable: Variable | Parameter
) -> headers.Declared:
    procedure = w.program.procedure(owner)
    whose = "" if procedure is None else procedure.name
    if isinstance(variable, Parameter):
        extents = (0,) * variable.dimensions
        return headers.Declared(name, variable.type, "parameter", whose, size=extents)
    return headers.Declared(
        name, variable.type, variable.storage, whose,
        variable.local, variable.initial is not None, variable.size,
    )  # fmt: skip


def _note_labels(w: Writer, head: headers.Header) -> None:
    mine = {p.name.lower() for p in w.program.procedures if p.unit == w.unit}
    for (owner, _), short in w.names.labels.items():
        original = w.names.original_labels[short]
        if owner in mine and short != original:
            head.names["label"][short] = original
    for (owner, _), short in w.names.loops.items():
        if owner in mine:
            head.names["loop"][short] = w.names.original_loops[short]
