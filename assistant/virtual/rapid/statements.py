"""Statements of RAPID with their jumps, calls of the program's own routines, and branches.

`branches` lists every way that a decision of a module can go, as `Machine.took` reports them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Final

from assistant.languages.rapid.tables.predefined import INSTRUCTIONS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.virtual.events import Branch, Branches, BranchKey, Stopped
from assistant.virtual.rapid.call_arguments import bound_parameters
from assistant.virtual.rapid.control_flow import (
    ERROR_NAMES,
    MOST_RAISED,
    Again,
    Cycled,
    Fault,
    Jump,
    NotSimulated,
    Onward,
    Over,
    Returned,
)
from assistant.virtual.rapid.controller import move_calls, target_data
from assistant.virtual.rapid.expressions import condition, declare, evaluate, numeric, place, whole
from assistant.virtual.rapid.handlers import (
    connect_trap,
    error_name,
    leave_handler,
    run_with_recovery,
    undo_handler,
)
from assistant.virtual.rapid.machine import MOST_CALLS, Machine
from assistant.virtual.rapid.records import number, text
from assistant.virtual.rapid.scopes import Cell, Frame, Known, Meaning, Pending
from assistant.virtual.rapid.values import (
    NUMBER,
    Double,
    Shape,
    Value,
    as_kind,
    copied,
    equal,
    fitted,
    is_like,
    single,
)

Body = Sequence[s.StatementNode]


def execute(machine: Machine, body: Body) -> None:
    """Runs a list of statements; a jump to a label in it goes on behind that label."""
    start = 0
    # A jump leaves nested lists by itself: it ends the loop here if the label is in this list.
    while True:
        try:
            for node in body[start:]:
                _run_statement(machine, node)
        except Jump as jump:
            found = _label_index(body, jump.label)
            if found is None:
                raise
            start = found
        else:
            return


def _label_index(body: Body, label: str) -> int | None:
    for i, node in enumerate(body):
        if isinstance(node, s.LabelMark) and node.name.lower() == label:
            return i
    return None


def _run_statement(machine: Machine, node: s.StatementNode) -> None:
    if isinstance(node, s.CommentLine | s.Data | s.TargetRunNode | s.LabelMark):
        return
    does = _STATEMENT_FORMS.get(type(node))
    if does is None:
        raise NotSimulated(f"the statement {type(node).__name__}")
    # Each statement is the unit of RETRY and TRYNEXT: the handler runs it again or the next one.
    run_with_recovery(machine, node, does, execute)


def _assign(machine: Machine, node: s.Assignment) -> None:
    target = place(machine, node.target)
    target.set(evaluate(machine, node.value, target.shape))


def _call(machine: Machine, node: s.ProcedureCall) -> None:
    if isinstance(node.name, str):
        call_named(machine, node.name, machine.meaning(node.name), node.arguments)
        return
    name = text(evaluate(machine, node.name))
    call_late(machine, name, node.arguments)


def call_late(machine: Machine, name: str, arguments: Sequence[s.Argument]) -> None:
    """A call of what is named while the program runs, `Module:procedure` or by name alone."""
    module, _, own = name.rpartition(":")
    meaning = machine.meaning(own)
    if module:
        unit = machine.modules.get(module.lower())
        meaning = None
        if unit is not None:
            # A name with a module finds what is local there,
            # and global data only if it is of that module.
            found = unit.names.get(own.lower()) or machine.named.get(own.lower())
            meaning = found if isinstance(found, Known) and found.unit is unit else None
    if meaning is None and own.lower() not in INSTRUCTIONS:
        raise Fault(f"a call of `{name}`, which there is not", "ERR_REFUNKPRC")
    if meaning is not None and not (isinstance(meaning, Known) and meaning.node.kind == "PROC"):
        raise Fault(f"a call of `{name}`, which is no procedure", "ERR_CALLPROC")
    call_named(machine, own, meaning, arguments)


def call_named(
    machine: Machine, name: str, meaning: Meaning | None, arguments: Sequence[s.Argument]
) -> None:
    """A call of a procedure of the program, or of an instruction of every controller."""
    if isinstance(meaning, Known):
        if meaning.node.kind != "PROC":
            raise Fault(f"`{name}` is no procedure")
        machine.abilities.call(machine, meaning, arguments)
        return
    instruction = machine.abilities.instructions.get(name.lower())
    if instruction is None:
        raise NotSimulated(f"the instruction or procedure `{name}`")
    instruction(machine, arguments)


def _goto(_: Machine, node: s.GotoLabel) -> None:
    raise Jump(node.label.lower())


def _return(machine: Machine, node: s.ReturnFrom) -> None:
    if node.value is None:
        raise Returned
    routine = machine.frame.routine
    wanted = Shape(machine.types.name(routine.type)) if routine and routine.type else None
    raise Returned(evaluate(machine, node.value, wanted))


def _run_word(machine: Machine, node: s.Word) -> None:
    if node.word == "EXIT":
        machine.task.tell(Stopped(end=True))
        raise Over("end")
    if machine.frame.handling is None:
        raise Fault(f"{node.word} outside of an error handler")
    raise Again if node.word == "RETRY" else Onward


def _raise(machine: Machine, node: s.RaiseError) -> None:
    """Without a number it is for a handler, with one for anywhere else."""
    handling = machine.frame.handling
    if node.value is None:
        if handling is None:
            raise Fault("RAISE without a number outside of an error handler")
        # `leave_handler` always raises.
        leave_handler(machine, machine.frame, handling)
    if handling is not None:
        raise Fault("RAISE with a number inside of an error handler")
    assert node.value is not None
    number = whole(numeric(machine, node.value), "the number of an error")
    known = (
        1 <= number <= MOST_RAISED or number in machine.controller.booked or number in ERROR_NAMES
    )
    if not known:
        raise Fault(f"RAISE of the number {number}, which nobody booked", "ERR_ILLRAISE")
    name = node.value.name if isinstance(node.value, s.NameRef) else error_name(number)
    raise Fault(f"the error {name} is raised", number=number)


def _if(machine: Machine, node: s.IfThen) -> None:
    for way, branch in enumerate(node.branches):
        # An unfilled `<EXP>` of the pendant loads, and is an error only when it is reached.
        if branch.condition is None:
            raise Fault("a branch that was never filled in", "ERR_EXECPHR")
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
    first, last, step = _loop_count(machine, node)
    kind = Shape("dnum") if isinstance(first, Double) else NUMBER
    runs = first <= last if step > 0.0 else first >= last
    machine.took(node, 0 if runs else 1)
    names, name = machine.frame.names, node.variable.lower()
    # The loop variable hides data of the routine of that name, which is back after the loop.
    hidden = names.get(name)
    try:
        value = first
        while (value <= last) if step > 0.0 else (value >= last):
            names[name] = Cell(kind, "LOOP", value)
            execute(machine, node.body)
            # Counts the head of the loop: an empty body would otherwise never come to an end.
            machine.step(node)
            value = as_kind(value + step, type(first))
    finally:
        if hidden is None:
            names.pop(name, None)
        else:
            names[name] = hidden


def _loop_count(machine: Machine, node: s.ForLoop) -> list[float]:
    """First and last value and step; of dnum if one of them is."""
    nodes = (node.first, node.last, *(() if node.step is None else (node.step,)))
    values = [evaluate(machine, one) for one in nodes]
    of = Double if any(isinstance(value, Double) for value in values) else single
    first, last, *steps = [of(number(value)) for value in values]
    step = steps[0] if steps else 1.0 if first <= last else -1.0
    if step == 0.0:
        raise NotSimulated("a FOR whose step is 0")
    return [first, last, step]


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
            raise Fault("a case that was never filled in", "ERR_EXECPHR")
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
    for row, move in enumerate(move_calls(node.run)):
        run_with_recovery(machine, node, partial(_move, move), execute, row)


def _move(move: s.ProcedureCall, machine: Machine, _: s.MoveRunNode) -> None:
    _call(machine, move)


def _placeholder(_: Machine, node: s.Placeholder) -> None:
    raise Fault(f"the placeholder `{node.text}`", "ERR_EXECPHR")


_STATEMENT_FORMS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    s.Assignment: _assign,
    s.ProcedureCall: _call,
    s.GotoLabel: _goto,
    s.ReturnFrom: _return,
    s.Word: _run_word,
    s.RaiseError: _raise,
    s.Connect: connect_trap,
    s.IfThen: _if,
    s.CompactIf: _compact_if,
    s.ForLoop: _for,
    s.WhileLoop: _while,
    s.TestOf: _test,
    s.MoveRunNode: _moves,
    s.Placeholder: _placeholder,
}


def call_routine(machine: Machine, known: Known, arguments: Sequence[s.Argument]) -> Value | None:
    """Runs a routine; the value of a function, None of a procedure."""
    # Each RAPID call takes several Python calls; deeper nesting would hit Python's own limit.
    if len(machine.frames) >= MOST_CALLS:
        raise NotSimulated(f"more than {MOST_CALLS} routines inside of one another")
    at = machine.at
    frame = Frame(known.unit, known.node, bound_parameters(machine, known.node, arguments), at)
    machine.frames.append(frame)
    try:
        value = _run_routine(machine, known.node)
    except Fault as fault:
        if fault.goal is not None:
            undo_handler(machine, frame, execute)
        if known.node.kind == "TRAP":  # its errors are dealt with by the system
            fault.number = None
        raise
    except Cycled:
        undo_handler(machine, frame, execute)
        raise
    finally:
        machine.frames.pop()
    machine.at = at
    return value


def _run_routine(machine: Machine, routine: s.Routine) -> Value | None:
    # Data first: declarations hold for the complete routine, wherever they are.
    for node in routine.body:
        for datum in target_data(node) if isinstance(node, s.TargetRunNode) else (node,):
            if isinstance(datum, s.Data):
                _declare_local(machine, datum)
    try:
        execute(machine, routine.body)
    except Returned as returned:
        return _routine_result(machine, routine, returned.value)
    except Jump as jump:
        raise Fault(f"there is no label `{jump.label}` that can be jumped to") from None
    if routine.kind == "FUNC":
        raise Fault(f"`{routine.name}` ends without RETURN", "ERR_FNCNORET")
    return None


def _declare_local(machine: Machine, node: s.Data) -> None:
    if node.storage == "PERS":
        raise Fault(f"the persistent `{node.name}` inside of a routine")
    cell = Cell(Shape("num"), "CONST" if node.storage == "CONST" else "VAR")
    try:
        declare(machine, cell, node)
    # Data of a type that is not simulated is harmless until it is used.
    except NotSimulated:
        if node.value is not None:
            raise
        cell.pending = Pending(node, machine.frame.unit)
    machine.frame.names[node.name.lower()] = cell


def _routine_result(machine: Machine, routine: s.Routine, value: Value | None) -> Value | None:
    if routine.kind != "FUNC":
        return None
    wanted = Shape(machine.types.name(routine.type))
    if value is None or not is_like(value, wanted):
        raise Fault(f"`{routine.name}` does not give {routine.type}")
    return fitted(copied(value), wanted)


def branches(files: Sequence[s.File]) -> Branches:
    """Every way that a statement of the routines can go on."""
    found: dict[BranchKey, Branch] = {}
    for file in files:
        path = (file.source.path if file.source else None) or ""
        for node in nodes(file.parts):
            if file.source is None or not isinstance(node, _DECISION_NODES) or node.span is None:
                continue
            start = node.span.start
            line = file.source.line_column(start)[0]
            for way, said in _branch_ways(node):
                found[path, start, way] = Branch(path, line, said)
    return found


_DECISION_NODES = s.IfThen | s.CompactIf | s.ForLoop | s.WhileLoop | s.TestOf


def _branch_ways(
    node: s.IfThen | s.CompactIf | s.ForLoop | s.WhileLoop | s.TestOf,
) -> Iterator[tuple[int, str]]:
    match node:
        case s.IfThen(branches=parts):
            for way, _ in enumerate(parts):
                yield way, "ELSEIF met" if way else "IF met"
            yield len(parts), "ELSE" if node.otherwise else "IF not met"
        case s.CompactIf():
            yield from ((0, "IF met"), (1, "IF not met"))
        # WHILE TRUE has no way out that a test could take.
        case s.WhileLoop(condition=condition) if not isinstance(condition, s.BoolLiteral):
            yield from ((0, "WHILE met"), (1, "WHILE not met"))
        # Without STEP the loop always runs at least once: it turns towards the end.
        case s.ForLoop(step=step) if step is not None:
            # Literal bounds decide the loop in the text: there is no second way to prove.
            bounds = (node.first, node.last)
            if not all(isinstance(bound, s.NumberLiteral) for bound in bounds):
                yield from ((0, "FOR entered"), (1, "FOR passed"))
        case s.TestOf(cases=cases):
            for way, _ in enumerate(cases):
                yield way, f"CASE {way + 1}"
            yield len(cases), "DEFAULT" if node.otherwise else "no CASE"
