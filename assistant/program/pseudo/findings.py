"""What can be wrong with a pseudo-program's text."""

from __future__ import annotations

from typing import Any, Final

from lark import Token, Tree

from assistant.program.diagnostics import Rule, Severity

_ERROR: Final = Severity.ERROR

UNEXPECTED = Rule("PS101", _ERROR, "{found} cannot stand here", "write {expected}")
UNFINISHED = Rule("PS102", _ERROR, "the line is not finished", "go on with {expected}")
UNKNOWN_WORD = Rule("PS103", _ERROR, "no line begins with `{word}`", "{cure}")
BAD_ESCAPE = Rule(
    "PS104",
    _ERROR,
    "`{escape}` is no escape",
    r"write one of \\ \" \` \n \r \t \x.. \u.... \U........",
)
TOO_DEEP = Rule("PS105", _ERROR, "the {what} is nested too deeply", "{cure}")
TOO_MANY = Rule("PS106", _ERROR, "more than {most} findings", "is this a pseudo-program?")

MOST_DEEP: Final = 100
"""Levels of brackets and operators in an expression."""
MOST_BLOCKS: Final = 50
"""Blocks in one another."""

NO_PROGRAM = Rule(
    "PS201", _ERROR, "the text does not begin with a `program` line", "begin with `program <name>`"
)
SECOND_PROGRAM = Rule(
    "PS202", _ERROR, "a second `program` line; the first is line {first}", "remove one of them"
)
DUPLICATE = Rule(
    "PS203",
    _ERROR,
    "the {kind} `{name}` is declared twice; first in line {first}",
    "rename one of them; names are compared without case",
)
OUTSIDE = Rule(
    "PS204",
    _ERROR,
    "`{word}` stands outside of a procedure",
    "put it between `procedure` and `end`",
)
INSIDE = Rule(
    "PS205",
    _ERROR,
    "`{word}` stands inside the procedure of line {first}",
    "end that procedure first; an `end` may be missing above",
)
LATE_VARIABLE = Rule(
    "PS206", _ERROR, "a variable is declared after a statement", "move it up below `procedure`"
)

SURPLUS_END = Rule(
    "PS211", _ERROR, "`end` ends nothing", "remove it, or look for a missing line above"
)
NOT_ENDED = Rule("PS212", _ERROR, "`{word}` is never ended", "write `end` where its lines are over")
NO_DIVISION = Rule(
    "PS213", _ERROR, "`{word}` does not belong to {block}", "`{word}` divides {owners}"
)
AFTER_ELSE = Rule(
    "PS214", _ERROR, "`{word}` after the `else` of line {first}", "move it above `else`"
)
NO_CASE = Rule("PS215", _ERROR, "a statement before the first `case`", "write a `case` above it")
NO_TEXT = Rule(
    "PS216",
    _ERROR,
    "`{word}` is no line of an opaque text",
    'begin it with `|`, or quote it with `"`',
)

NUMBER_SIZE = Rule("PS301", _ERROR, "`{number}` is too large", "write a smaller number")
COUNT = Rule(
    "PS302",
    _ERROR,
    "{count} number{s} in brackets instead of {expected}",
    "write {expected} numbers",
)
NOT_UNIT = Rule(
    "PS303",
    _ERROR,
    "the quaternion is of length {length:.6g}",
    "give a unit quaternion [w, x, y, z]",
)
NOT_FINITE = Rule("PS304", _ERROR, "{what} is not a finite number", "write a finite number")
NOT_ASSIGNABLE = Rule(
    "PS305",
    _ERROR,
    "this cannot be assigned to",
    "assign to a name, a component or an array element",
)
QUADRANT = Rule(
    "PS306", _ERROR, "quadrant {number} is beyond -128 to 127", "write the true quadrant"
)
NO_PLACE = Rule(
    "PS307",
    _ERROR,
    "`here` does not say which tool it is of, and in which frame",
    "write both names, as `here(tool0, base)`",
)

INCOMPLETE_ROW = Rule(
    "PS401", _ERROR, "the first row of a path states no {what}", "state it, as `{example}`"
)
LONE_VIA = Rule(
    "PS402", _ERROR, "a `via` row without a `to` row after it", "add the end of the arc"
)
LONE_TO = Rule(
    "PS403", _ERROR, "a `to` row without a `via` row before it", "add a point of the arc"
)

NO_FOLDER = Rule(
    "PS411",
    _ERROR,
    "the path is in the side table `{name}`, and it is not known where that is",
    "name the folder that holds it",
)
NOT_BARE = Rule(
    "PS412", _ERROR, "`{name}` is no plain file name", "put the side table beside the text"
)
NO_TABLE = Rule(
    "PS413", _ERROR, "the side table `{name}` cannot be read: {reason}", "put it beside the text"
)
OTHER_TABLE = Rule(
    "PS414",
    _ERROR,
    "the side table `{name}` is not the one that the text was written with",
    "take the text and its tables from the same place; their sha256 sums differ",
)
BAD_TABLE = Rule(
    "PS415", _ERROR, "the side table `{name}` is damaged: {reason}", "write the program again"
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
