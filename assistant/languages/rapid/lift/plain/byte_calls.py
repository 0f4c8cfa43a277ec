"""What RAPID does with bytes, as calls of the routines of `tables/bytes.txt`.

Reference manual of instructions: PackRawBytes, UnpackRawBytes and their kin, SocketSend and
SocketReceive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from typing import Any, Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.plain.library import function_call
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called

LENGTH_ARRAY: Final = "raw_length"
ROWS: Final = 8
IN_ROW: Final = 128
"""Bytes stand in rows, for controllers whose arrays end at 999: 1024 of each."""
WHOLE_SIZES: Final = {
    "usint": 1, "uint": 2, "udint": 4, "ulint": 8, "sint": -1, "int": -2, "dint": -4, "lint": -8,
}  # fmt: skip
"""Bytes of the whole numbers that inttypes names, negative of those with a sign."""
MOST_BYTES: Final = ROWS * IN_ROW
LONGEST_TEXT: Final = 80
"""Characters of a text (reference manual: string); what comes after them is received next."""
DEFAULT_TIMEOUT: Final = "60"
r"""Seconds that a socket waits without `\Time` (reference manual: SocketReceive)."""
_LOOP_VARIABLE: Final = "raw_at"
"""The variable of the loops that go through lists of numbers."""
_ASSIGNABLE: Final = (s.NameRef, s.Component, s.Element)
"""Expressions that take a value."""
_NUMBER_TYPES: Final = frozenset(("num", "dnum", "byte"))


class ByteCalls:
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
                return (call_at("put_byte", node, raw, at, value),)
            case "intx", s.Node() as kind:
                return (
                    call_at("pack_whole", node, value, raw, at, _whole_number_kind(kind), order),
                )
            case "float4", None:
                return (call_at("pack_float", node, value, raw, at, order),)
            case "ascii", None if self._is_number(value):
                return (call_at("put_byte", node, raw, at, value),)
            case "ascii", None:
                return (call_at("pack_text", node, value, raw, at),)
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
        return (call_at("clear_bytes", node, call.given[0], first),)

    def copy(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        if len(call.given) != 4 or not set(call.options) <= {"noofbytes"}:
            return None
        raw, first, into, at = call.given
        count = call.options.get("noofbytes")
        if count is None:
            left = s.Infix("-", length_of(raw), s.Group(_whole_list(first)[0]))
            count = s.Infix("+", left, s.NumberLiteral("1"))
        return (call_at("copy_bytes", node, raw, first, into, at, count),)

    def send(self, node: Any, call: Called[s.Expression]) -> Sequence[s.StatementNode] | None:
        given, count = call.options, call.options.get("noofbytes")
        if len(call.given) != 1 or not set(given) <= {"rawdata", "data", "str", "noofbytes"}:
            return None
        if (text := given.get("str")) is not None and id(node) in self.texts:
            own, first = self._own(), s.NumberLiteral("1")
            return (
                call_at("clear_bytes", node, own, first),
                call_at("pack_text", node, text, own, first),
                call_at("send_bytes", node, call.given[0], own, count or length_of(own)),
            )
        raw, array = given.get("rawdata"), _named_list(given.get("data"))
        if raw is not None:
            return (call_at("send_bytes", node, call.given[0], raw, count or length_of(raw)),)
        if array is None:
            return None
        own, at, first = self._own(), s.NameRef(_LOOP_VARIABLE), s.NumberLiteral("1")
        size = count or function_call("Dim", array, first)
        put = call_at("put_byte", node, own, at, s.Element(array, (at,)))
        return (
            call_at("clear_bytes", node, own, first),
            s.ForLoop(_LOOP_VARIABLE, first, size, first, (put,), span=node.span),
            call_at("send_bytes", node, call.given[0], own, length_of(own)),
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
        longest = MOST_BYTES if text is None else LONGEST_TEXT
        least, most = (asked or s.NumberLiteral("1")), (asked or s.NumberLiteral(str(longest)))
        seconds = given.get("time") or s.NumberLiteral(DEFAULT_TIMEOUT)
        made: list[s.StatementNode] = [
            call_at("receive_bytes", node, call.given[0], into, least, most, seconds)
        ]
        if array is not None and raw is None:
            at, first = s.NameRef(_LOOP_VARIABLE), s.NumberLiteral("1")
            value = function_call("byte_at", into, at)
            put = s.Assignment(s.Element(array, (at,)), value, span=node.span)
            made.append(
                s.ForLoop(_LOOP_VARIABLE, first, length_of(into), first, (put,), span=node.span)
            )
        if isinstance(text, _ASSIGNABLE):
            value = function_call("unpack_text", into, s.NumberLiteral("1"), length_of(into))
            made.append(s.Assignment(text, value, span=node.span))
        count = given.get("norecbytes")
        if isinstance(count, _ASSIGNABLE):
            made.append(s.Assignment(count, length_of(into), span=node.span))
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


def length_of(raw: Any) -> s.Element:
    return s.Element(s.NameRef(LENGTH_ARRAY), (raw,))


def _named_list(node: s.Expression | None) -> Any:
    """The list that is given, None if it is none by its name."""
    match node:
        case s.NameRef():
            return node
        case s.Element(s.NameRef() as name, (s.Whole(),)):
            return name
    return None


def _whole_list(*values: s.Expression | None) -> tuple[s.Expression, ...]:
    return tuple(value for value in values if value is not None)


def call_at(name: str, node: Any, *given: s.Expression | None) -> s.ProcedureCall:
    """A call that stands for a statement, at its place."""
    return s.ProcedureCall(name, tuple(map(s.Positional, _whole_list(*given))), span=node.span)


def _byte_format(call: Called[s.Expression]) -> tuple[str, s.Expression | None]:
    """The option that says what bytes mean, with its value."""
    found = [(name, value) for name, value in call.options.items() if name != "network"]
    return found[0] if len(found) == 1 else ("", None)


def _whole_number_kind(node: s.Expression) -> s.Expression:
    """The number of a type of whole numbers that is named."""
    known = WHOLE_SIZES.get(node.name.lower()) if isinstance(node, s.NameRef) else None
    if known is None:
        return node
    size = s.NumberLiteral(str(abs(known)))
    return s.Prefix("-", size) if known < 0 else size


_ByteLowering = Callable[[ByteCalls, Any, Called[s.Expression]], Sequence[s.StatementNode] | None]
_LOWERINGS: Final[Mapping[str, _ByteLowering]] = {
    "packrawbytes": ByteCalls.pack,
    "unpackrawbytes": ByteCalls.unpack,
    "clearrawbytes": ByteCalls.clear,
    "copyrawbytes": ByteCalls.copy,
    "socketsend": ByteCalls.send,
    "socketreceive": ByteCalls.receive,
}
"""By lower-case names of instructions."""
