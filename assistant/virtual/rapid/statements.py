"""Statements, one after the other, with their jumps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.events import Stopped
from assistant.virtual.rapid.ends import Fault, Jump, NotSimulated, Over, Returned
from assistant.virtual.rapid.expressions import condition, evaluate, numeric, place
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.poses import text
from assistant.virtual.rapid.rows import moves
from assistant.virtual.rapid.scopes import Cell, Known
from assistant.virtual.rapid.values import NUMBER, Shape, equal

Body = Sequence[s.StatementNode]


def execute(machine: Machine, body: Body) -> None:
    """Runs a list of statements; a jump to a label in it goes on behind that label."""
    start = 0
    while True:
        try:
            for node in body[start:]:
                _run(machine, node)
        except Jump as jump:
            found = _label(body, jump.label)
            if found is None:
                raise
            start = found
        else:
            return


def _label(body: Body, label: str) -> int | None:
    for i, node in enumerate(body):
        if isinstance(node, s.LabelMark) and node.name.lower() == label:
            return i
    return None


def _run(machine: Machine, node: s.StatementNode) -> None:
    if isinstance(node, s.CommentLine | s.Data | s.TargetRunNode | s.LabelMark):
        return
    machine.step(node)
    does = STATEMENTS.get(type(node))
    if does is None:
        raise NotSimulated(f"the statement {type(node).__name__}")
    does(machine, node)


def _assign(machine: Machine, node: s.Assignment) -> None:
    target = place(machine, node.target)
    target.set(evaluate(machine, node.value, target.shape))


def _call(machine: Machine, node: s.ProcedureCall) -> None:
    name = node.name
    if not isinstance(name, str):
        name = text(evaluate(machine, name)).rpartition(":")[2]
    meaning = machine.meaning(name)
    if isinstance(meaning, Known):
        if meaning.node.kind != "PROC":
            raise Fault(f"`{name}` is no procedure")
        machine.abilities.call(machine, meaning, node.arguments)
        return
    instruction = machine.abilities.instructions.get(name.lower())
    if instruction is None:
        raise NotSimulated(f"the instruction or procedure `{name}`")
    instruction(machine, node.arguments)


def _goto(_: Machine, node: s.GotoLabel) -> None:
    raise Jump(node.label.lower())


def _return(machine: Machine, node: s.ReturnFrom) -> None:
    if node.value is None:
        raise Returned
    routine = machine.frame.routine
    wanted = Shape(machine.types.name(routine.type)) if routine and routine.type else None
    raise Returned(evaluate(machine, node.value, wanted))


def _word(machine: Machine, node: s.Word) -> None:
    if node.word != "EXIT":
        raise Fault(f"{node.word} outside of an error handler")
    machine.task.tell(Stopped(end=True))
    raise Over("end")


def _if(machine: Machine, node: s.IfThen) -> None:
    for way, branch in enumerate(node.branches):
        if branch.condition is None:
            raise Fault("a branch that was never filled in")
        if condition(machine, branch.condition):
            machine.took(node, way)
            execute(machine, branch.body)
            return
    machine.took(node, len(node.branches))
    execute(machine, node.otherwise or ())


def _compact_if(machine: Machine, node: s.CompactIf) -> None:
    met = condition(machine, node.condition)
    machine.took(node, 0 if met else 1)
    if met:
        execute(machine, (node.statement,))


def _for(machine: Machine, node: s.ForLoop) -> None:
    """Bounds and step are worked out once; without STEP it goes towards the end by 1."""
    first, last = numeric(machine, node.first), numeric(machine, node.last)
    step = (1.0 if first <= last else -1.0) if node.step is None else numeric(machine, node.step)
    if step == 0.0:
        raise NotSimulated("a FOR whose step is 0")
    runs = first <= last if step > 0.0 else first >= last
    machine.took(node, 0 if runs else 1)
    names, name = machine.frame.names, node.variable.lower()
    hidden = names.get(name)
    try:
        value = first
        while (value <= last) if step > 0.0 else (value >= last):
            names[name] = Cell(NUMBER, "LOOP", value)
            execute(machine, node.body)
            machine.step(node)
            value += step
    finally:
        if hidden is None:
            names.pop(name, None)
        else:
            names[name] = hidden


def _while(machine: Machine, node: s.WhileLoop) -> None:
    while condition(machine, node.condition):
        machine.took(node, 0)
        execute(machine, node.body)
        machine.step(node)
    machine.took(node, 1)


def _test(machine: Machine, node: s.TestOf) -> None:
    subject = evaluate(machine, node.subject)
    for way, case in enumerate(node.cases):
        if not case.values:
            raise Fault("a case that was never filled in")
        try:
            if any(equal(subject, evaluate(machine, value)) for value in case.values):
                machine.took(node, way)
                execute(machine, case.body)
                return
        except ValueError as error:
            raise Fault(str(error)) from None
    machine.took(node, len(node.cases))
    execute(machine, node.otherwise or ())


def _moves(machine: Machine, node: s.MoveRunNode) -> None:
    for row, move in enumerate(moves(node.run)):
        machine.row = row
        machine.task.step()
        _call(machine, move)


def _placeholder(_: Machine, node: s.Placeholder) -> None:
    raise Fault(f"the placeholder `{node.text}`")


STATEMENTS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    s.Assignment: _assign,
    s.ProcedureCall: _call,
    s.GotoLabel: _goto,
    s.ReturnFrom: _return,
    s.Word: _word,
    s.IfThen: _if,
    s.CompactIf: _compact_if,
    s.ForLoop: _for,
    s.WhileLoop: _while,
    s.TestOf: _test,
    s.MoveRunNode: _moves,
    s.Placeholder: _placeholder,
}
"""Others, as RAISE and CONNECT, are not simulated."""
