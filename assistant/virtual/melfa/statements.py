"""What each statement of MELFA-BASIC does, in two tables: by form and by word."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import (
    blocks,
    communication,
    expressions,
    interrupts,
    mechanism,
    motion,
    settings,
    status,
)
from assistant.virtual.melfa.stops import Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import Bare, holds, kind_of, text, whole, with_component

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


def execute(m: Machine, statement: s.Statement) -> None:
    """Runs one statement; the row that comes next is set already."""
    if isinstance(statement, s.Command):
        settings.run_command(m, statement)
        return
    run = STATEMENT_FORMS.get(type(statement))
    if run is None:
        raise Unknown(f"the statement {type(statement).__name__}")
    run(m, statement)


def _no_effect(_m: Machine, _node: Any) -> None:
    """Definitions are taken in before the program runs."""


def _run_motion(m: Machine, node: s.Motion) -> None:
    motion.move(m, node)


# ------------------------------------------------------------------------------- assignments


def _assign(m: Machine, node: s.Assign) -> None:
    target, key = node.target, node.target.key
    value = expressions.value(m, node.value)
    if m.is_result(target):
        _assign_result(m, target, value)
    elif m.world.commands and f"{key}=" in m.world.commands:
        m.world.given(f"{key}=", (*expressions.values(m, target.arguments or ()), value))
    elif not m.is_own(key) and key in m.code.signals:
        first, width, mask = expressions.io_of(m, m.code.signals[key])
        _switch_signals(m, node, first, width, whole(value), mask)
    elif key in status.SIGNAL_WIDTHS and not m.is_own(key):
        first = _element_index(m, target)
        if not status.SIGNAL_WIDTHS[key][0]:
            raise Failed(3210, f"{target.name} is written")
        _switch_signals(m, node, first, status.SIGNAL_WIDTHS[key][1], whole(value))
    elif status.REGISTER_OUTPUTS.get(key) and not m.is_own(key):
        m.world.set_register(_element_index(m, target), value)
    elif key == "M_TIMER":
        m.world.set_timer(status.timer_number(_element_index(m, target)), float(whole(value)))
    elif key == "M_HND":
        mechanism.order_hand(m, _element_index(m, target), float(whole(value)))
    elif key == "M_TOOL":
        mechanism.choose_tool(m, whole(value))
    elif key == "C_COM" and not m.is_own(key):
        communication.set_target(
            m.world, _element_index(m, target), text(value, "the target of a line")
        )
    elif expressions.is_status(key) and not m.is_own(key):
        raise Unknown(f"setting the status variable {target.name}")
    elif node.delay is not None:
        raise Failed(4220, "a pulse of what is no output")
    else:
        expressions.store(m, target, value)


def _assign_result(m: Machine, target: s.Variable, value: Any) -> None:
    """The result of the Function that runs."""
    if target.component:
        m.set_result(with_component(m.result(), target.component, value, m.world.options))
    else:
        m.set_result(value)


def _element_index(m: Machine, target: s.Variable) -> int:
    if not target.arguments or len(target.arguments) != 1:
        raise Failed(4370, f"{target.name} without one number")
    return expressions.integer(m, target.arguments[0], f"the number of {target.name}")


def _switch_signals(
    m: Machine, node: s.Assign, first: int, width: int, value: int, mask: int = -1
) -> None:
    """Sets outputs; with a time it is a pulse."""
    if node.delay is None:
        m.world.switch(first, width, value, mask)
        return
    before = m.world.read(output=True, first=first, width=width)
    if width != 1:
        raise Unknown("a pulse of a group of signals")
    seconds = float(expressions.plain(m, node.delay, "the time of a pulse"))
    if seconds < 0:
        raise out_of_range("the time of a pulse")
    if before == value:
        raise Unknown("a pulse of an output that is as it would be set")
    m.world.pulse(first, value, before, seconds)


# ------------------------------------------------------------------------------------ jumps


def _run_if(m: Machine, node: s.If) -> None:
    if node.then is None:
        blocks.enter_if(m, node)
        return
    met = holds(expressions.value(m, node.condition))
    m.took(0 if met else 1)
    branch = node.then if met else node.otherwise
    if isinstance(branch, s.Target):
        m.jump(branch)
    elif branch is not None:
        execute(m, branch)


def _run_jump(m: Machine, node: s.Jump) -> None:
    if node.keyword == "GoSub":
        m.gosub(node.target)
    else:
        m.jump(node.target)


def _on_jump(m: Machine, node: s.OnJump) -> None:
    which = expressions.integer(m, node.subject, "the place of a jump")
    if not 0 <= which <= LARGEST_INDEX:
        raise out_of_range(f"the place {which} of a jump")
    passed = not 1 <= which <= len(node.targets)
    m.took(0 if passed else which)
    if passed:
        return
    target = node.targets[which - 1]
    if target is None:
        raise out_of_range(f"the empty place {which} of a jump")
    _run_jump(m, s.Jump(node.keyword, target))


LARGEST_INDEX: Final = 32767


def _call_subroutine(m: Machine, node: s.Call) -> None:
    if node.function.key in m.world.commands:
        given = node.function.arguments or ()
        arguments = expressions.values(m, given)
        m.world.given(node.function.key, arguments)
    else:
        m.call(node.function)


def _call_program(m: Machine, node: s.CallP) -> None:
    name = text(expressions.value(m, node.program), "the name of a program")
    m.call_program(name, tuple(expressions.value(m, a) for a in node.arguments))


def _take_parameters(m: Machine, node: s.FPrm) -> None:
    if len(node.variables) != len(m.arguments):
        raise Failed(3120, f"{len(m.arguments)} arguments for {len(node.variables)}")
    for variable, value in zip(node.variables, m.arguments, strict=True):
        kind = expressions.reference(m, variable)[0].kind
        wanted = "number" if kind in expressions.NUMBER_KINDS else kind
        if not isinstance(value, Bare) and kind_of(value) != wanted:
            raise Failed(3810, f"an argument for {variable.name} of another type")
        expressions.store(m, variable, value)


# ------------------------------------------------------------------------------ definitions


def _define_constant(m: Machine, node: s.Const) -> None:
    place, index = expressions.reference(m, node.variable)
    place.set(expressions.value(m, node.value), index)


def _define_other(m: Machine, node: s.DefOther) -> None:
    if node.kind.upper() == "ARCH":
        m.world.note("Def Arch has no effect: Mva is not simulated")
        return
    if node.kind.upper() != "PLT":
        raise Unknown(f"Def {node.kind}")
    settings.define_pallet(m, node.arguments)


def _end_function(m: Machine, _: s.Function) -> None:
    """A Function that is run into: the first one of a program is its beginning."""
    block = m.code.functions.get("MAIN")
    if block is None:
        raise Unknown("a program that runs into a Function")
    m.enter_main(block)


STATEMENT_FORMS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    s.Motion: _run_motion,
    s.Assign: _assign,
    s.If: _run_if,
    s.ElseIf: blocks.skip_rest,
    s.For: blocks.begin_for,
    s.Next: blocks.next_turn,
    s.Select: blocks.choose_case,
    s.Case: blocks.skip_rest,
    s.Jump: _run_jump,
    s.OnJump: _on_jump,
    s.CallP: _call_program,
    s.Call: _call_subroutine,
    s.FPrm: _take_parameters,
    s.DefNames: _no_effect,
    s.DefIo: _no_effect,
    s.DefFunction: _no_effect,
    s.DefOther: _define_other,
    s.Dim: _no_effect,
    s.Const: _define_constant,
    s.Static: _no_effect,
    **communication.FILE_FORMS,
    **interrupts.FORMS,
    s.Function: _end_function,
}
