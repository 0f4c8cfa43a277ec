"""Which variables of a file keep one value that is known, and which are ever assigned."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from assistant.languages.melfa_basic.tables.vocabulary import commands, function, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import block_word
from assistant.languages.melfa_basic.tree.walk import nodes

Value = float | str


INITIAL_STATUS: Final = {"M_NOVRD": 100.0, "M_NJOVRD": 100.0}
"""Status variables that never change: the percentages that hold when a program starts."""


class Constants:
    """assigned: upper-case names that a statement may change, elements and components too.

    values: those that are set once, before anything else can have happened, or by `Const`.
    kept: which arguments the functions and arrays of the file leave alone.
    """

    def __init__(self, code: Sequence[s.Entry]) -> None:
        count: Counter[str] = Counter()
        self.kept = kept = kept_arguments(code)
        for item in code:
            if item.statement is not None:
                count.update(changed_variables(item.statement, kept))
        self.assigned = frozenset(count)
        self.values: dict[str, Value] = {}
        self.placed: dict[str, s.Constant] = {}
        """Positions that are given one constant, before anything else reads them."""
        at_start, read = True, set[str]()
        for item in code:
            statement = item.statement
            if isinstance(statement, s.Const):
                self._take(statement.variable, statement.value, count, at_start)
            at_start = at_start and item.label is None and not _leads_away(statement)
            if at_start and isinstance(statement, s.Assign):
                self._take(statement.target, statement.value, count, True)
                if statement.target.key not in read:
                    self._place(statement, count)
            if at_start and not isinstance(statement, s.DefNames):
                read.update(x.key for x in nodes(statement) if isinstance(x, s.Variable))

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

    def _place(self, node: s.Assign, count: Counter[str]) -> None:
        key, value = node.target.key, node.value
        if count[key] == 1 and node.target.arguments is None and not node.target.component:
            if isinstance(value, s.Constant) and key[1:2] != "_" and status(key) is None:
                self.placed[key] = value

    def value(self, node: s.Expression | None) -> Value | None:
        """What an expression comes to if that is known: literals, constants, their sums."""
        match node:
            case s.Number(value=number):
                return float(number)
            case s.String(value=text):
                return text
            case s.Variable(arguments=None, component=""):
                return INITIAL_STATUS.get(node.key) or self.values.get(node.key)
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
    return bool(block_word(statement).opens) or isinstance(statement, s.Next | s.OnCom)


KeptArguments = Mapping[str, Sequence[bool]]
"""By upper-case name of a function or array, which arguments it leaves alone."""


def kept_arguments(code: Sequence[s.Entry]) -> dict[str, Sequence[bool]]:
    """What is known of the functions and arrays of a file."""
    found: dict[str, Sequence[bool]] = {}
    for item in code:
        match item.statement.definition if isinstance(item.statement, s.Static) else item.statement:
            case s.Function(name=name, parameters=parameters):
                found[name.upper()] = [q.mode == "ByVal" for q in parameters or ()]
            case s.Dim(variables=variables) | s.DefNames(variables=variables):
                found.update({v.key: [True] * len(v.arguments or ()) for v in variables})
            case s.DefFunction(name=name, parameters=variables):
                found[name.upper()] = [True] * len(variables)
    return found


def changed_variables(statement: s.Statement, kept: KeptArguments) -> Iterator[str]:
    """Upper-case names of the variables that a statement may give a new value."""
    for part in nodes(statement):
        match part:
            case s.Assign(target=variable) | s.Const(variable=variable):
                yield variable.key
            case s.For(variable=variable) | s.DefIo(variable=variable):
                yield variable.key
            case s.Input(variables=variables) | s.FPrm(variables=variables):
                yield from (v.key for v in variables)
            case s.Command(keyword, arguments) if keyword not in commands("reads"):
                yield from _changed_arguments(arguments)
            case s.Variable(arguments=tuple(given)) if status(part.key) is None:
                yield from _changed_arguments(
                    given, _unchanged_arguments(part.key, kept)
                )  # a function may change it


def _unchanged_arguments(key: str, kept: KeptArguments) -> Sequence[bool]:
    known = function(key)
    if known is not None and key not in kept:
        last = [not argument.assigned for argument in known.arguments]
        return [*last, *last[-1:] * 16]
    return kept.get(key, ())


def _changed_arguments(arguments: Sequence[Any], kept: Sequence[bool] = ()) -> Iterator[str]:
    """Variables among arguments, but for those that are left alone."""
    for at, argument in enumerate(arguments):
        if isinstance(argument, s.Variable) and not (at < len(kept) and kept[at]):
            yield argument.key
