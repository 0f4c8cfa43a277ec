"""What data of a type consist of: the parts that a plain program has a variable for each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from assistant.languages.rapid.tables.predefined import types as predefined
from assistant.languages.rapid.tables.words import VALUE_OF_TYPE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.signatures import MOST_ALIASES, Type

ComponentPath = tuple[str, ...]
"""Names of components in lower case, the outermost first; empty of the whole."""

SETTING_TYPES: Final = frozenset(("tooldata", "wobjdata", "speeddata", "zonedata"))
"""Records that moves name: they have a place of their own in the pseudo-program."""
READ_ONLY_TYPES: Final = SETTING_TYPES | {"loaddata"}
"""Types of data that instructions only read, though they want them to be PERS."""
SPEED_AND_ZONE: Final = frozenset(("speeddata", "zonedata"))
"""Those of them that a move may also state by their parts."""
MOST_PARTS: Final = 400
"""Of one record; larger ones stay whole."""


@dataclass(frozen=True, slots=True)
class Part:
    """One value in a record. name: as its type spells it. type: without aliases, lower case."""

    path: ComponentPath
    name: str
    type: str


class RecordLayouts:
    """The types of a program: its own and those that every controller knows.

    A tool, frame, speed or zone in a record stays one value where a move or another instruction is
    given the component. apart: types of those that do not.
    """

    def __init__(self, modules: Sequence[s.Module], apart: frozenset[str] = frozenset()) -> None:
        self._whole = SETTING_TYPES - apart
        self._named = frozenset(_passed_components(modules))
        self._types: dict[str, Type] = dict(predefined())
        self._parts: dict[str, tuple[Part, ...] | None] = {}
        declared: dict[str, list[Type]] = {}
        for item in (item for module in modules for item in module.items):
            match item:
                case s.Alias(_, of, name):
                    declared.setdefault(name.lower(), []).append(Type(name, "ALIAS", of))
                case s.Record(_, name, components):
                    known = {inner: type for type, inner in components}
                    whole = len(known) == len(components)
                    found = Type(name, "RECORD", components=known if whole else None)
                    declared.setdefault(name.lower(), []).append(found)
        for name, types in declared.items():
            said = {(one.kind, one.of.lower(), *(one.components or {}).items()) for one in types}
            self._types[name] = types[0] if len(said) == 1 else Type(name, "OTHER")

    def base(self, type: str) -> str:
        """The type itself in lower case, of an alias what it stands for."""
        low = type.lower()
        for _ in range(MOST_ALIASES):
            found = self._types.get(low)
            if found is None or not found.of:
                break
            low = found.of.lower()
        return low

    def kind(self, type: str) -> str:
        """What a type is in the words of its table, empty if nothing declares it."""
        found = self._types.get(self.base(type))
        return "" if found is None else found.kind

    def components(self, type: str) -> tuple[tuple[str, str], ...]:
        """Names and types of the components of a record, none of any other type."""
        found = self._types.get(self.base(type))
        return () if found is None else tuple((found.components or {}).items())

    def component(self, type: str, name: str) -> str | None:
        """The type of a component without aliases, None if there is none of that name."""
        low = name.lower()
        found = (of for inner, of in self.components(type) if inner.lower() == low)
        return next(map(self.base, found), None)

    def is_whole(self, type: str) -> bool:
        """Whether the pseudo-program has one variable for a value of a type."""
        return self.base(type) in VALUE_OF_TYPE

    def parts(self, type: str) -> tuple[Part, ...] | None:
        """The values in a record, None of what is no record or not known in all its parts."""
        base = self.base(type)
        if base not in self._parts:
            self._parts[base] = None  # a record that holds itself ends here
            found = None if self.is_whole(base) else self._found(base)
            self._parts[base] = found if found and len(found) <= MOST_PARTS else None
        return self._parts[base]

    def _found(self, base: str) -> tuple[Part, ...] | None:
        listed: list[Part] = []
        for name, of in self.components(base):
            kind = self.base(of)
            inner = self.parts(kind)
            unknown = inner is None and kind in self._types and not self.components(kind)
            named = kind in self._whole and name.lower() in self._named
            if unknown or named or self.is_whole(kind):
                listed.append(Part((name.lower(),), name, kind))
            elif inner is None:
                return None
            else:
                listed += (
                    Part((name.lower(), *one.path), f"{name}_{one.name}", one.type) for one in inner
                )
        return tuple(listed) or None


def _passed_components(modules: Sequence[s.Module]) -> Iterator[str]:
    """Components in lower case that calls are given as they are."""
    for node in nodes(tuple(modules)):
        match node:
            case s.Positional(s.Component(_, name)) | s.Option(_, s.Component(_, name)):
                yield name.lower()
