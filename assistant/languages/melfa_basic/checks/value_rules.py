"""The findings of types and of the values of arguments."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

OUT_OF_RANGE: Final = error(
    "MB601", "{what} is {value}, not {range} (controller error {number})", "{cure}"
)
ARGUMENT_COUNT: Final = error(
    "MB602",
    "`{word}` takes {wanted}, not {given} (controller error {number})",
    "write what it takes",
)
ARGUMENT_TYPE: Final = error(
    "MB603",
    "{which} of `{word}` is {given}, not {wanted} (controller error 3810)",
    "write {wanted} there",
)
ASSIGNED_TYPE: Final = error(
    "MB604",
    "`{name}` is {wanted}, but is given {given} (controller error 4390)",
    "assign it {wanted}, or use a variable that takes {given}",
)
OPERAND_TYPE: Final = error(
    "MB605",
    "`{operator}` joins {left} with {right} (controller error 4390)",
    "convert one of them: `Str$` makes a text of a number, `Val` a number of a text",
)
SUFFIX: Final = warning(
    "MB606",
    "`{name}` has the mark of {marked}, but is declared as {declared} (controller error 4390)",
    "use one of the two everywhere",
)
READ_ONLY: Final = error("MB607", "`{name}` can only be read (controller error 3210)", "{cure}")
WRITE_ONLY: Final = warning(
    "MB608",
    "`{name}` cannot be read (controller error 4330)",
    "keep the value in a variable of your own",
)
UNKNOWN_STATUS: Final = warning(
    "MB609", "`{name}` is no status variable of {title}, and nothing declares it", "{cure}"
)
TIMER: Final = info(
    "MB610",
    "`M_Timer` is compared with {value}: it counts milliseconds",
    "write {better} if seconds are meant",
)
DEGREES: Final = warning(
    "MB611",
    "{what} is {value}: angles in expressions are in radian",
    "write `Rad({value})` if degrees are meant",
)
NO_TEXT_MARK: Final = error(
    "MB612",
    "`{name}` is given a text, but has no `$` and no `Def Char` (controller error 4390)",
    "write `{name}$`",
)
INTEGER_RANGE: Final = error(
    "MB613",
    "{value} does not fit into `{name}`, which holds whole numbers from {low} to {high}",
    "declare it with `Def {wider}`",
)
DIMENSIONS: Final = error("MB614", "the array `{name}` {what} (controller error 4370)", "{cure}")
SHORT_WAIT: Final = info(
    "MB619",
    "{title} waits {least:g} seconds at least, not {value}",
    "write a longer time, or leave it out",
)
GAP: Final = warning(
    "MB616",
    "the position `{name}` leaves out {what}, whose value is undefined then",
    "write every value; 0 is one",
)
UNDEFINED: Final = error(
    "MB622",
    "the position `{name}` has no value for {what}, and is taken as a pose (controller error 2800)",
    "write every value; 0 is one",
)
LEFT_OUT: Final = error(
    "MB617", "the {which} argument of `{word}` is left out (controller error 3120)", "write it"
)
EMPTY_STEP: Final = warning(
    "MB618",
    "step {number} holds nothing: a step number alone deletes that step",
    "write a statement or a comment there, or delete the line",
)
AMONG_STEPS: Final = warning(
    "MB620",
    "`{name}` is given a value by a line without step number between steps",
    "write a step number if it is a statement, else move it behind the last step",
)
MANY_PULSES: Final = error(
    "MB621",
    "more than {most} pulses of outputs begin here at a time",
    "let some end first, with `Dly` between, or set those outputs and set them back",
)
