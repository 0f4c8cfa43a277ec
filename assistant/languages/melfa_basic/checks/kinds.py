"""Types of values: number, text, position, joints; and the rules that they follow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic.checks import value_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.variables import TYPE_MARKS, TYPES, DataType
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import declarations, literal

Kind = str
"""`M` (a number), `C` (a text), `P` (a position), `J` (joints), `PJ` (one of the last two); empty
where it is not known.
"""

KIND_WORDS: Final[Mapping[Kind, str]] = {
    "M": "a number", "C": "a text", "P": "a position", "J": "joints",
    "PJ": "a position or joints", "JP": "a position or joints", "PM": "a position or a number",
}  # fmt: skip
COMPARISONS: Final = frozenset(("=", "<>", "><", "<", "<=", "=<", ">", ">=", "=>"))
NUMERIC_OPERATORS: Final = frozenset(("AND", "OR", "XOR", "MOD", "\\", "<<", ">>", "^"))


def declared_types(look: Look) -> dict[str, DataType]:
    """Variables by name in upper case → the type that Def gives them; of two the last."""
    found: dict[str, DataType] = {}
    for line in look.lines:
        match line.statement:
            case s.DefIo(variable):
                found[variable.key] = TYPES["Inte"]
            case s.Function(parameters=parameters):
                for parameter in parameters or ():
                    if not parameter.suffix:
                        found.pop(parameter.name.upper(), None)
            case statement:
                typed = declarations(statement)
                found |= {variable.key: TYPES[word] for variable, word in typed if word}
    return found


def kind_of_variable(look: Look, variable: s.Variable) -> Kind:
    """The type of a variable, an array's element, a component or a function's result."""
    key = variable.key
    if variable.component:
        return "M"
    if variable.suffix:
        return TYPE_MARKS[variable.suffix].letter
    if variable.arguments is not None and (function := vocabulary.function(key)) is not None:
        return _certain_kind(function.result)
    if key in look.functions:
        return _kind_of_function(look.functions[key])
    if key.startswith("FN"):
        return _certain_kind(key[2:3])
    if (status := vocabulary.status(key)) is not None:
        return _certain_kind(status.type)
    if (known := look.once(declared_types).get(key)) is not None:
        return known.letter
    if look.has_strangers and (variable.arguments is not None or key[0] not in KIND_WORDS):
        return ""  # a function or a name that a file declares which is not among these
    return key[0] if key[0] in "PJ" or key.startswith("C_") else "M"


def _certain_kind(types: str) -> Kind:
    return types if types in KIND_WORDS else ""


def _kind_of_function(function: s.Function) -> Kind:
    mark = function.suffix or function.result[-1:]
    return (
        TYPE_MARKS[mark].letter
        if mark in TYPE_MARKS
        else _certain_kind(function.result[:1].upper())
    )


def kind_of(look: Look, value: s.Expression | None) -> Kind:
    """The type of a value, empty where it is not known or cannot be."""
    match value:
        case s.Number():
            return "M"
        case s.String():
            return "C"
        case s.Constant(_, flags):
            return "PJ" if flags is None else "P"
        case s.Pallet():
            return "P"
        case s.Variable():
            return kind_of_variable(look, value)
        case s.Unary(_, operand):
            return kind_of(look, operand)
        case s.Binary(operator, left, right):
            return _kind_of_operation(operator, kind_of(look, left), kind_of(look, right))
    return ""


def _kind_of_operation(operator: str, left: Kind, right: Kind) -> Kind:
    if operator in COMPARISONS or operator in NUMERIC_OPERATORS:
        return "M"
    if left == right:
        return left
    of_points = (one for one in "PJ" if {left, right} in ({one, "PJ"}, {one, "M"}))
    return next(of_points, "")


def kind_fits(given: Kind, wanted: str) -> bool:
    """Whether a value of a type may stand where some types are wanted."""
    return not given or not wanted or not set(given).isdisjoint(wanted)


# --------------------------------------------------------------------------------------- rules


def assigned_types(look: Look) -> Found:
    """Values of another type than the variable that they are assigned to."""
    for line, node in look.all(s.Assign):
        yield from _assigned_type(look, line, node.target, node.value)
    for item in look.data:
        if isinstance(item, s.Data) and not item.type:
            yield from _assigned_type(look, item, item.variable, item.value)


def _assigned_type(look: Look, item: s.Item, target: s.Variable, value: s.Expression) -> Found:
    wanted, given = kind_of_variable(look, target), kind_of(look, value)
    if not wanted or not given or kind_fits(given, wanted):
        yield from _integer_range(look, item, target, value)
        return
    if target.key in look.functions or _is_function_result(look, target):
        return
    plain = (
        not target.suffix and not target.component and target.key not in look.once(declared_types)
    )
    if given == "C" and wanted == "M" and plain:
        yield look.at(rules.NO_TEXT_MARK, item, target)
        return
    name = target.marked + (f".{target.component}" if target.component else "")
    said, got = KIND_WORDS[wanted], KIND_WORDS[given]
    yield look.at(rules.ASSIGNED_TYPE, item, target, name=name, wanted=said, given=got)


def _is_function_result(look: Look, target: s.Variable) -> bool:
    return any(
        scope.function and scope.function.name.upper() == target.key for scope in look.scopes
    )


def _integer_range(look: Look, line: s.Item, target: s.Variable, value: s.Expression) -> Found:
    kind = TYPE_MARKS.get(target.suffix) or look.once(declared_types).get(target.key)
    number = literal(value)
    if kind is None or kind.whole is None or number is None or target.component:
        return
    bits = isinstance(value, s.Number) and value.base != 10  # a pattern: &HFFFF fits into 16
    low, high = kind.whole
    if not low <= round(number) <= high and not bits:
        words = {"name": target.marked, "value": f"{number:g}", "wider": kind.wider}
        yield look.at(rules.INTEGER_RANGE, line, target, low=low, high=high, **words)


def operand_types(look: Look) -> Found:
    """Numbers and texts that are added or compared."""
    for line, node in look.all(s.Binary):
        left, right = kind_of(look, node.left), kind_of(look, node.right)
        if left and right and left != right and "C" in (left, right):
            named = next((n for n in (node.left, node.right) if isinstance(n, s.Variable)), None)
            where = (named and look.place(line, named)) or line
            kinds = {"left": KIND_WORDS[left], "right": KIND_WORDS[right]}
            yield look.finding(rules.OPERAND_TYPE, where, operator=node.operator, **kinds)


def type_marks(look: Look) -> Found:
    """Marks that say another type than the declaration."""
    seen: set[str] = set()
    for line, use in look.uses:
        variable = use.variable
        kind, marked = look.once(declared_types).get(variable.key), TYPE_MARKS.get(variable.suffix)
        if kind is None or marked is None or marked == kind or variable.key in seen:
            continue
        if use.role == "declared" or {kind.word, marked.word} <= {"Float", "Double"}:
            continue
        seen.add(variable.key)
        words = {"name": variable.marked, "marked": marked.title, "declared": kind.title}
        yield look.at(rules.SUFFIX, line, variable, **words)


def array_dimensions(look: Look) -> Found:
    """Arrays of one to three dimensions of 1 to 999, and literal subscripts that fit."""
    sizes: dict[str, list[float | None]] = {}
    for line, dim in look.all(s.Dim):
        for variable in dim.variables:
            size = [literal(a) for a in variable.arguments or ()]
            odd = [f"{n:g}" for n in size if n is not None and not 1 <= n <= MOST_ELEMENTS]
            what = "has a dimension of " + " and ".join(odd)
            if not 1 <= len(size) <= MOST_DIMENSIONS:
                what = f"has {len(size)} dimensions"
            elif not odd:
                if None not in size:
                    sizes[variable.key] = size
                continue
            cure = f"use one to {MOST_DIMENSIONS} dimensions of 1 to {MOST_ELEMENTS}"
            yield look.at(rules.DIMENSIONS, line, variable, what=what, cure=cure)
    parameters = {p.name.upper() for f in look.functions.values() for p in f.parameters or ()}
    for line, use in look.uses:
        variable = use.variable
        most = [int(n) for n in sizes.get(variable.key, ()) if n is not None]
        if not most or use.role == "declared" or not variable.arguments:
            continue
        if variable.key in parameters:
            continue
        given = [literal(a) for a in variable.arguments]
        missing = [
            n for n, m in zip(given, most, strict=False) if n is not None and not 1 <= round(n) <= m
        ]
        cure = f"it has the elements 1 to {' by '.join(map(str, most))}"
        if len(given) != len(most):
            what = f"has {len(most)} dimensions, not {len(given)}"
        elif missing:
            what = f"has no element {missing[0]:g}"
        else:
            continue
        yield look.at(rules.DIMENSIONS, line, variable, what=what, cure=cure)


MOST_DIMENSIONS: Final = 3
MOST_ELEMENTS: Final = 999
"""Of a dimension (COSIROP help, DIM)."""
