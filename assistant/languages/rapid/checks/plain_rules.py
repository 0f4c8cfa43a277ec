"""The findings of the rules that know no signatures: storage, the way through, timing, arcs."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Rule, Severity

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

SECOND_MAIN: Final = Rule(
    "RA212",
    WARNING,
    "module `{other}` has a `main` as well: one task cannot load both",
    "rename one if they are one program; else check each program or task apart",
)
SAME_MODULE: Final = Rule(
    "RA213",
    WARNING,
    "a second module is named `{name}`: one task cannot load both",
    "rename one of them; if they are two states of one module, check them apart",
)
MODULE_NAME: Final = Rule(
    "RA214",
    WARNING,
    "the module is named like the {what} `{name}`",
    'use different names, so that a search and `%"{name}:…"%` find what is meant',
)
ASSIGNED_CONST: Final = Rule(
    "RA215", ERROR, "the constant `{name}` is assigned to", "declare it with VAR or PERS"
)
ASSIGNED_LOOP: Final = Rule(
    "RA216",
    ERROR,
    "the loop variable `{name}` is assigned to",
    "it is read only: use WHILE with a variable of its own, or leave the loop with RETURN or GOTO",
)
NOT_CONSTANT: Final = Rule(
    "RA217",
    ERROR,
    "the initial value of `{name}` uses {what}",
    "write literals and constants; assign anything else in a routine",
)
NO_VALUE: Final = Rule(
    "RA218", ERROR, "the constant `{name}` has no value", "write `:=` and a value behind its name"
)
HANDLE_VALUE: Final = Rule(
    "RA219",
    ERROR,
    "`{name}` is given a value, but a {type} has none",
    "leave out `:=` and what follows",
)
NO_PLACE: Final = Rule(
    "RA220",
    ERROR,
    "{what} may not stand {where}",
    "PERS, LOCAL and TASK belong to the data of a module, declarations to the begin of a routine",
)
DIMENSIONS: Final = Rule(
    "RA221", ERROR, "the array `{name}` {what}", "use one to three dimensions of 1 or more each"
)
NO_TRAP: Final = Rule(
    "RA222", ERROR, "`{name}` is connected to an interrupt, but is no TRAP", "declare it with TRAP"
)
ALIAS_OF_ALIAS: Final = Rule(
    "RA223", ERROR, "`{name}` is an alias of the alias `{of}`", "name the type itself"
)
NO_LABEL: Final = Rule(
    "RA224",
    ERROR,
    "no label `{name}` stands in {kind} `{routine}`",
    "write `{name}:` where it should go on; a GOTO does not leave its routine",
)
INTO_BLOCK: Final = Rule(
    "RA225",
    ERROR,
    "GOTO jumps to `{name}` inside a block that it is not in itself",
    "put the label before or behind the block",
)
OUTSIDE_HANDLER: Final = Rule(
    "RA226",
    ERROR,
    "{what} stands outside of an ERROR handler",
    "move it behind ERROR at the end of the routine; `RAISE` outside needs an error number",
)
HANDLER_PLACE: Final = Rule(
    "RA228",
    ERROR,
    "a handler {kind} stands {what}",
    "a routine has at most one of each: BACKWARD (of a PROC only), ERROR, UNDO, in this order",
)
WRONG_RETURN: Final = Rule(
    "RA229",
    ERROR,
    "{kind} `{name}` {what}",
    "a FUNC returns a value of its type, a PROC or TRAP none",
)

# What loads, but hardly does what was meant

UNREACHABLE: Final = Rule(
    "RA450", WARNING, "nothing behind {before} is ever reached", "remove it, or move it before"
)
NO_RETURN: Final = Rule(
    "RA451",
    WARNING,
    "FUNC `{name}` may end without RETURN",
    "give back a value on every way through it",
)
UNUSED_DATA: Final = Rule(
    "RA452", INFO, "nothing uses {names}", "remove {them}, or use {them} where it was meant"
)
UNUSED_ROUTINE: Final = Rule(
    "RA453",
    INFO,
    "nothing calls {names}",
    "remove {them}, or call {them} where it was meant",
)
ENDLESS_WAIT: Final = Rule(
    "RA454",
    INFO,
    "{word} waits without a time limit",
    "hand over `\\MaxTime` and handle ERR_WAIT_MAXTIME, or pass `\\TimeFlag`",
)
ON_THE_FLY: Final = Rule(
    "RA455",
    INFO,
    "{word} may run before the move in front of it has ended",
    "end the move with `fine` if the place matters, or use MoveLDO or TriggL",
)
READ_ON_THE_FLY: Final = Rule(
    "RA456",
    INFO,
    "the position is read before the move in front of it has ended",
    "end the move with `fine`, or write `WaitRob \\InPos` between",
)
SAME_CASE: Final = Rule(
    "RA457", WARNING, "an earlier CASE takes this value", "remove it, or correct the value"
)
BAD_STEP: Final = Rule(
    "RA458", WARNING, "the loop over `{name}` {what}", "correct its bounds or its step"
)
ARC_CLOSE: Final = Rule(
    "RA459",
    ERROR,
    "{what} of an arc are less than 0.1 mm apart{more}",
    "move them apart, use MoveL, or split a full circle into two arcs",
)
ARC_STRAIGHT: Final = Rule(
    "RA460",
    WARNING,
    "seen from its start, the points of an arc are less than 1 degree apart{more}",
    "use MoveL, or put the circle point beside the line",
)
ARC_LONG: Final = Rule(
    "RA461",
    INFO,
    "an arc goes round {angle:.0f} degrees{more}",
    "split it: up to 240 degrees the circle is exact, with its circle point near the middle",
)
NO_ORIENTATION: Final = Rule(
    "RA462",
    WARNING,
    "the orientation of `{name}` is [0,0,0,0]{more}",
    "write a quaternion, [1,0,0,0] for none; the robot cannot move to it",
)
NO_QUADRANTS: Final = Rule(
    "RA463",
    ERROR,
    "the configuration of `{name}` is no four whole numbers: {numbers}{more}",
    "state the quadrants of axes 1, 4 and 6 and cfx, as the robot shows them",
)
NO_CFX: Final = Rule(
    "RA464",
    WARNING,
    "cfx of `{name}` is {cfx}; arms of six axes count it from 0 to 7{more}",
    "state it as the robot shows it",
)
NEVER_SET_UP: Final = Rule(
    "RA465",
    WARNING,
    "a move is given the triggdata `{name}`, which nothing sets up",
    "set it up before the move, with TriggIO or TriggEquip",
)
LONG_TIME: Final = Rule(
    "RA466",
    WARNING,
    "a time before the end of a move is longer than {most:g} s",
    "give at most {most:g} s, or a distance in mm",
)
