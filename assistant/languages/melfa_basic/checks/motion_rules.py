"""The findings of motion, interrupts, lines of communication and other programs."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

NEVER_TAUGHT: Final = warning(
    "MB701",
    "the robot is moved to `{name}`, which was never taught: {what}{more}",
    "teach it, or assign it before the move",
)
FLAGS: Final = error(
    "MB702",
    "`{word}` leads from the flag {before} to {after} of `{name}`{more} (controller error 2810)",
    "use `Mov`, teach both with one posture, or write `Type 0,1` behind the move",
)
ARC_STRAIGHT: Final = warning(
    "MB703",
    "{what}: the controller moves straight to the end{more}",
    "use `Mvs`, or put the second point beside the line",
)
ARC_START: Final = info(
    "MB704",
    "the arc starts at `{name}`, {distance:.1f} mm from where the move before ends{more}",
    "let the arc start where the robot is; it moves straight to the start first",
)
FULL_CIRCLE: Final = warning(
    "MB705",
    "`Mvc` drives a full circle back to `{start}`, but the next move starts at `{name}`",
    "write `Mvr` for an arc that ends at its third point",
)
CNT_LEFT: Final = info(
    "MB706",
    "`Cnt 1` is on, so `{word}` may run before the move in front of it has ended",
    "write `Cnt 0` in front of that move",
)
NO_GETM: Final = error(
    "MB707",
    "`{name}` runs in slot {slot} and moves the robot without `GetM` (controller error 3280)",
    "write `RelM` in the program of slot 1, and `GetM 1` in front of the first move of `{name}`",
)
NO_ACT: Final = warning(
    "MB708",
    "the interrupt {number} is switched, but no `Def Act {number}` defines it",
    "define it first, or correct its number",
)
ACT_OFF: Final = warning(
    "MB709", "the interrupt {number} is defined, but never switched on", "write `Act {number}=1`"
)
NO_TOOL: Final = info(
    "MB710",
    "the program moves with the tool that was set last: nothing here sets one",
    "write `Tool` with a position, or `Tool P_NTool`, in front of the first move",
)
NOT_OPENED: Final = warning(
    "MB711",
    "`{word} #{number}` uses a file that nothing here opens",
    "write `Open … As #{number}` in front",
)
NOT_CLOSED: Final = info(
    "MB712",
    "the file {number} is opened, but never closed",
    "write `Close #{number}`; only `End` of the main program closes it otherwise",
)
OPENED_TWICE: Final = warning(
    "MB713",
    "the file {number} is opened again while it is open (controller error 3130)",
    "close it first, or use another number",
)
