"""Types and values of arguments and positions: their rules and findings.

A type is a letter: `M` (a number), `C` (a text), `P` (a position), `J` (joints). The rules compare
types in assignments, operations and arguments, count arguments, check the range of plain numbers
(angles in expressions are in radian), and find values that are missing: coordinates of positions,
arguments, steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf
from typing import Any, Final, TypeGuard

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Severity, error, info, warning
from assistant.languages.checks.registry import Found, alternatives
from assistant.languages.checks.values import Limits
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.variables import TYPE_MARKS, TYPES, DataType
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.line_tables import split_name
from assistant.languages.melfa_basic.tree.walk import declarations, literal, nodes

_OUT_OF_RANGE: Final = error(
    "MB601", "{what} is {value}, not {range} (controller error {number})", "{cure}"
)
_ARGUMENT_COUNT: Final = error(
    "MB602",
    "`{word}` takes {wanted}, not {given} (controller error {number})",
    "write what it takes",
)
_ARGUMENT_TYPE: Final = error(
    "MB603",
    "{which} of `{word}` is {given}, not {wanted} (controller error 3810)",
    "write {wanted} there",
)
_ASSIGNED_TYPE: Final = error(
    "MB604",
    "`{name}` is {wanted}, but is given {given} (controller error 4390)",
    "assign it {wanted}, or use a variable that takes {given}",
)
_OPERAND_TYPE: Final = error(
    "MB605",
    "`{operator}` joins {left} with {right} (controller error 4390)",
    "convert one of them: `Str$` makes a text of a number, `Val` a number of a text",
)
SUFFIX: Final = warning(
    "MB606",
    "`{name}` has the mark of {marked}, but is declared as {declared} (controller error 4390)",
    "use one of the two everywhere",
)
_READ_ONLY: Final = error("MB607", "`{name}` can only be read (controller error 3210)", "{cure}")
_WRITE_ONLY: Final = warning(
    "MB608",
    "`{name}` cannot be read (controller error 4330)",
    "keep the value in a variable of your own",
)
UNKNOWN_STATUS: Final = warning(
    "MB609", "`{name}` is no status variable of {title}, and nothing declares it", "{cure}"
)
_TIMER: Final = info(
    "MB610",
    "`M_Timer` is compared with {value}: it counts milliseconds",
    "write {better} if seconds are meant",
)
_DEGREES: Final = warning(
    "MB611",
    "{what} is {value}: angles in expressions are in radian",
    "write `Rad({value})` if degrees are meant",
)
_NO_TEXT_MARK: Final = error(
    "MB612",
    "`{name}` is given a text, but has no `$` and no `Def Char` (controller error 4390)",
    "write `{name}$`",
)
_INTEGER_RANGE: Final = error(
    "MB613",
    "{value} does not fit into `{name}`, which holds whole numbers from {low} to {high}",
    "declare it with `Def {wider}`",
)
_DIMENSIONS: Final = error("MB614", "the array `{name}` {what} (controller error 4370)", "{cure}")
_SHORT_WAIT: Final = info(
    "MB619",
    "{title} waits {least:g} seconds at least, not {value}",
    "write a longer time, or leave it out",
)
_GAP: Final = warning(
    "MB616",
    "the position `{name}` leaves out {what}, whose value is undefined then",
    "write every value; 0 is one",
)
UNDEFINED: Final = error(
    "MB622",
    "the position `{name}` has no value for {what}, and is taken as a pose (controller error 2800)",
    "write every value; 0 is one",
)
_LEFT_OUT: Final = error(
    "MB617", "the {which} argument of `{word}` is left out (controller error 3120)", "write it"
)
_EMPTY_STEP: Final = warning(
    "MB618",
    "step {number} holds nothing: a step number alone deletes that step",
    "write a statement or a comment there, or delete the line",
)
_AMONG_STEPS: Final = warning(
    "MB620",
    "`{name}` is given a value by a line without step number between steps",
    "write a step number if it is a statement, else move it behind the last step",
)
MANY_PULSES: Final = error(
    "MB621",
    "more than {most} pulses of outputs begin here at a time",
    "let some end first, with `Dly` between, or set those outputs and set them back",
)


Kind = str
"""`M` (a number), `C` (a text), `P` (a position), `J` (joints), `PJ` (one of the last two); empty
where it is not known.
"""

_KIND_WORDS: Final[Mapping[Kind, str]] = {
    "M": "a number", "C": "a text", "P": "a position", "J": "joints",
    "PJ": "a position or joints", "JP": "a position or joints", "PM": "a position or a number",
}  # fmt: skip
_COMPARISONS: Final = frozenset(("=", "<>", "><", "<", "<=", "=<", ">", ">=", "=>"))
_NUMERIC_OPERATORS: Final = frozenset(("AND", "OR", "XOR", "MOD", "\\", "<<", ">>", "^"))


def _declared_types(look: Look) -> dict[str, DataType]:
    """Variables by name in upper case → the type that Def gives them; of two the last."""
    found: dict[str, DataType] = {}
    for line in look.lines:
        match line.statement:
            case s.DefIo(variable):
                found[variable.key] = TYPES["Inte"]
            # An unmarked parameter hides the variable that `Def` types, so its type is not certain.
            case s.Function(parameters=parameters):
                for parameter in parameters or ():
                    if not parameter.suffix:
                        found.pop(parameter.name.upper(), None)
            case statement:
                typed = declarations(statement)
                found |= {variable.key: TYPES[word] for variable, word in typed if word}
    return found


def _kind_of_variable(look: Look, variable: s.Variable) -> Kind:
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
    if (known := look.once(_declared_types).get(key)) is not None:
        return known.letter
    if look.has_strangers and (variable.arguments is not None or key[0] not in _KIND_WORDS):
        return ""  # a function or a name that a file declares which is not among these
    # Texts need the mark `$`, but external ones begin with `C_`; other first letters are numbers.
    return key[0] if key[0] in "PJ" or key.startswith("C_") else "M"


def _certain_kind(types: str) -> Kind:
    return types if types in _KIND_WORDS else ""


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
            return _kind_of_variable(look, value)
        case s.Unary(_, operand):
            return kind_of(look, operand)
        case s.Binary(operator, left, right):
            return _kind_of_operation(operator, kind_of(look, left), kind_of(look, right))
    return ""


def _kind_of_operation(operator: str, left: Kind, right: Kind) -> Kind:
    if operator in _COMPARISONS or operator in _NUMERIC_OPERATORS:
        return "M"
    if left == right:
        return left
    # A position times a number stays a position; a constant without flags takes the other's type.
    of_points = (one for one in "PJ" if {left, right} in ({one, "PJ"}, {one, "M"}))
    return next(of_points, "")


def _kind_fits(given: Kind, wanted: str) -> bool:
    """True if a value of a type may be used where one of several types is required."""
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
    wanted, given = _kind_of_variable(look, target), kind_of(look, value)
    if not wanted or not given or _kind_fits(given, wanted):
        yield from _integer_range(look, item, target, value)
        return
    # The name of a Function holds its result, which may be of another type than the name shows.
    if target.key in look.functions or _is_function_result(look, target):
        return
    plain = (
        not target.suffix and not target.component and target.key not in look.once(_declared_types)
    )
    if given == "C" and wanted == "M" and plain:
        yield look.at(_NO_TEXT_MARK, item, target)
        return
    name = target.marked + (f".{target.component}" if target.component else "")
    said, got = _KIND_WORDS[wanted], _KIND_WORDS[given]
    yield look.at(_ASSIGNED_TYPE, item, target, name=name, wanted=said, given=got)


def _is_function_result(look: Look, target: s.Variable) -> bool:
    return any(
        scope.function and scope.function.name.upper() == target.key for scope in look.scopes
    )


def _integer_range(look: Look, line: s.Item, target: s.Variable, value: s.Expression) -> Found:
    kind = TYPE_MARKS.get(target.suffix) or look.once(_declared_types).get(target.key)
    number = literal(value)
    if kind is None or kind.whole is None or number is None or target.component:
        return
    bits = isinstance(value, s.Number) and value.base != 10  # a pattern: &HFFFF fits into 16
    low, high = kind.whole
    if not low <= round(number) <= high and not bits:
        words = {"name": target.marked, "value": f"{number:g}", "wider": kind.wider}
        yield look.at(_INTEGER_RANGE, line, target, low=low, high=high, **words)


def operand_types(look: Look) -> Found:
    """Numbers and texts that are added or compared."""
    for line, node in look.all(s.Binary):
        left, right = kind_of(look, node.left), kind_of(look, node.right)
        if left and right and left != right and "C" in (left, right):
            named = next((n for n in (node.left, node.right) if isinstance(n, s.Variable)), None)
            where = (named and look.place(line, named)) or line
            kinds = {"left": _KIND_WORDS[left], "right": _KIND_WORDS[right]}
            yield look.finding(_OPERAND_TYPE, where, operator=node.operator, **kinds)


def type_marks(look: Look) -> Found:
    """Marks that say another type than the declaration."""
    seen: set[str] = set()
    for line, use in look.uses:
        variable = use.variable
        kind, marked = look.once(_declared_types).get(variable.key), TYPE_MARKS.get(variable.suffix)
        if kind is None or marked is None or marked == kind or variable.key in seen:
            continue
        # `Float` and `Double` differ only in precision, which the controller converts.
        if use.role == "declared" or {kind.word, marked.word} <= {"Float", "Double"}:
            continue
        seen.add(variable.key)
        words = {"name": variable.marked, "marked": marked.title, "declared": kind.title}
        yield look.at(SUFFIX, line, variable, **words)


def array_dimensions(look: Look) -> Found:
    """Arrays of one to three dimensions of 1 to 999, and literal subscripts that fit."""
    sizes: dict[str, list[float | None]] = {}
    for line, dim in look.all(s.Dim):
        for variable in dim.variables:
            size = [literal(a) for a in variable.arguments or ()]
            odd = [f"{n:g}" for n in size if n is not None and not 1 <= n <= _MOST_ELEMENTS]
            what = "has a dimension of " + " and ".join(odd)
            if not 1 <= len(size) <= _MOST_DIMENSIONS:
                what = f"has {len(size)} dimensions"
            elif not odd:
                if None not in size:
                    sizes[variable.key] = size
                continue
            cure = f"use one to {_MOST_DIMENSIONS} dimensions of 1 to {_MOST_ELEMENTS}"
            yield look.at(_DIMENSIONS, line, variable, what=what, cure=cure)
    # An array parameter has the size of the caller's array, not of one with that name.
    parameters = {p.name.upper() for f in look.functions.values() for p in f.parameters or ()}
    for line, use in look.uses:
        variable = use.variable
        most = [int(n) for n in sizes.get(variable.key, ()) if n is not None]
        if not most or use.role == "declared" or not variable.arguments:
            continue
        if variable.key in parameters:
            continue
        given = [literal(a) for a in variable.arguments]
        # The controller rounds subscripts before it looks for the element (COSIROP help, DIM).
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
        yield look.at(_DIMENSIONS, line, variable, what=what, cure=cure)


_MOST_DIMENSIONS: Final = 3
_MOST_ELEMENTS: Final = 999
"""Greatest number of elements of a dimension (COSIROP help, DIM)."""


PERCENT: Final = "write a percentage; `Spd` takes mm/s"
HAND: Final = Limits("the number of the hand", 1, 8)
_SLOT: Final = Limits("the slot", 1, 32, number=3880)
FILE: Final = Limits("the file number", 1, 8)
ACT: Final = Limits("the number of the interrupt", 1, 8)

COMMANDS: Final[dict[str, tuple[Limits | None, ...]]] = {
    "Ovrd": (Limits("the override", 0, 100, True, PERCENT),) * 3,
    "JOvrd": (Limits("the joint override", 0, 100, True, PERCENT),),
    "Spd": (Limits("the speed", 0, inf, True, "write mm/s, or `Spd M_NSpd` for the fastest"),),
    "Accel": (Limits("the acceleration", 0, inf, True, "write a percentage"),) * 6,
    "Dly": (Limits("the time", 0, inf, False, "write seconds"),),
    "Cnt": (
        Limits("the first argument of `Cnt`", 0, 1, False, "`Cnt 1` blends, `Cnt 0` does not"),
        Limits("the distance", 0, inf),
        Limits("the distance", 0, inf),
    ),
    "Fine": (Limits("the first argument of `Fine`", 0, inf),),
    "HOpen": (HAND,),
    "HClose": (HAND,),
    "Act": (Limits("the number of the interrupt", 0, 8),),
    "Error": (Limits("the error", 9000, 9299, False, "own errors are 9000 to 9299"),),
    "XRun": (_SLOT,),
    "XLoad": (_SLOT,),
    "XStp": (_SLOT,),
    "XRst": (_SLOT,),
    "XClr": (_SLOT,),
    "Priority": (Limits("the priority", 1, 31), _SLOT),
    "Clr": (Limits("what `Clr` clears", 0, 3),),
    "MvTune": (Limits("the mode of `MvTune`", 1, 4),),
    "Torq": (Limits("the axis", 1, 8), Limits("the torque", 0, 100)),
    "LoadSet": (Limits("the hand condition", 0, 8), Limits("the work condition", 0, 8)),
}
"""Word of a statement → what its arguments may be, where they are plain numbers."""
_DEFINITIONS: Final[dict[str, tuple[Limits | None, ...]]] = {
    "Plt": (
        Limits("the number of the pallet", 1, 8), None, None, None, None, None, None,
        Limits("the direction of the pallet", 1, 13),
    ),
    "Arch": (Limits("the number of the arch", 1, 4),),
}  # fmt: skip
_INDICES: Final[dict[str, Limits]] = {
    "M_TIMER": Limits("the number of the timer", 1, 8),
    "M_OPEN": FILE,
}
"""Status variable → what its subscript may be."""


_PULSE: Final = Limits("the length of the pulse", 0, inf)
_TYPE_NUMBER: Final = Limits("the first number of `Type`", 0, 1)

_Values = Sequence[s.Expression | None]
_LIMITED: Final[Mapping[type[Any], Callable[[Any], tuple[Sequence[Limits | None], _Values]]]] = {
    s.Command: lambda node: (COMMANDS.get(node.keyword, ()), node.arguments),
    s.DefOther: lambda node: (_DEFINITIONS.get(node.kind, ()), node.arguments),
    s.DefAct: lambda node: ((ACT,), (node.number,)),
    s.Open: lambda node: ((FILE,), (node.number,)),
    s.Print: lambda node: ((FILE,), (node.number,)),
    s.Input: lambda node: ((FILE,), (node.number,)),
    s.Channel: lambda node: ((FILE,), (node.number,)),
    s.Opening: lambda node: ((FILE,), (node.number,)),
    s.Close: lambda node: ((FILE,) * len(node.numbers), node.numbers),
    s.Assign: lambda node: ((_PULSE,), (node.delay,)),
    s.Variable: lambda node: ((_INDICES.get(node.key),), node.arguments or ()),
    s.Motion: lambda node: ((_TYPE_NUMBER,), (node.type or ())[:1]),
}
"""Construct → numbers in it, and what each may be where it is a plain one."""


def argument_ranges(look: Look) -> Found:
    """Plain numbers that an argument cannot be."""
    for construct, limited in _LIMITED.items():
        for line, node in look.all(construct):
            for limits, argument in zip(*limited(node), strict=False):
                yield from _in_range(look, line, limits, argument)
    limits = Limits("the second number of `Type`", 0, 2 if look.dialect.singular_type else 1)
    for line, move in look.all(s.Motion):
        yield from _in_range(look, line, limits, move.type[1] if move.type else None)


def _in_range(
    look: Look, line: s.Line, limits: Limits | None, argument: s.Expression | None
) -> Found:
    value = literal(argument)
    if limits is not None and value is not None and not limits.holds(value):
        words = limits.words(value, _RANGE_ERROR)
        yield look.at(_OUT_OF_RANGE, line, f"{abs(value):g}", **words)


# ------------------------------------------------------------------------------------ arguments

_MOST_PARAMETERS: Final = 16
"""Greatest number of parameters of CallP and FPrm (COSIROP help)."""
_TOO_MANY_ERROR, _TOO_FEW_ERROR, _RANGE_ERROR = 3120, 4220, 3110
"""Numbers of the controller's errors."""
_ARGUMENT_TYPES: Final = {"XLoad": "MC", "XRun": "MC", "Tool": ("PM",), "Base": ("PM",)}
"""Types of arguments that may be more than a number. Where a version has no stored frames, a number
is a finding of what it lacks.
"""
_MOVE_POINT_TYPES: Final = {"Mov": ("PJ",), "Mvs": ("P",), "Mva": ("P",)}
"""Word of a move → types of its points; other moves have three positions."""
_SPLINES: Final = ("MvSpl", "EMvSpl")
"""They go along a spline that is stored by its number (CR750 manual, appendix 7.3)."""
_ORDINALS: Final = (
    "the first argument",
    "the second argument",
    "the third argument",
    "an argument",
)


@dataclass(frozen=True, slots=True)
class _TakenArguments:
    """Arguments given to something that takes arguments.

    what: the word, or the name that is called. types: of the arguments, as `_kind_fits` takes them;
    further ones are of the type `more`. least, most: permitted numbers of arguments.
    """

    what: str | s.Variable
    given: Sequence[s.Expression | None]
    least: int = 0
    most: int | None = None
    types: Sequence[str] = ()
    more: str = ""
    too_few: int = _TOO_MANY_ERROR

    @property
    def word(self) -> str:
        return self.what if isinstance(self.what, str) else self.what.name


def _taken_arguments(look: Look) -> list[tuple[s.Line, _TakenArguments]]:
    """Everything in a file that takes arguments."""
    return list(_arguments_taken(look))


def _arguments_taken(look: Look) -> Iterator[tuple[s.Line, _TakenArguments]]:
    for line, command in look.all(s.Command):
        word = command.keyword
        row = vocabulary.statement(word)
        types: Sequence[str] = _ARGUMENT_TYPES.get(word) or "M" * len(COMMANDS.get(word, ()))
        if row is not None and row.role == "command":
            yield (
                line,
                _TakenArguments(
                    word, command.arguments, row.least, row.most, types, "", _TOO_FEW_ERROR
                ),
            )
    for line, motion in look.all(s.Motion):
        row = vocabulary.statement(motion.keyword)
        types = _MOVE_POINT_TYPES.get(motion.keyword, "PPP")
        if row is not None and motion.keyword not in _SPLINES:
            word, given = motion.keyword, motion.arguments
            yield (
                line,
                _TakenArguments(word, given, row.least, row.most, types, "M", _TOO_FEW_ERROR),
            )
    for line, call in look.all(s.CallP):
        yield line, _TakenArguments("CallP", call.arguments, most=_MOST_PARAMETERS)
        yield line, _TakenArguments("CallP", (call.program,), types="C")
    for line, opened in look.all(s.Open):
        yield line, _TakenArguments("Open", (opened.name,), types="C")
    for line, head in look.all(s.FPrm):
        yield line, _TakenArguments("FPrm", head.variables, 1, _MOST_PARAMETERS)
    for line, variable in look.all(s.Variable):
        if variable.arguments is None:
            continue
        function, own = _called_function(look, variable), look.functions.get(variable.key)
        if function is not None:
            types = [argument.types for argument in function.arguments]
            least, most = function.least, function.most
            more = types[-1] if types else ""
            yield line, _TakenArguments(variable, variable.arguments, least, most, types, more)
        if own is not None:
            wanted = len(own.parameters or ())
            yield line, _TakenArguments(variable, variable.arguments, wanted, wanted)


def _called_function(look: Look, variable: s.Variable) -> vocabulary.Function | None:
    """The function of the language that a variable with arguments calls."""
    own = variable.key in look.once(_declared_types) or variable.key in look.functions
    return None if variable.component or own else vocabulary.function(variable.key)


def argument_counts(look: Look) -> Found:
    """Statements and functions with more or fewer arguments than they take."""
    for line, one in look.once(_taken_arguments):
        given = len(one.given)
        if given < one.least or (one.most is not None and given > one.most):
            yield look.at(
                _ARGUMENT_COUNT,
                line,
                one.what,
                word=one.word,
                wanted=alternatives(one.least, one.most, "argument"),
                given=given,
                number=one.too_few if given < one.least else _TOO_MANY_ERROR,
            )


_STRANGE_ARGUMENTS: Final[Mapping[type[Any], tuple[vocabulary.Effect, str]]] = {
    s.Channel: ("lines", "the number of a line"),
    s.Opening: ("lines", "a line that is opened"),
    s.Target: ("labels", "a label"),
}
"""Arguments that only some statements take: the mark of those in the vocabulary, and its words."""


def strange_arguments(look: Look) -> Found:
    """Lines and labels among the arguments of statements that take neither."""
    for line, command in look.all(s.Command):
        row = vocabulary.statement(command.keyword)
        for at, argument in enumerate(command.arguments):
            effect, given = _STRANGE_ARGUMENTS.get(type(argument), ("reads", ""))
            if given and (row is None or effect not in row.effects):
                yield look.at(
                    _ARGUMENT_TYPE,
                    line,
                    command.keyword,
                    word=command.keyword,
                    which=_ORDINALS[min(at, 3)],
                    given=given,
                    wanted="a value",
                )


def argument_types(look: Look) -> Found:
    """Arguments of another type than a statement or function takes."""
    for line, one in look.once(_taken_arguments):
        for at, argument in enumerate(one.given):
            given = kind_of(look, argument)
            wanted = one.types[at] if at < len(one.types) else one.more
            if wanted in _KIND_WORDS and not _kind_fits(given, wanted):
                yield look.at(
                    _ARGUMENT_TYPE,
                    line,
                    argument if isinstance(argument, s.Variable) else one.what,
                    word=one.word,
                    which=_ORDINALS[min(at, 3)],
                    given=_KIND_WORDS[given],
                    wanted=_KIND_WORDS[wanted],
                )


# --------------------------------------------------------------------------------------- habits

_SECONDS: Final = 100
"""A timer is hardly compared with fewer milliseconds than this."""
_ANGLES: Final = ("A", "B", "C", "J1", "J2", "J3", "J4", "J5", "J6")
_TURN: Final = 6.3
"""A little more than a full turn in radian."""
_CIRCULAR: Final = frozenset({"SIN", "COS", "TAN"})


def short_waits(look: Look) -> Found:
    """Times that are shorter than a controller waits."""
    least = look.dialect.shortest_wait
    stated = [(x, c.arguments[:1]) for x, c in look.all(s.Command) if c.keyword == "Dly"]
    stated += [(x, (assign.delay,)) for x, assign in look.all(s.Assign)]
    for line, arguments in stated:
        value = literal(arguments[0]) if arguments else None
        if value is not None and 0 < value < least:
            title = look.dialect.title
            yield look.at(
                _SHORT_WAIT, line, f"{value:g}", value=f"{value:g}", least=least, title=title
            )


def argument_units(look: Look) -> Found:
    """Seconds for a timer, degrees for an angle."""
    for line, node in look.all(s.Binary):
        if node.operator not in _COMPARISONS or node.operator == "=":
            continue
        for side, other in ((node.left, node.right), (node.right, node.left)):
            value = literal(other)
            if _is_variable(side, "M_TIMER") and value is not None and 0 < value < _SECONDS:
                words = {"value": f"{value:g}", "better": f"{value * 1000:g}"}
                yield look.at(_TIMER, line, "M_Timer", **words)
    for line, variable, what, angle in _angles(look):
        value = literal(angle)
        if value is not None and abs(value) > _TURN:
            yield look.at(_DEGREES, line, variable, what=what, value=f"{value:g}")


def _angles(look: Look) -> Iterator[tuple[s.Line, s.Variable, str, s.Expression | None]]:
    """Yield every use of an angle in radian: its line and name, its words in a finding, and the
    angle.
    """
    for line, assign in look.all(s.Assign):
        target = assign.target
        if target.component in _ANGLES:
            yield line, target, f"`{target.name}.{target.component}`", assign.value
    for line, variable in look.all(s.Variable):
        if variable.key in _CIRCULAR and variable.arguments:
            yield line, variable, f"the angle of `{variable.name}`", variable.arguments[0]


def _is_variable(value: s.Expression, key: str) -> bool:
    return isinstance(value, s.Variable) and value.key == key


# --------------------------------------------------------------------------------------- status


def status_access(look: Look) -> Found:
    """Status variables that are assigned but only read, and the other way round."""
    for line, use in look.uses:
        variable = use.variable
        row = vocabulary.status(variable.key)
        if row is None or variable.key in look.once(_declared_types):
            continue
        if use.role == "written" and not row.writable:
            other = variable.key.replace("M_IN", "M_OUT", 1)
            better = vocabulary.status(other)
            cure = "assign another variable"
            if better is not None and better.writable:
                cure = f"outputs are `{better.name}`"
            elif row.setter:
                cure = f"write `{row.setter}`"
            # what the tool lists for reading only, controllers may still let programs set
            sure = bool(row.setter) or variable.key.startswith("M_IN")
            severity = None if sure else Severity.WARNING
            yield look.at(_READ_ONLY, line, variable, name=row.name, cure=cure, severity=severity)
        elif use.role == "read" and not row.readable:
            yield look.at(_WRITE_ONLY, line, variable, name=row.name)


_POSITION_ELEMENTS: Final = ("X", "Y", "Z", "A", "B", "C", "L1", "L2")
_POSE_ELEMENTS: Final = 6
"""Elements that a pose has."""
_LEAST_VALUES: Final = 3
"""Values of a position without flags; fewer are joints."""
_LEFT_OUT_BY_FOUR_AXES: Final = ("A", "B")
"""Components that positions of a horizontal arm may leave out (CR1D 4.3.12)."""
_LEFT_OUT_BY_FIVE_AXES: Final = ("C",)
"""Components that positions of a five-axis arm may leave out."""


def missing_coordinates(look: Look) -> Found:
    """Positions that leave out values; those that leave out all were never taught.

    An error where the program takes them as a pose, which the controller refuses.
    """
    taken = set[tuple[int, str]]()
    for lacking in incomplete_poses(look.tree):
        taken.add((id(lacking.item), lacking.name.upper()))
        yield look.at(UNDEFINED, lacking.item, lacking.word, name=lacking.name, what=lacking.what)
    for item in look.data:
        if not isinstance(item, s.Data) or not isinstance(item.value, s.Constant):
            continue
        values, flags = item.value.values, item.value.flags
        if all(value is None for value in values):
            continue
        left_out = list(
            _missing_elements(item.value) if not item.variable.key.startswith("J") else ()
        )
        if flags is not None and (flags[0] is None) != (flags[1] is None):
            left_out.append("FL1" if flags[0] is None else "FL2")
        if (
            left_out
            and tuple(left_out) != _LEFT_OUT_BY_FOUR_AXES
            and (id(item), item.variable.key) not in taken
        ):
            what = " and ".join(left_out)
            yield look.at(_GAP, item, item.variable, name=item.variable.name, what=what)
    for line, node in look.all(s.Binary):
        for constant in incomplete_summands(node):
            name, what = printer.expression(constant), " and ".join(_missing_elements(constant))
            yield look.at(_GAP, line, name, name=name, what=what)


def _missing_elements(constant: s.Constant) -> tuple[str, ...]:
    """The elements of a pose that a constant leaves out, and additional axes among others."""
    values = constant.values
    short = _POSITION_ELEMENTS[len(values) : _POSE_ELEMENTS]
    return (
        *(name for name, value in zip(_POSITION_ELEMENTS, values, strict=False) if value is None),
        *short,
    )


def _is_undefined(value: object) -> TypeGuard[s.Constant]:
    """True if it is a position constant that the controller does not accept as a pose."""
    if not isinstance(value, s.Constant) or all(one is None for one in value.values):
        return False
    if value.flags is None and len(value.values) < _LEAST_VALUES:
        return False
    found = tuple(
        name for name in _missing_elements(value) if name in _POSITION_ELEMENTS[:_POSE_ELEMENTS]
    )
    return bool(found) and found not in (_LEFT_OUT_BY_FOUR_AXES, _LEFT_OUT_BY_FIVE_AXES)


def incomplete_summands(node: s.Binary) -> Iterator[s.Constant]:
    """Constants of a sum or a difference of positions that leave out values."""
    if node.operator in ("+", "-"):
        yield from (one for one in (node.left, node.right) if _is_undefined(one))


@dataclass(frozen=True, slots=True)
class IncompletePose:
    """A position that is taken as a pose and has elements without a value.

    item: its line, word: what of it; the name is as it is written.
    """

    item: s.Line | s.Data
    word: s.Variable | str
    name: str
    what: str


def incomplete_poses(tree: s.File) -> Iterator[IncompletePose]:
    """Positions of a file that it takes as poses though they leave out elements of one.

    One whose elements the program sets, or that anything else may change, is left aside.
    """
    given: dict[str, tuple[s.Line | s.Data, s.Variable, s.Constant]] = {}
    for item in tree.items:
        if isinstance(item, s.Data) and item.variable.arguments is None:
            if _is_undefined(item.value) and not item.variable.key.startswith("J"):
                given[item.variable.key] = item, item.variable, item.value
    code = [item for item in tree.items if isinstance(item, s.Line) and item.statement is not None]
    # An assignment or a call may fill in what is missing: such positions are not certain.
    changed, copies = set[str](), list[tuple[str, str]]()
    for line in code:
        for node in nodes(line.statement):
            match node:
                case s.Assign(s.Variable(component="") as target, value) if _is_undefined(value):
                    given.setdefault(target.key, (line, target, value))
                case s.Assign(s.Variable(component="", arguments=None) as target, value):
                    if isinstance(value, s.Variable) and not value.component:
                        copies.append((target.key, value.key))
                    else:
                        changed.add(target.key)
                case s.Assign(s.Variable(arguments=None) as target):
                    changed.add(target.key)
                case s.Input() | s.FPrm() | s.CallP() | s.Call() | s.DefOther():
                    changed |= {x.key for x in nodes(node) if isinstance(x, s.Variable)}
    # Pass missing elements on along plain copies. Each round follows at least one copy more, so as
    # many rounds as copies suffice.
    origin = {key: key for key in given if key not in changed}
    for _ in copies:
        found = {to: origin[key] for to, key in copies if key in origin and to not in changed}
        if found.items() <= origin.items():
            break
        origin |= {to: key for to, key in found.items() if to not in origin}
    # Uses as a pose. Of a variable, the place that gave it its value is reported, once.
    said = set[str]()
    for line in code:
        for pose in _poses(line.statement):
            if isinstance(pose, s.Constant) and _is_undefined(pose):
                text = printer.expression(pose)
                yield IncompletePose(line, text, text, _missing_words(pose))
            elif isinstance(pose, s.Variable) and pose.key in origin and not pose.component:
                said.add(origin[pose.key])
    # Moves in columns hold the numbers of their positions instead of nodes.
    for rows in (item for item in tree.items if isinstance(item, MoveRows)):
        for key in origin:
            named = split_name(s.Variable(key))
            if named is not None and named[0].upper() == rows.stem.upper():
                if any(named[1] in column for column in (rows.start, rows.via, rows.end)):
                    said.add(origin[key])
    for key in sorted(said, key=list(given).index):
        item, variable, constant = given[key]
        yield IncompletePose(item, variable, variable.name, _missing_words(constant))


def _missing_words(constant: s.Constant) -> str:
    return " and ".join(
        name for name in _missing_elements(constant) if name in _POSITION_ELEMENTS[:_POSE_ELEMENTS]
    )


def _poses(statement: s.Statement | s.Target | None) -> Iterator[s.Expression | None]:
    """Values that a statement takes as poses."""
    for node in nodes(statement):
        match node:
            case s.Motion(arguments=arguments):
                yield from arguments
            case s.Command("Tool" | "Base", arguments):
                yield from arguments
            case s.Binary("*" | "/", left, right):
                if any(map(_is_position, (left, right))):
                    yield from (left, right)
            case s.Variable(key="INV", arguments=tuple(arguments)):
                yield from arguments


def _is_position(value: s.Expression) -> bool:
    return isinstance(value, s.Constant) or (
        isinstance(value, s.Variable) and value.key.startswith("P") and not value.component
    )


_NEEDED_ARGUMENTS: Final = {"Plt": 3}
"""`Def` of what → arguments behind its number that may not be left out."""


def missing_arguments(look: Look) -> Found:
    """Arguments that only stand after another one, and positions that a definition needs."""
    for line, motion in look.all(s.Motion):
        # `Mvs ,dist` moves along the tool from where the robot is: only there the target may be
        # missing.
        if motion.keyword != "Mvs" and motion.arguments[:1] == (None,):
            yield look.at(_LEFT_OUT, line, motion.keyword, word=motion.keyword, which="first")
    for line, node in look.all(s.DefOther):
        needed = node.arguments[: 1 + _NEEDED_ARGUMENTS.get(node.kind, 0)]
        if None in needed:
            word = f"Def {node.kind}"
            which = ("first", "second", "third", "fourth")[needed.index(None)]
            yield look.at(_LEFT_OUT, line, word, word=word, which=which)
    for line, variable in look.all(s.Variable):
        if variable.arguments == () and vocabulary.status(variable.name) is not None:
            name = variable.name
            yield look.at(_LEFT_OUT, line, variable, word=name, which="first")


def misplaced_lines(look: Look) -> Found:
    """Steps that hold nothing, and what looks like a variable line between steps."""
    for item in before_last_step(look):
        match item:
            case s.Line(number=int(), label=None, statement=None, comment=None):
                yield look.finding(_EMPTY_STEP, item, number=item.number)
            case s.Data(type=""):
                yield look.at(_AMONG_STEPS, item, item.variable)


def before_last_step(look: Look) -> Sequence[s.Item]:
    """The lines up to the last step."""
    code = [at for at, item in enumerate(look.tree.items) if _is_step(look, item)]
    return look.tree.items[: code[-1] + 1] if code else ()


def _is_step(look: Look, item: s.Item) -> bool:
    """True if an item is code; a damaged line without a number may be a variable line."""
    sure = look.damage is None
    return isinstance(item, MoveRows) or (
        isinstance(item, s.Line) and (sure or item.number is not None)
    )
