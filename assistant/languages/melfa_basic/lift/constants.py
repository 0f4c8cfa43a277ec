"""Which variables of a file keep one value that is known, and which are ever assigned."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, Final

from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MoveRows
from assistant.languages.melfa_basic.lift.blocks import opened
from assistant.languages.melfa_basic.lift.walk import nodes
from assistant.languages.melfa_basic.vocabulary import status

Value = float | str

READING: Final = frozenset(
    {
        *("Spd", "Ovrd", "JOvrd", "Cnt", "Fine", "Accel", "Tool", "Base", "Dly", "Wait", "HOpen"),
        *("HClose", "Hlt", "End", "Return", "Error", "Servo", "While", "Oadl", "LoadSet", "Cmp"),
        *("CmpG", "ColChk", "ColLvl", "Fsc", "FsGChg", "XRun", "XLoad", "XStp", "XRst", "XClr"),
        *("Priority", "GetM", "RelM", "Torq", "Prec", "MvTune", "SpdOpt", "Act", "JRC", "Mxt"),
    }
)
"""Commands that leave the variables alone that they are given."""


class Constants:
    """assigned: upper-case names that a statement may change, elements and components too.

    values: those that are set once, before anything else can have happened, or by `Const`.
    """

    def __init__(self, code: Sequence[s.Line | MoveRows]) -> None:
        count: Counter[str] = Counter()
        for item in code:
            if isinstance(item, s.Line) and item.statement is not None:
                count.update(changed(item.statement))
        self.assigned = frozenset(count)
        self.values: dict[str, Value] = {}
        at_start = True
        for item in code:
            statement = item.statement if isinstance(item, s.Line) else None
            if isinstance(statement, s.Const):
                self._take(statement.variable, statement.value, count, at_start)
            if isinstance(item, s.Line) and (item.label is not None or _leads_away(statement)):
                at_start = False
            if at_start and isinstance(statement, s.Assign):
                self._take(statement.target, statement.value, count, True)

    def _take(
        self, variable: s.Variable, node: s.Expression, count: Counter[str], plain: bool
    ) -> None:
        key = variable.key
        if not plain or count[key] != 1 or variable.arguments is not None or variable.component:
            return
        if key[1:2] == "_" or status(key) is not None:  # others may change those
            return
        value = self.value(node)
        if value is not None:
            whole = variable.suffix in ("%", "&") and isinstance(value, float)
            self.values[key] = float(round(value)) if whole else value  # type: ignore[arg-type]

    def value(self, node: s.Expression | None) -> Value | None:
        """What an expression comes to if that is known: literals, constants, their sums."""
        match node:
            case s.Number(value=number):
                return float(number)
            case s.String(value=text):
                return text
            case s.Variable(arguments=None, component=""):
                return self.values.get(node.key)
            case s.Unary(operator=("-" | "+") as sign, operand=operand):
                inner = self.value(operand)
                if not isinstance(inner, float):
                    return None
                return -inner if sign == "-" else inner
            case s.Binary(operator=("+" | "-" | "*") as sign, left=left, right=right):
                one, two = self.value(left), self.value(right)
                if not isinstance(one, float) or not isinstance(two, float):
                    return None
                return one + two if sign == "+" else one - two if sign == "-" else one * two
        return None


def _leads_away(statement: s.Statement | None) -> bool:
    """Whether what stands behind it may run more than once, later, or not at all."""
    if isinstance(statement, s.Jump | s.If | s.OnJump | s.CallP | s.Call | s.Function | s.DefAct):
        return True
    return opened(statement) is not None or isinstance(statement, s.Next | s.OnCom)


def changed(statement: s.Statement) -> Iterator[str]:
    """Upper-case names of the variables that a statement may give a new value."""
    match statement:
        case s.Assign(target=target):
            yield target.key
        case s.For(variable=variable) | s.Const(variable=variable) | s.DefIo(variable=variable):
            yield variable.key
        case s.Input(variables=variables) | s.FPrm(variables=variables):
            yield from (v.key for v in variables)
        case s.Call(function=function):
            yield from _given(function.arguments or ())
        case s.Command(keyword=keyword, arguments=arguments) if keyword not in READING:
            yield from _given(arguments)
        case s.If(then=then, otherwise=otherwise):
            for branch in (then, otherwise):
                if branch is not None and not isinstance(branch, s.Target):
                    yield from changed(branch)
        case s.Motion(append=s.Append(statement=inner)):
            yield from changed(inner)
    for part in nodes(statement):  # a function may change what it is given
        if isinstance(part, s.Variable) and part.arguments and status(part.key) is None:
            yield from _given(part.arguments)


def _given(arguments: Sequence[Any]) -> Iterator[str]:
    return (a.key for a in arguments if isinstance(a, s.Variable) and a.arguments is None)
