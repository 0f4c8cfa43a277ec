r"""Numbers of 64 bits, as those that other languages have.

A `dnum` becomes a `num`, and what is worked out with it a function of those: `PowDnum(2,n)` is
`Pow(2,n)`. Neither language here rounds a number of another program to the 24 bits of a `num`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import mentions, nodes
from assistant.program.rewriting import rewrite

LONG: Final = "dnum"
SHORT: Final = "num"
_CONVERSIONS: Final = frozenset(("numtodnum", "dnumtonum"))
"""Functions that give the same number as the other type."""
_RENAMED: Final = {"dnumtostr": "NumToStr"}
_BIT_FUNCTIONS: Final = frozenset(
    ("bitanddnum", "bitordnum", "bitxordnum", "bitnegdnum", "bitlshdnum")
)
"""Functions of more bits than those of a byte, which do something else there."""


def with_long_numbers(
    modules: Sequence[s.Module], files: Sequence[s.File]
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules of some files without such numbers, and the findings of each."""
    if not mentions(files, (LONG,)):
        return modules, [[] for _ in modules]
    items = (item for module in modules for item in module.items)
    own = {item.name.lower() for item in items if isinstance(item, s.Routine)}

    def short(node: Any) -> Any:
        match node:
            case s.Data(type=type) | s.ParameterNode(type=type) | s.Routine(type=type):
                return replace(node, type=SHORT) if type.lower() == LONG else node
            case s.Alias(type=type):
                return replace(node, type=SHORT) if type.lower() == LONG else node
            case s.Record(components=parts):
                made = tuple((SHORT if of.lower() == LONG else of, name) for of, name in parts)
                return node if made == parts else replace(node, components=made)
            case s.Option(word, value) if word.lower() == LONG:
                return s.Option("Num", value)
            case s.FunctionCall(str(word), arguments) if word.lower() not in own:
                return _num_function(node, word.lower(), arguments)
        return node

    made = [rewrite(module, short, ()) for module in modules]
    return made, [list(_long_number_findings(module)) for module in modules]


def _num_function(node: s.FunctionCall, word: str, arguments: Sequence[s.Argument]) -> s.Expression:
    """A function of long numbers as that of others, if there is one that does the same."""
    match arguments:
        case (s.Positional(value), *_) if word in _CONVERSIONS:
            return s.Group(value)
    plain = _RENAMED.get(word) or node.name[: -len(LONG)]
    if (not word.endswith(LONG) and word not in _RENAMED) or word in _BIT_FUNCTIONS:
        return node
    return replace(node, name=plain) if signature(plain) is not None else node


def _long_number_findings(module: s.Module) -> Iterator[Diagnostic]:
    """A finding for each declaration of such a number."""
    for node in nodes(module):
        match node:
            case s.Data(type=type, name=name) | s.ParameterNode(type=type, name=name):
                if type.lower() == LONG:
                    yield rules.LONG_NUMBER(name=name, span=node.span)
            case s.Routine(type=type, name=name) if type.lower() == LONG:
                yield rules.LONG_NUMBER(name=name, span=node.span)
            case s.Record(name=name, components=parts):
                if any(of.lower() == LONG for of, _ in parts):
                    yield rules.LONG_NUMBER(name=name, span=node.span)
