"""The findings of blocks, jumps and subroutines."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

UNBALANCED: Final = error(
    "MB105",
    "`{word}` has no `{other}` (controller error {number})",
    "close each block in the order it was opened",
)
CROSSED: Final = error(
    "MB131",
    "`{word}` stands inside a `{inner}` that is still open (controller error {number})",
    "close the inner block first",
)
TOO_DEEP: Final = error(
    "MB132",
    "`{word}` stands {depth} blocks deep, more than {most} (controller error {number})",
    "move the inner blocks into a subroutine",
)
NESTED_SELECT: Final = error(
    "MB133",
    "{title} takes no `Select` inside another one",
    "move the inner one into a subroutine, or write it with `If`",
)
INTO_BLOCK: Final = warning(
    "MB134",
    "the jump leads to `{name}` inside a `{kind}` that it does not stand in itself{error}",
    "put the label before or behind the block",
)
FALLS_IN: Final = warning(
    "MB135",
    "control can run into the subroutine `{name}` from above (controller error 3840 at `Return`)",
    "write `End` or a `GoTo` in front of the label",
)
JUMPED_INTO: Final = warning(
    "MB136",
    "`GoTo` leads into the subroutine `{name}` (controller error 3840 at its `Return`)",
    "call it with `GoSub`",
)
RETURN_ALONE: Final = warning(
    "MB137",
    "`Return` is reached without a `GoSub` (controller error 3840)",
    "write `End`, or call these lines with `GoSub`",
)
NO_RETURN: Final = warning(
    "MB138",
    "the subroutine `{name}` never comes to a `Return`",
    "end it with `Return`, or go there with `GoTo`",
)
HANDLER_RETURN: Final = error(
    "MB139",
    "the interrupt's subroutine `{name}` ends with a `Return` without number",
    "write `Return 0` to redo the interrupted line, `Return 1` to go on with the next one",
)
NUMBERED_RETURN: Final = warning(
    "MB140",
    "`Return` has a number, but `{name}` is no subroutine of an interrupt",
    "write `Return` alone",
)
UNREACHABLE: Final = warning(
    "MB141", "nothing leads here: {before}", "remove the lines, or jump to a label at them"
)
CALLED_TOO_DEEP: Final = error(
    "MB142",
    "`CallP` is {depth} programs deep here, more than {most} (controller error 3710)",
    "call fewer programs inside each other",
)
CALLS_ITSELF: Final = error(
    "MB143", "the program calls itself: {chain}; `CallP` knows no recursion", "write a loop"
)
READ_BEFORE_SET: Final = warning(
    "MB148",
    "`{program}`, which starts here in {slot}, reads `{name}` in line {reading}, and {setter} may "
    "not have set it by then: it finds 0, or what the last run left there",
    "set `{name}` before the line that starts `{program}`",
)
LAST_VALUE: Final = info(
    "MB149",
    "`{name}` is read here before this program has set it, and {program} sets it in another slot: "
    "until then it is 0, or what the last run left there",
    "set `{name}` before the line that starts {program}",
)
LOOP_VARIABLE: Final = info(
    "MB144",
    "the variable `{name}` of the loop is changed inside it",
    "use a variable of its own, or write the loop with `While`",
)
SAME_VARIABLE: Final = warning(
    "MB145",
    "a loop over `{name}` stands inside another one over it",
    "use a variable of its own for the inner loop",
)
WRONG_NEXT: Final = error(
    "MB146",
    "`Next` names `{name}`, but the loop runs over `{wanted}` (controller error 3230)",
    "write `Next {wanted}`",
)
TWO_ELSE: Final = error(
    "MB147",
    "`{word}` stands behind the `{other}` of its block{error}",
    "put `{other}` last, and once",
)
