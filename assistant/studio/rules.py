"""The findings of the studio."""

from __future__ import annotations

from assistant.base.diagnostics import error, info
from assistant.base.installation import missing_extra

NO_LIBRARY = missing_extra(
    "ST001",
    "the studio is served by the library {name}, which is not installed",
    "studio",
)
NOT_SERVED = error(
    "ST002",
    "the studio cannot be served on {where}: {reason}",
    "name another --port or --host, or leave them out",
)
NO_FOLDER = error("ST003", "there is no folder `{name}`", "name one that is there")
READ_ONLY = error(
    "ST010",
    "another window of the studio is open, and only that one changes anything",
    "close the other window; this one may write then",
)
NOT_ASKED = error(
    "ST011", "the page asked for something that is wrong: {reason}", "load the page anew"
)
SYSTEM = error("ST012", "the system refuses: {reason}", "make room, or look whether it is there")
NO_PLAIN_NAME = error(
    "ST020",
    "`{name}` cannot be the name of a file here",
    "rename it: letters, digits, `-`, `_`, `.` and spaces, without a folder",
)
NOT_TAKEN = error(
    "ST021",
    "`{name}` is nothing that a project is made of",
    "drop a file that ends in one of {known}",
)
THERE_ALREADY = error(
    "ST022",
    "`{name}` is there already and says something else; it was not touched",
    "rename the file that is dropped, or take the other one away",
)
OUTSIDE = error("ST023", "`{name}` is no file of the project", "name a file inside the project")
CHANGED = error(
    "ST024",
    "`{name}` was changed by somebody else since it was opened; nothing was written",
    "take over what is there now, or keep what stands here",
)
NOT_KEPT = error(
    "ST025",
    "`{key}` cannot be written into {name} without changing the rest of it; it was not touched",
    "write it by hand",
)
GONE = error("ST026", "`{name}` is not there any more", "save it under its name again, or close it")

NO_RUN = error("ST060", "no program is running", "start one")
RUN_NOT_HELD = error(
    "ST061", "the program is not held, so there is no step to make", "pause it first"
)
RUN_ASKS_NOTHING = error("ST062", "the program asks nothing now", "wait until it does")
RUN_BUSY = error(
    "ST063",
    "the program did not come to it within {seconds:g} s",
    "wait until its motions are planned, or end it",
)
RUN_WITHOUT_ARM = info(
    "ST064",
    "no robot is chosen, so motions take no time and reach anything",
    "choose a robot and start again",
)
NO_SCENE = error(
    "ST050", "what the scene shows has changed since", "show the file in the scene again"
)
NOT_SHOWN = error(
    "ST051",
    "`{name}` is nothing that a scene shows",
    "open a program, a table, taught targets, or a drawing",
)
NOT_MOVED = error("ST052", "`{name}` cannot be moved here: {reason}", "{cure}")

NOT_CONNECTED = error("ST040", "no controller is connected", "choose one of the project")
NOT_CONFIRMED = error(
    "ST041",
    "this {what}, and nobody confirmed it; nothing was changed",
    "look that nobody is near, then type `{word}`",
)
OTHER_WORD = error(
    "ST042",
    "`{word}` was not typed, so nothing was changed",
    "type it as it stands there to confirm",
)
NO_CONTROL = error("ST043", "this window has no control of the arm", "take control of it first")
MOTORS_ON = error(
    "ST044",
    "the motors of {name} may still be on",
    "switch them off at the controller",
)
OFF_SINCE = error(
    "ST049",
    "the motors were switched off while they waited to be switched on, and stay off",
    "switch them on again",
)
FOLDER_THERE = error(
    "ST045", "`{name}` is there already: a backup gets a folder of its own", "name another one"
)
NO_BACKUP = error("ST046", "there is no folder `{name}`", "name one that a backup was written into")
OTHER_PLAN = error(
    "ST048",
    "what would be sent to {name}, or what is there, is not what was shown; nothing was changed",
    "compare again, look at the differences, and deploy then",
)
NO_TARGET = error(
    "ST047",
    "no target of the project is for `{name}`, so nothing is meant to be on it",
    "add one to the project's file, with the programs that it gets",
)
