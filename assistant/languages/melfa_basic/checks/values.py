"""Rules of arguments: how many, of what type, and which values they may have."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Final

from assistant.base.diagnostics import Severity
from assistant.languages.checks.registry import Found, alternatives
from assistant.languages.checks.values import Limits
from assistant.languages.melfa_basic.checks import kinds
from assistant.languages.melfa_basic.checks import value_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import literal

PERCENT: Final = "write a percentage; `Spd` takes mm/s"
HAND: Final = Limits("the number of the hand", 1, 8)
SLOT: Final = Limits("the slot", 1, 32, number=3880)
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
    "XRun": (SLOT,),
    "XLoad": (SLOT,),
    "XStp": (SLOT,),
    "XRst": (SLOT,),
    "XClr": (SLOT,),
    "Priority": (Limits("the priority", 1, 31), SLOT),
    "Clr": (Limits("what `Clr` clears", 0, 3),),
    "MvTune": (Limits("the mode of `MvTune`", 1, 4),),
    "Torq": (Limits("the axis", 1, 8), Limits("the torque", 0, 100)),
    "LoadSet": (Limits("the hand condition", 0, 8), Limits("the work condition", 0, 8)),
}
"""Word of a statement → what its arguments may be, where they are plain numbers."""
DEFINITIONS: Final[dict[str, tuple[Limits | None, ...]]] = {
    "Plt": (
        Limits("the number of the pallet", 1, 8), None, None, None, None, None, None,
        Limits("the direction of the pallet", 1, 13),
    ),
    "Arch": (Limits("the number of the arch", 1, 4),),
}  # fmt: skip
INDICES: Final[dict[str, Limits]] = {
    "M_TIMER": Limits("the number of the timer", 1, 8),
    "M_OPEN": FILE,
}
"""Status variable → what its subscript may be."""


PULSE: Final = Limits("the length of the pulse", 0, inf)
TYPE_NUMBER: Final = Limits("the first number of `Type`", 0, 1)

_Values = Sequence[s.Expression | None]
LIMITED: Final[Mapping[type[Any], Callable[[Any], tuple[Sequence[Limits | None], _Values]]]] = {
    s.Command: lambda node: (COMMANDS.get(node.keyword, ()), node.arguments),
    s.DefOther: lambda node: (DEFINITIONS.get(node.kind, ()), node.arguments),
    s.DefAct: lambda node: ((ACT,), (node.number,)),
    s.Open: lambda node: ((FILE,), (node.number,)),
    s.Print: lambda node: ((FILE,), (node.number,)),
    s.Input: lambda node: ((FILE,), (node.number,)),
    s.Channel: lambda node: ((FILE,), (node.number,)),
    s.Opening: lambda node: ((FILE,), (node.number,)),
    s.Close: lambda node: ((FILE,) * len(node.numbers), node.numbers),
    s.Assign: lambda node: ((PULSE,), (node.delay,)),
    s.Variable: lambda node: ((INDICES.get(node.key),), node.arguments or ()),
    s.Motion: lambda node: ((TYPE_NUMBER,), (node.type or ())[:1]),
}
"""Construct → numbers in it, and what each may be where it is a plain one."""


def argument_ranges(look: Look) -> Found:
    """Plain numbers that an argument cannot be."""
    for construct, limited in LIMITED.items():
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
        words = limits.words(value, RANGE_ERROR)
        yield look.at(rules.OUT_OF_RANGE, line, f"{abs(value):g}", **words)


# ------------------------------------------------------------------------------------ arguments

MOST_PARAMETERS: Final = 16
"""Of CallP and FPrm (COSIROP help)."""
TOO_MANY_ERROR, TOO_FEW_ERROR, RANGE_ERROR = 3120, 4220, 3110
"""Numbers of the controller's errors."""
ARGUMENT_TYPES: Final = {"XLoad": "MC", "XRun": "MC", "Tool": ("PM",), "Base": ("PM",)}
"""Types of arguments that may be more than a number. Where a version has no stored frames, a number
is a finding of what it lacks.
"""
MOVE_POINT_TYPES: Final = {"Mov": ("PJ",), "Mvs": ("P",), "Mva": ("P",)}
"""Word of a move → types of its points; other moves have three positions."""
SPLINES: Final = ("MvSpl", "EMvSpl")
"""They go along a spline that is stored by its number (CR750 manual, appendix 7.3)."""
ORDINALS: Final = ("the first argument", "the second argument", "the third argument", "an argument")


@dataclass(frozen=True, slots=True)
class TakenArguments:
    """What is given where arguments are taken.

    what: the word, or the name that is called. types: of the arguments, as `kinds.fits` wants
    them; further ones are of the type `more`. least, most: how many there may be.
    """

    what: str | s.Variable
    given: Sequence[s.Expression | None]
    least: int = 0
    most: int | None = None
    types: Sequence[str] = ()
    more: str = ""
    too_few: int = TOO_MANY_ERROR

    @property
    def word(self) -> str:
        return self.what if isinstance(self.what, str) else self.what.name


def taken_arguments(look: Look) -> list[tuple[s.Line, TakenArguments]]:
    """Everything in a file that takes arguments."""
    return list(_arguments_taken(look))


def _arguments_taken(look: Look) -> Iterator[tuple[s.Line, TakenArguments]]:
    for line, command in look.all(s.Command):
        word = command.keyword
        row = vocabulary.statement(word)
        types: Sequence[str] = ARGUMENT_TYPES.get(word) or "M" * len(COMMANDS.get(word, ()))
        if row is not None and row.role == "command":
            yield (
                line,
                TakenArguments(
                    word, command.arguments, row.least, row.most, types, "", TOO_FEW_ERROR
                ),
            )
    for line, motion in look.all(s.Motion):
        row = vocabulary.statement(motion.keyword)
        types = MOVE_POINT_TYPES.get(motion.keyword, "PPP")
        if row is not None and motion.keyword not in SPLINES:
            word, given = motion.keyword, motion.arguments
            yield line, TakenArguments(word, given, row.least, row.most, types, "M", TOO_FEW_ERROR)
    for line, call in look.all(s.CallP):
        yield line, TakenArguments("CallP", call.arguments, most=MOST_PARAMETERS)
        yield line, TakenArguments("CallP", (call.program,), types="C")
    for line, opened in look.all(s.Open):
        yield line, TakenArguments("Open", (opened.name,), types="C")
    for line, head in look.all(s.FPrm):
        yield line, TakenArguments("FPrm", head.variables, 1, MOST_PARAMETERS)
    for line, variable in look.all(s.Variable):
        if variable.arguments is None:
            continue
        function, own = _called_function(look, variable), look.functions.get(variable.key)
        if function is not None:
            types = [argument.types for argument in function.arguments]
            least, most = function.least, function.most
            more = types[-1] if types else ""
            yield line, TakenArguments(variable, variable.arguments, least, most, types, more)
        if own is not None:
            wanted = len(own.parameters or ())
            yield line, TakenArguments(variable, variable.arguments, wanted, wanted)


def _called_function(look: Look, variable: s.Variable) -> vocabulary.Function | None:
    """The function of the language that a variable with arguments calls."""
    own = variable.key in look.once(kinds.declared_types) or variable.key in look.functions
    return None if variable.component or own else vocabulary.function(variable.key)


def argument_counts(look: Look) -> Found:
    """Statements and functions with more or fewer arguments than they take."""
    for line, one in look.once(taken_arguments):
        given = len(one.given)
        if given < one.least or (one.most is not None and given > one.most):
            yield look.at(
                rules.ARGUMENT_COUNT,
                line,
                one.what,
                word=one.word,
                wanted=alternatives(one.least, one.most, "argument"),
                given=given,
                number=one.too_few if given < one.least else TOO_MANY_ERROR,
            )


STRANGE_ARGUMENTS: Final[Mapping[type[Any], tuple[vocabulary.Effect, str]]] = {
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
            effect, given = STRANGE_ARGUMENTS.get(type(argument), ("reads", ""))
            if given and (row is None or effect not in row.effects):
                yield look.at(
                    rules.ARGUMENT_TYPE,
                    line,
                    command.keyword,
                    word=command.keyword,
                    which=ORDINALS[min(at, 3)],
                    given=given,
                    wanted="a value",
                )


def argument_types(look: Look) -> Found:
    """Arguments of another type than a statement or function takes."""
    for line, one in look.once(taken_arguments):
        for at, argument in enumerate(one.given):
            given = kinds.kind_of(look, argument)
            wanted = one.types[at] if at < len(one.types) else one.more
            if wanted in kinds.KIND_WORDS and not kinds.kind_fits(given, wanted):
                yield look.at(
                    rules.ARGUMENT_TYPE,
                    line,
                    argument if isinstance(argument, s.Variable) else one.what,
                    word=one.word,
                    which=ORDINALS[min(at, 3)],
                    given=kinds.KIND_WORDS[given],
                    wanted=kinds.KIND_WORDS[wanted],
                )


# --------------------------------------------------------------------------------------- habits

SECONDS: Final = 100
"""A timer is hardly compared with fewer milliseconds than this."""
ANGLES: Final = ("A", "B", "C", "J1", "J2", "J3", "J4", "J5", "J6")
TURN: Final = 6.3
"""A little more than a full turn in radian."""
CIRCULAR: Final = frozenset({"SIN", "COS", "TAN"})


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
                rules.SHORT_WAIT, line, f"{value:g}", value=f"{value:g}", least=least, title=title
            )


def argument_units(look: Look) -> Found:
    """Seconds for a timer, degrees for an angle."""
    for line, node in look.all(s.Binary):
        if node.operator not in kinds.COMPARISONS or node.operator == "=":
            continue
        for side, other in ((node.left, node.right), (node.right, node.left)):
            value = literal(other)
            if _is_variable(side, "M_TIMER") and value is not None and 0 < value < SECONDS:
                words = {"value": f"{value:g}", "better": f"{value * 1000:g}"}
                yield look.at(rules.TIMER, line, "M_Timer", **words)
    for line, variable, what, angle in _angles(look):
        value = literal(angle)
        if value is not None and abs(value) > TURN:
            yield look.at(rules.DEGREES, line, variable, what=what, value=f"{value:g}")


def _angles(look: Look) -> Iterator[tuple[s.Line, s.Variable, str, s.Expression | None]]:
    """What takes an angle in radian: its line and name, how it is told of, and the angle."""
    for line, assign in look.all(s.Assign):
        target = assign.target
        if target.component in ANGLES:
            yield line, target, f"`{target.name}.{target.component}`", assign.value
    for line, variable in look.all(s.Variable):
        if variable.key in CIRCULAR and variable.arguments:
            yield line, variable, f"the angle of `{variable.name}`", variable.arguments[0]


def _is_variable(value: s.Expression, key: str) -> bool:
    return isinstance(value, s.Variable) and value.key == key


# --------------------------------------------------------------------------------------- status


def status_access(look: Look) -> Found:
    """Status variables that are assigned but only read, and the other way round."""
    for line, use in look.uses:
        variable = use.variable
        row = vocabulary.status(variable.key)
        if row is None or variable.key in look.once(kinds.declared_types):
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
            yield look.at(
                rules.READ_ONLY, line, variable, name=row.name, cure=cure, severity=severity
            )
        elif use.role == "read" and not row.readable:
            yield look.at(rules.WRITE_ONLY, line, variable, name=row.name)
