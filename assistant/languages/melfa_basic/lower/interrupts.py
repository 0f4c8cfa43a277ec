"""Interrupts as `Def Act`, `Act`, and the lines that call what answers each.

`Def Act 1,M_In(3)=1 GoSub *AC1` leads to lines behind the end of the program, which call a
procedure and go on where the program was by `Return 0`. An interrupt of a lower number may come
while one is answered; as none shall, several are shut meanwhile.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.lower import control
from assistant.languages.melfa_basic.lower.expressions import Unsayable
from assistant.languages.melfa_basic.tables.vocabulary.interrupts import (
    ALL_INTERRUPTS,
    INTERRUPT_NUMBERS,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called
from assistant.program.program import walk
from assistant.program.rewriting import records

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.writer import Writer


def interrupt_label(number: int) -> str:
    """What an interrupt leads to."""
    return f"AC{number}"


def write_interrupt_answers(w: Writer) -> None:
    """The lines that interrupts lead to."""
    shut = len(w.answers) > 1
    for node in w.answers:
        w.label(interrupt_label(w.names.interrupts[node.name.lower()]))
        if shut:
            w.add(_act_command(ALL_INTERRUPTS, on=False))
        with w.findings.at(node.span), w.saying():
            control.write_call(w, node.call)
        if shut:
            w.add(_act_command(ALL_INTERRUPTS, on=True))
        if node.ends is not None:
            with w.findings.at(node.span), w.saying():
                w.add(s.If(w.expressions.of(node.ends), s.Command("End")))
        w.add(s.Command("Return", (s.Number(0),)))
    w.answers.clear()


def _write_interrupt(w: Writer, node: p.Interrupt) -> None:
    if any(isinstance(one, e.Here) for one in records(node.condition)):
        raise Unsayable(
            f"the interrupt `{node.name}`, which asks for the position of the robot",
            "ask for it in the program",
        )
    _check_interrupt(w, node)
    number = _interrupt_number(w, node.name)
    condition = w.expressions.of(node.condition)
    w.add(s.DefAct(s.Number(number), condition, "GoSub", s.Target(interrupt_label(number))))
    w.answers.append(node)


def _check_interrupt(w: Writer, node: p.Interrupt) -> None:
    """Raises Unsayable for what would change how the moves of the program are made."""
    pending, seen = [node.call.procedure.lower()], set[str]()
    while pending:
        procedure = w.program.procedure(pending.pop())
        if procedure is None or procedure.name.lower() in seen:
            continue
        seen.add(procedure.name.lower())
        pending += called(procedure)
        for one in walk(procedure.body):
            if isinstance(one, p.Moving | p.SetOverride | p.SetAcceleration):
                raise Unsayable(
                    f"the interrupt `{node.name}`, which moves the robot or sets how it moves",
                    "set an output or a variable in it, and move where the program asks for that",
                )
            if isinstance(one, p.SwitchInterrupts):
                raise Unsayable(
                    f"the interrupt `{node.name}`, which switches all interrupts",
                    "switch them one by one",
                )


def _write_switch(w: Writer, node: p.SwitchInterrupt) -> None:
    w.add(_act_command(_interrupt_number(w, node.name), on=node.state == "on"))


def _write_switch_all(w: Writer, node: p.SwitchInterrupts) -> None:
    w.add(_act_command(ALL_INTERRUPTS, on=node.state == "on"))


def _interrupt_number(w: Writer, name: str) -> int:
    number = w.names.interrupts.get(name.lower())
    if number is None:
        if name.lower() not in w.names.defined:
            raise Unsayable(f"the interrupt `{name}`, which nothing defines", "define it")
        raise Unsayable(f"more than {len(INTERRUPT_NUMBERS)} interrupts", "use fewer of them")
    return number


def _act_command(number: int, *, on: bool) -> s.Command:
    return s.Command("Act", (s.Binary("=", s.Number(number), s.Number(int(on))),))


INTERRUPT_WRITERS: Final[Mapping[type, Callable[[Writer, Any], None]]] = {
    p.Interrupt: _write_interrupt,
    p.SwitchInterrupt: _write_switch,
    p.SwitchInterrupts: _write_switch_all,
}
