r"""Data of type rawbytes as numbers in an array that all of them share.

`VAR rawbytes b` becomes the number of its bytes, and `PackRawBytes n,b,1\IntX:=DINT;` a call of a
routine of `tables/bytes.txt`, which the program gets as far as it calls it. Routines are given
that number.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.byte_calls import (
    IN_ROW,
    LENGTH_ARRAY,
    ROWS,
    ByteCalls,
    call_at,
    length_of,
)
from assistant.languages.rapid.lift.plain.byte_sockets import texts_on_byte_sockets
from assistant.languages.rapid.lift.plain.exchanging import rewritten
from assistant.languages.rapid.lift.plain.library import library
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import option
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import inner_names, nodes
from assistant.program.rewriting import rewrite

BYTES_TYPE: Final = "rawbytes"
BYTES_PREFIX: Final = "raw_byte"
MOST_DATA: Final = 40
"""Data of the type in one program."""
_SOCKET_CALLS: Final = ("socketsend", "socketreceive")

ComponentNames = tuple[str, ...]


def with_raw_bytes(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules with numbers for their bytes; themselves if there are none, or not only such."""
    if not any(map(_is_of_bytes, nodes(tuple(modules)))):
        return modules
    said = _RawBytes(modules)
    return said.modules() if said.can_be_said() else modules


def _is_of_bytes(node: Any) -> bool:
    match node:
        case s.Data(type=type) | s.ParameterNode(type=type):
            return type.lower() == BYTES_TYPE
        case s.Record(components=components):
            return any(type.lower() == BYTES_TYPE for type, _ in components)
        case s.ProcedureCall(str(name)) if name.lower() in _SOCKET_CALLS:
            return option(node, "rawdata", "data") is not None
    return False


class _RawBytes:
    """records: the ways to bytes in records, by lower-case type. numbers: by `id` of what declares
    them, of each way, counted from 1. lists: arrays of bytes by name in lower case.
    """

    def __init__(self, modules: Sequence[s.Module]) -> None:
        self.all = modules
        items = [item for module in modules for item in module.items]
        self.routines = [item for item in items if isinstance(item, s.Routine)]
        self.records = _byte_components(items)
        inner = [d for r in self.routines for d in nodes(r.body) if isinstance(d, s.Data)]
        data = [item for item in items if isinstance(item, s.Data)]
        self.types = {d.name.lower(): d.type.lower() for d in (*data, *inner)}
        self.types |= {
            one.name.lower(): one.type.lower()
            for one in nodes(tuple(self.routines))
            if isinstance(one, s.ParameterNode)
        }
        self.fixed = {d.name.lower(): d.value for d in data if d.storage == "CONST"}
        self.numbers: dict[int, dict[ComponentNames, int]] = {}
        self.lists: set[str] = set()
        self.count = 0
        self.sound = True
        for one in (*data, *inner):
            self._counted(one)
        texts = texts_on_byte_sockets(self.routines)
        self.takes_others = bool(texts) or any(
            isinstance(node, s.ProcedureCall) and option(node, "data") is not None
            for node in nodes(tuple(self.routines))
        )
        """True if sockets of bytes take lists of numbers or texts: the last bytes are for these."""
        self.calls = ByteCalls(self.types, self.count + 1, texts)
        self.whole = [d for d in data if d.type.lower() in self.records]
        """Records of modules, whose bytes get their numbers when the program begins."""

    def _counted(self, one: s.Data) -> None:
        low = one.type.lower()
        ways = [()] if low == BYTES_TYPE else self.records.get(low, ())
        if not ways:
            return
        size = 1
        if one.dimensions:
            found = [self._extent(node) for node in one.dimensions]
            if len(found) != 1 or found[0] is None or low != BYTES_TYPE:
                self.sound = False
                return
            size = found[0]
            self.lists.add(one.name.lower())
        self.numbers[id(one)] = {}
        for way in ways:
            self.numbers[id(one)][way] = self.count + 1
            self.count += size

    def _extent(self, node: Any) -> int | None:
        value = self.fixed.get(node.name.lower()) if isinstance(node, s.NameRef) else node
        found = None if value is None else literal_number(value)
        return found if isinstance(found, int) else None

    def can_be_said(self) -> bool:
        """Whether each of them has a number, and nothing has a name of what is added."""
        names = {name.lower() for name in inner_names(self.routines)} | set(self.types)
        names |= {one.name.lower() for one in self.routines}
        added = {BYTES_PREFIX, LENGTH_ARRAY, *(one.name.lower() for one in library())}
        if not self.sound or self.count > MOST_DATA or not names.isdisjoint(added):
            return False
        main = [one for one in self.routines if one.name.lower() == "main"]
        if self.whole and len(main) != 1:
            return False
        return all(self.types[name] == BYTES_TYPE for name in self.lists) and not self._recurs()

    def _recurs(self) -> bool:
        """Whether a routine with bytes of its own may be called while it runs."""
        calls: dict[str, set[str]] = {}
        for one in self.routines:
            called = calls.setdefault(one.name.lower(), set())
            for node in nodes(one):
                if isinstance(node, s.ProcedureCall | s.FunctionCall) and isinstance(
                    node.name, str
                ):
                    called.add(node.name.lower())
        for one in self.routines:
            if any(id(node) in self.numbers for node in one.body):
                key = one.name.lower()
                reached: set[str] = set()
                pending = [*calls[key]]
                while pending:
                    name = pending.pop()
                    if name not in reached:
                        reached.add(name)
                        pending += calls.get(name, ())
                if key in reached:
                    return True
        return False

    def modules(self) -> Sequence[s.Module]:
        made = [self._module(module) for module in self.all]
        count = str(self.count + self.takes_others)
        size = tuple(map(s.NumberLiteral, (count, str(ROWS), str(IN_ROW))))
        data = (
            s.Data("", "PERS", "num", BYTES_PREFIX, size),
            s.Data("", "VAR", "num", LENGTH_ARRAY, size[:1]),
        )
        own = {one.name.lower() for one in self.routines}
        there = tuple(one for one in library() if one.name.lower() not in own)
        first, *others = made
        return (replace(first, items=(*data, *first.items, *there)), *others)

    def _module(self, module: s.Module) -> s.Module:
        made = rewritten(module, self.calls.said)
        items: list[s.Item] = []
        for item in made.items:
            if isinstance(item, s.Routine):
                begun = self._begun(item)
                items.append(rewrite(begun, self._value, ()))
            elif isinstance(item, s.Data):
                items.append(self._declared(item, "CONST"))
            elif isinstance(item, s.Record):
                of = ((self._type(type), name) for type, name in item.components)
                items.append(replace(item, components=tuple(of)))
            else:
                items.append(item)
        return replace(made, items=tuple(items))

    def _type(self, type: str) -> str:
        return "num" if type.lower() == BYTES_TYPE else type

    def _declared(self, item: s.Data, storage: str) -> s.Data:
        numbers = self.numbers.get(id(item))
        if numbers is None or () not in numbers:
            return item
        value = s.NumberLiteral(str(numbers[()]))
        return replace(item, storage=storage, type="num", dimensions=(), value=value)

    def _begun(self, routine: s.Routine) -> s.Routine:
        """A routine whose own bytes are empty at its beginning, and have their numbers."""
        body: list[s.StatementNode] = []
        first: list[s.StatementNode] = []
        if routine.name.lower() == "main":
            for one in self.whole:
                first += self._numbered(one)
        declared = 0
        for at, node in enumerate(routine.body):
            if isinstance(node, s.Data):
                declared = at + 1
                numbers = self.numbers.get(id(node), {})
                first += self._numbered(node) if () not in numbers else ()
                for number in numbers.values():
                    extent = self._extent(node.dimensions[0]) if node.dimensions else 1
                    for each in range(number, number + (extent or 1)):
                        of = s.NumberLiteral(str(each))
                        first.append(call_at("clear_bytes", node, of, s.NumberLiteral("1")))
                node = self._declared(node, "VAR")
            body.append(node)
        if not first and all(a is b for a, b in zip(body, routine.body, strict=True)):
            return routine
        return replace(routine, body=(*body[:declared], *first, *body[declared:]))

    def _numbered(self, one: s.Data) -> Iterator[s.StatementNode]:
        for way, number in self.numbers.get(id(one), {}).items():
            place: Any = s.NameRef(one.name)
            for name in way:
                place = s.Component(place, name)
            yield s.Assignment(place, s.NumberLiteral(str(number)), span=one.span)

    def _value(self, node: Any) -> Any:
        """Elements of lists of bytes, lengths and parameters; any other node as it is."""
        match node:
            case s.ParameterNode(type=type) if type.lower() == BYTES_TYPE:
                return replace(node, mode="", type="num", dimensions=0)
            case s.Element(s.NameRef(name) as base, (index,)) if name.lower() in self.lists:
                if isinstance(index, s.Whole):
                    return base
                before = s.Group(s.Infix("-", s.Group(index), s.NumberLiteral("1")))
                return s.Group(s.Infix("+", base, before))
            case s.FunctionCall(name, (s.Positional(value, None),)):
                if name.lower() == "rawbyteslen":
                    return length_of(value)
                if name.lower() == "socketpeek":
                    return replace(node, name="bytes_waiting")
        return node


def _byte_components(items: Sequence[s.Item]) -> Mapping[str, Sequence[ComponentNames]]:
    """The ways to bytes in each type of records that has any, by lower-case name."""
    known = {one.name.lower(): one for one in items if isinstance(one, s.Record)}
    found: dict[str, Sequence[ComponentNames]] = {}

    def ways(low: str) -> Sequence[ComponentNames]:
        if low not in found:
            found[low] = ()  # a record that holds itself ends here
            parts: list[ComponentNames] = []
            for type, name in known[low].components:
                if type.lower() == BYTES_TYPE:
                    parts.append((name,))
                elif type.lower() in known:
                    parts += ((name, *way) for way in ways(type.lower()))
            found[low] = tuple(parts)
        return found[low]

    return {low: ways(low) for low in known if ways(low)}
