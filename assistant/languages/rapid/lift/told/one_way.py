"""Files that a program only writes, or only reads, whatever they are opened for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import head, records

_WITHOUT_MODE: Final = ("open", "close")


def file_modes(program: Program) -> Mapping[str, p.ChannelMode]:
    """Which of the two, by lower-case name; without those of which neither is sure."""
    ways: dict[str, set[str]] = {}
    for node in program.statements():
        for part in records(head(node)):
            for word, name in _named_files(part):
                ways.setdefault(name.lower(), set()).add(_access_of(word.lower()))
    modes: dict[str, p.ChannelMode] = {}
    for name, found in ways.items():
        match found - {""}:
            case one if one == {"write"}:
                modes[name] = "write"
            case one if one == {"read"}:
                modes[name] = "read"
    return modes


def _access_of(word: str) -> str:
    """What an instruction or function does to a file that it names."""
    if word in _WITHOUT_MODE:
        return ""
    return next((way for way in ("write", "read") if word.startswith(way)), "both")


def _named_files(part: Any) -> Iterator[tuple[str, str]]:
    """What names something, and the name: calls of texts that are kept, and other calls."""
    match part:
        case p.Opaque(verbatim.LANGUAGE, text):
            yield from _files_in_tree(verbatim.understood(verbatim.statements, text))
        case e.Verbatim(verbatim.LANGUAGE, text):
            yield from _files_in_tree(verbatim.understood(verbatim.expression, text))
        case e.Apply(word, arguments) | p.Call(word, arguments):
            for one in arguments:
                if isinstance(one, e.Name):
                    yield word, one.name


def _files_in_tree(tree: Any) -> Iterator[tuple[str, str]]:
    for call in nodes(tree) if tree is not None else ():
        if isinstance(call, s.ProcedureCall | s.FunctionCall) and isinstance(call.name, str):
            for argument in call.arguments:
                if isinstance(argument, s.Positional) and isinstance(argument.value, s.NameRef):
                    yield call.name, argument.value.name
