r"""Texts that go over the same sockets as bytes.

A socket that sends or receives bytes somewhere is connected to a gateway, which takes bytes alone:
a text goes there as the bytes of its characters. A socket may have several names: those of
parameters, and of what routines are called with.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence, Set
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import option
from assistant.languages.rapid.tree.walk import nodes

SOCKET_INSTRUCTIONS: Final = frozenset(("socketsend", "socketreceive"))
"""Instructions in lower case, whose first argument is a socket."""
_BYTE_OPTIONS: Final = ("rawdata", "data")
_PEEK_FUNCTION: Final = "socketpeek"

SocketKey = tuple[str, str]
"""A routine, empty for data of a module, and the name of what is a socket there or has one."""


def texts_on_byte_sockets(routines: Sequence[s.Routine]) -> Set[int]:
    """The calls with texts, by `id`, whose sockets also send or receive bytes."""
    same = _SocketNames()
    own = {one.name.lower(): one for one in routines}
    inner = {one.name.lower(): frozenset(_names_of_routine(one)) for one in routines}
    bytes_of: list[SocketKey] = []
    texts: list[tuple[SocketKey, s.Node]] = []
    for routine in routines:
        low = routine.name.lower()
        for node in nodes(routine):
            if not isinstance(node, s.ProcedureCall | s.FunctionCall):
                continue
            if not isinstance(node.name, str):
                continue
            word = node.name.lower()
            if word in SOCKET_INSTRUCTIONS or word == _PEEK_FUNCTION:
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
    found = {same.first(key) for key in bytes_of}
    return frozenset(id(node) for key, node in texts if same.first(key) in found)


def _names_of_routine(routine: s.Routine) -> Iterator[str]:
    """Names in lower case of the parameters and the data of a routine."""
    for node in nodes(routine):
        if isinstance(node, s.ParameterNode | s.Data):
            yield node.name.lower()


def _socket_key(given: Any, routine: str, inner: Set[str]) -> SocketKey | None:
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
        self.above: dict[SocketKey, SocketKey] = {}

    def first(self, key: SocketKey) -> SocketKey:
        """One name of all that are the same."""
        while key in self.above:
            key = self.above[key]
        return key

    def join(self, one: SocketKey, other: SocketKey) -> None:
        one, other = self.first(one), self.first(other)
        if one != other:
            self.above[one] = other
