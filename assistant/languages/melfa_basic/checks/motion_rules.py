"""The findings of motion, interrupts, lines of communication and other programs."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import Rule, Severity

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO

NEVER_TAUGHT: Final = Rule(
    "MB701",
    WARNING,
    "the robot is moved to `{name}`, which was never taught: {what}{more}",
    "teach it, or assign it before the move",
)
FLAGS: Final = Rule(
    "MB702",
    ERROR,
    "`{word}` leads from the flag {before} to {after} of `{name}`{more} (controller error 2810)",
    "use `Mov`, teach both with one posture, or write `Type 0,1` behind the move",
)
ARC_STRAIGHT: Final = Rule(
    "MB703",
    WARNING,
    "{what}: the controller moves straight to the end{more}",
    "use `Mvs`, or put the second point beside the line",
)
ARC_START: Final = Rule(
    "MB704",
    INFO,
    "the arc starts at `{name}`, {distance:.1f} mm from where the move before ends{more}",
    "let the arc start where the robot is; it moves straight to the start first",
)
FULL_CIRCLE: Final = Rule(
    "MB705",
    WARNING,
    "`Mvc` drives a full circle back to `{start}`, but the next move starts at `{name}`",
    "write `Mvr` for an arc that ends at its third point",
)
CNT_LEFT: Final = Rule(
    "MB706",
    INFO,
    "`Cnt 1` is on, so `{word}` may run before the move in front of it has ended",
    "write `Cnt 0` in front of that move",
)
NO_GETM: Final = Rule(
    "MB707",
    ERROR,
    "`{name}` runs in slot {slot} and moves the robot without `GetM` (controller error 3280)",
    "write `RelM` in the program of slot 1, and `GetM 1` in front of the first move of `{name}`",
)
NO_ACT: Final = Rule(
    "MB708",
    WARNING,
    "the interrupt {number} is switched, but no `Def Act {number}` defines it",
    "define it first, or correct its number",
)
ACT_OFF: Final = Rule(
    "MB709",
    WARNING,
    "the interrupt {number} is defined, but never switched on",
    "write `Act {number}=1`",
)
NO_TOOL: Final = Rule(
    "MB710",
    INFO,
    "the program moves with the tool that was set last: nothing here sets one",
    "write `Tool` with a position, or `Tool P_NTool`, in front of the first move",
)
NOT_OPENED: Final = Rule(
    "MB711",
    WARNING,
    "`{word} #{number}` uses a file that nothing here opens",
    "write `Open … As #{number}` in front",
)
NOT_CLOSED: Final = Rule(
    "MB712",
    INFO,
    "the file {number} is opened, but never closed",
    "write `Close #{number}`; only `End` of the main program closes it otherwise",
)
OPENED_TWICE: Final = Rule(
    "MB713",
    WARNING,
    "the file {number} is opened again while it is open (controller error 3130)",
    "close it first, or use another number",
)
