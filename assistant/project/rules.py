"""Findings of a project as a whole: its tables, what is built of it, and what it starts."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import error, info

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
NO_FILE: Final = error("PR105", "`{key}` names `{file}`, which is no file of the project", "{cure}")
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
    "the process that made `{name}` ended without an answer",
    "look whether there is memory enough, or build with `--jobs 1`",
)
NOT_KEPT: Final = error(
    "PR204", "`{file}` cannot be written: {reason}", "make room, or see whose the folder is"
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
NOT_STARTED: Final = error(
    "PR401",
    "the virtual controller `{name}` cannot start: {reason}",
    "see whether another command uses it, and whether its packages are installed "
    "(`robot-assistant[virtual,rws]`)",
)
BUSY: Final = error(
    "PR402",
    "another process uses the virtual controller `{name}`",
    "wait until it has ended",
)
