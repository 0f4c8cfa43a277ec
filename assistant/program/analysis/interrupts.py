"""The interrupts of a program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from assistant.program import statements as p
from assistant.program.contents import records_in_body
from assistant.program.program import Program


def interrupts(program: Program) -> tuple[p.Interrupt, ...]:
    """Wherever they are defined, in order of the text."""
    return tuple(one for q in program.procedures for one in records_in_body(q, p.Interrupt))


def numbered_interrupts(program: Program, numbers: Sequence[int]) -> dict[str, int]:
    """The number of each by its lower-case name; those beyond the numbers have none."""
    names = dict.fromkeys(node.name.lower() for node in interrupts(program))
    return dict(zip(names, numbers, strict=False))


def interrupt_names(program: Program, numbers: Mapping[str, int]) -> dict[str, str]:
    """The name that each number stands for."""
    known = {node.name.lower(): node.name for node in interrupts(program)}
    return {str(number): known[key] for key, number in numbers.items()}
