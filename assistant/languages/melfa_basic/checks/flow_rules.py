"""The findings of blocks, jumps and subroutines."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Rule, Severity

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

UNBALANCED: Final = Rule(
    "MB105",
    ERROR,
    "`{word}` has no `{other}` (controller error {number})",
    "close each block in the order it was opened",
)
CROSSED: Final = Rule(
    "MB131",
    ERROR,
    "`{word}` stands inside a `{inner}` that is still open (controller error {number})",
    "close the inner block first",
)
TOO_DEEP: Final = Rule(
    "MB132",
    ERROR,
    "`{word}` stands {depth} blocks deep, more than {most} (controller error {number})",
    "move the inner blocks into a subroutine",
)
NESTED_SELECT: Final = Rule(
    "MB133",
    ERROR,
    "{title} takes no `Select` inside another one",
    "move the inner one into a subroutine, or write it with `If`",
)
INTO_BLOCK: Final = Rule(
    "MB134",
    WARNING,
    "the jump leads to `{name}` inside a `{kind}` that it does not stand in itself{error}",
    "put the label before or behind the block",
)
FALLS_IN: Final = Rule(
    "MB135",
    WARNING,
    "control can run into the subroutine `*{name}` from above (controller error 3840 at `Return`)",
    "write `End` or a `GoTo` in front of the label",
)
JUMPED_INTO: Final = Rule(
    "MB136",
    WARNING,
    "`GoTo` leads into the subroutine `*{name}` (controller error 3840 at its `Return`)",
    "call it with `GoSub`",
)
RETURN_ALONE: Final = Rule(
    "MB137",
    WARNING,
    "`Return` is reached without a `GoSub` (controller error 3840)",
    "write `End`, or call these lines with `GoSub`",
)
NO_RETURN: Final = Rule(
    "MB138",
    WARNING,
    "the subroutine `*{name}` never comes to a `Return`",
    "end it with `Return`, or go there with `GoTo`",
)
HANDLER_RETURN: Final = Rule(
    "MB139",
    ERROR,
    "the interrupt's subroutine `*{name}` ends with a `Return` without number",
    "write `Return 0` to redo the interrupted line, `Return 1` to go on with the next one",
)
NUMBERED_RETURN: Final = Rule(
    "MB140",
    WARNING,
    "`Return` has a number, but `*{name}` is no subroutine of an interrupt",
    "write `Return` alone",
)
UNREACHABLE: Final = Rule(
    "MB141", WARNING, "nothing leads here: {before}", "remove the lines, or jump to a label at them"
)
CALLED_TOO_DEEP: Final = Rule(
    "MB142",
    ERROR,
    "`CallP` is {depth} programs deep here, more than {most} (controller error 3710)",
    "call fewer programs inside each other",
)
CALLS_ITSELF: Final = Rule(
    "MB143",
    ERROR,
    "the program calls itself: {chain}; `CallP` knows no recursion",
    "write a loop",
)
LOOP_VARIABLE: Final = Rule(
    "MB144",
    INFO,
    "the variable `{name}` of the loop is changed inside it",
    "use a variable of its own, or write the loop with `While`",
)
SAME_VARIABLE: Final = Rule(
    "MB145",
    WARNING,
    "a loop over `{name}` stands inside another one over it",
    "use a variable of its own for the inner loop",
)
WRONG_NEXT: Final = Rule(
    "MB146",
    ERROR,
    "`Next` names `{name}`, but the loop runs over `{wanted}` (controller error 3230)",
    "write `Next {wanted}`",
)
TWO_ELSE: Final = Rule(
    "MB147",
    ERROR,
    "`{word}` stands behind the `{other}` of its block{error}",
    "put `{other}` last, and once",
)
