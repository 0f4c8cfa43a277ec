"""What routines may change while they run, and which may be called again while they do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from assistant.languages.rapid.lift.plain.layouts import READ_ONLY_TYPES
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.signatures import Parameter
from assistant.program.analysis.uses import recursive_names

Routines = Mapping[str, Sequence[s.Routine]]
"""Those of a program by lower-case name."""
_ANY_TRAP: Final = "trap"
"""All that may run at any time; a word of the language, which no routine has for its name."""


def call_graph(routines: Routines) -> Mapping[str, set[str]]:
    """By routine what it calls, in lower case; empty for a name that is worked out."""
    return {
        key: {name for one in own for name in _called_names(one)} for key, own in routines.items()
    }


def _called_names(routine: s.Routine) -> set[str]:
    return {
        one.name.lower() if isinstance(one.name, str) else ""
        for one in nodes(routine)
        if isinstance(one, s.ProcedureCall | s.FunctionCall)
    }


def reentrant_routines(calls: Mapping[str, set[str]]) -> frozenset[str]:
    """Routines that may be called again while they run; a name that is worked out may be any."""
    return recursive_names({**calls, "": frozenset(calls)})


def assigned_names(routine: s.Routine) -> set[str]:
    """Names that a routine assigns to, in lower case."""
    targets = (root(one.target) for one in nodes(routine) if isinstance(one, s.Assignment))
    return {one.name.lower() for one in targets if one is not None}


class ChangedData:
    """Which data routines may change, by names in lower case."""

    def __init__(self, routines: Routines) -> None:
        self._known = routines
        self._own: dict[int, frozenset[str]] = {}
        self._calls: dict[str, set[str]] = {}
        traps = [one for own in routines.values() for one in own if one.kind == "TRAP"]
        self._all = {**routines, _ANY_TRAP: traps}

    def of(self, routine: str) -> frozenset[str] | None:
        """All that may be changed until a routine comes back; None if nobody knows."""
        found: set[str] = set()
        seen: set[str] = set()
        pending = [routine, _ANY_TRAP]
        while pending:
            key = pending.pop()
            if key in seen or key not in self._all:
                continue
            seen.add(key)
            if key not in self._calls:
                self._calls[key] = {name for one in self._all[key] for name in _called_names(one)}
            if "" in self._calls[key]:
                return None
            found = found.union(*map(self.own, self._all[key]))
            pending += self._calls[key]
        return frozenset(found)

    def own(self, routine: s.Routine) -> frozenset[str]:
        """What a routine itself assigns to, or hands to what may change it."""
        if id(routine) not in self._own:
            changed = assigned_names(routine)
            self._own[id(routine)] = frozenset(changed)  # for one that calls itself
            for one in nodes(routine):
                if isinstance(one, s.ProcedureCall | s.FunctionCall):
                    changed |= self.by(one)
            self._own[id(routine)] = frozenset(changed)
        return self._own[id(routine)]

    def by(self, call: s.ProcedureCall | s.FunctionCall) -> set[str]:
        """What a call hands to a routine that may change it."""
        known = self._known.get(call.name.lower()) if isinstance(call.name, str) else None
        changed: set[str] = set()
        if known is None:
            found = signature(call.name) if isinstance(call.name, str) else None
            alternatives = () if found is None else (a for q in found.slots for a in q.alternatives)
            if found is None or any(a.mode and not _is_only_read(a) for a in alternatives):
                for argument in call.arguments:
                    match argument:
                        case s.Conditional(_, value) | s.Option(_, value) | s.Positional(value):
                            place = root(value)
                    changed |= set() if place is None else {place.name.lower()}
            return changed
        plain = [a.value for a in call.arguments if isinstance(a, s.Positional)]
        options: dict[str, s.Expression] = {}
        for argument in call.arguments:
            match argument:
                case s.Option(name, value) | s.Conditional(name, value) if value is not None:
                    options[name.lower()] = value
        for routine in known:
            own, places = self.own(routine), iter(plain)
            for group in routine.parameters:
                at = None if group.optional else next(places, None)
                for one in group.alternatives:
                    if isinstance(one, s.ParameterNode) and one.mode and one.name.lower() in own:
                        given = root(options.get(one.name.lower(), at))
                        changed |= set() if given is None else {given.name.lower()}
        return changed


def _is_only_read(slot: Parameter) -> bool:
    """Whether an instruction only reads what it wants to be persistent."""
    return slot.mode == "PERS" and slot.type in READ_ONLY_TYPES
