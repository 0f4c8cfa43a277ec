"""Rules of arguments: how many, of what type, and which values they may have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Final

from assistant.languages.melfa_basic.checks import kinds
from assistant.languages.melfa_basic.checks import value_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.checks.kinds import literal
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.diagnostics import Diagnostic, Severity

Found = Iterator[Diagnostic]


@dataclass(frozen=True, slots=True)
class Limits:
    """What a literal number may be. number: of the controller's error. above: low is too low."""

    what: str
    low: float
    high: float
    above: bool = False
    cure: str = ""
    number: int = 3110

    def holds(self, value: float) -> bool:
        return self.low <= value <= self.high and not (self.above and value == self.low)

    @property
    def range(self) -> str:
        if self.high == inf:
            return f"above {self.low:g}" if self.above else f"{self.low:g} or more"
        begin = f"above {self.low:g} and at most" if self.above else f"{self.low:g} to"
        return f"{begin} {self.high:g}"


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


def ranges(look: Look) -> Found:
    """Plain numbers that an argument cannot be."""
    for line, command in look.all(s.Command):
        yield from _in(look, line, COMMANDS.get(command.keyword, ()), command.arguments)
    for line, node in look.all(s.DefOther):
        yield from _in(look, line, DEFINITIONS.get(node.kind, ()), node.arguments)
    for line, act in look.all(s.DefAct):
        yield from _in(look, line, (ACT,), (act.number,))
    for line, opened in look.all(s.Open):
        yield from _in(look, line, (FILE,), (opened.number,))
    for line, printed in look.all(s.Print):
        yield from _in(look, line, (FILE,), (printed.number,))
    for line, read in look.all(s.Input):
        yield from _in(look, line, (FILE,), (read.number,))
    for line, closed in look.all(s.Close):
        yield from _in(look, line, (FILE,) * len(closed.numbers), closed.numbers)
    for line, assign in look.all(s.Assign):
        delay = Limits("the length of the pulse", 0, inf)
        yield from _in(look, line, (delay,), (assign.delay,))
    for line, variable in look.all(s.Variable):
        limits = INDICES.get(variable.key)
        if limits is not None:
            yield from _in(look, line, (limits,), variable.arguments or ())
    for line, move in look.all(s.Motion):
        limits_of = (
            Limits("the first number of `Type`", 0, 1),
            Limits("the second number of `Type`", 0, 2 if look.dialect.singular_type else 1),
        )
        yield from _in(look, line, limits_of, move.type or ())


def _in(
    look: Look,
    line: s.Line,
    limits: Sequence[Limits | None],
    arguments: Sequence[s.Expression | None],
) -> Found:
    for one, argument in zip(limits, arguments, strict=False):
        value = literal(argument)
        if one is not None and value is not None and not one.holds(value):
            text = f"{abs(value):g}"
            yield look.at(
                rules.OUT_OF_RANGE,
                line,
                text,
                what=one.what,
                value=f"{value:g}",
                range=one.range,
                number=one.number,
                cure=one.cure or f"write {one.range}",
            )


# --------------------------------------------------------------------------------------- counts


def counts(look: Look) -> Found:
    """Statements and functions with more or fewer arguments than they take."""
    for line, command in look.all(s.Command):
        row = vocabulary.statement(command.keyword)
        if row is not None and row.role == "command":
            given = len(command.arguments)
            yield from _count(look, line, command.keyword, row.least, row.most, given)
    for line, motion in look.all(s.Motion):
        row = vocabulary.statement(motion.keyword)
        if row is not None:
            given = len(motion.arguments)
            yield from _count(look, line, motion.keyword, row.least, row.most, given)
    for line, call in look.all(s.CallP):
        yield from _count(look, line, "CallP", 0, MOST_PARAMETERS, len(call.arguments), 3120)
    for line, head in look.all(s.FPrm):
        yield from _count(look, line, "FPrm", 1, MOST_PARAMETERS, len(head.variables), 3120)
    for line, variable in look.all(s.Variable):
        function = _function(look, variable)
        if function is not None and variable.arguments is not None:
            given = len(variable.arguments)
            yield from _count(look, line, variable, function.least, function.most, given, 3120)
        own = look.functions.get(variable.key)
        if own is not None and variable.arguments is not None:
            wanted = len(own.parameters or ())
            given = len(variable.arguments)
            yield from _count(look, line, variable, wanted, wanted, given, 3120)


MOST_PARAMETERS: Final = 16
"""Of CallP and FPrm (COSIROP help)."""


def _function(look: Look, variable: s.Variable) -> vocabulary.Function | None:
    """The function of the language that a variable with arguments calls."""
    if variable.arguments is None or variable.component:
        return None
    if variable.key in look.once(kinds.declared) or variable.key in look.functions:
        return None
    return vocabulary.function(variable.key)


def _count(
    look: Look,
    line: s.Line,
    what: str | s.Variable,
    least: int,
    most: int | None,
    given: int,
    number: int = 0,
) -> Found:
    if given < least or (most is not None and given > most):
        if most is None:
            wanted = f"{least} arguments or more"
        elif least == most:
            wanted = f"{least or 'no'} argument" + "s" * (least != 1)
        else:
            wanted = f"{least} to {most} arguments"
        code = number or (4220 if given < least else 3120)
        word = what if isinstance(what, str) else what.name
        yield look.at(
            rules.ARGUMENT_COUNT, line, what, word=word, wanted=wanted, given=given, number=code
        )


# ---------------------------------------------------------------------------------------- types

PLACES: Final = ("Tool", "Base")
ORDER: Final = ("the first argument", "the second argument", "the third argument", "an argument")
TEXTS: Final = {"XLoad": 1, "XRun": 1}
"""Word of a statement → which of its arguments is a program's name."""


def types(look: Look) -> Found:
    """Arguments of another type than a statement or function takes."""
    for line, variable in look.all(s.Variable):
        function = _function(look, variable)
        if function is not None:
            for at, argument in enumerate(variable.arguments or ()):
                wanted = function.arguments[min(at, len(function.arguments) - 1)].types
                yield from _type(look, line, variable, at, argument, wanted)
    for line, motion in look.all(s.Motion):
        points = 1 if motion.keyword in ("Mov", "Mvs", "Mva") else 3
        wanted = "PJ" if motion.keyword == "Mov" else "P"
        for at, argument in enumerate(motion.arguments[:points]):
            yield from _type(look, line, motion.keyword, at, argument, wanted)
        for at, argument in enumerate(motion.arguments[points:], points):
            yield from _type(look, line, motion.keyword, at, argument, "M")
    for line, command in look.all(s.Command):
        word = command.keyword
        if word in PLACES and command.arguments:
            # where a version has no stored ones, a number is a finding of what it lacks
            yield from _type(look, line, word, 0, command.arguments[0], "PM")
        for at, argument in enumerate(command.arguments):
            if word in COMMANDS and at < len(COMMANDS[word]):
                yield from _type(look, line, word, at, argument, "M")
            elif TEXTS.get(word) == at:
                yield from _type(look, line, word, at, argument, "C")
    for line, call in look.all(s.CallP):
        yield from _type(look, line, "CallP", 0, call.program, "C")
    for line, opened in look.all(s.Open):
        yield from _type(look, line, "Open", 0, opened.name, "C")


def _type(
    look: Look,
    line: s.Line,
    what: str | s.Variable,
    at: int,
    argument: s.Expression | None,
    wanted: str,
) -> Found:
    given = kinds.of(look, argument)
    if wanted == "PM":
        fitting, said = not given or given in ("P", "PJ", "M"), "a position or a number"
    else:
        fitting, said = kinds.fits(given, wanted), kinds.SPOKEN.get(wanted, "")
    if not fitting and said:
        yield look.at(
            rules.ARGUMENT_TYPE,
            line,
            argument if isinstance(argument, s.Variable) else what,
            word=what if isinstance(what, str) else what.name,
            which=ORDER[min(at, 3)],
            given=kinds.SPOKEN[given],
            wanted=said,
        )


# --------------------------------------------------------------------------------------- habits

SECONDS: Final = 100
"""A timer is hardly compared with fewer milliseconds than this."""
ANGLES: Final = ("A", "B", "C", "J1", "J2", "J3", "J4", "J5", "J6")
TURN: Final = 6.3
"""A little more than a full turn in radian."""
CIRCULAR: Final = frozenset({"SIN", "COS", "TAN"})


def waits(look: Look) -> Found:
    """Times that are shorter than a controller waits."""
    least = look.dialect.shortest_wait
    for line, command in look.all(s.Command):
        value = literal(command.arguments[0]) if command.arguments else None
        if command.keyword == "Dly" and value is not None and 0 < value < least:
            title = look.dialect.title
            yield look.at(
                rules.SHORT_WAIT, line, f"{value:g}", value=f"{value:g}", least=least, title=title
            )


def units(look: Look) -> Found:
    """Seconds for a timer, degrees for an angle."""
    for line, node in look.all(s.Binary):
        if node.operator not in kinds.COMPARISONS or node.operator == "=":
            continue
        for side, other in ((node.left, node.right), (node.right, node.left)):
            value = literal(other)
            if _is(side, "M_TIMER") and value is not None and 0 < value < SECONDS:
                yield look.at(
                    rules.TIMER,
                    line,
                    "M_Timer",
                    value=f"{value:g}",
                    better=f"{value * 1000:g}",
                )
    for line, assign in look.all(s.Assign):
        angle, value = assign.target.component in ANGLES, literal(assign.value)
        if angle and value is not None and abs(value) > TURN:
            what = f"`{assign.target.name}.{assign.target.component}`"
            yield look.at(rules.DEGREES, line, assign.target, what=what, value=f"{value:g}")
    for line, variable in look.all(s.Variable):
        if variable.key in CIRCULAR and variable.arguments:
            value = literal(variable.arguments[0])
            if value is not None and abs(value) > TURN:
                what = f"the angle of `{variable.name}`"
                yield look.at(rules.DEGREES, line, variable, what=what, value=f"{value:g}")


def _is(value: s.Expression, key: str) -> bool:
    return isinstance(value, s.Variable) and value.key == key


# --------------------------------------------------------------------------------------- status


def status(look: Look) -> Found:
    """Status variables that are assigned but only read, and the other way round."""
    for line, use in look.uses:
        variable = use.variable
        row = vocabulary.status(variable.key)
        if row is None or variable.key in look.once(kinds.declared):
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
