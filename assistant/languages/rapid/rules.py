"""Findings of RAPID: their codes, messages and cures.

First those of reading, lowering and translating; then those of the rules in `checks/` that need no
signatures of routines: storage, control flow, timing, arcs, tools and targets; last those of how
names, values and routines are used.
"""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Severity, error, info, warning

SYNTAX: Final = error("RA101", "{found} stands where {expected} should", "{hint}")
TOO_DEEP: Final = error(
    "RA102", "more than {most} brackets or blocks stand inside each other", "simplify it"
)
TOO_LONG: Final = error(
    "RA108", "more than {most} operators stand in a row", "compute it in several statements"
)
MISSING: Final = error("RA103", "{what} missing", "{hint}")
MANY: Final = error(
    "RA104",
    "more than {most} places are damaged; the rest was not looked at",
    "correct these first",
)
UNREADABLE: Final = error("RA105", "this is no text of RAPID: {why}", "{hint}")
ENCODING: Final = warning(
    "RA106",
    "the file is written in UTF-16, which no controller reads",
    "save it as ISO 8859-1, or as UTF-8 for RobotWare 7",
)
LINE_END: Final = warning(
    "RA107",
    "a line ends with CR CR LF, at which controllers stop loading",
    "save the file with CR LF or LF",
)
DUPLICATE: Final = error("RA201", "the name `{name}` is declared twice", "rename one of the two")
LONG_NAME: Final = error("RA202", "the name `{name}` has {length} characters", "use at most 32")
LONG_STRING: Final = error(
    "RA203", "a string has {length} characters", "use at most 80; join several with `+`"
)
LARGE_NUMBER: Final = error(
    "RA230", "`{number}` is larger than any {type}", "write a smaller number"
)
UNKNOWN_SPEED: Final = error(
    "RA204", "unknown speed `{name}`", "write {near}, or declare a speeddata of that name"
)
UNKNOWN_ZONE: Final = error(
    "RA205", "unknown zone `{name}`", "write {near}, or declare a zonedata of that name"
)
NOT_UNIT: Final = error(
    "RA206",
    "the quaternion of `{name}` is off unit length by {off:.2g}{more}",
    "normalise it: the sum of the squares must be 1 within 0.00001",
)
NOT_PERSISTENT: Final = error(
    "RA208", "`{name}` is handed over as {role}, but is no PERS", "declare it with PERS"
)
OUT_OF_ORDER: Final = error(
    "RA209",
    "{what} stands after {after}",
    "the order is records, data, routines in a module; declarations, statements in a routine",
)
RESERVED_NAME: Final = warning(
    "RA210", "`{name}` is predefined, and is declared again", "choose another name"
)
UNDECLARED: Final = error(
    "RA211", "nothing declares `{name}`", "declare it, or write the name that is meant", misses=True
)

SHORTENED: Final = info(
    "RA301",
    "the name `{name}` is written `{short}`: {why}",
    "the header of the module keeps the original",
)
NO_LOAD: Final = warning(
    "RA302",
    "the load of tool `{name}` is not known; 0.001 kg is written",
    "write `mass` in kg and `centre` of gravity in mm under [tools.{name}] of the process file or "
    "the cell file, or give a Load in Python: the controller needs them to move safely",
)
NO_CONFIGURATION: Final = warning(
    "RA303",
    "targets state no configuration (how the arm reaches them); [0,0,0,0] is written, with which "
    "the robot may stop before the move or take another way",
    "compile for a robot that reaches them, or state the configurations",
)
OTHER_LANGUAGE: Final = error(
    "RA304", "a statement of {language} has no meaning in RAPID: {text}", "{cure}"
)
NO_MEANING: Final = error("RA305", "RAPID cannot say {what}", "{cure}")
CHANGED: Final = warning("RA306", "{what} is written as {instead}", "{cure}")
NOT_FINITE: Final = error("RA307", "{what} holds a number that is not finite", "correct the input")
NOT_RAPID: Final = error("RA308", "this is no RAPID: {text} ({why})", "correct it")
SPLIT: Final = info(
    "RA309",
    "path `{name}` of {count} targets is spread over {parts} modules",
    "they are loaded one after the other while the program runs",
)
PACKED: Final = info(
    "RA320",
    "{count} paths of `{name}` are in further modules, {parts} in all",
    "they are loaded one after the other while the program runs",
)
COUNTER: Final = error(
    "RA310",
    "the variable `{name}` of a `for` {why}; a loop of RAPID has a variable of its own",
    "use another name for the loop, or copy the value to a declared variable inside it",
)
LEFT_OUT: Final = warning("RA311", "`{what}` is left out: {loss}", "{cure}")
PULSE_UNLIKE: Final = warning(
    "RA313",
    "`{name}` may be on when its pulse begins: PulseDO leaves it off, the other language as it was",
    "set it to 0 before the pulse if it shall be off behind it",
)
PULSE_FROM_OFF: Final = info(
    "RA314",
    "`{name}` is taken to be off where its pulse begins, as the program never switches it on",
    "switch it off at the start of the program if anything else may have switched it on",
)
REGISTER_UNITS: Final = warning(
    "RA474",
    "the analog signal `{name}` is a number in the units of its configuration, where the other "
    "language has a register of whole numbers as its device counts",
    "let the limits of the signal in EIO.cfg, logical and in bits, be those of the register, so "
    "that a logical value of 75 is 75 in bits",
)
DELAY_WAITS: Final = warning(
    "RA472",
    "the program waits until the delay of `{name}` is over, where RAPID goes on meanwhile",
    "see that what follows may come that much later; else take the delay out and set `{name}` "
    "further below",
)
SET_ON_WAY: Final = error(
    "RA473",
    "the delay of `{name}` lasts until the robot moves, which other languages cannot say",
    "set `{name}` in front of the move, or at a place on its way by TriggIO and TriggL",
)
HANDLED: Final = warning(
    "RA315",
    "the error handler of `{name}` is for these errors here: {errors}; others stop the program",
    "test for what may go wrong before it is done",
)
STOPS: Final = warning(
    "RA316",
    "`RAISE {name}` stops the program here, as no handler that is said is for it",
    "say by a variable what went wrong, and test it where the procedure was called",
)
MEETING: Final = warning(
    "RA317",
    "the programs that meet at `{point}` count there in `{name}`, which is kept when they end",
    "start them together, with 0 in it, each in a slot of its own",
)
INTERRUPTED: Final = warning(
    "RA318",
    "while `{name}` is answered the arm stands, and goes on behind it; of what interrupts it "
    "meanwhile again, the last change counts",
    "let what answers it be short, and let signals stay until it is done",
)
PLACE_UNLIKE: Final = warning(
    "RA312",
    "`{name}` is set on the way of {what}, which controllers may count differently",
    "see on the robot where it is set, or measure it on a straight move, before its corner",
)
ASKED: Final = warning(
    "RA331",
    "`{what}` asks a person over inputs: keys from the left are `operator_key_1` and on, a number "
    "from 0 to 32767 stands at `operator_number` while `operator_entered` is on",
    "give these signals their numbers in the process file, and wire keys or a panel to them",
)
UNREAD: Final = info("RA341", "nothing reads {names}, which is left out", "none is needed")
NOT_NEEDED: Final = info(
    "RA342",
    "the declaration of `{name}` is left out: it has no value, or nothing speaks of it",
    "none is needed",
)
RECEIVED: Final = warning(
    "RA332",
    "`{what}` reads as the other controller does: up to a carriage return or a comma, without an "
    "end of the time, of the file or of the connection",
    "let whoever writes end each text with a carriage return, and put no comma into it",
)
GATEWAY: Final = warning(
    "RA333",
    "bytes go over a line of texts to a gateway, a program that hands them on as they are",
    "let `robot-assistant gateway` run between the line of the controller and the other end",
)
NO_AXIS: Final = warning(
    "RA343",
    "`{axis}` is left out: no target states a place of that external axis, so that there is none, "
    "or the cell file says that it stands still",
    "state a place of it in a target, if the arm has such an axis",
)
SIGNS: Final = warning(
    "RA351",
    "the quaternion of a target is worked out of its angles: all parts may have the other sign",
    "none is needed where they turn something again, as both say the same orientation",
)
STANDS: Final = warning(
    "RA361",
    "the mechanical unit `{unit}` is taken to stand still where the cell file has the frame "
    "`{frame}`: what it carries does not turn with it",
    "state its place in the cell file, and let the unit stand there",
)
OWN_TASK: Final = warning(
    "RA363",
    "the position is read of the arm of the task `{task}`, which is taken for the arm of this "
    "program's controller",
    "see that this controller has the arm of that task",
)
BEFORE_MOVES: Final = warning(
    "RA362",
    "where no move came before, this reads the position of the flange in the robot's base",
    r"name what is meant, as `CRobT(\Tool:=tool0\WObj:=wobj0)`",
)
UNCALLED: Final = warning(
    "RA346",
    "nothing calls `{name}`, which is left out: what it works with is given by those that call it",
    "keep it in the source for programs that call it",
)
UNREAD_CALLERS: Final = warning(
    "RA347",
    "nothing that was read calls `{name}`: what it is given is {names} here, data of the program",
    "set them before each call, and name signals and lines in the cell file; if it is called in "
    "another way too, copy it",
)
COUNTED: Final = warning(
    "RA352",
    "nothing that was read calls `{name}`: it takes how many elements its arrays have as {names}",
    "give it that number in each call",
)
LONG_NUMBER: Final = warning(
    "RA348",
    "`{name}` is of the type dnum, and a number like any other here",
    "see that it needs no more than the digits of a number there, and that its text is as long",
)
COMPARED: Final = warning(
    "RA349",
    "targets are compared by where they are and the angles of their orientation: configurations, "
    "and signs of quaternions, may differ",
    "none is needed where a program asks whether the arm stands at a target",
)
NEARLY: Final = warning(
    "RA350",
    "a pose is compared with numbers: it counts as equal up to 0.005 mm and 0.05 degrees",
    "compare a distance with a limit if that is too much",
)
IDLE: Final = info("RA344", "this is left out: nothing reads what it assigns", "none is needed")
SETTLED: Final = warning(
    "RA345",
    "`{name}` is given no other value, and holds it from the start: this is left out",
    "see that no move with it comes before this one is done",
)
WRONG_SIZE: Final = warning(
    "RA371",
    "`{array}` has another number of elements than it is given here: the program stops there",
    "give it as many as it has, if this is ever done",
)
STATED: Final = warning(
    "RA391",
    "what the controller tells of itself is taken from the cell file here: `{name}`, which stays "
    "as it is while the program runs",
    "write its value in the cell file, and see that nothing depends on its changing",
)
BASE_FRAME: Final = warning(
    "RA381",
    "the robot stands at {where} in the world that its program counts from, as its system "
    "parameters state; the other robot counts from its own base",
    "put the other robot there in a world of its own, or state the work objects from its base",
)
OTHER_TASK: Final = info(
    "RA382",
    "the task `{task}` is {kind}: it runs by itself as long as the controller, beside the robot",
    "have the other controller run its program in a slot of its own, always",
)
SYSTEM_SIGNALS: Final = warning(
    "RA383",
    "signals are wired to actions and states of the controller itself, which is not translated: "
    "{signals}",
    "set them as dedicated inputs and outputs of the other controller, before the first run",
)
OPENED_ANEW: Final = warning(
    "RA392",
    "`{name}` is opened for writing alone, so that the file is empty: RAPID leaves what is in it "
    "behind what is written",
    "none is needed where nothing reads behind the text that is written",
)
CHOSEN: Final = warning(
    "RA393",
    "which signal `{name}` stands for is chosen among {names}; for any other name the program ends",
    "see that these are all that it may be, and give each its number",
)
ALWAYS_STOPS: Final = warning(
    "RA385",
    "the move stops at its target on every way: on one of them the program waits for the arm to "
    "stand, on others the arm would go on in the corner",
    "none is needed, unless the stop takes too long",
)
WAITS_FOR_KEPT: Final = warning(
    "RA397",
    "the wait for the arm is left out: a move before it, which is not translated, has to stop",
    "let the move that you write for it stop at its target",
)
TAKEN_FOR: Final = warning(
    "RA379",
    "`{what}` asks for the most that the arm can, and is taken for {value}",
    "write the number of the arm that the program was made for",
)
BY_NAME: Final = warning(
    "RA372",
    "`{what}` is a choice among {count} data, whose names are to be spelled as they are declared",
    "write names with the capital and small letters of their declarations",
)
STILL_AXIS: Final = warning(
    "RA373",
    "the place of the external axis `{axis}` is left out: the cell file says that it stands still",
    "see that the arm alone comes to these targets, and that the axis stands where it should",
)
SHARED: Final = warning(
    "RA395",
    "`{name}`, which tasks share, is `{new}` of all programs; {begins} gives it its first value",
    "start that program first, and again only where the value is to begin anew",
)
OTHER_VALUE: Final = warning(
    "RA398",
    "`{name}`, which tasks share, begins with `{value}` here and with `{other}` at {there}: a "
    "controller has one of the two for all of them, and nobody knows which",
    "write the value that the controller shows in both places",
)
NOT_SHARED: Final = warning(
    "RA396",
    "`{name}` is shared by tasks, of which each program has its own now: it is no single number, "
    "truth or text, or there are no more variables of all programs",
    "hand it over between the programs by signals, or one number at a time",
)
NAMED_LATE: Final = warning(
    "RA394",
    "`{name}` is called here whichever module the text names: only one has a routine that it fits",
    "see that the text never names another module, for which RAPID would raise an error",
)


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


UNKNOWN_ROUTINE: Final = warning(
    "RA401",
    "neither RobotWare nor a given module has a routine `{name}`",
    "check together with the module that declares it, or correct the name",
)
MISSPELT_ROUTINE: Final = warning(
    "RA402", "there is no routine `{name}`, but `{near}`", "write `{near}` if it is meant"
)
UNKNOWN_DATA: Final = info(
    "RA403",
    "no given module declares `{name}`",
    "check together with the module that does, or correct the name",
)
MISSING_ARGUMENTS: Final = error(
    "RA404", "`{routine}` lacks {parameters}", "write `{usage}`, with options as needed"
)
TOO_MANY: Final = error(
    "RA405",
    "`{routine}` does not take {given} arguments",
    "write `{usage}`, with options as needed",
)
UNKNOWN_OPTION: Final = error(
    "RA406", "`{routine}` has no optional argument `\\{option}`", "{hint}"
)
NEW_OPTION: Final = warning(
    "RA418",
    "`{routine}` of RobotWare 6 has no optional argument `\\{option}`",
    "{hint}, unless a later RobotWare has it",
)
EXCLUSIVE: Final = error(
    "RA407",
    "only one of `\\{one}` and `\\{other}` may be given to `{routine}`",
    "leave one of them out",
)
OPTION_WITHOUT_VALUE: Final = error(
    "RA408",
    "`\\{option}` of `{routine}` has no value",
    "write `\\{option}:=` and a {type} behind it",
)
SWITCH_WITH_VALUE: Final = error(
    "RA409",
    "`\\{option}` of `{routine}` is a switch and takes no value",
    "write only `\\{option}`, or leave it out",
)
WRONG_NAME: Final = error(
    "RA410",
    "an argument is named `{name}` where `{parameter}` of `{routine}` stands",
    "write `{parameter}`, or no name at all",
)
WRONG_ARGUMENT: Final = error(
    "RA411",
    "`{parameter}` of `{routine}` is {wanted}, and is given {given}",
    "give it a value of type {wanted}",
)
NO_REFERENCE: Final = error(
    "RA412",
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "hand over data that can be changed",
)
NO_PERSISTENT: Final = error(
    "RA413",
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "declare the data with PERS",
)
NO_VARIABLE: Final = warning(
    "RA414",
    "`{routine}` is given {what}, for its {mode} parameter `{parameter}`",
    "declare the data with VAR",
)
FUNCTION_ALONE: Final = error(
    "RA415",
    "`{name}` is a function, which cannot be called as an instruction",
    "use its value: `data:={name}(...);`",
)
NO_FUNCTION: Final = error(
    "RA416",
    "`{name}` is called as a function, but has no value",
    "call it as an instruction of its own, without parentheses",
)
NOT_A_ROUTINE: Final = error("RA417", "`{name}` is called, but is {what}", "correct the name")
NAME_WITHOUT_VALUE: Final = error(
    "RA419", "`{name}` is {what}, which has no value of its own", "name data, or call the routine"
)
UNKNOWN_TYPE: Final = warning(
    "RA421",
    "neither RobotWare nor a given module has a type `{name}`",
    "check together with the module that declares it, or correct the name",
)
MISSPELT_TYPE: Final = warning(
    "RA422", "there is no type `{name}`, but `{near}`", "write `{near}` if it is meant"
)
COMPONENT_COUNT: Final = error(
    "RA423", "a {type} has {count} components, {given} are written", "write all of them: {names}"
)
ELEMENT_COUNT: Final = error(
    "RA424",
    "{given} elements are written for an array of {count}",
    "write one for each, or change the declared size",
)
WRONG_VALUE: Final = error(
    "RA425", "{given} stands where {wanted} should", "write a value of type {wanted}"
)
UNKNOWN_COMPONENT: Final = error("RA426", "a {type} has no component `{name}`", "{hint}")
INDEX_COUNT: Final = error(
    "RA427",
    "the number of indices is {given}, that of dimensions {count}",
    "write one index for each declared dimension",
)
INDEX_RANGE: Final = warning(
    "RA430",
    "index {index} is outside of `{name}`, where it goes from 1{to}",
    "correct the index, or declare more elements",
)
OPERANDS: Final = error("RA428", "`{operator}` cannot join {left} and {right}", "{hint}")
NO_TRUTH: Final = error(
    "RA429", "{given} stands where a condition should", "compare it with a value, or use a bool"
)
