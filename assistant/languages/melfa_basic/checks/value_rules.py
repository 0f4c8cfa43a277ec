"""The findings of types and of the values of arguments."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Rule, Severity

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

OUT_OF_RANGE: Final = Rule(
    "MB601", ERROR, "{what} is {value}, not {range} (controller error {number})", "{cure}"
)
ARGUMENT_COUNT: Final = Rule(
    "MB602",
    ERROR,
    "`{word}` takes {wanted}, not {given} (controller error {number})",
    "write what it takes",
)
ARGUMENT_TYPE: Final = Rule(
    "MB603",
    ERROR,
    "{which} of `{word}` is {given}, not {wanted} (controller error 3810)",
    "write {wanted} there",
)
ASSIGNED_TYPE: Final = Rule(
    "MB604",
    ERROR,
    "`{name}` is {wanted}, but is given {given} (controller error 4390)",
    "assign it {wanted}, or use a variable that takes {given}",
)
OPERAND_TYPE: Final = Rule(
    "MB605",
    ERROR,
    "`{operator}` joins {left} with {right} (controller error 4390)",
    "convert one of them: `Str$` makes a text of a number, `Val` a number of a text",
)
SUFFIX: Final = Rule(
    "MB606",
    WARNING,
    "`{name}` has the mark of {marked}, but is declared as {declared} (controller error 4390)",
    "use one of the two everywhere",
)
READ_ONLY: Final = Rule(
    "MB607",
    ERROR,
    "`{name}` can only be read (controller error 3210)",
    "{cure}",
)
WRITE_ONLY: Final = Rule(
    "MB608",
    WARNING,
    "`{name}` cannot be read (controller error 4330)",
    "keep the value in a variable of your own",
)
UNKNOWN_STATUS: Final = Rule(
    "MB609",
    WARNING,
    "`{name}` is no status variable of {title}, and nothing declares it",
    "{cure}",
)
TIMER: Final = Rule(
    "MB610",
    INFO,
    "`M_Timer` is compared with {value}: it counts milliseconds",
    "write {better} if seconds are meant",
)
DEGREES: Final = Rule(
    "MB611",
    WARNING,
    "{what} is {value}: angles in expressions are in radian",
    "write `Rad({value})` if degrees are meant",
)
NO_TEXT_MARK: Final = Rule(
    "MB612",
    ERROR,
    "`{name}` is given a text, but has no `$` and no `Def Char` (controller error 4390)",
    "write `{name}$`",
)
INTEGER_RANGE: Final = Rule(
    "MB613",
    ERROR,
    "{value} does not fit into `{name}`, which holds whole numbers from {low} to {high}",
    "declare it with `{wider}`",
)
DIMENSIONS: Final = Rule(
    "MB614", ERROR, "the array `{name}` {what} (controller error 4370)", "{cure}"
)
SHORT_WAIT: Final = Rule(
    "MB619",
    INFO,
    "{title} waits {least:g} seconds at least, not {value}",
    "write a longer time, or leave it out",
)
GAP: Final = Rule(
    "MB616",
    WARNING,
    "the position `{name}` leaves out {what}, whose value is undefined then",
    "write every value; 0 is one",
)
LEFT_OUT: Final = Rule(
    "MB617",
    ERROR,
    "the {which} argument of `{word}` is left out (controller error 3120)",
    "write it",
)
EMPTY_STEP: Final = Rule(
    "MB618",
    WARNING,
    "step {number} holds nothing: a step number alone deletes that step",
    "write a statement or a comment there, or delete the line",
)
AMONG_STEPS: Final = Rule(
    "MB620",
    WARNING,
    "`{name}` is given a value by a line without step number between steps",
    "write a step number if it is a statement, else move it behind the last step",
)
MANY_PULSES: Final = Rule(
    "MB621",
    ERROR,
    "more than {most} pulses of outputs begin here at a time",
    "let some end first, with `Dly` between, or set those outputs and set them back",
)
