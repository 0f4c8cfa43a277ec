"""The findings of the rules that know no signatures: storage, the way through, timing, arcs."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Severity, error, info, warning

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

SECOND_MAIN: Final = warning(
    "RA212",
    "module `{other}` has a `main` as well: one task cannot load both",
    "rename one if they are one program; else check each program or task apart",
)
MAIN_TAKES: Final = error(
    "RA235",
    "`main` takes {parameters}: no task starts at a procedure with parameters",
    "rename it and call it from a `main` without any, or delete the parameters",
)
SAME_MODULE: Final = warning(
    "RA213",
    "a second module is named `{name}`: one task cannot load both",
    "rename one of them; if they are two states of one module, check them apart",
)
MODULE_NAME: Final = warning(
    "RA214",
    "the module is named like the {what} `{name}`",
    'use different names, so that a search and `%"{name}:…"%` find what is meant',
)
ASSIGNED_CONST: Final = error(
    "RA215", "the constant `{name}` is assigned to", "declare it with VAR or PERS"
)
ASSIGNED_LOOP: Final = error(
    "RA216",
    "the loop variable `{name}` is assigned to",
    "it is read only: use WHILE with a variable of its own, or leave the loop with RETURN or GOTO",
)
NOT_CONSTANT: Final = error(
    "RA217",
    "the initial value of `{name}` uses {what}",
    "write literals and constants; assign anything else in a routine",
)
NOT_LITERAL: Final = error(
    "RA207",
    "the initial value of PERS `{name}` is no literal",
    "write numbers, strings, TRUE or FALSE; assign anything else in a routine",
)
CONSTANT_WITHOUT_VALUE: Final = error(
    "RA218", "the constant `{name}` has no value", "write `:=` and a value behind its name"
)
HANDLE_VALUE: Final = error(
    "RA219", "`{name}` is given a value, but a {type} has none", "leave out `:=` and what follows"
)
NO_PLACE: Final = error(
    "RA220",
    "{what} may not stand {where}",
    "PERS, LOCAL and TASK belong to the data of a module, declarations to the begin of a routine",
)
DIMENSIONS: Final = error(
    "RA221", "the array `{name}` {what}", "use one to three dimensions of 1 or more each"
)
NO_TRAP: Final = error(
    "RA222", "`{name}` is connected to an interrupt, but is no TRAP", "declare it with TRAP"
)
ALIAS_OF_ALIAS: Final = error(
    "RA223", "`{name}` is an alias of the alias `{of}`", "name the type itself"
)
NO_LABEL: Final = error(
    "RA224",
    "no label `{name}` stands in {kind} `{routine}`",
    "write `{name}:` where it should go on; a GOTO does not leave its routine",
)
INTO_BLOCK: Final = error(
    "RA225",
    "GOTO jumps to `{name}` inside a block that it is not in itself",
    "put the label before or behind the block",
)
OUTSIDE_HANDLER: Final = error(
    "RA226",
    "{what} stands outside of an ERROR handler",
    "move it behind ERROR at the end of the routine; `RAISE` outside needs an error number",
)
HANDLER_PLACE: Final = error(
    "RA228",
    "a handler {kind} stands {what}",
    "a routine has at most one of each: BACKWARD (of a PROC only), ERROR, UNDO, in this order",
)
WRONG_RETURN: Final = error(
    "RA229", "{kind} `{name}` {what}", "a FUNC returns a value of its type, a PROC or TRAP none"
)

# What loads, but hardly does what was meant

UNREACHABLE: Final = warning(
    "RA450", "nothing behind {before} is ever reached", "remove it, or move it before"
)
NO_RETURN: Final = warning(
    "RA451", "FUNC `{name}` may end without RETURN", "give back a value on every way through it"
)
UNUSED_DATA: Final = info(
    "RA452", "nothing uses {names}", "remove {them}, or use {them} where it was meant"
)
UNUSED_ROUTINE: Final = info(
    "RA453", "nothing calls {names}", "remove {them}, or call {them} where it was meant"
)
ENDLESS_WAIT: Final = info(
    "RA454",
    "{word} waits without a time limit",
    "hand over `\\MaxTime` and handle ERR_WAIT_MAXTIME, or pass `\\TimeFlag`",
)
ON_THE_FLY: Final = info(
    "RA455",
    "{word} may run before the move in front of it has ended",
    "end the move with `fine` if the place matters, or use MoveLDO or TriggL",
)
READ_ON_THE_FLY: Final = info(
    "RA456",
    "the position is read before the move in front of it has ended",
    "end the move with `fine`, or write `WaitRob \\InPos` between",
)
SAME_CASE: Final = warning(
    "RA457", "an earlier CASE takes this value", "remove it, or correct the value"
)
BAD_STEP: Final = warning(
    "RA458", "the loop over `{name}` {what}", "correct its bounds or its step"
)
ARC_CLOSE: Final = error(
    "RA459",
    "{what} of an arc are less than 0.1 mm apart{more}",
    "move them apart, use MoveL, or split a full circle into two arcs",
)
ARC_STRAIGHT: Final = warning(
    "RA460",
    "seen from its start, the points of an arc are less than 1 degree apart{more}",
    "use MoveL, or put the circle point beside the line",
)
ARC_LONG: Final = info(
    "RA461",
    "an arc goes round {angle:.0f} degrees{more}",
    "split it: up to 240 degrees the circle is exact, with its circle point near the middle",
)
NO_ORIENTATION: Final = warning(
    "RA462",
    "the orientation of `{name}` is [0,0,0,0]{more}",
    "write a quaternion, [1,0,0,0] for none; the robot cannot move to it",
)
NO_QUADRANTS: Final = error(
    "RA463",
    "the configuration of `{name}` is no four whole numbers: {numbers}{more}",
    "state the quadrants of axes 1, 4 and 6 and cfx, as the robot shows them",
)
NO_CFX: Final = warning(
    "RA464",
    "cfx of `{name}` is {cfx}; arms of six axes count it from 0 to 7{more}",
    "state it as the robot shows it",
)
NEVER_SET_UP: Final = warning(
    "RA465",
    "a move is given the triggdata `{name}`, which nothing sets up",
    "set it up before the move, with TriggIO or TriggEquip",
)
NEVER_BOOKED: Final = warning(
    "RA467",
    "{what}: a program may raise the errors 1 to 90 and those that it has booked",
    "declare the error as `VAR errnum` and write `BookErrNo` with its name before it is raised",
)
NO_UNIT: Final = error(
    "RA468",
    "nothing moves the work object `{name}`: its `ufprog` is FALSE, and its `ufmec` names no unit",
    "write TRUE for a work object that stands still, or name the mechanical unit that moves it",
)
NO_MASS: Final = warning(
    "RA469",
    "the tool `{name}` has a mass of {mass:g} kg: the controller stops at the first move with it "
    "(undefined load, 41439)",
    "state its mass in kg and its centre of gravity; 0.001 kg is the least that counts",
)
HELD_TWICE: Final = error(
    "RA470",
    "the robot would hold both the tool `{tool}` and the work object `{frame}` of this move",
    "set `robhold` of the one that stands in the room to FALSE, or move with another",
)
HELD_NOWHERE: Final = error(
    "RA471",
    "the robot holds neither the tool `{tool}` nor the work object `{frame}` of this move",
    "set `robhold` of the one that the robot carries to TRUE, or move with another",
)
LONG_TIME: Final = warning(
    "RA466",
    "a time before the end of a move is longer than {most:g} s",
    "give at most {most:g} s, or a distance in mm",
)
