"""Findings of the MELFA-BASIC room: one table, most with the number that a controller shows."""

from __future__ import annotations

from assistant.base.diagnostics import error, info, warning

# ----------------------------------------------------------------------------- reading
TOKENISED = error(
    "MB001", "this is a tokenised controller file (`ROBPRG`), not text",
    "export the program as text (.prg) with RT ToolBox, or back it up as text over the link",
)  # fmt: skip
SYNTAX = error("MB002", "{what} (controller error 4220, syntax error)", "{cure}")
QUOTES = error("MB003", "{what} (controller error 4310, illegal character)", "{cure}")
REMARK = error(
    "MB004",
    "words stand behind the statement without a mark (controller error 4220, syntax error)",
    "write `'` before a comment",
)

# ---------------------------------------------------------------------------- checking
# more about checked programs in checks: flow_rules, value_rules, motion_rules
NO_LABEL = error(
    "MB101",
    "there is no label `*{name}`{where} (controller error 3600)",
    "add the label or correct the name",
)
NO_STEP = error(
    "MB102", "there is no line {name} (controller error 4230)", "jump to a label instead"
)
TWO_LABELS = error(
    "MB103", "the label `*{name}` stands twice (controller error 4440)", "rename one of them"
)
NO_POSITION = warning(
    "MB104",
    "the {kind} `{name}` has no value (controller error 3860)",
    "add its line at the end of the program, assign it first, or teach it on the controller",
)
LONG_NAME = error(
    "MB106",
    "the name `{name}` is longer than {most} characters (controller error 4300)",
    "shorten it, or state `name-length` in assistant.toml if your controller takes longer ones",
)
LONG_LINE = error(
    "MB107",
    "the step is {length} bytes long, more than {most} (controller error 4210)",
    "split the statement or shorten its comment; `step-length` in assistant.toml sets the limit",
)
NOT_ASCENDING = error(
    "MB108",
    "step {number} follows step {before}: steps are stored in ascending order",
    "put the line where its number belongs, or give it one between those of its neighbours",
)
STEP_RANGE = error(
    "MB109",
    "step number {number} is not 1 to {most} (controller error 4420)",
    "number the steps again in smaller steps or split the program",
)
NO_STEP_NUMBER = warning("MB110", "{what} (controller error 4470)", "number every line")
NOT_IN_DIALECT = error("MB111", "{title} has no {word} (controller error 4220)", "{cure}")
TWO_POSITIONS = error(
    "MB112", "`{name}` has two lines (controller error 4350)", "delete one of them"
)
NO_VALUE = warning(
    "MB113",
    "`{name}` is read, but nothing gives it a value",
    "assign it first, or correct the name",
)
NO_EXTERNAL = info(
    "MB114",
    "`{name}` is an external variable, which no file here gives a value",
    "check the file together with the program that sets it, or set it on the controller",
)
NO_PROGRAM = info(
    "MB115",
    "the program `{name}` is not among these files (controller error 4140 if it is missing)",
    "put its file beside this one, or see that the controller has it",
)
NOT_CALLED = warning(
    "MB123",
    "the program `{name}`, which `CallP` calls, is not among these files: the call stops with "
    "error 4140 if the controller lacks it, and nothing of it is checked or translated",
    "put its file beside this one, or correct the name",
)
UNUSED = info(
    "MB116", "nothing uses {what} {names}", "remove {them}, or use {them} where it was meant"
)
LABEL_FORM = warning(
    "MB117",
    "{title} takes no `_` in the label `*{name}`, except behind an `L` that it begins with",
    "leave out the `_`",
)
PROGRAM_NAME = warning(
    "MB118",
    "the controller takes no program named `{name}`: {what} (controller error {number})",
    "name the file with at most 12 letters A to Z and digits",
)
NO_DIM = warning(
    "MB119",
    "`{name}` has subscripts, but no `Dim` declares it and no function is named so",
    "write `Dim {name}(…)` in front, or correct the name",
)
DECLARED_TWICE = warning(
    "MB120", "`{name}` is declared twice (controller error 4350)", "delete one of the declarations"
)
LINE_TARGET = warning(
    "MB121",
    "the jump names line {name}: tools of {title} number lines anew, and leave it as it is",
    "put a label in front of that line, and jump to it",
)
NO_CALL = warning(
    "MB122",
    "there is no Function `{name}`",
    "correct its name, or include the file that defines it",
)

# ---------------------------------------------------------------------------- adapting
NO_NUMBER = error(
    "MB201", "the signal `{name}` has no number, which MELFA-BASIC addresses signals by",
    "give `number = …` for the signal in the process file or the cell file; `translate` lists all",
    misses=True,
)  # fmt: skip
NO_CONFIGURATION = warning(
    "MB202", "{count} targets state no arm configuration and get the flags (7,0)",
    "name a robot that reaches them, so that it is computed, or state it in the source",
)  # fmt: skip
SPEED_PARTS = warning(
    "MB203",
    "a speed states {part}, which MELFA-BASIC cannot say; the controller's own limits apply",
    "check that reorientations and external axes are slow enough",
)
JOINT_PERCENT = warning(
    "MB204", "a joint move states {tcp} mm/s but no percentage and gets JOVRD {percent:g}",
    "try it slowly, and state the percentage that suits as `joint_percent` at the top of the "
    "process file or the cell file, or pass it as percent where Python gives the poses or joints",
)  # fmt: skip
COMPUTED_PERCENT = warning(
    "MB284",
    "a joint move states mm/s that are worked out, and gets JOVRD by their share of {tcp:g}",
    "try it slowly and write the JOVRD that suits",
)
BLEND_PARTS = info(
    "MB205", "a blend states zone sizes beside its distance, which MELFA-BASIC cannot say",
    "the distance alone is used",
)  # fmt: skip
LOAD = warning(
    "MB206", "the load of the tool `{name}` is not written: the controller keeps it as HNDDAT",
    "set the hand condition in the controller's parameters",
)  # fmt: skip
HELD = error(
    "MB207", "`{name}` is a work piece that the robot holds or a tool that it does not hold",
    "use a tool on the flange and a frame that stands still",
)  # fmt: skip
FRAME_JOINED = info(
    "MB208", "user and object frame of `{name}` are written as one", "none is needed"
)
CANNOT_SAY = error("MB209", "MELFA-BASIC cannot say {what}", "{cure}")
RENAMED = warning(
    "MB297",
    "the {count} positions `{first}` to `{last}` lose their names: they become the path `{name}`, "
    "whose targets are `{name}_1` to `{name}_{count}`",
    "use the new names; `--names` writes a table of both",
)
IN_DEGREES = info(
    "MB299",
    "the written program has the angles in {names} in degrees, where the source has them in radian",
    "none is needed in the program, as each of their uses is converted; who reads or sets them by "
    "hand has degrees now",
)
LEFT_OPEN = warning(
    "MB298",
    "a jump leaves `{name}` without going back, so that it is called again while the first call is "
    "open: the other controller may hold fewer open calls than this one",
    "leave the subroutine by its last line, and jump in the lines that call it",
)
FULL_SPEED = warning(
    "MB294",
    "nothing sets the speed of this move: it is as fast as the arm can be, in both languages",
    "write `Spd` with mm/s in front of it, or `Spd M_NSpd` if full speed is meant",
)
ADDED = warning(
    "MB293",
    "values that `{name}` leaves out count as 0 in the sum, which no manual confirms",
    "write every value; 0 is one",
)
ANGLES = error(
    "MB292",
    "the angles of `{name}` are read or set one by one, and {why}: they may be beyond what its "
    "orientation tells",
    "keep the angles in variables beside it, or set all three of them together",
)
UNKNOWN = error(
    "MB210", "{what} `{name}` is not declared", "declare it or correct the name", misses=True
)
MESSAGE = warning(
    "MB211", "a message on the teach pendant becomes a comment: {text}",
    "watch the program another way, MELFA-BASIC has no statement for it",
)  # fmt: skip
SPLIT = info(
    "MB212", "the path `{name}` of {count} targets is split into {parts} programs",
    "install all of them; the first calls the others",
)  # fmt: skip
UNREACHABLE = error(
    "MB213", "the orientation of `{name}` is {angle:.2f} degrees from what five axes can reach",
    "turn the tool axis into the vertical plane through the robot's first axis",
)  # fmt: skip
TO_BASE = warning(
    "MB214", "the targets of frame `{name}` are converted to the robot's base for a 5-axis arm",
    "move the frame in the source, not on the controller",
)  # fmt: skip
FIVE_AXIS_TOOL = error(
    "MB215", "the tip of tool `{name}` is not on the flange's axis of a 5-axis arm",
    "use a tool whose tip has x = y = 0 and no rotation",
)  # fmt: skip
NAMED = info("MB216", "{count} named speeds and blends are written as numbers", "none is needed")
ARC_AT_START = warning(
    "MB217", "an arc of `{name}` starts where the robot stands, which is read as it runs",
    "let a straight move that stops (fine) in the same tool and frame stand before the arc",
)  # fmt: skip
NOT_FINITE = error(
    "MB218", "{what} holds a number that is not finite or too large for a robot",
    "correct the number in the source",
)  # fmt: skip
LOCAL_DATA = error(
    "MB219", "`{name}` is used in several programs, whose variables are their own",
    "keep the procedures that share it in one unit",
)  # fmt: skip
TOO_MANY_STEPS = error(
    "MB220", "the program `{name}` needs {count} steps, more than {most}",
    "split it into procedures in units of their own",
)  # fmt: skip
OVER_THE_BACK = error(
    "MB221", "`{name}` reaches over the arm's back with a tilted tool: A and B are uncertain",
    "turn the cell so that the arm reaches forward, or point the tool straight down",
)  # fmt: skip

AS_VARIABLES = info(
    "MB223", "parameters and result of `{name}` are variables of the program", "none is needed"
)
RECURSIVE = error(
    "MB224", "`{name}` calls itself, but its parameters and variables exist only once",
    "write a loop instead",
)  # fmt: skip
TEXT_CHANGED = warning(
    "MB226", "the text {given} is written as {text}", "avoid quotes and control characters"
)
PERSISTENT = warning(
    "MB227", "the persistent `{name}` gets its first value at each start",
    "delete its line at the top after the first start, or keep the value in an external variable",
)  # fmt: skip
SHARED_BRANCH = warning(
    "MB228", "targets of frame `{name}` differ in their arm branch, a product has the frame's",
    "write frames as base instead of as products",
)  # fmt: skip
UNDECLARED = error(
    "MB229",
    "`{name}` {what}", "{cure}", misses=True,
)  # fmt: skip
MISSING = error(
    "MB230", "the procedure `{name}` that is called is not in what was read",
    "give the file that holds it as well, or take the call out", misses=True,
)  # fmt: skip
ROUNDED_TEXT = warning(
    "MB231", "a number is written out without the zeros behind its last decimal",
    "add them to the text where they matter",
)  # fmt: skip
RENAMED_IN_TEXT = error(
    "MB232", "`{text}` keeps its text, but {names} is written under another name",
    "use a name in the source that stays: P, J, M or C in front, letters and digits only, short",
)  # fmt: skip

SLOT = info(
    "MB288", "the list of slots has `{name}` in slot {number}: {how}",
    "have the other controller start and repeat it that way",
)  # fmt: skip
KEPT_BY_A_PARAMETER = warning(
    "MB289", "nothing sets the {what} of the program: the one is said that the parameter `{name}` "
    "held when its list was written",
    "see that no other program sets another one before it, or write `{word}` in front of the moves",
)  # fmt: skip
SETTING_KEPT = warning(
    "MB233", "no `{word}` stands before this move: the robot moves with the {what} that another "
    "program or a person set last; the move is written {how}",
    "write `{word} {plain}` in front of it if no {what} is meant, else `{word}` with the position "
    "that is meant",
)  # fmt: skip
LOOP_CHANGED = warning(
    "MB234", "the loop changes {names}, which its end or step is made of: the other "
    "controller works its end and step out once",
    "count in a variable of its own up to a value that stays, or write While",
)  # fmt: skip
PULSE_UNLIKE = warning(
    "MB253",
    "`{name}` may be on where `M_Out()=1 Dly` is written, which then leaves it on; the statement "
    "of the other language switches it off in the end",
    "set `{name}` to 0 in front of the statement, if it may be off there",
)
REGISTER_UNITS = warning(
    "MB300",
    "the analog signal `{name}` is a register of whole numbers: a value with decimals is rounded, "
    "and the other language may count in other units (volt, bar)",
    "compare the scale of `{name}` in the other controller's configuration with that of the "
    "register's device; where they differ, multiply the value in the source",
)
PULSE_WAITS = warning(
    "MB291", "the pulse of `{name}` begins when that of `{before}` has ended, as no more than "
    "{most} run at a time: the program waits for that",
    "none is needed if there is time; else set some of the outputs and set them back",
)  # fmt: skip
PLACE_UNLIKE = warning(
    "MB238", "`{name}` is set on the way of {what}, which controllers may count differently",
    "see on the robot where it is set, or measure it on a straight move, before its corner",
)  # fmt: skip
BY_SPEED = warning(
    "MB241", "`{name}`, which is set {when} a place on the way, is set where the robot is then at "
    "{speed} mm/s", "see that it is set in time where the robot is slower, or stops",
)  # fmt: skip
BEHIND = info(
    "MB239", "`{name}`, which is set at the very end of a move, is set behind the move",
    "none is needed: the robot stops there",
)  # fmt: skip
SET_BEFORE = warning(
    "MB295", "`{name}`, which is set as the move begins, is set by a statement before the move, as "
    "one `Wth` alone is appended to it", "none is needed where the robot stops before the move",
)  # fmt: skip
NO_CORNER = warning(
    "MB235", "a corner of 0 mm is written as a stop at the target",
    "write `Cnt 0`, or give both distances",
)  # fmt: skip
SIGNED_BITS = error(
    "MB250", "`{word}` may meet a number below 0, whose bits other languages do not say",
    "take `Abs` of it, or give it no value below 0",
)  # fmt: skip
JOINT_OVERRIDE = warning(
    "MB249", "a percentage of joint speed for the moves below is said as the speed of each",
    "check the speeds of these moves",
)  # fmt: skip
BEGINS = warning(
    "MB251", "nothing gives `{name}` a value before it may be read: it begins with {value}, "
    "where a controller for MELFA-BASIC has what was kept, or stops",
    "give it its value above, at the top of the program",
)  # fmt: skip
UNSIGNED = warning(
    "MB285", "the number of the signals `{name}` is never below 0, where a MELFA-BASIC controller "
    "may read one of {bits} signals whose highest is on as negative",
    "none is needed where that signal stays off",
)  # fmt: skip
SLIDES = warning(
    "MB286",
    "the place of an additional axis is read or set as mm, which it is if the axis slides; "
    "of one that turns the controller counts in radian",
    "none is needed for an axis that slides; of one that turns, write degrees instead",
)  # fmt: skip
JOINTS_UNTOLD = error(
    "MB252", "nothing says what the joints `{name}` are before they may be read: others would "
    "begin with all axes at 0, and move there",
    "add the line that holds them, or give them their value above",
)  # fmt: skip
CARRIED = warning(
    "MB237", "`{name}` gets its first value in each cycle, not only at a start from the top: "
    "it does not keep what the cycle before left in it",
    "let the cycle stand in a loop without end (`WHILE TRUE` in RAPID), or give it its value in it",
)  # fmt: skip
REPEATED = warning(
    "MB263", "the cycle stands in a loop without end, as it begins with what the one before left "
    "in {names}: one that is to be the last does not end it",
    "stop the program, or give these their values in the cycle",
)  # fmt: skip
STRAIGHT_ARC = warning(
    "MB255",
    "the places of the arc pallet {number:g} lie on a line: its points, that no manual tells, "
    "are written at equal distances from its start to its end",
    "see on the controller where they are, or define a pallet of one row",
)  # fmt: skip
PALLET_TURNED = warning(
    "MB259", "the pallet {number:g} interpolates the angles of `{name}`, which the controller "
    "calculates: the sign of an angle of 180 degrees is undetermined, and so is the path of the "
    "angle to it",
    "add 10 to the direction of the pallet, so that all points have the angles of its start",
)  # fmt: skip
OUTSIDE = warning(
    "MB256",
    "`{what}` is said as a call of `{name}`, a routine that the cell has to give",
    "write there what the other controller has for it, and try it with care",
)
STATE = warning(
    "MB258",
    "`{name}` is data of the program, which the cell's routines have to read and write: of a "
    "position the last three numbers are the angles of its orientation",
    "see that these routines take it like that",
)
MEASURED = warning(
    "MB257",
    "P_Fbc, the position that is measured, is said as the present one, as P_Curr is",
    "see whether the other controller measures it too, if the arm is pushed or gives way",
)
NUMBERED = warning(
    "MB270",
    "which {what} it is is worked out while the program runs: `{name}` chooses among the numbers "
    "{which}, {numbers}, and ends the program at any other",
    "see that no other number is met, and that the cell has these signals",
)
UNCALLED = info(
    "MB271",
    "nothing calls `{name}`: where it sets no speed or corner itself, it moves as a program does "
    "that has just begun",
    "leave it out, or set `Spd`, `JOvrd` and `Cnt` above its moves",
)
LEFT_OUT = warning("MB254", "`{what}` is left out: {loss}", "{cure}")
NO_ENTRY = error(
    "MB245", "`{name}` has no main procedure: the program would end at once",
    "name the procedure with --entry, or call it `main` in the source",
)  # fmt: skip
NO_FIT = error(
    "MB240", "the {bits} of the signal `{name}` cannot be {value:g}",
    "write a whole number from 0 to {most}, or state the right number of bits",
)  # fmt: skip
ENDED = info(
    "MB236", "an end for good is written as `Hlt` in a loop: `End` would begin the next cycle",
    "none is needed; reset the program on the controller to start it from the top",
)  # fmt: skip

LINE = warning(
    "MB261", "`{name}` is the line `{com}`, which {role}; a text ends with a carriage return "
    "there, and `Input #` takes what stands before a comma by itself",
    "set the controller's parameters {parameters}, and see that the other end writes and reads so",
)  # fmt: skip
FILE_NAMED = warning(
    "MB262", "the file {given} is {name} on the controller, which has no folders; its lines end "
    "with a carriage return",
    "give each file a name of its own, of at most 16 letters",
)  # fmt: skip

# --------------------------------------------------------------- from one dialect to another
NOT_CONVERTED = error("MB501", "{title} cannot say {what}", "{cure}")

# ------------------------------------------------------------------------- renumbering
PAST_LAST_STEP = error(
    "MB401",
    "{count} steps from {first} in steps of {step} end at {last}, the highest number is {most}",
    "number in smaller steps, 1,1 at the least, or split the program",
)
