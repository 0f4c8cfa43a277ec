"""What is found where FMUs are made."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, warning

NO_COMPILER: Final = warning(
    "BL401",
    "there is no C compiler here, so the FMU holds its source only",
    "install one (gcc, clang or the Python package ziglang) and write it again, or compile "
    "sources/model.c where it is to run",
)
NO_CROSS_COMPILER: Final = warning(
    "BL402",
    "there is no compiler here that makes libraries for {platform}",
    "install {what}, or write the FMU again on such a machine",
)
NOT_COMPILED: Final = error(
    "BL403",
    "{compiler} does not compile the FMU: {reason}",
    "look at what that compiler needs, or have another one first in PATH",
)
TOO_MANY_ROWS: Final = error(
    "BL404",
    "{seconds:.0f} s at {period:g} s make {rows} rows, more than {most}",
    "take a period of {least:g} s or longer",
)
NO_MOTION: Final = error(
    "BL405", "the program takes no time, so there is no motion to play", "let it move the arm"
)
NO_LIVE_CONTROLLER: Final = error(
    "BL406",
    "{title} has a controller {controller}, which no live FMU speaks with",
    "choose an arm of a CR controller, or lead this one from Python",
)
BAD_CYCLE: Final = error(
    "BL407", "{value:g} s is no cycle of a controller", "give 0.001 to 0.1 seconds"
)
PARTLY_PLAYED: Final = warning(
    "BL408",
    "the FMU plays the program as far as it is known before it runs: {what}",
    "state its places in numbers, and look at a run of it beside the FMU",
)
