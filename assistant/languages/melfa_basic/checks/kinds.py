"""Types of values: number, text, position, joints; and the rules that they follow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic.checks import value_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s

Kind = Literal["M", "C", "P", "J", "PJ", ""]
"""A number, a text, a position, joints; either of the last two; not known."""

SPOKEN: Final[Mapping[str, str]] = {
    "M": "a number", "C": "a text", "P": "a position", "J": "joints",
    "PJ": "a position or joints", "JP": "a position or joints", "PM": "a position or a number",
}  # fmt: skip
DECLARED: Final[Mapping[str, Kind]] = {
    "Inte": "M", "Long": "M", "Float": "M", "Double": "M", "Char": "C", "Pos": "P", "Jnt": "J",
    "Work": "P",
}  # fmt: skip
MARKS: Final[Mapping[str, str]] = {
    "$": "Char",
    "%": "Inte",
    "&": "Long",
    "!": "Float",
    "#": "Double",
}
NUMBERS: Final = {
    "Inte": "16-bit integers", "Long": "32-bit integers", "Float": "single precision",
    "Double": "double precision", "Char": "a text", "Pos": "a position", "Jnt": "joints",
    "Work": "a work coordinate",
}  # fmt: skip
RANGES: Final = {
    "Inte": (-(2**15), 2**15 - 1, "Def Long"),
    "Long": (-(2**31), 2**31 - 1, "Def Double"),
}
"""Type → least and greatest whole number, and the type that reaches further."""
COMPARISONS: Final = frozenset(("=", "<>", "><", "<", "<=", "=<", ">", ">=", "=>"))
NUMERIC: Final = frozenset(("AND", "OR", "XOR", "MOD", "\\", "<<", ">>", "^"))


def declared(look: Look) -> dict[str, str]:
    """Variables by name in upper case → the type that Def gives them; of two the last."""
    found: dict[str, str] = {}
    for line in look.lines:
        definition = line.statement
        if isinstance(definition, s.Static):
            definition = definition.definition
        if isinstance(definition, s.DefNames):
            found |= {variable.key: definition.type for variable in definition.variables}
        elif isinstance(definition, s.DefIo):
            found[definition.variable.key] = "Inte"
        elif isinstance(definition, s.Const):
            found[definition.variable.key] = definition.type or _const(definition)
        elif isinstance(definition, s.Function):
            for parameter in definition.parameters or ():
                if not parameter.suffix:
                    found.pop(parameter.name.upper(), None)
    return {name: kind for name, kind in found.items() if kind}


def _const(definition: s.Const) -> str:
    return "Char" if isinstance(definition.value, s.String) else ""


def of_variable(look: Look, variable: s.Variable) -> Kind:
    """The type of a variable, an array's element, a component or a function's result."""
    key = variable.key
    if variable.component:
        return "M"
    if variable.suffix:
        return "C" if variable.suffix == "$" else "M"
    if variable.arguments is not None and (function := vocabulary.function(key)) is not None:
        return _kind(function.result)
    if key.startswith("FN") and key not in look.functions:
        return {"M": "M", "C": "C", "P": "P", "J": "J"}.get(key[2:3], "")  # type: ignore[return-value]
    if key in look.functions:
        return _of_function(look.functions[key])
    status = vocabulary.status(key)
    if status is not None:
        return _kind(status.type)
    known = look.once(declared).get(key)
    if known is not None:
        return DECLARED.get(known, "")
    if key[0] in "PJ":
        return "P" if key[0] == "P" else "J"
    if key[0] == "C" and key[1:2] == "_":
        return "C"
    return "M"


def _kind(types: str) -> Kind:
    return {"M": "M", "C": "C", "P": "P", "J": "J", "PJ": "PJ"}.get(types, "")  # type: ignore[return-value]


def _of_function(function: s.Function) -> Kind:
    if function.suffix:
        return "C" if function.suffix == "$" else "M"
    result = function.result.upper()
    if not result:
        return ""
    if result.endswith("$"):
        return "C"
    return _kind(result[0])


def of(look: Look, value: s.Expression | None) -> Kind:
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
            return of_variable(look, value)
        case s.Unary(_, operand):
            return of(look, operand)
        case s.Binary(operator, left, right):
            return _joined(operator, of(look, left), of(look, right))
    return ""


def _joined(operator: str, left: Kind, right: Kind) -> Kind:
    if operator in COMPARISONS or operator in NUMERIC:
        return "M"
    if left == right:
        return left
    if {left, right} == {"P", "PJ"} or {left, right} == {"P", "M"}:
        return "P"
    if {left, right} == {"J", "PJ"} or {left, right} == {"J", "M"}:
        return "J"
    return ""


def fits(given: Kind, wanted: str) -> bool:
    """Whether a value of a type may stand where some types are wanted."""
    return not given or not wanted or any(letter in wanted for letter in given)


# --------------------------------------------------------------------------------------- rules


def assignments(look: Look) -> Found:
    """Values of another type than the variable that they are assigned to."""
    for line, node in look.all(s.Assign):
        yield from _assigned(look, line, node.target, node.value)
    for item in look.data:
        if isinstance(item, s.Data) and not item.type:
            yield from _assigned(look, item, item.variable, item.value)


def _assigned(look: Look, item: s.Item, target: s.Variable, value: s.Expression) -> Found:
    wanted, given = of_variable(look, target), of(look, value)
    if not wanted or not given or fits(given, wanted):
        yield from _range(look, item, target, value)
        return
    if target.key in look.functions or _is_function_result(look, target):
        return
    plain = not target.suffix and not target.component and target.key not in look.once(declared)
    if given == "C" and wanted == "M" and plain:
        yield look.at(rules.NO_TEXT_MARK, item, target, name=target.name)
        return
    name = target.name + target.suffix + (f".{target.component}" if target.component else "")
    said, got = SPOKEN[wanted], SPOKEN[given]
    yield look.at(rules.ASSIGNED_TYPE, item, target, name=name, wanted=said, given=got)


def _is_function_result(look: Look, target: s.Variable) -> bool:
    return any(
        scope.function and scope.function.name.upper() == target.key for scope in look.scopes
    )


def _range(look: Look, line: s.Item, target: s.Variable, value: s.Expression) -> Found:
    kind = MARKS.get(target.suffix) or look.once(declared).get(target.key, "")
    number = literal(value)
    if kind not in RANGES or number is None or target.component:
        return
    low, high, wider = RANGES[kind]
    if not low <= round(number) <= high and not _is_hex(value):
        name = target.name + target.suffix
        yield look.at(
            rules.INTEGER_RANGE,
            line,
            target,
            name=name,
            value=f"{number:g}",
            low=low,
            high=high,
            wider=wider,
        )


def _is_hex(value: s.Expression) -> bool:
    """Hexadecimal and binary numbers are patterns of bits: &HFFFF fits into 16."""
    return isinstance(value, s.Number) and value.base != 10


def literal(value: s.Expression | None) -> float | None:
    """The number that an expression is, None if it is no plain number."""
    match value:
        case s.Number(number):
            return number
        case s.Unary("-", s.Number(number)):
            return -number
        case s.Unary("+", s.Number(number)):
            return number
    return None


def operands(look: Look) -> Found:
    """Numbers and texts that are added or compared."""
    for line, node in look.all(s.Binary):
        left, right = of(look, node.left), of(look, node.right)
        if {left, right} == {"M", "C"} or (
            {"C"} & {left, right} and left and right and left != right
        ):
            named = next((n for n in (node.left, node.right) if isinstance(n, s.Variable)), None)
            yield look.finding(
                rules.OPERAND_TYPE,
                (named and look.place(line, named)) or line,
                operator=node.operator,
                left=SPOKEN[left],
                right=SPOKEN[right],
            )


def suffixes(look: Look) -> Found:
    """Marks that say another type than the declaration."""
    seen: set[str] = set()
    kinds = look.once(declared)
    for line, use in look.uses:
        variable = use.variable
        kind, marked = kinds.get(variable.key), MARKS.get(variable.suffix)
        if kind is None or marked is None or marked == kind or variable.key in seen:
            continue
        if use.role == "declared" or {kind, marked} <= {"Float", "Double"}:
            continue
        seen.add(variable.key)
        name = variable.name + variable.suffix
        yield look.at(
            rules.SUFFIX,
            line,
            variable,
            name=name,
            marked=NUMBERS[marked],
            declared=NUMBERS[kind],
        )


def dimensions(look: Look) -> Found:
    """Arrays of one to three dimensions of 1 to 999, and literal subscripts that fit."""
    sizes: dict[str, tuple[int, ...]] = {}
    for line, dim in look.all(s.Dim):
        for variable in dim.variables:
            bounds = [literal(a) for a in variable.arguments or ()]
            what = ""
            if not 1 <= len(bounds) <= MOST_DIMENSIONS:
                what = f"has {len(bounds)} dimensions"
            elif any(b is not None and not 1 <= b <= MOST_ELEMENTS for b in bounds):
                what = "has a dimension of " + " and ".join(
                    f"{b:g}" for b in bounds if b is not None and not 1 <= b <= MOST_ELEMENTS
                )
            elif all(b is not None for b in bounds):
                sizes[variable.key] = tuple(int(b) for b in bounds if b is not None)
            if what:
                cure = f"use one to {MOST_DIMENSIONS} dimensions of 1 to {MOST_ELEMENTS}"
                yield look.at(
                    rules.DIMENSIONS, line, variable, name=variable.name, what=what, cure=cure
                )
    parameters = {p.name.upper() for f in look.functions.values() for p in f.parameters or ()}
    for line, use in look.uses:
        variable = use.variable
        size = sizes.get(variable.key)
        if size is None or use.role == "declared" or not variable.arguments:
            continue
        if variable.key in parameters:
            continue
        given = [literal(a) for a in variable.arguments]
        what = ""
        if len(given) != len(size):
            what = f"has {len(size)} dimensions, not {len(given)}"
        elif bad := [
            g for g, n in zip(given, size, strict=True) if g is not None and not 1 <= round(g) <= n
        ]:
            what = f"has no element {bad[0]:g}"
        if what:
            cure = f"it has the elements 1 to {' by '.join(map(str, size))}"
            yield look.at(
                rules.DIMENSIONS, line, variable, name=variable.name, what=what, cure=cure
            )


MOST_DIMENSIONS: Final = 3
MOST_ELEMENTS: Final = 999
"""Of a dimension (COSIROP help, DIM)."""
