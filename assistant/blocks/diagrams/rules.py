"""What is wrong with block diagrams and their runs."""

from __future__ import annotations

from assistant.base.diagnostics import error, warning

SAME_BLOCK_NAME = error("BL101", "two blocks are called `{name}`", "rename one of them")
NO_PORT = error("BL102", "block `{block}` has no {kind} `{name}`", "write one of {known}")
TWO_WIRES = error(
    "BL103", "two wires lead to `{port}` of `{block}`", "take one of them out, or add the signals"
)
NO_WIRE = error("BL104", "nothing leads to `{port}` of `{block}`", "wire it, or give it a constant")
OTHER_SIGNAL_SIZE = error(
    "BL105",
    "`{start}` gives {given} numbers, and `{end}` takes {wanted}",
    "wire a signal of the same size",
)
OTHER_SIGNAL_UNIT = warning(
    "BL106", "`{start}` is in {given}, and `{end}` is taken as {wanted}", "convert it in between"
)
ALGEBRAIC_LOOP = error(
    "BL107",
    "blocks {names} wait for each other within a step",
    "put a delay or another block that is not direct into the loop",
)
BAD_STEP = error("BL108", "{what} is {value} s", "{cure}")
BLOCK_OF_NO_DIAGRAM = error(
    "BL109", "block `{name}` is of no diagram", "add it before it is wired, each block to one"
)
BLOCK_FAILED = error(
    "BL110", "block `{name}` failed at {now:g} s: {reason}", "look at what it is given"
)
MOTION_NOT_CONFIRMED = error(
    "BL111",
    "block `{block}` moves the arm of `{name}`, and nobody confirmed it; nothing was begun",
    "look that nobody is near, then run it with moving=[{name!r}]",
)
