"""Control flow, calls and assignments as lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower import channels
from assistant.languages.melfa_basic.lower.expressions import Unsayable
from assistant.languages.melfa_basic.lower.signals import write_row
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.dialects import EMITTED_LINE
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure
from assistant.program.rewriting import Body

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.writer import Writer


def write_call(w: Writer, node: p.Call) -> None:
    callee = w.program.procedure(node.procedure)
    if callee is None:
        w.report(rules.MISSING(name=node.procedure))
        return
    arguments = tuple(w.expressions.argument(a) for a in node.arguments)
    if len(arguments) != len(callee.parameters):
        raise Unsayable(
            f"{len(arguments)} arguments for the {len(callee.parameters)} of `{callee.name}`",
            "give one for each parameter",
        )
    if callee.unit != w.unit:
        if callee.unit is None or not w.is_first(callee):
            raise Unsayable(
                f"a call of `{callee.name}` inside another program",
                "let it be the first procedure of its unit",
            )
        w.add(s.CallP(s.String(w.names.units[callee.unit]), arguments))
    elif w.is_first(callee):
        raise Unsayable(f"a call of `{callee.name}` from its own program", "move its body")
    elif w.functions:
        w.add(s.Call(s.Variable(w.names.procedures[callee.name.lower()], "", arguments)))
    elif arguments:
        raise Unsayable(f"the arguments of `{callee.name}`", "use variables instead")
    else:
        w.add(s.Jump("GoSub", s.Target(w.names.procedures[callee.name.lower()])))
    w.forget()


def write_assignment(w: Writer, node: p.Assign) -> None:
    match node.value:
        case e.Apply(function, (e.Text(channel),)) if function in e.TAKING:
            channels.write_input(w, node.target, channel)
            return
    if (base := w.changed_frame(node.target)) is not None:
        w.add(s.Assign(base, w.expressions.of(e.inverse(node.value))))
        w.previous = None
        return
    target = w.expressions.place(node.target)
    if poses.is_angle(target.component, w.expressions.robot):
        value = w.expressions.angle(node.value)
    elif isinstance(node.target, e.Member) and node.target.field.lower() in poses.ADDITIONAL:
        value = w.expressions.additional(node.value, node.target.field)
    else:
        value = w.expressions.of(node.value)
    w.add(s.Assign(target, value))
    w.changed_tool(node.target)
    w.previous = None


def write_return(w: Writer, node: p.Return) -> None:
    first = w.owner is not None and w.is_first(w.owner)
    if node.value is not None:
        if not w.functions or w.owner is None:
            raise Unsayable("a result of a procedure", "use a variable instead")
        w.add(s.Assign(result_of(w, w.owner), w.expressions.of(node.value)))
        if node is w.owner.body[-1]:
            return
    if w.functions and not first:
        w.add(s.Command("Exit Function"))
    else:
        w.add(s.Command("End" if first else "Return"))


def result_of(w: Writer, procedure: Procedure) -> s.Variable:
    """What a Function's result is assigned to: its own name."""
    suffix = "$" if procedure.result == "text" else ""
    return s.Variable(w.names.procedures[procedure.name.lower()], suffix)


def write_stop(w: Writer, node: p.Stop) -> None:
    if node.end:
        raise Unsayable("an end for good", "write `Hlt` in a loop")
    write_row(w, node)
    w.previous = None


# ----------------------------------------------------------------------------- branches


SHORT_STATEMENTS: Final = (
    p.Assign,
    p.SetSignal,
    p.Goto,
    p.Call,
    p.Stop,
    p.Return,
    p.Wait,
    p.Gripper,
)
"""Statements that one line of an `If` may hold."""


def write_if(w: Writer, node: p.If) -> None:
    if w.dialect.blocks:
        _write_if_block(w, node)
    elif not _write_short_if(w, node):
        _write_if_of_jumps(w, node)


def _write_if_block(w: Writer, node: p.If) -> None:
    for i, branch in enumerate(node.branches):
        condition = w.expressions.of(branch.condition)
        w.part(s.If(condition, None) if i == 0 else s.ElseIf(condition), branch.body)
    if node.otherwise:
        w.part(s.Command("Else"), node.otherwise)
    w.part(s.Command("EndIf"))


def _write_short_if(w: Writer, node: p.If) -> bool:
    """Writes an `If` of one short statement, or one for each case; False if it is another."""
    if len(node.branches) != 1:
        return False
    (branch,) = node.branches
    then, otherwise = _short_statement(w, branch.body), _short_statement(w, node.otherwise)
    if then is None or (otherwise is None and node.otherwise):
        return False
    line = s.Line(statement=s.If(w.expressions.of(branch.condition), then, otherwise))
    if len(printer.line(line, w.dialect.upper).encode()) > EMITTED_LINE - len("32767 "):
        return False
    w.items.append(line)
    w.forget()
    return True


def _short_statement(w: Writer, body: Body) -> s.Statement | s.Target | None:
    """The one statement that a body is, None if it is another."""
    if len(body) != 1 or not isinstance(body[0], SHORT_STATEMENTS):
        return None
    before = len(w.items)
    try:
        w.statement(body[0])
    except Unsayable:
        return None  # found once more where the body is written by itself, at its own place
    finally:
        made, w.items[before:] = w.items[before:], []
    match made:
        case [s.Line(statement=s.Jump("GoTo", target))]:
            return target
        case [s.Line(statement=statement)]:
            return statement
    return None


def _write_if_of_jumps(w: Writer, node: p.If) -> None:
    label = w.made_label("I")
    for i, branch in enumerate(node.branches, start=1):
        condition = w.expressions.of(branch.condition)
        then, following = f"{label}T{i}", f"{label}N{i}"
        w.add(s.If(condition, s.Target(then), s.Target(following)))
        w.label(then)
        w.body(branch.body)
        w.add(s.Jump("GoTo", s.Target(label + "Z")))
        w.label(following)
    w.body(node.otherwise)
    w.label(label + "Z")


def write_switch(w: Writer, node: p.Switch) -> None:
    w.add(s.Select(w.expressions.of(node.subject)))
    for case in node.cases:
        w.part(s.Case(tuple(s.CaseRange(w.expressions.of(v)) for v in case.values)), case.body)
        _write_break(w)
    if node.otherwise:
        w.part(s.Command("Default"), node.otherwise)
        _write_break(w)
    w.part(s.Command("End Select"))


def _write_break(w: Writer) -> None:
    """The word that people end a case with, where there is one."""
    if w.dialect.breaks:
        w.add(s.Command("Break"))


def write_while(w: Writer, node: p.While) -> None:
    w.part(s.Command("While", (w.expressions.of(node.condition),)), node.body)
    w.stand(node.condition)
    w.part(s.Command("WEnd"))


def write_for(w: Writer, node: p.For) -> None:
    short = w.expressions.variable(node.variable)
    if short is None:
        raise Unsayable(f"the loop variable `{node.variable}`", "give it another name")
    variable = s.Variable(short)
    first, last = w.expressions.of(node.first), w.expressions.of(node.last)
    step = None if node.step is None or node.step == p.ONE else w.expressions.of(node.step)
    w.part(s.For(variable, first, last, step), node.body)
    w.part(s.Next((variable,)))


# --------------------------------------------------------------------------------- jumps


def write_label(w: Writer, node: p.Label) -> None:
    w.label(_label_target(w, node.name))


def write_goto(w: Writer, node: p.Goto) -> None:
    w.add(s.Jump("GoTo", s.Target(_label_target(w, node.label))))


def _label_target(w: Writer, name: str) -> str:
    owner = w.owner.name.lower() if w.owner else ""
    short = w.names.labels.get((owner, name.lower()))
    if short is None:
        raise Unsayable(f"a jump to `{name}`, which is missing", "add the label")
    return short
