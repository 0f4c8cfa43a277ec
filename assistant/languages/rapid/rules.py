"""The findings of the RAPID room."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Rule, Severity

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

SYNTAX: Final = Rule("RA101", ERROR, "{found} stands where {expected} should", "{hint}")
TOO_DEEP: Final = Rule(
    "RA102", ERROR, "more than {most} brackets or blocks stand inside each other", "simplify it"
)
TOO_LONG: Final = Rule(
    "RA108",
    ERROR,
    "more than {most} operators stand in a row",
    "compute it in several statements",
)
MISSING: Final = Rule("RA103", ERROR, "{what} missing", "{hint}")
MANY: Final = Rule(
    "RA104",
    ERROR,
    "more than {most} places are damaged; the rest was not looked at",
    "correct these first",
)
UNREADABLE: Final = Rule("RA105", ERROR, "this is no text of RAPID: {why}", "{hint}")
ENCODING: Final = Rule(
    "RA106",
    WARNING,
    "the file is written in UTF-16, which no controller reads",
    "save it as ISO 8859-1, or as UTF-8 for RobotWare 7",
)
LINE_END: Final = Rule(
    "RA107",
    WARNING,
    "a line ends with CR CR LF, at which controllers stop loading",
    "save the file with CR LF or LF",
)
DUPLICATE: Final = Rule(
    "RA201", ERROR, "the name `{name}` is declared twice", "rename one of the two"
)
LONG_NAME: Final = Rule(
    "RA202", ERROR, "the name `{name}` has {length} characters", "use at most 32"
)
LONG_STRING: Final = Rule(
    "RA203", ERROR, "a string has {length} characters", "use at most 80; join several with `+`"
)
UNKNOWN_SPEED: Final = Rule(
    "RA204", ERROR, "unknown speed `{name}`", "write {near}, or declare a speeddata of that name"
)
UNKNOWN_ZONE: Final = Rule(
    "RA205", ERROR, "unknown zone `{name}`", "write {near}, or declare a zonedata of that name"
)
NOT_UNIT: Final = Rule(
    "RA206",
    ERROR,
    "the quaternion of `{name}` is off unit length by {off:.2g}",
    "normalise it: the sum of the squares must be 1 within 0.00001",
)
NOT_LITERAL: Final = Rule(
    "RA207",
    ERROR,
    "the initial value of PERS `{name}` is no literal",
    "write numbers, strings, TRUE or FALSE; assign anything else in a routine",
)
NOT_PERSISTENT: Final = Rule(
    "RA208",
    ERROR,
    "`{name}` is handed over as {role}, but is no PERS",
    "declare it with PERS",
)
OUT_OF_ORDER: Final = Rule(
    "RA209",
    ERROR,
    "{what} stands after {after}",
    "the order is records, data, routines in a module; declarations, statements in a routine",
)
RESERVED_NAME: Final = Rule(
    "RA210", WARNING, "`{name}` is predefined, and is declared again", "choose another name"
)
UNDECLARED: Final = Rule(
    "RA211",
    ERROR,
    "nothing declares `{name}`",
    "declare it, or write the name that is meant",
    misses=True,
)

SHORTENED: Final = Rule(
    "RA301",
    INFO,
    "the name `{name}` is written `{short}`: {why}",
    "the header of the module keeps the original",
)
NO_LOAD: Final = Rule(
    "RA302",
    WARNING,
    "the load of tool `{name}` is not known; 0.001 kg is written",
    "state mass and centre of gravity, the controller needs them to move safely",
)
NO_CONFIGURATION: Final = Rule(
    "RA303",
    WARNING,
    "targets state no configuration; [0,0,0,0] is written",
    "compile for a robot, or state the configurations",
)
OTHER_LANGUAGE: Final = Rule(
    "RA304",
    ERROR,
    "a statement of {language} has no meaning in RAPID: {text}",
    "{cure}",
)
NO_MEANING: Final = Rule("RA305", ERROR, "RAPID cannot say {what}", "{cure}")
CHANGED: Final = Rule("RA306", WARNING, "{what} is written as {instead}", "{cure}")
NOT_FINITE: Final = Rule(
    "RA307", ERROR, "{what} holds a number that is not finite", "correct the input"
)
NOT_RAPID: Final = Rule("RA308", ERROR, "this is no RAPID: {text} ({why})", "correct it")
SPLIT: Final = Rule(
    "RA309",
    INFO,
    "path `{name}` of {count} targets is spread over {parts} modules",
    "they are loaded one after the other while the program runs",
)
COUNTER: Final = Rule(
    "RA310",
    ERROR,
    "the variable `{name}` of a `for` {why}; a loop of RAPID has a variable of its own",
    "use another name for the loop, or copy the value to a declared variable inside it",
)
LEFT_OUT: Final = Rule("RA311", WARNING, "`{what}` is left out: {loss}", "{cure}")
PULSE_UNLIKE: Final = Rule(
    "RA313",
    WARNING,
    "`{name}` may be on when its pulse begins: PulseDO leaves it off, the other language as it was",
    "set it to 0 before the pulse if it shall be off behind it",
)
PLACE_UNLIKE: Final = Rule(
    "RA312",
    WARNING,
    "`{name}` is set on the way of {what}, which controllers may count differently",
    "see on the robot where it is set, or measure it on a straight move, before its corner",
)
