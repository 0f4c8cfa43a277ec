"""What is wrong with connections of blocks."""

from __future__ import annotations

from assistant.program.diagnostics import error

NO_STATEMENTS = error(
    "BL201",
    "`{name}` at {address} carries out no single statements",
    "name a controller of Mitsubishi's CR family, by the address of its controller link",
)
OUT_OF_LIMITS = error(
    "BL202",
    "block `{block}` is to go to J{axis} {value:.2f}, outside {low:g} to {high:g}",
    "give it joints that {robot} reaches",
)
NO_NUMBERS = error(
    "BL203", "block `{block}` is to go to a place of numbers that are none", "look at its source"
)
NOT_IN_STEP = error(
    "BL204",
    "a virtual controller does not keep step with the model: {reason}",
    "look at its program, or run the model in real time",
)
