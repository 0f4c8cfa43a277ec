"""Bytes, lines and files of channels, in statements that other languages have.

All data of type rawbytes share one array of numbers, 1024 bytes each: `VAR rawbytes b` becomes its
number in that array, which routines take instead. `PackRawBytes` becomes a call of a routine of
`tables/bytes.txt` (reference manual of instructions: PackRawBytes, UnpackRawBytes and related
instructions, SocketSend, SocketReceive). A socket of bytes connects to a gateway that accepts only
bytes: texts on that socket, under any of its names, are sent as the bytes of their characters. A
loop that receives a text byte by byte, up to the end of a line or a comma, becomes `ReadStr` or
`ReadNum`: `lower/` writes channels of other languages as loops of this kind. A removed file becomes
an empty one, also where the program first asks if it exists.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.languages.patterns import Called
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.data_names import FreshNames
from assistant.languages.rapid.lift.flatten.library import function_call, library
from assistant.languages.rapid.lift.flatten.tree_rewriting import rewritten
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import called, inner_names, mentions, nodes, option
from assistant.program.rewriting import rewrite

_LENGTH_ARRAY: Final = "raw_length"
_ROWS: Final = 8
_IN_ROW: Final = 128
"""Bytes per row, for controllers whose arrays end at 999: 1024 bytes in rows for each data."""
_WHOLE_SIZES: Final = {
    "usint": 1, "uint": 2, "udint": 4, "ulint": 8, "sint": -1, "int": -2, "dint": -4, "lint": -8,
}  # fmt: skip
"""Bytes of the whole numbers that inttypes names, negative of those with a sign."""
_MOST_BYTES: Final = _ROWS * _IN_ROW
_LONGEST_TEXT: Final = 80
"""Characters of a text (reference manual: string); what comes after them is received next."""
_DEFAULT_TIMEOUT: Final = "60"
r"""Seconds that a socket waits without `\Time` (reference manual: SocketReceive)."""
_LOOP_VARIABLE: Final = "raw_at"
"""The variable of the loops that go through lists of numbers."""
_ASSIGNABLE: Final = (s.NameRef, s.Component, s.Element)
"""Expressions that take a value."""
_NUMBER_TYPES: Final = frozenset(("num", "dnum", "byte"))


class _ByteCalls:
    """types: of data and parameters by name, all in lower case. own: the number of the bytes that
    lists of numbers and texts go through. texts: `id` of calls with texts that sockets of bytes
    send or receive.
    """

    def __init__(self, types: Mapping[str, str], own: int, texts: Set[int] = frozenset()) -> None:
        self.types, self.own, self.texts = types, own, texts

    def said(self, node: s.StatementNode) -> Iterator[s.StatementNode]:
        call = called(node) if isinstance(node, s.ProcedureCall) else None
        word = "" if call is None else call.word.lower()
        made = (
            None if call is None or word not in _LOWERINGS else _LOWERINGS[word](self, node, call)
        )
        if made is None:
            yield node
        else:
            yield from made

    def pack(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        if len(call.given) != 3 or None in call.given:
            return None
        value, raw, at = call.given
        order = s.BoolLiteral("network" in call.options)
        match _byte_format(call):
            case "hex1", None:
                return (_call_at("put_byte", node, raw, at, value),)
            case "intx", s.Node() as kind:
                return (
                    _call_at("pack_whole", node, value, raw, at, _whole_number_kind(kind), order),
                )
            case "float4", None:
                return (_call_at("pack_float", node, value, raw, at, order),)
            # A byte may be packed as the character that it is the code of.
            case "ascii", None if self._is_number(value):
                return (_call_at("put_byte", node, raw, at, value),)
            case "ascii", None:
                return (_call_at("pack_text", node, value, raw, at),)
        return None

    def unpack(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        if len(call.given) != 3 or None in call.given:
            return None
        raw, at, target = call.given
        order = s.BoolLiteral("network" in call.options)
        match _byte_format(call):
            case "hex1", None:
                value = function_call("byte_at", *_whole_list(raw, at))
            case "intx", s.Node() as kind:
                value = function_call(
                    "unpack_whole", *_whole_list(raw, at, _whole_number_kind(kind), order)
                )
            case "float4", None:
                value = function_call("unpack_float", *_whole_list(raw, at, order))
            case "ascii", s.Node() if self._is_number(target):
                value = function_call("byte_at", *_whole_list(raw, at))
            case "ascii", s.Node() as count:
                value = function_call("unpack_text", *_whole_list(raw, at, count))
            case _:
                return None
        if not isinstance(target, _ASSIGNABLE):
            return None
        return (s.Assignment(target, value, span=node.span),)

    def clear(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        if len(call.given) != 1 or not set(call.options) <= {"fromindex"}:
            return None
        first = call.options.get("fromindex") or s.NumberLiteral("1")
        return (_call_at("clear_bytes", node, call.given[0], first),)

    def copy(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        if len(call.given) != 4 or not set(call.options) <= {"noofbytes"}:
            return None
        raw, first, into, at = call.given
        count = call.options.get("noofbytes")
        # Without a number, the rest of the bytes is copied.
        if count is None:
            left = s.Infix("-", _length_of(raw), s.Group(_whole_list(first)[0]))
            count = s.Infix("+", left, s.NumberLiteral("1"))
        return (_call_at("copy_bytes", node, raw, first, into, at, count),)

    def send(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        given, count = call.options, call.options.get("noofbytes")
        if len(call.given) != 1 or not set(given) <= {"rawdata", "data", "str", "noofbytes"}:
            return None
        # The gateway on this socket takes bytes only, so the text goes through the bytes of the
        # program.
        if (text := given.get("str")) is not None and id(node) in self.texts:
            own, first = self._own(), s.NumberLiteral("1")
            return (
                _call_at("clear_bytes", node, own, first),
                _call_at("pack_text", node, text, own, first),
                _call_at("send_bytes", node, call.given[0], own, count or _length_of(own)),
            )
        raw, array = given.get("rawdata"), _named_list(given.get("data"))
        if raw is not None:
            return (_call_at("send_bytes", node, call.given[0], raw, count or _length_of(raw)),)
        if array is None:
            return None
        own, at, first = self._own(), s.NameRef(_LOOP_VARIABLE), s.NumberLiteral("1")
        size = count or function_call("Dim", array, first)
        put = _call_at("put_byte", node, own, at, s.Element(array, (at,)))
        return (
            _call_at("clear_bytes", node, own, first),
            s.ForLoop(_LOOP_VARIABLE, first, size, first, (put,), span=node.span),
            _call_at("send_bytes", node, call.given[0], own, _length_of(own)),
        )

    def receive(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        given, asked = call.options, call.options.get("readnoofbytes")
        known = {"rawdata", "data", "str", "readnoofbytes", "norecbytes", "time"}
        if len(call.given) != 1 or not set(given) <= known:
            return None
        raw, array = given.get("rawdata"), _named_list(given.get("data"))
        text = given.get("str") if id(node) in self.texts else None
        if raw is None and array is None and not isinstance(text, _ASSIGNABLE):
            return None
        into = self._own() if raw is None else raw
        longest = _MOST_BYTES if text is None else _LONGEST_TEXT
        # Without a number, the first bytes that arrive end the wait.
        least, most = (asked or s.NumberLiteral("1")), (asked or s.NumberLiteral(str(longest)))
        seconds = given.get("time") or s.NumberLiteral(_DEFAULT_TIMEOUT)
        made: list[s.StatementNode] = [
            _call_at("receive_bytes", node, call.given[0], into, least, most, seconds)
        ]
        if array is not None and raw is None:
            at, first = s.NameRef(_LOOP_VARIABLE), s.NumberLiteral("1")
            value = function_call("byte_at", into, at)
            put = s.Assignment(s.Element(array, (at,)), value, span=node.span)
            made.append(
                s.ForLoop(_LOOP_VARIABLE, first, _length_of(into), first, (put,), span=node.span)
            )
        if isinstance(text, _ASSIGNABLE):
            value = function_call("unpack_text", into, s.NumberLiteral("1"), _length_of(into))
            made.append(s.Assignment(text, value, span=node.span))
        count = given.get("norecbytes")
        if isinstance(count, _ASSIGNABLE):
            made.append(s.Assignment(count, _length_of(into), span=node.span))
        return made

    def _own(self) -> s.Expression:
        """The bytes that lists of numbers go through."""
        return s.NumberLiteral(str(self.own))

    def _is_number(self, value: Any) -> bool:
        match value:
            case s.NumberLiteral():
                return True
            case s.NameRef(name):
                return self.types.get(name.lower(), "") in _NUMBER_TYPES
        return False


def _length_of(raw: Any) -> s.Element:
    return s.Element(s.NameRef(_LENGTH_ARRAY), (raw,))


def _named_list(node: s.Expression | None) -> Any:
    """Return the array passed by its name, None for anything else."""
    match node:
        case s.NameRef():
            return node
        case s.Element(s.NameRef() as name, (s.Whole(),)):
            return name
    return None


def _whole_list(*values: s.Expression | None) -> tuple[s.Expression, ...]:
    return tuple(value for value in values if value is not None)


def _call_at(name: str, node: Any, *given: s.Expression | None) -> s.ProcedureCall:
    """A call that stands for a statement, at its place."""
    return s.ProcedureCall(name, tuple(map(s.Positional, _whole_list(*given))), span=node.span)


def _byte_format(call: Called[s.Expression]) -> tuple[str, s.Expression | None]:
    """The option that says what bytes mean, with its value."""
    # `\Network` gives the order of bytes; exactly one other option gives their meaning.
    found = [(name, value) for name, value in call.options.items() if name != "network"]
    return found[0] if len(found) == 1 else ("", None)


def _whole_number_kind(node: s.Expression) -> s.Expression:
    """The number of a type of whole numbers that is named."""
    known = _WHOLE_SIZES.get(node.name.lower()) if isinstance(node, s.NameRef) else None
    if known is None:
        return node
    size = s.NumberLiteral(str(abs(known)))
    return s.Prefix("-", size) if known < 0 else size


_ByteLowering = Callable[[_ByteCalls, Any, Called[s.Expression]], Sequence[s.StatementNode] | None]
_LOWERINGS: Final[Mapping[str, _ByteLowering]] = {
    "packrawbytes": _ByteCalls.pack,
    "unpackrawbytes": _ByteCalls.unpack,
    "clearrawbytes": _ByteCalls.clear,
    "copyrawbytes": _ByteCalls.copy,
    "socketsend": _ByteCalls.send,
    "socketreceive": _ByteCalls.receive,
}
"""By lower-case names of instructions."""


_SOCKET_INSTRUCTIONS: Final = frozenset(("socketsend", "socketreceive"))
"""Instructions in lower case, whose first argument is a socket."""
_BYTE_OPTIONS: Final = ("rawdata", "data")
_PEEK_FUNCTION: Final = "socketpeek"

_SocketKey = tuple[str, str]
"""A routine, empty for data of a module, and the name of what is a socket there or has one."""


def _texts_on_byte_sockets(routines: Sequence[s.Routine]) -> Set[int]:
    """The calls with texts, by `id`, whose sockets also send or receive bytes."""
    same = _SocketNames()
    own = {one.name.lower(): one for one in routines}
    inner = {one.name.lower(): frozenset(_names_of_routine(one)) for one in routines}
    bytes_of: list[_SocketKey] = []
    texts: list[tuple[_SocketKey, s.Node]] = []
    for routine in routines:
        low = routine.name.lower()
        for node in nodes(routine):
            if not isinstance(node, s.ProcedureCall | s.FunctionCall):
                continue
            if not isinstance(node.name, str):
                continue
            word = node.name.lower()
            if word in _SOCKET_INSTRUCTIONS or word == _PEEK_FUNCTION:
                key = _socket_key(next(iter(node.arguments), None), low, inner[low])
                if key is not None and (
                    word == _PEEK_FUNCTION or option(node, *_BYTE_OPTIONS) is not None
                ):
                    bytes_of.append(key)
                elif key is not None and option(node, "str") is not None:
                    texts.append((key, node))
            elif word in own:
                for given, name in _arguments_by_parameter(node, own[word]):
                    key = _socket_key(given, low, inner[low])
                    if key is not None:
                        same.join(key, (word, name))
    # All joins are made by now, so every key has its final representative.
    found = {same.first(key) for key in bytes_of}
    return frozenset(id(node) for key, node in texts if same.first(key) in found)


def _names_of_routine(routine: s.Routine) -> Iterator[str]:
    """Names in lower case of the parameters and the data of a routine."""
    for node in nodes(routine):
        if isinstance(node, s.ParameterNode | s.Data):
            yield node.name.lower()


def _socket_key(given: Any, routine: str, inner: Set[str]) -> _SocketKey | None:
    """Arguments by the name that each begins with."""
    value = given.value if isinstance(given, s.Positional | s.Option) else None
    while isinstance(value, s.Component | s.Element):
        value = value.value
    if not isinstance(value, s.NameRef):
        return None
    name = value.name.lower()
    return (routine if name in inner else "", name)


def _arguments_by_parameter(
    call: s.ProcedureCall | s.FunctionCall, routine: s.Routine
) -> Iterator[tuple[s.Argument, str]]:
    """Arguments of a call, with the name of the parameter in lower case."""
    required = [one for one in routine.parameters if not one.optional]
    given = [one for one in call.arguments if isinstance(one, s.Positional)]
    for value, group in zip(given, required, strict=False):
        for one in _alternative_names(group.alternatives):
            yield value, one
    known = {one for group in routine.parameters for one in _alternative_names(group.alternatives)}
    for argument in call.arguments:
        if isinstance(argument, s.Option) and argument.name.lower() in known:
            yield argument, argument.name.lower()


def _alternative_names(alternatives: Iterable[Any]) -> Iterator[str]:
    return (one.name.lower() for one in alternatives if isinstance(one, s.ParameterNode))


class _SocketNames:
    """Names that stand for the same thing."""

    def __init__(self) -> None:
        self.above: dict[_SocketKey, _SocketKey] = {}

    def first(self, key: _SocketKey) -> _SocketKey:
        """One name of all that are the same."""
        while key in self.above:
            key = self.above[key]
        return key

    def join(self, one: _SocketKey, other: _SocketKey) -> None:
        one, other = self.first(one), self.first(other)
        if one != other:
            self.above[one] = other


_BYTES_TYPE: Final = "rawbytes"
_BYTES_PREFIX: Final = "raw_byte"
_MOST_DATA: Final = 40
"""Data of the type in one program."""
_SOCKET_CALLS: Final = ("socketsend", "socketreceive")

_ComponentNames = tuple[str, ...]


def with_raw_bytes(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """Return the modules with numbers in place of raw bytes; unchanged if they have no raw bytes,
    or some without an equivalent.
    """
    if not any(map(_is_of_bytes, nodes(tuple(modules)))):
        return modules
    said = _RawBytes(modules)
    return said.modules() if said.can_be_said() else modules


def _is_of_bytes(node: Any) -> bool:
    match node:
        case s.Data(type=type) | s.ParameterNode(type=type):
            return type.lower() == _BYTES_TYPE
        case s.Record(components=components):
            return any(type.lower() == _BYTES_TYPE for type, _ in components)
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
        # Names are unique in the program by now, so local and module data share one table.
        self.types = {d.name.lower(): d.type.lower() for d in (*data, *inner)}
        self.types |= {
            one.name.lower(): one.type.lower()
            for one in nodes(tuple(self.routines))
            if isinstance(one, s.ParameterNode)
        }
        self.fixed = {d.name.lower(): d.value for d in data if d.storage == "CONST"}
        self.numbers: dict[int, dict[_ComponentNames, int]] = {}
        self.lists: set[str] = set()
        self.count = 0
        self.sound = True
        # Numbers are given in the order of declaration: module data first.
        for one in (*data, *inner):
            self._counted(one)
        texts = _texts_on_byte_sockets(self.routines)
        self.takes_others = bool(texts) or any(
            isinstance(node, s.ProcedureCall) and option(node, "data") is not None
            for node in nodes(tuple(self.routines))
        )
        """True if sockets of bytes take lists of numbers or texts: the last bytes are for these."""
        self.calls = _ByteCalls(self.types, self.count + 1, texts)
        self.whole = [d for d in data if d.type.lower() in self.records]
        """Records of modules, whose bytes get their numbers when the program begins."""

    def _counted(self, one: s.Data) -> None:
        low = one.type.lower()
        ways = [()] if low == _BYTES_TYPE else self.records.get(low, ())
        if not ways:
            return
        size = 1
        if one.dimensions:
            found = [self._extent(node) for node in one.dimensions]
            # Only plain lists of known length can be numbered one after the other.
            if len(found) != 1 or found[0] is None or low != _BYTES_TYPE:
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
        """True if all raw bytes can be numbered and no name clashes with the added data and
        routines.
        """
        names = {name.lower() for name in inner_names(self.routines)} | set(self.types)
        names |= {one.name.lower() for one in self.routines}
        added = {_BYTES_PREFIX, _LENGTH_ARRAY, *(one.name.lower() for one in library())}
        if not self.sound or self.count > _MOST_DATA or not names.isdisjoint(added):
            return False
        main = [one for one in self.routines if one.name.lower() == "main"]
        if self.whole and len(main) != 1:
            return False
        # A numbered buffer exists once: a recursive routine would overwrite the bytes of its
        # caller.
        return all(self.types[name] == _BYTES_TYPE for name in self.lists) and not self._recurs()

    def _recurs(self) -> bool:
        """True if a routine with local raw bytes may be called recursively."""
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
        # One more row holds what lists of numbers and texts pass through.
        count = str(self.count + self.takes_others)
        size = tuple(map(s.NumberLiteral, (count, str(_ROWS), str(_IN_ROW))))
        # Both arrays go before the routines that use them, in the first module alone.
        data = (
            s.Data("", "PERS", "num", _BYTES_PREFIX, size),
            s.Data("", "VAR", "num", _LENGTH_ARRAY, size[:1]),
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
        return "num" if type.lower() == _BYTES_TYPE else type

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
        # Data of modules cannot compute its initial value, so the program's start gives the
        # numbers.
        if routine.name.lower() == "main":
            for one in self.whole:
                first += self._numbered(one)
        declared = 0
        for at, node in enumerate(routine.body):
            if isinstance(node, s.Data):
                declared = at + 1
                numbers = self.numbers.get(id(node), {})
                first += self._numbered(node) if () not in numbers else ()
                # Local raw bytes are empty at every call; those of the last call may still be in
                # the array.
                for number in numbers.values():
                    extent = self._extent(node.dimensions[0]) if node.dimensions else 1
                    for each in range(number, number + (extent or 1)):
                        of = s.NumberLiteral(str(each))
                        first.append(_call_at("clear_bytes", node, of, s.NumberLiteral("1")))
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
            case s.ParameterNode(type=type) if type.lower() == _BYTES_TYPE:
                return replace(node, mode="", type="num", dimensions=0)
            case s.Element(s.NameRef(name) as base, (index,)) if name.lower() in self.lists:
                # The list is the number of its first element; the others follow it.
                if isinstance(index, s.Whole):
                    return base
                before = s.Group(s.Infix("-", s.Group(index), s.NumberLiteral("1")))
                return s.Group(s.Infix("+", base, before))
            case s.FunctionCall(name, (s.Positional(value, None),)):
                if name.lower() == "rawbyteslen":
                    return _length_of(value)
                if name.lower() == "socketpeek":
                    return replace(node, name="bytes_waiting")
        return node


def _byte_components(items: Sequence[s.Item]) -> Mapping[str, Sequence[_ComponentNames]]:
    """The ways to bytes in each type of records that has any, by lower-case name."""
    known = {one.name.lower(): one for one in items if isinstance(one, s.Record)}
    found: dict[str, Sequence[_ComponentNames]] = {}

    def ways(low: str) -> Sequence[_ComponentNames]:
        if low not in found:
            found[low] = ()  # a record that holds itself ends here
            parts: list[_ComponentNames] = []
            for type, name in known[low].components:
                if type.lower() == _BYTES_TYPE:
                    parts.append((name,))
                elif type.lower() in known:
                    parts += ((name, *way) for way in ways(type.lower()))
            found[low] = tuple(parts)
        return found[low]

    return {low: ways(low) for low in known if ways(low)}


_SHORTEST_LOOP: Final = 3
"""Statements that read a text; two more make a number of it."""
_TEXT_ENDS: Final = frozenset(("\r", ","))
_SKIPPED_CHARACTER: Final = "\n"
_Body = tuple[s.StatementNode, ...]


def with_line_reads(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules with one statement for each text that is read so."""
    return [rewrite(module, _with_reads_in, ()) for module in modules]


def _with_reads_in(node: Any) -> Any:
    match node:
        case s.Routine(body=body) | s.IfBranch(body=body) | s.ForLoop(body=body):
            pass
        case s.WhileLoop(body=body) | s.TestCase(body=body):
            pass
        case _:
            return node
    made = _with_line_reads(body)
    return node if made is body else replace(node, body=made)


def _with_line_reads(body: _Body) -> _Body:
    made: list[s.StatementNode] = []
    at = 0
    while at < len(body):
        text = _line_read(body[at : at + _SHORTEST_LOOP])
        if text is None:
            made.append(body[at])
            at += 1
            continue
        target = _number_target(body[at + _SHORTEST_LOOP : at + _SHORTEST_LOOP + 2], text.into)
        word = "ReadStr" if target is None else "ReadNum"
        given = s.Positional(text.socket), s.Option("Delim", s.StringLiteral(","))
        into = text.into if target is None else target
        made.append(s.Assignment(into, s.FunctionCall(word, given), span=body[at].span))
        at += _SHORTEST_LOOP if target is None else _SHORTEST_LOOP + 2
    return tuple(made) if len(made) < len(body) else body


@dataclass(frozen=True, slots=True)
class _LineRead:
    """A text that is read. into: its variable."""

    socket: s.Expression
    into: s.NameRef


def _line_read(some: _Body) -> _LineRead | None:
    match some:
        case (
            s.Assignment(s.NameRef() as into, s.StringLiteral("")),
            s.ProcedureCall() as first,
            s.WhileLoop(
                s.Infix("AND", left, right),
                (
                    s.IfThen(
                        (s.IfBranch(beside, (s.Assignment(grown, s.Infix("+", one, more)),)),), None
                    ),
                    s.ProcedureCall() as again,
                ),
            ),
        ):
            received = _received_byte(first)
        case _:
            return None
    # Spans take no part in comparing nodes, so equal text means equal nodes.
    if received is None or first != again or (grown, one) != (into, into):
        return None
    socket, last = received
    marks = {_tested_text(left, last), _tested_text(right, last)}
    if marks != _TEXT_ENDS or _tested_text(beside, last) != _SKIPPED_CHARACTER or more != last:
        return None
    return _LineRead(socket, into)


def _received_byte(call: s.ProcedureCall) -> tuple[s.Expression, s.Expression] | None:
    """The socket that a byte is received from, and the text that it comes into."""
    if not isinstance(call.name, str) or call.name.lower() != "socketreceive":
        return None
    socket: s.Expression | None = None
    options: dict[str, s.Expression | None] = {}
    for one in call.arguments:
        match one:
            case s.Positional(value) if socket is None:
                socket = value
            case s.Option(name, value):
                options[name.lower()] = value
            case _:
                return None
    into, count = options.pop("str", None), options.pop("readnoofbytes", None)
    # `lower/` writes WAIT_MAX; with a limit of time the loop ends otherwise than ReadStr does.
    endless = options.pop("time", None) == s.NameRef("WAIT_MAX")
    if socket is None or into is None or options or not endless or count != s.NumberLiteral("1"):
        return None
    return socket, into


def _tested_text(condition: s.Expression | None, last: s.Expression) -> str | None:
    """The text that a condition says something is not."""
    match condition:
        case s.Infix("<>", left, s.StringLiteral(mark)) if left == last:
            return mark
    return None


def _number_target(some: _Body, text: s.NameRef) -> s.Variable | None:
    """Return the variable that takes the number read from a text; the program ends if the text is
    not a number.
    """
    match some:
        case (
            s.Assignment(s.NameRef() as read, s.FunctionCall(str(word), (given, target))),
            s.IfThen((s.IfBranch(s.Prefix("NOT", asked), (s.Word("EXIT"),)),), None),
        ) if word.lower() == "strtoval" and asked == read:
            pass
        case _:
            return None
    match given, target:
        case s.Positional(value), s.Positional(s.NameRef() | s.Element() | s.Component() as into):
            return into if value == text else None
    return None


_REMOVE_INSTRUCTION: Final = "removefile"
_IS_FILE: Final = "isfile"


def with_emptied_files(
    modules: Sequence[s.Module], files: Sequence[s.File]
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules of some files without such statements, and the findings of each."""
    nothing: list[list[Diagnostic]] = [[] for _ in modules]
    own = {i.name.lower() for m in modules for i in m.items if isinstance(i, s.Routine)}
    # A routine of the program with such a name is not RAPID's.
    if {_REMOVE_INSTRUCTION, _IS_FILE} & own or not mentions(files, (_REMOVE_INSTRUCTION,)):
        return modules, nothing
    name = FreshNames(modules)("removed")
    made = [rewritten(module, lambda node: _emptied(node, name)) for module in modules]
    for at, module in enumerate(modules):
        if made[at] is not module and name in _opened_names(made[at]):
            data = s.Data("LOCAL", "VAR", "iodev", name)
            made[at] = replace(made[at], items=(data, *made[at].items))
        nothing[at] += _removed_file_findings(module)
    return made, nothing


def _emptied(node: s.StatementNode, name: str) -> Iterator[s.StatementNode]:
    match node:
        case s.ProcedureCall(str(word), (s.Positional(path, None),)) if (
            word.lower() == _REMOVE_INSTRUCTION
        ):
            channel = s.Positional(s.NameRef(name))
            opened = (s.Positional(path), channel, s.Option("Write", None))
            yield s.ProcedureCall("Open", opened, span=node.span)
            yield s.ProcedureCall("Close", (channel,), span=node.span)
        # Opening for writing creates a missing file, so the question is not needed.
        case s.IfThen((s.IfBranch(condition, body),), None) if _only_removes_existing(
            condition, _without_comments(body), name
        ):
            yield from body
        case _:
            yield node


def _without_comments(body: Sequence[s.StatementNode]) -> list[s.StatementNode]:
    return [one for one in body if not isinstance(one, s.CommentLine)]


def _only_removes_existing(condition: Any, body: Sequence[Any], name: str) -> bool:
    """True if a branch does nothing but remove the file that it asks for."""
    match condition, body:
        case (
            s.FunctionCall(str(word), (s.Positional(file, None), *_)),
            [s.ProcedureCall("Open", (s.Positional(path), s.Positional(s.NameRef(one)), *_)), _],
        ):
            return (word.lower(), one) == (_IS_FILE, name) and file == path
        case s.Group(inner) | s.Infix("=", inner, s.BoolLiteral(True)), _:
            return _only_removes_existing(inner, body, name)
    return False


def _removed_file_findings(module: s.Module) -> Iterator[Diagnostic]:
    for node in nodes(module):
        if isinstance(node, s.ProcedureCall) and str(node.name).lower() == _REMOVE_INSTRUCTION:
            yield rules.LEFT_OUT(
                what=str(node.name), loss="the file stays on the controller, and is empty",
                cure="see that nothing asks whether it is there", span=node.span,
            )  # fmt: skip


def _opened_names(module: s.Module) -> set[str]:
    """Names of what a module opens."""
    calls = (one for one in nodes(module) if isinstance(one, s.ProcedureCall))
    given = (x for one in calls if one.name == "Open" for x in one.arguments[1:2])
    values = (x.value for x in given if isinstance(x, s.Positional))
    return {value.name for value in values if isinstance(value, s.NameRef)}
