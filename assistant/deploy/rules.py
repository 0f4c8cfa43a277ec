"""Findings of planning and deploying."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Severity, error, info

ERROR: Final = Severity.ERROR

NO_FILES = error("DP101", "there is nothing to deploy", "name at least one program file")
SAME_NAME = error(
    "DP102",
    "`{first}` and `{second}` would both become `{name}` on the controller",
    "rename one of them",
)
WRONG_LANGUAGE = error(
    "DP103",
    "the file is {given}, but {address} takes {taken}",
    "compile it for that controller, or deploy it to another",
)
UNKNOWN_LANGUAGE = error(
    "DP104",
    "the file is no program that {address} takes ({taken})",
    "compile it for that controller",
)
CHANGED_SINCE = error(
    "DP201",
    "`{name}` on the controller changed since the plan was made; nothing was changed by this run",
    "plan again and look at the difference",
)
ALTERED = error(
    "DP202",
    "`{name}` read back from the controller is not what was sent (first difference in line "
    "{row}: sent {sent}, read {read})",
    "check the line and the controller's version of the language",
)
NO_BACKUP = error(
    "DP203",
    "the backup in `{folder}` could not be written: {reason}; nothing was changed on the "
    "controller",
    "choose another folder or make room",
)
PUT_BACK = info("DP301", "`{name}` on the controller is again what it was before")
REMOVED = info("DP302", "`{name}`, which was new, is off the controller again")
NOT_PUT_BACK = error(
    "DP303",
    "`{name}` on the controller could not be seen to be what it was before; {backup}",
    "do not start the program; look at the file and put the right one there by hand",
)
INTERRUPTED = error(
    "DP304", "the deployment was interrupted while `{name}` was written", "run it again"
)
