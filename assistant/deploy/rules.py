"""Findings of planning and deploying."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Rule, Severity

ERROR: Final = Severity.ERROR

NO_FILES = Rule("DP101", ERROR, "there is nothing to deploy", "name at least one program file")
SAME_NAME = Rule(
    "DP102",
    ERROR,
    "`{first}` and `{second}` would both become `{name}` on the controller",
    "rename one of them",
)
WRONG_LANGUAGE = Rule(
    "DP103",
    ERROR,
    "the file is {given}, but {address} takes {taken}",
    "compile it for that controller, or deploy it to another",
)
UNKNOWN_LANGUAGE = Rule(
    "DP104",
    ERROR,
    "the file is no program that {address} takes ({taken})",
    "compile it for that controller",
)
CHANGED_SINCE = Rule(
    "DP201",
    ERROR,
    "`{name}` on the controller changed since the plan was made; nothing was changed by this run",
    "plan again and look at the difference",
)
ALTERED = Rule(
    "DP202",
    ERROR,
    "`{name}` read back from the controller is not what was sent (first difference in line "
    "{row}: sent {sent}, read {read})",
    "check the line and the controller's version of the language",
)
NO_BACKUP = Rule(
    "DP203",
    ERROR,
    "the backup in `{folder}` could not be written: {reason}; nothing was changed on the "
    "controller",
    "choose another folder or make room",
)
PUT_BACK = Rule(
    "DP301",
    Severity.INFO,
    "`{name}` on the controller is again what it was before",
)
REMOVED = Rule(
    "DP302",
    Severity.INFO,
    "`{name}`, which was new, is off the controller again",
)
NOT_PUT_BACK = Rule(
    "DP303",
    ERROR,
    "`{name}` on the controller could not be seen to be what it was before; {backup}",
    "do not start the program; look at the file and put the right one there by hand",
)
INTERRUPTED = Rule(
    "DP304", ERROR, "the deployment was interrupted while `{name}` was written", "run it again"
)
