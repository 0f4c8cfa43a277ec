"""What the procedures of a file are called, what they take and what they give back."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, cast

from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.structure.regions import Region
from assistant.languages.melfa_basic.lift.structure.scopes import (
    LETTER_TYPES,
    Scope,
    letter_type,
    scope_of,
)
from assistant.languages.melfa_basic.lift.values.constants import changed_variables
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import Inside, Routine, Symbols, Unliftable
from assistant.languages.melfa_basic.tables.variables import MARK_VALUE_TYPES
from assistant.languages.melfa_basic.text import effects, printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program import statements as p
from assistant.program.program import (
    Declaration,
    Parameter,
    Procedure,
    TakenNames,
    ValueType,
    Variable,
    identifier,
)

EXIT_FUNCTION: Final = s.Command("Exit Function")


def routine_of(code: Code, region: Region, name: str, symbols: Symbols) -> Routine:
    """What a function is. Parameters of several extents, or changed in an unknown way, are None."""
    function = region.function
    assert function is not None
    kept = symbols.constants.kept
    assigned = {
        key
        for item in code[region.low : region.high]
        if item.statement is not None
        for key in changed_variables(item.statement, kept)
    }
    parameters: list[Parameter] = []
    extents = _subscript_counts(code[region.low : region.high])
    for given in function.parameters or ():
        key = given.name.upper()
        whole = extents.get(key, set()) <= {1}  # no other number of subscripts than one
        if (not given.mode and key in assigned) or (given.array and not whole):
            return Routine(name, result_type(function, symbols), None)
        mode: Any = "inout" if given.mode == "ByRef" else "in"
        known = symbols.header.variables.get(key) if symbols.own else None
        kind = known.type if known else MARK_VALUE_TYPES.get(given.suffix, letter_type(key))
        spelled = known.name if known else given.name
        parameters.append(Parameter(spelled, kind, mode, int(given.array)))
    return Routine(name, result_type(function, symbols), tuple(parameters))


def _subscript_counts(code: Code) -> dict[str, set[int]]:
    """Numbers of subscripts that names stand with, in upper case."""
    found: dict[str, set[int]] = {}
    for item in code:
        for part in nodes(item.statement):
            if isinstance(part, s.Variable) and part.arguments is not None:
                found.setdefault(part.key, set()).add(len(part.arguments))
    return found


def result_type(function: s.Function, symbols: Symbols) -> ValueType | None:
    """The type of a function's result, None for none."""
    written = function.result.upper()
    if written in ("", "V"):
        return None
    stated = symbols.header.names["result"].get(function.name.upper()) if symbols.own else None
    if stated in ("truth", "integer", "pose"):
        return cast(ValueType, stated)
    return MARK_VALUE_TYPES.get(written[-1], LETTER_TYPES.get(written[0], "number"))


def inside_function(
    code: Code, region: Region, routine: Routine, symbols: Symbols, globals_: Scope
) -> tuple[Inside, dict[str, Variable]]:
    """A function's own names, and the variables that it declares."""
    function = region.function
    assert function is not None
    key = function.name.upper()
    inside = Inside(key, {}, {}, {})
    local: dict[str, Variable] = {}
    if symbols.own:
        return inside, {}
    for parameter in routine.parameters or ():
        inside.names[parameter.name.upper()] = parameter.name
        inside.types[parameter.name.upper()] = parameter.type
        inside.sizes[parameter.name.upper()] = (0,) * parameter.dimensions
    scope = scope_of(code[region.low : region.high], (*symbols.routines, key))
    taken = TakenNames(inside.names)
    defined = _declared_keys(code[region.low : region.high])
    for name_key, written in scope.names.items():
        declared = name_key in scope.types and name_key in defined
        known = name_key in globals_.names or symbols.positions.constant(written) is not None
        if name_key in inside.names or name_key[1:2] == "_" or (known and not declared):
            continue
        if name_key in symbols.io:
            continue
        name = identifier(written, taken)
        kind = scope.types.get(name_key, letter_type(name_key))
        size = scope.sizes.get(name_key, ())
        if name_key in scope.static:  # outlives the function
            name = symbols.static(routine.name, name_key, name)
            symbols.variables.setdefault(name, Variable(kind, None, size))
        else:
            local[name] = Variable(kind, None, size)
        taken.add(name)
        inside.names[name_key], inside.types[name_key] = name, kind
        inside.sizes[name_key] = size
    if routine.result is not None and not _returns_directly(code, region, key):
        inside.result = identifier("result", taken | {n.upper() for n in symbols.spelling})
        local[inside.result] = Variable(routine.result)
    return inside, local


def _declared_keys(code: Code) -> set[str]:
    """Variables that some lines declare, in upper case."""
    found: set[str] = set()
    for item in code:
        statement = item.statement
        if isinstance(statement, s.Static):
            statement = statement.definition
        if isinstance(statement, s.DefNames | s.Dim):
            found.update(v.key for v in statement.variables)
    return found


def _returns_directly(code: Code, region: Region, key: str) -> bool:
    """Whether each result is given right before the function is left, so that it is `return`."""
    left: set[int] = set()
    for at in range(region.low, region.high):
        statement = code[at].statement
        if statement is None:
            continue
        if isinstance(statement, s.Assign) and _is_result(statement.target, key):
            following = code[at + 1]
            if not isinstance(following, s.Line) or following.label is not None:
                return False
            if following.statement != EXIT_FUNCTION and at + 1 != region.high:
                return False
            left.add(at + 1)
            statement = s.Command("Hlt", (statement.value,))
        elif statement == EXIT_FUNCTION and at not in left:
            return False
        for part in nodes(statement):
            if isinstance(part, s.Variable) and _is_result(part, key):
                return False
            if part == EXIT_FUNCTION and part is not statement:
                return False
    return region.high in left  # else it may end without one, and gives back what it began with


def _is_result(variable: s.Variable, key: str) -> bool:
    return variable.key == key and variable.arguments is None


def defined_functions(code: Code, symbols: Symbols, taken: TakenNames) -> list[Procedure]:
    """Functions of one expression (`Def FN`) as procedures; those that can be said get routines.

    taken: names of procedures, to which theirs are added.
    """
    made = []
    for item in code:
        node = item.statement
        if not isinstance(node, s.DefFunction) or node.name.upper() in symbols.routines:
            continue
        name = identifier(node.name, taken)
        key = node.name.upper()
        kind = MARK_VALUE_TYPES.get(node.suffix, LETTER_TYPES.get(key[2:3], "number"))
        parameters = tuple(
            Parameter(v.name, MARK_VALUE_TYPES.get(v.suffix, letter_type(v.key)))
            for v in node.parameters
        )
        names = {q.name.upper(): q.name for q in parameters}
        symbols.inside = Inside(key, names, {q.name.upper(): q.type for q in parameters}, {})
        try:
            value = Expressions(symbols).number(node.value)
        except Unliftable:
            continue
        finally:
            symbols.inside = None
        body = (p.Return(value, span=item.span),)
        made.append(Procedure(name, body, parameters, result=kind, span=item.span))
        symbols.routines[key] = Routine(name, kind, parameters)
        taken.add(name)
    return made


def function_text(code: Code, region: Region, dialect: str) -> Declaration:
    """A whole function as its text."""
    upper = dialect.endswith("-4")
    items = code[region.low - 1 : region.high + 1]
    text = "\n".join(
        printer.line(replace(item, number=None), upper)
        for item in items
        if isinstance(item, s.Line)
    )
    return Declaration(dialect, text, effect=effects.of_text(text, "declaration"))
