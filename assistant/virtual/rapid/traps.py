"""Trap routines: how interrupts are connected to them, and how they run."""

from __future__ import annotations

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import place
from assistant.virtual.rapid.interrupts import Interrupt
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.poses import number
from assistant.virtual.rapid.scopes import Cell, Known


def connect_trap(machine: Machine, node: s.Connect) -> None:
    """CONNECT: a variable gets the number of a new interrupt."""
    variable = place(machine, node.interrupt)
    if variable.storage not in ("VAR", "IN"):
        raise Fault("what is no variable is connected to a trap routine", "ERR_CNTNOTVAR")
    trap = machine.meaning(node.trap)
    if not isinstance(trap, Known) or trap.node.kind != "TRAP":
        raise Fault(f"`{node.trap}` is no trap routine")
    given = machine.interrupts.connect(int(number(variable.get())), trap)
    variable.set(float(given))


def run_trap(machine: Machine, interrupt: Interrupt) -> None:
    """Other interrupts wait meanwhile. `INTNO` is its number."""
    intno = machine.predefined["intno"]
    assert isinstance(intno, Cell)
    before, on_way = intno.value, machine.on_way
    intno.value, machine.on_way = float(interrupt.number), ()
    machine.task.closed += 1
    try:
        machine.abilities.call(machine, interrupt.trap, ())
    finally:
        machine.task.closed -= 1
        intno.value, machine.on_way = before, on_way
