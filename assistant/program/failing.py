"""What fails where nothing may: told as a finding, of one program where it is known which."""

from __future__ import annotations

import os
from typing import Final

from assistant.program.diagnostics import Diagnostic, error
from assistant.program.system.budgets import overrun

INTERNAL_ERROR: Final = error(
    "CL900",
    "robot-assistant itself failed: {kind}: {error}",
    "nothing of it was written; set ROBOT_ASSISTANT_TRACEBACK=1 for the details of a report",
)


def traceback_wanted() -> bool:
    """Whether the error itself is to be raised, for a report on it."""
    return bool(os.environ.get("ROBOT_ASSISTANT_TRACEBACK"))


def internal_error(error: BaseException) -> Diagnostic:
    """The finding that stands for an error: ours, or of what the machine has no more of."""
    return overrun(error, "the command") or INTERNAL_ERROR(kind=type(error).__name__, error=error)
