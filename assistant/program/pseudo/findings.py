"""What can be wrong with a pseudo-program's text."""

from __future__ import annotations

from typing import Any, Final

from lark import Token, Tree

from assistant.program.diagnostics import Rule, error

UNEXPECTED = error("PS101", "{found} cannot stand here", "write {expected}")
UNFINISHED = error("PS102", "the line is not finished", "go on with {expected}")
UNKNOWN_WORD = error("PS103", "no line begins with `{word}`", "{cure}")
BAD_ESCAPE = error(
    "PS104", "`{escape}` is no escape", r"write one of \\ \" \` \n \r \t \x.. \u.... \U........"
)
TOO_DEEP = error("PS105", "the {what} is nested too deeply", "{cure}")
TOO_MANY = error("PS106", "more than {most} findings", "is this a pseudo-program?")

MOST_DEEP: Final = 100
"""Levels of brackets and operators in an expression."""
MOST_BLOCKS: Final = 50
"""Blocks in one another."""

NO_PROGRAM = error(
    "PS201", "the text does not begin with a `program` line", "begin with `program <name>`"
)
SECOND_PROGRAM = error(
    "PS202", "a second `program` line; the first is line {first}", "remove one of them"
)
DUPLICATE = error(
    "PS203",
    "the {kind} `{name}` is declared twice; first in line {first}",
    "rename one of them; names are compared without case",
)
OUTSIDE = error(
    "PS204", "`{word}` stands outside of a procedure", "put it between `procedure` and `end`"
)
INSIDE = error(
    "PS205",
    "`{word}` stands inside the procedure of line {first}",
    "end that procedure first; an `end` may be missing above",
)
LATE_VARIABLE = error(
    "PS206", "a variable is declared after a statement", "move it up below `procedure`"
)

SURPLUS_END = error("PS211", "`end` ends nothing", "remove it, or look for a missing line above")
NOT_ENDED = error("PS212", "`{word}` is never ended", "write `end` where its lines are over")
NO_DIVISION = error("PS213", "`{word}` does not belong to {block}", "`{word}` divides {owners}")
AFTER_ELSE = error("PS214", "`{word}` after the `else` of line {first}", "move it above `else`")
NO_CASE = error("PS215", "a statement before the first `case`", "write a `case` above it")
NO_TEXT = error(
    "PS216", "`{word}` is no line of an opaque text", 'begin it with `|`, or quote it with `"`'
)
NAME_OF_FUNCTION = error(
    "PS217",
    "the procedure `{name}` has the name of the function `{function}`, which calls would mean",
    "choose another name",
)

NUMBER_SIZE = error("PS301", "`{number}` is too large", "write a smaller number")
COUNT = error(
    "PS302", "{count} number{s} in brackets instead of {expected}", "write {expected} numbers"
)
NOT_UNIT = error(
    "PS303", "the quaternion is of length {length:.6g}", "give a unit quaternion [w, x, y, z]"
)
NOT_FINITE = error("PS304", "{what} is not a finite number", "write a finite number")
NOT_ASSIGNABLE = error(
    "PS305", "this cannot be assigned to", "assign to a name, a component or an array element"
)
QUADRANT = error("PS306", "quadrant {number} is beyond -128 to 127", "write the true quadrant")
NO_PLACE = error(
    "PS307",
    "`here` does not say which tool it is of, and in which frame",
    "write both names, as `here(tool0, base)`",
)

INCOMPLETE_ROW = error(
    "PS401", "the first row of a path states no {what}", "state it, as `{example}`"
)
LONE_VIA = error("PS402", "a `via` row without a `to` row after it", "add the end of the arc")
LONE_TO = error("PS403", "a `to` row without a `via` row before it", "add a point of the arc")

NO_FOLDER = error(
    "PS411",
    "the path is in the side table `{name}`, and it is not known where that is",
    "name the folder that holds it",
)
NOT_BARE = error("PS412", "`{name}` is no plain file name", "put the side table beside the text")
NO_TABLE = error(
    "PS413", "the side table `{name}` cannot be read: {reason}", "put it beside the text"
)
OTHER_TABLE = error(
    "PS414",
    "the side table `{name}` is not the one that the text was written with",
    "take the text and its tables from the same place; their sha256 sums differ",
)
BAD_TABLE = error(
    "PS415", "the side table `{name}` is damaged: {reason}", "write the program again"
)


class Wrong(Exception):
    """Something wrong in one line: a rule, its fields, and the columns it is about.

    start, end: offsets in the line; None for the whole line.
    """

    def __init__(self, rule: Rule, at: Token | Tree[Token] | None = None, **fields: Any) -> None:
        super().__init__(rule.code)
        self.rule: Final = rule
        self.fields: Final = fields
        self.start, self.end = _columns(at)


def _columns(at: Token | Tree[Token] | None) -> tuple[int | None, int | None]:
    if isinstance(at, Token):
        return at.start_pos, at.end_pos
    if at is None or at.meta.empty:
        return None, None
    return at.meta.start_pos, at.meta.end_pos
