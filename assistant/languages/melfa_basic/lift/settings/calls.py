"""What a statement calls that may change settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from assistant.languages.melfa_basic.lift.settings.held import ALL_SETTINGS
from assistant.languages.melfa_basic.lift.structure.regions import Region, place_name
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import exits_of
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program.program import identifier

Calls = Callable[[s.Statement], Iterable[int | frozenset[int]]]
"""Numbers of the regions that a statement calls, or the settings that a program elsewhere sets."""


def calls_of(parts: Sequence[Region], touched: Mapping[str, frozenset[int]]) -> Calls:
    """touched: the settings that each program sets, by its name in upper case."""
    by_label = {region.label: k for k, region in enumerate(parts) if region.label}
    by_name = {r.function.name.upper(): k for k, r in enumerate(parts) if r.function}

    def calls(statement: s.Statement) -> Iterable[int | frozenset[int]]:
        match statement:
            case s.CallP(program=s.String(value=name)):
                yield touched.get(identifier(name).upper(), ALL_SETTINGS)
            case s.CallP():
                yield ALL_SETTINGS
            case s.Jump() | s.OnJump():
                for target in exits_of(statement).calls:
                    yield by_label.get(place_name(target), ALL_SETTINGS)
        if by_name:
            node = statement.condition if isinstance(statement, s.If) else statement
            for part in nodes(node):
                if isinstance(part, s.Variable) and part.key in by_name:
                    if part is not getattr(statement, "target", None):
                        yield by_name[part.key]

    return calls
