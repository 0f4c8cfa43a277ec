"""Signals that share a number, and groups that are compared with numbers they never have."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.base.diagnostics import Declared, Diagnostic, Severity, warning
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import used_signal_names
from assistant.program.program import Program, walk
from assistant.program.rewriting import head, records

SHARED_NUMBER: Final = warning(
    "CK121",
    "`{name}` and `{other}` are both the {kind} {direction} {number}",
    "give each signal its own number, or use one name for it",
)
BEYOND_BITS: Final = warning(
    "CK122",
    "`{name}` has {bits} bits, 0 to {most}, and is compared with {value:g}",
    "give the group as many bits as the number needs, or correct the number",
)
LEAST_SIGNED_BITS: Final = 16
"""Bits from which on controllers may take a group for a number with a sign."""
COMPARISONS: Final = frozenset(("=", "<>", "<", ">", "<=", ">="))


def shared_numbers(program: Program) -> Iterator[Diagnostic]:
    """Signals of one kind and direction with the same number: an error if both are used.

    A digital signal may be a bit of a group: controllers read both. So they do with a group input
    that is the lower bits of a wider one, which is mostly a mistake all the same.
    """
    used: set[str] | None = None
    found: dict[tuple[str, str, int], str] = {}
    for name, signal in program.signals.items():
        if signal.number is None:
            continue
        key = (signal.kind, signal.direction, signal.number)
        other = found.setdefault(key, name)
        if other != name:
            used = used_signal_names(program) if used is None else used
            both = {name.lower(), other.lower()} <= used
            if signal.direction == "input" and signal.bits != program.signals[other].bits:
                both = False
            yield SHARED_NUMBER(
                severity=Severity.ERROR if both else Severity.WARNING,
                name=name,
                other=other,
                kind=signal.kind,
                direction=signal.direction,
                number=signal.number,
                about=Declared(name, "signals"),
            )


def group_values(program: Program) -> Iterator[Diagnostic]:
    """Comparisons of groups, and of data that was read from one, with numbers beyond their bits."""
    groups = {
        name.lower(): (name, signal.bits)
        for name, signal in program.signals.items()
        if signal.kind == "group" and signal.number is not None
    }
    if not groups:
        return
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            names = groups
            if isinstance(statement, p.While):  # an answer is asked for until it is in its range
                names = {**groups, **_group_data(statement.body, groups)}
            for name, bits, value in _group_comparisons(statement, names):
                most = 2**bits - 1
                least = -(2 ** (bits - 1)) if bits >= LEAST_SIGNED_BITS else 0
                if not least <= value <= most:
                    yield BEYOND_BITS(
                        name=name, bits=bits, most=most, value=value, span=statement.span
                    )


def _group_data(
    body: tuple[p.Statement, ...], groups: dict[str, tuple[str, int]]
) -> dict[str, tuple[str, int]]:
    """By lower-case name the data that a loop reads from groups, with the group."""
    return {
        x.target.name.lower(): groups[x.value.name.lower()]
        for x in body
        if isinstance(x, p.Assign) and isinstance(x.target, e.Name) and isinstance(x.value, e.Name)
        if x.value.name.lower() in groups
    }


def _group_comparisons(
    statement: p.Statement, names: dict[str, tuple[str, int]]
) -> Iterator[tuple[str, int, float]]:
    """Groups of a statement, their bits, and the numbers that they are compared with."""
    if isinstance(statement, p.WaitSignal) and isinstance(statement.value, e.Number):
        if statement.signal.lower() in names:
            yield *names[statement.signal.lower()], float(statement.value.value)
    for part in records(head(statement)):
        match part:
            case e.Binary(operator, e.Name(name), e.Number(value)) | e.Binary(
                operator, e.Number(value), e.Name(name)
            ) if operator in COMPARISONS and name.lower() in names:
                yield *names[name.lower()], float(value)
