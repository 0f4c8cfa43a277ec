"""The findings of the RAPID room."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

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
    "state mass and centre of gravity, the controller needs them to move safely",
)
NO_CONFIGURATION: Final = warning(
    "RA303",
    "targets state no configuration; [0,0,0,0] is written",
    "compile for a robot, or state the configurations",
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
