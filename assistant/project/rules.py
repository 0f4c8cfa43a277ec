"""Findings of a project as a whole: its tables, what is built of it, and what it starts."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning
from assistant.base.installation import missing_extra

NO_PROJECT: Final = error(
    "PR101",
    "no project is here: {what}",
    "run `robot-assistant init`, or write [programs] and [targets] into assistant.toml",
)
NO_TABLE: Final = error("PR102", "`{key}` is no table", "write [{key}] with lines below it")
BAD_NAME: Final = error(
    "PR103",
    "`{name}` cannot be the name of a {kind}",
    "write letters, digits, `_` and `-`, a letter first, 60 at most",
)
OUTSIDE: Final = error(
    "PR104",
    "`{file}` is outside of the folder of the project",
    "name a file of the project, from its folder, without leading upwards",
)
LINK: Final = error(
    "PR112",
    "`{file}` is a link: commands would write to where it leads",
    "look who put it there, and take it away",
)
NO_FILE: Final = error("PR105", "`{file}` is no file of the project", "{cure}")
MISSING: Final = error("PR106", "`{name}` has no {key}", "write {key} = {example}")
UNKNOWN: Final = error("PR107", "there is no {kind} `{name}`", "{cure}")
NO_PROGRAMS: Final = error(
    "PR108",
    "`{name}` has no programs",
    "write names of [programs], or program files of the project, into `programs`",
)
SAME_TARGET: Final = error(
    "PR109",
    "`{name}` and `{other}` put programs into the same task of the same controller",
    "have one target for both, or give each a task of its own",
)
NOT_TAKEN: Final = error(
    "PR110",
    "`{name}` is to be in {given}, but its controller takes {taken}",
    "leave `language` out, or name another controller",
)
OPEN_LANGUAGE: Final = error(
    "PR111",
    "it is not known in which of {taken} `{name}` is to be",
    "write `language` for the program, or `robot` for the controller",
)
SAME_FILE: Final = error(
    "PR201",
    "`{first}` and `{second}` would both be `{file}` on `{target}`",
    "rename one of the sources",
)
NOT_BUILT: Final = error(
    "PR202",
    "`{name}` is not built for `{target}`: {reason}",
    "run `robot-assistant build`",
)
DIED: Final = error(
    "PR203",
    "the process that made `{name}` ended without an answer: {reason}",
    "look whether there is memory enough, or build with `--jobs 1`",
)
NOT_KEPT: Final = error(
    "PR204", "`{file}` cannot be used: {reason}", "see whose it is, and whether there is room"
)
NOT_BESIDE: Final = error(
    "PR205",
    "the program calls `{file}`, which is outside of the folder of the project",
    "keep what a program calls beside it in the project",
)
ONLY_WITH_FILES: Final = error(
    "PR206",
    "`{option}` says nothing without files: a project states it itself",
    "name the files, or write it into assistant.toml",
)
KEPT: Final = info("PR301", "`{file}` is there already and was left as it is", "{cure}")
NOT_ADDED: Final = info(
    "PR302",
    "assistant.toml does not say yet that `{source}` is a program",
    'add {table}, and "{name}" to the programs of a target',
)
OTHER_DRAWING: Final = error(
    "PR303",
    "`{file}` is in the project already, and is another drawing",
    "rename one of them, or copy the new one over it and name that",
)
NOT_WORK: Final = info(
    "PR305",
    "`{file}` leaves out what is drafting by its name or shape, not work: {what}",
    "give a layer that is work a table there, [layers.NAME]; delete the entry of a line type or"
    ' block from leave_out; write follow = ["border"] for a border',
)
NOTHING_ELSE: Final = warning(
    "PR306",
    "all that could be followed is drafting by its name or shape, and `{file}` leaves it out:"
    " {what}",
    'give each layer that is work a table there, [layers.NAME]; write follow = ["border"] for a'
    " border",
)
ASSUMED: Final = warning(
    "PR307",
    "assumed, as it is not stated: {what}",
    "measure it before an arm moves, and write it into the process file",
)
NO_ROOM: Final = warning(
    "PR308",
    "no position was found at which {robot} reaches all of the work{size}, with its tool pointing"
    " down",
    "{cure}",
)
OTHER_LANGUAGE: Final = error("PR309", "{robot} takes no programs in `{given}`", "{cure}")
HAS_CONTROLLER: Final = error(
    "PR310",
    "the project is there already, and its assistant.toml says which robot it has",
    "name no robot and no language",
)
ROBOT_OUTSIDE: Final = error(
    "PR311",
    "the robot file `{file}` is outside of the folder of the project",
    "copy it into the folder, and name it there",
)
BLOCKS_MISSING: Final = warning(
    "PR312",
    "the drawing inserts blocks that its file does not contain: {names}; `{file}` leaves them out",
    "export the drawing again with these blocks if they are work, and delete their entries from"
    " leave_out",
)
NOTHING_DRAWN: Final = warning(
    "PR313",
    "the drawing holds no lines, curves or locations that a robot could follow or visit: {held}",
    "draw or export the contours of the work as lines, arcs, polylines or splines",
)
LARGE_UNIT: Final = warning(
    "PR314",
    "the work is {size} in the unit that the drawing names, for which {robot} was taken",
    "{cure}",
)
NOT_STARTED: Final = missing_extra(
    "PR401",
    "the virtual controller `{name}` cannot start: {reason}",
    "virtual,rws",
    "see whether another command uses it, and whether its packages are installed: `{install}`",
)
BUSY: Final = error(
    "PR402",
    "another process uses the virtual controller `{name}`",
    "wait until it has ended",
)
BOTH_CHANGED: Final = error(
    "PR501",
    "`{name}` was changed on the controller and here at the same place; nothing was written",
    "look at both with `plan`, write what you want into the program here, and drop what is there "
    "with `--replace {name}`",
)
NOT_ONLY_TARGETS: Final = error(
    "PR502",
    "`{name}` was changed on the controller in more than the places of its targets, which cannot "
    "be brought into `{source}`; nothing was written",
    "look at it with `plan`, change the source by hand, and drop what is there with "
    "`--replace {name}`",
)
OTHER_TARGET: Final = error(
    "PR503",
    "the target `{target}` of `{name}` does not stand in `{source}` as it was deployed, or cannot "
    "be written there; nothing was written",
    "build and look at the difference with `plan`, then change the source by hand",
)
NOT_COMMITTED: Final = error(
    "PR505",
    "`{file}` has changes that are not committed; nothing was written",
    "commit them or stash them first, so that nothing is lost",
)
GONE_THERE: Final = error(
    "PR506",
    "`{name}` is not on the controller any more: there is nothing to bring home",
    "deploy it again with `--replace {name}`, or take it out of the project",
)
TWO_CHANGES: Final = error(
    "PR507",
    "of `{name}` both the file and the module in memory were changed, and say different things; "
    "nothing was written",
    "save the module on the controller, or load its file, and pull again",
)
NOT_READ: Final = error(
    "PR508",
    "what the controller has as `{name}` cannot be read as a program; nothing was written",
    "copy it with `get` and look at it",
)
NOTHING_THERE: Final = info(
    "PR509", "nothing was changed on the controller that would have to be brought home"
)
KEPT_BESIDE: Final = info(
    "PR510", "no git repository keeps `{file}`: what it said before is in `{kept}`"
)
