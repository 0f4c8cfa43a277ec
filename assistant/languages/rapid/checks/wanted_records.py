"""Records of types that nobody declares, with what their uses and values tell of their components.

`VAR message m:=[[0,"x"],FALSE];` with `m.data.text` and `m.full` in a program without the type: a
record of a record, with a number and a text, and a truth. Names that are used are given to the
first values that they may be; what has no name is a `part_1`. The cell says what it really is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from assistant.languages.rapid.checks.kinds import NUMBER, Types
from assistant.languages.rapid.tree import syntax as s
from assistant.program.program import TakenNames, identifier
from assistant.program.undeclared_names import Plain, Wanted

_SCALARS: Final[dict[str, Plain]] = {"num": 0.0, "dnum": 0.0, "bool": False, "string": ""}
_ANY_KIND: Final = ""
"""Of a value that may be of any type."""
_BRACKETS: Final = "["


_OWN_PARTS: Final[Mapping[str, tuple[str, ...]]] = {
    "robtarget": ("robconf",),
    "jointtarget": ("robax",),
    "tooldata": ("tframe", "tload"),
    "wobjdata": ("uframe", "oframe", "ufprog", "ufmec"),
    "speeddata": ("v_tcp", "v_ori", "v_leax", "v_reax"),
    "zonedata": ("finep", "pzone_tcp", "pzone_ori", "zone_ori"),
    "loaddata": ("mass", "cog", "aom"),
    "pos": ("x", "y", "z"),
    "orient": ("q1", "q2", "q3", "q4"),
    "confdata": ("cf1", "cf4", "cf6", "cfx"),
}
_RECORD_OF_PART: Final = {part: type for type, parts in _OWN_PARTS.items() for part in parts}
"""Components that one predefined record alone has → that record."""


@dataclass(slots=True)
class RecordUses:
    """A type, or a component that is a record itself.

    parts: by lower-case name. types: of one that is no record, how often its uses want each.
    rows: values in brackets.
    """

    name: str
    parts: dict[str, RecordUses] = field(default_factory=dict)
    types: Counter[str] = field(default_factory=Counter)
    rows: list[s.AggregateNode] = field(default_factory=list)
    uses: dict[str, None] = field(default_factory=dict)

    def note(self, path: Sequence[str], type: str, place: str) -> None:
        """A use of a component of a component …, and the type that is wanted there."""
        if place:
            self.uses.setdefault(place)
        if not path:
            if type:
                self.types[type] += 1
            return
        first, *rest = path
        self.parts.setdefault(first.lower(), RecordUses(first)).note(rest, type, "")

    def join(self, other: RecordUses) -> None:
        for key, part in other.parts.items():
            self.parts.setdefault(key, RecordUses(part.name)).join(part)
        self.types += other.types
        self.uses |= other.uses


@dataclass(frozen=True, slots=True)
class SolvedRecord:
    """Components of a type, (type, name) each, with the value that says least."""

    components: tuple[tuple[str, str], ...]
    nothing: Plain | None


class UndeclaredRecords:
    """The types of a program that nobody declares, or whose components are not known."""

    def __init__(self, types: Types) -> None:
        self.types = types
        self.found: dict[str, RecordUses] = {}
        self.solved: dict[str, SolvedRecord] = {}
        self._names: dict[str, str] = {}
        self._taken = TakenNames()

    def is_open(self, type: str) -> bool:
        """Whether a type may be a record whose components nobody tells."""
        low = type.lower()
        if not low:
            return False
        base = self.types.base(low) or low
        kind = self.types.kind(base)
        return kind == "" or (kind == "RECORD" and not self.types.components(base))

    def note(self, type: str, path: Sequence[str], wanted: str, place: str) -> None:
        self.found.setdefault(type.lower(), RecordUses(type)).note(path, wanted, place)

    def row(self, type: str, value: s.Expression, dimensions: int, place: str) -> None:
        """A value of a type, in an array of so many dimensions."""
        if not isinstance(value, s.AggregateNode):
            return
        if dimensions > 0:
            for item in value.items:
                self.row(type, item, dimensions - 1, place)
            return
        shape = self.found.setdefault(type.lower(), RecordUses(type))
        shape.rows.append(value)
        shape.note((), "", place)

    def owner(self, data: str, parts: RecordUses) -> str:
        """The type of data with components of these names: a new one if no other or several do."""
        names = parts.parts.keys()
        found = [key for key, shape in self.found.items() if names & shape.parts.keys()]
        if len(found) == 1:
            return self.found[found[0]].name
        name = f"{data}_type"
        self.found.setdefault(name.lower(), RecordUses(name))
        return name

    def wanted(self) -> Iterator[Wanted]:
        """The types with their components, as far as those can be."""
        self._taken.update(shape.name for shape in self.found.values())
        for key, shape in list(self.found.items()):
            if self._is_told(key, shape):
                made = list(self._made(shape.name, shape))
                yield from made

    def _is_told(self, key: str, shape: RecordUses) -> bool:
        """Whether it is worth a question: a type of an option only if a component is asked for."""
        return bool(shape.parts) or (bool(shape.rows) and self.types.kind(key) == "")

    def _made(self, name: str, shape: RecordUses) -> Iterator[Wanted]:
        solved = self._solve(name, shape)
        if solved is None:
            return
        inner, outer = solved
        self.solved[name.lower()] = outer
        said = tuple(f"{type} {part}" for type, part in outer.components)
        yield Wanted(name, "record", uses=tuple(shape.uses), nothing=said)
        yield from inner

    def _solve(self, name: str, shape: RecordUses) -> tuple[list[Wanted], SolvedRecord] | None:
        """The components of a record, and the records among them; None if its uses disagree."""
        slots = _kinds_of_values(shape.rows)
        if slots is None:
            return None
        inner: list[Wanted] = []
        found: dict[int, tuple[str, str, Plain | None]] = {}
        parts = sorted(shape.parts.values(), key=lambda part: not part.parts)
        for part in parts:
            at = self._place(part, slots, found) if shape.rows else len(found)
            if at is None:
                return None
            if shape.rows:
                part.rows += _inner_values(shape.rows, at)
                if not part.types and slots[at] in _SCALARS:  # no use tells more than its value
                    part.types[slots[at]] += 1
            said = self._component(name, part, inner)
            if said is None:
                return None
            found[at] = (said[0], part.name, said[1])
        for at, kind in enumerate(slots):
            if at not in found:
                rest = RecordUses(
                    identifier(f"part_{at + 1}", {p.name for p in shape.parts.values()})
                )
                rest.rows += _inner_values(shape.rows, at)
                rest.types[kind or "num"] += kind != _BRACKETS
                said = self._component(name, rest, inner)
                if said is None:
                    return None
                found[at] = (said[0], rest.name, said[1])
        order = [found[at] for at in sorted(found)]
        values = [value for _, _, value in order if value is not None]
        nothing = tuple(values) if len(values) == len(order) else None
        return inner, SolvedRecord(tuple((type, part) for type, part, _ in order), nothing)

    def _component(
        self, owner: str, part: RecordUses, inner: list[Wanted]
    ) -> tuple[str, Plain | None] | None:
        """The type of a component and the value of it that says least."""
        type = part.types.most_common(1)[0][0] if part.types else _ANY_KIND
        type = "num" if type == NUMBER else type
        if part.parts or (part.rows and not self._fits(type, part.rows)):
            name = identifier(f"{owner}_{part.name}", self._taken)[:32]
            self._taken.add(name)
            made = list(self._made(name, part))
            if not made:
                return None
            inner += made
            return name, self.solved[name.lower()].nothing
        type = type or "num"
        return type, _SCALARS.get(self.types.base(type) or type)

    def _place(
        self,
        part: RecordUses,
        slots: Sequence[str],
        taken: dict[int, tuple[str, str, Plain | None]],
    ) -> int | None:
        """The first value that a component may be."""
        type = part.types.most_common(1)[0][0] if part.types else _ANY_KIND
        base = self.types.base(type) or type
        if part.parts or (base and base not in _SCALARS and base != NUMBER):
            kinds: tuple[str, ...] = (_BRACKETS, _ANY_KIND)
        else:
            kinds = ("num" if base in (NUMBER, "dnum") else base, _ANY_KIND)
        elsewhere = not base and not part.parts
        for at, kind in enumerate(slots):
            if at not in taken and (kind in kinds or (elsewhere and kind != _BRACKETS)):
                return at
        return None

    def _fits(self, type: str, rows: Sequence[s.AggregateNode]) -> bool:
        """Whether values in brackets may be of a type that is known."""
        components = self.types.components(self.types.base(type) or type) if type else None
        return bool(components) and all(len(row.items) == len(components or ()) for row in rows)


def _kinds_of_values(rows: Sequence[s.AggregateNode]) -> list[str] | None:
    """What the values of records are, one after the other; None if they are not alike."""
    slots: list[str] = []
    for row in rows:
        kinds = list(map(_value_kind, row.items))
        slots = slots or kinds
        if len(kinds) != len(slots):
            return None
        for at, (one, other) in enumerate(zip(slots, kinds, strict=True)):
            if one and other and one != other:
                return None
            slots[at] = one or other
    return slots


def _inner_values(rows: Sequence[s.AggregateNode], at: int) -> list[s.AggregateNode]:
    items = (row.items[at] for row in rows)
    return [item for item in items if isinstance(item, s.AggregateNode)]


def _value_kind(node: s.Expression) -> str:
    match node:
        case s.AggregateNode():
            return _BRACKETS
        case s.NumberLiteral() | s.Prefix("-" | "+", s.NumberLiteral()):
            return "num"
        case s.StringLiteral():
            return "string"
        case s.BoolLiteral():
            return "bool"
    return _ANY_KIND


def record_of(parts: Sequence[str]) -> str:
    """The predefined record that has a component of a component …, empty if several have."""
    first = parts[0]
    if first in _RECORD_OF_PART:
        return _RECORD_OF_PART[first]
    if first in ("trans", "rot"):
        return "robtarget"
    if first == "extax":
        return "jointtarget" if "robax" in parts else "robtarget"
    return ""
