"""Routines that are given what only a name can be, and the ways in which they are called."""

from __future__ import annotations

from dataclasses import dataclass, field

from assistant.languages.rapid.lift.plain.changing import assigned_names
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inner_names, nodes

CallArguments = tuple[s.Expression | None, ...]
"""What a call gives for the parameters that a copy has not, in their order; None for nothing."""


@dataclass(frozen=True, slots=True)
class CopiedParameter:
    """One of a routine. place: among the required ones, -1 of an optional one."""

    node: s.ParameterNode
    place: int

    @property
    def key(self) -> str:
        return self.node.name.lower()

    @property
    def is_copied(self) -> bool:
        """Whether it is an array by its value."""
        return bool(self.node.dimensions) and not self.node.mode


@dataclass(slots=True)
class CallPattern:
    """A routine that copies are made of. ways: what it is called with, and the name of the copy.

    stays: somebody calls it in a way that no copy is for. hidden: names of its own, and changed:
    those that it assigns to, in lower case. runs: it has moves in columns, whose settings are
    names.
    """

    node: s.Routine
    parameters: tuple[CopiedParameter, ...]
    ways: dict[tuple[str | None, ...], tuple[str, CallArguments]] = field(default_factory=dict)
    stays: bool = False
    hidden: frozenset[str] = frozenset()
    changed: frozenset[str] = frozenset()
    runs: bool = False

    @staticmethod
    def of(node: s.Routine, parameters: tuple[CopiedParameter, ...]) -> CallPattern:
        hidden = frozenset(name.lower() for name in inner_names((node,)))
        runs = any(isinstance(inner, s.MoveRunNode) for inner in nodes(node))
        changed = frozenset(assigned_names(node))
        return CallPattern(node, parameters, hidden=hidden, changed=changed, runs=runs)
