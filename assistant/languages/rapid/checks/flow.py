"""Rules of control flow: unreachable statements, jumps, returns, error handlers, CASE values.

Also the order of declarations and handlers in modules and routines.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

from assistant.base.diagnostics import Severity
from assistant.languages.checks.control_flow import Reachability
from assistant.languages.checks.registry import Found
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.rule_context import RuleContext, Task
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import blocks, nodes, root

_Body = Sequence[s.StatementNode]

_ENDING_INSTRUCTIONS: Final = frozenset({"exitcycle"})
"""Instructions after which nothing more of a routine runs."""
_SILENT_NODES: Final = (s.CommentLine, s.Placeholder, s.Data, s.TargetRunNode)


def unreachable(look: RuleContext) -> Found:
    """The first statement of each stretch that nothing leads to; a label always may."""
    for routine in look.routines:
        for body in (routine.body, *(h.body for h in routine.handlers)):
            for statement, before in _REACH.dead(body):
                yield look.finding(rules.UNREACHABLE, statement, before=before)


def _leaving_statement(statement: s.StatementNode) -> str:
    """Return what keeps every path through a statement from reaching the next one; empty for most
    statements.
    """
    match statement:
        case s.ReturnFrom():
            return "RETURN"
        case s.RaiseError():
            return "RAISE"
        case s.GotoLabel():
            return "GOTO"
        case s.Word(word):
            return word
        case s.ProcedureCall(str(name)) if name.lower() in _ENDING_INSTRUCTIONS:
            return name
        case s.WhileLoop(condition) if _without_parentheses(condition) == s.BoolLiteral(True):
            return "a loop that never ends"
        # Only with ELSE or DEFAULT one of the branches always runs.
        case s.IfThen(otherwise=tuple()) | s.TestOf(otherwise=tuple()):
            return (
                ""
                if any(map(_REACH.falls_through, blocks(statement)))
                else "branches that all leave"
            )
    return ""


def _without_parentheses(value: s.Expression) -> s.Expression:
    """Without the parentheses around it."""
    while isinstance(value, s.Group):
        value = value.inner
    return value


_REACH: Final[Reachability[s.StatementNode]] = Reachability(
    blocks=blocks,
    leaves=_leaving_statement,
    entered=lambda node: any(isinstance(n, s.LabelMark) for n in nodes(node)),
    silent=lambda node: isinstance(node, _SILENT_NODES),
)


def returns(look: RuleContext) -> Found:
    """Values that are given back where none is wanted, and the other way round."""
    for routine in look.routines:
        function = routine.kind == "FUNC"
        for node in nodes((routine.body, *(h.body for h in routine.handlers if h.kind != "UNDO"))):
            if isinstance(node, s.ReturnFrom) and function == (node.value is None):
                what = "gives back no value" if function else "gives back a value"
                yield look.finding(
                    rules.WRONG_RETURN, node, what=what, kind=routine.kind, name=routine.name
                )
        if function and _REACH.falls_through(routine.body):
            yield look.finding(rules.NO_RETURN, routine, name=routine.name)


def jumps(look: RuleContext) -> Found:
    """GOTO without its label, or to one that stands inside a block."""
    for routine in look.routines:
        marks: dict[str, tuple[int, ...]] = {}
        gotos: list[tuple[s.GotoLabel, tuple[int, ...]]] = []
        for body in (routine.body, *(h.body for h in routine.handlers)):
            for statement, around in _nested_statements(body, (id(body),)):
                if isinstance(statement, s.LabelMark):
                    if statement.name.lower() in marks:
                        yield look.finding(rules.DUPLICATE, statement, name=statement.name)
                    marks.setdefault(statement.name.lower(), around)
                elif isinstance(statement, s.GotoLabel):
                    gotos.append((statement, around))
        for goto, around in gotos:
            label = marks.get(goto.label.lower())
            if label is None:
                yield look.finding(
                    rules.NO_LABEL, goto, name=goto.label, kind=routine.kind, routine=routine.name
                )
            # The lists around the label have to be around the GOTO as well.
            elif around[: len(label)] != label:
                yield look.finding(rules.INTO_BLOCK, goto, name=goto.label)


def _nested_statements(
    body: _Body, around: tuple[int, ...]
) -> Iterator[tuple[s.StatementNode, tuple[int, ...]]]:
    """Every statement with the lists around it, outermost first."""
    for statement in body:
        yield statement, around
        for at, block in enumerate(blocks(statement)):
            # A compact IF is no block: a jump into its one statement is allowed.
            inner = around if isinstance(statement, s.CompactIf) else (*around, id(statement), at)
            yield from _nested_statements(block, inner)


def outside_handlers(look: RuleContext) -> Found:
    """RETRY, TRYNEXT and bare RAISE where no error is being handled."""
    for routine in look.routines:
        for node in nodes((routine.body, *(h.body for h in routine.handlers if h.kind != "ERROR"))):
            if isinstance(node, s.Word) and node.word != "EXIT":
                yield look.finding(rules.OUTSIDE_HANDLER, node, what=node.word)
            elif isinstance(node, s.RaiseError) and node.value is None:
                what = "RAISE without a number"
                yield look.finding(rules.OUTSIDE_HANDLER, node, what=what)


_MOST_RAISED: Final = 90
"""The numbers of errors that a program may raise without booking them begin with 1."""


def never_booked(look: RuleContext) -> Found:
    """Errors that are raised with a number that no error has.

    Another module that is not given may book what all modules see.
    """
    for routine in look.routines:
        for node in nodes((routine.body, *(h.body for h in routine.handlers))):
            match node:
                case s.RaiseError(s.NameRef(name)):
                    yield from _raised(look, routine, node, name)
                case s.RaiseError(value) if value is not None:
                    number = literal_number(value)
                    if number is not None and not _may_be_raised(number):
                        what = f"the error {number:g} is raised"
                        yield look.finding(rules.NEVER_BOOKED, node, what=what)
                case s.ProcedureCall(str(word), (s.Positional(s.StringLiteral(name)), *_)):
                    if word.lower() == "errraise":
                        yield from _raised(look, routine, node, name)


def _raised(look: RuleContext, routine: s.Routine, node: s.Node, name: str) -> Found:
    found = look.find(name, routine)
    data = found.node if found is not None else None
    if found is None or not isinstance(data, s.Data) or data.dimensions or _is_given(look, name):
        return
    # An errnum without a value is 0.
    number = 0.0 if data.value is None else literal_number(data.value)
    if number is None or _may_be_raised(number):
        return
    # Another module that sees the data may book the number there.
    sure = found.local or found.kind == "CONST"
    what = f"`{name}` is raised with the number {number:g}, and nothing books it"
    severity = Severity.ERROR if sure else Severity.WARNING
    yield look.finding(rules.NEVER_BOOKED, node, what=what, severity=severity)


def _may_be_raised(number: float) -> bool:
    return 1 <= number <= _MOST_RAISED


def _is_given(look: RuleContext, name: str) -> bool:
    """True if some statement may give data of this name another number."""
    return name.lower() in look.task.once(_given_names)


def _given_names(task: Task) -> set[str]:
    """Lower-case names that are assigned to, or handed over to a routine."""
    found: set[str] = set()
    for node in nodes(task.modules):
        match node:
            case s.Assignment(target):
                data = root(target)
                found |= set() if data is None else {data.name.lower()}
            case s.ProcedureCall(_, arguments) | s.FunctionCall(_, arguments):
                for one in arguments:
                    value = getattr(one, "value", None)
                    if isinstance(value, s.NameRef):
                        found.add(value.name.lower())
    return found


def cases_and_steps(look: RuleContext) -> Found:
    """CASE values that an earlier CASE takes, and loops whose step leads nowhere."""
    for test in look.all(s.TestOf):
        seen: set[s.Expression | float | str] = set()
        for case in test.cases:
            for value in case.values:
                key = _case_key(value)
                if key is not None and key in seen:
                    yield look.finding(rules.SAME_CASE, value)
                elif key is not None:
                    seen.add(key)
    for loop in look.all(s.ForLoop):
        yield from _loop_step(look, loop)


def _case_key(value: s.Expression) -> s.Expression | float | str | None:
    """Return a key that is equal for equal case values: the number, or the name of data."""
    match value:
        case s.StringLiteral() | s.BoolLiteral():
            return value
        case s.NameRef(name):
            return name.lower()
    return literal_number(value)


def _loop_step(look: RuleContext, loop: s.ForLoop) -> Found:
    step = None if loop.step is None else literal_number(loop.step)
    if step == 0:
        yield look.finding(
            rules.BAD_STEP, loop, name=loop.variable, what="never ends: its step is 0"
        )
        return
    first, last = literal_number(loop.first), literal_number(loop.last)
    if step is not None and first is not None and last is not None and (last - first) * step < 0:
        what = f"never runs: step {step:g} leads away from {last:g}"
        yield look.finding(rules.BAD_STEP, loop, name=loop.variable, what=what)


# Where declarations and handlers may stand


_DECLARATION_RANKS: Final[tuple[tuple[Any, int, str], ...]] = (
    (s.Record | s.Alias, 0, "a record"),
    (s.Data | s.TargetRunNode, 1, "data"),
    (s.Routine, 2, "a routine"),
)
_RANK_TEXTS: Final = {1: "data", 2: "a routine"}
_HANDLER_ORDER: Final = ("BACKWARD", "ERROR", "UNDO")


def declarations(look: RuleContext) -> Found:
    """Records, data, routines in a module; declarations, then statements in a routine."""
    seen = 0
    for item in look.module.items:
        rank, what = next(
            ((r, w) for kind, r, w in _DECLARATION_RANKS if isinstance(item, kind)), (seen, "")
        )
        if rank < seen:
            yield look.finding(rules.OUT_OF_ORDER, item, what=what, after=_RANK_TEXTS[seen])
        seen = max(seen, rank)
    for routine in look.routines:
        yield from _declarations_first(look, routine.body)


def _declarations_first(look: RuleContext, body: Sequence[s.StatementNode]) -> Found:
    stated = False
    for node in body:
        if isinstance(node, s.Data | s.TargetRunNode):
            if stated:
                yield look.finding(
                    rules.OUT_OF_ORDER, node, what="a declaration", after="a statement"
                )
        elif not isinstance(node, s.CommentLine | s.Placeholder):
            stated = True


def handlers(look: RuleContext) -> Found:
    """At most one of each kind, in one order; BACKWARD of procedures only."""
    for routine in look.routines:
        yield from _handlers(look, routine)


def _handlers(look: RuleContext, routine: s.Routine) -> Found:
    before = -1
    for handler in routine.handlers:
        at = _HANDLER_ORDER.index(handler.kind)
        if at <= before:
            what = "a second time" if at == before else f"behind {_HANDLER_ORDER[before]}"
            yield look.finding(rules.HANDLER_PLACE, handler, kind=handler.kind, what=what)
        elif handler.kind == "BACKWARD" and routine.kind != "PROC":
            what = f"in a {routine.kind}"
            yield look.finding(rules.HANDLER_PLACE, handler, kind=handler.kind, what=what)
        before = max(before, at)
