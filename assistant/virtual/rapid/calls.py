"""Calls of the program's own routines: their parameters, data and results."""

from __future__ import annotations

from collections.abc import Sequence

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.ends import Cycled, Fault, Jump, NotSimulated, Returned
from assistant.virtual.rapid.expressions import declare
from assistant.virtual.rapid.machine import MOST_CALLS, Machine
from assistant.virtual.rapid.parameters import bound_parameters
from assistant.virtual.rapid.recovery import undo_handler
from assistant.virtual.rapid.rows import target_data
from assistant.virtual.rapid.scopes import Cell, Frame, Known, Pending
from assistant.virtual.rapid.statements import execute
from assistant.virtual.rapid.values import Shape, Value, copied, fitted, is_like


def call_routine(machine: Machine, known: Known, arguments: Sequence[s.Argument]) -> Value | None:
    """Runs a routine; the value of a function, None of a procedure."""
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
