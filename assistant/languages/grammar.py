"""A grammar as its readers need it: terminals and tables, worked out by lark once and kept.

Working them out takes longer than all else that is done with a small program. So they are kept
where Python keeps the bytecode of the package, since who can write there can change the program as
well. Readers load lark only where the grammar has changed or nothing can be kept; the proof parses
with lark itself, whose parser is kept in the same place.
"""

from __future__ import annotations

import json
import marshal
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.lalr import END, Passing, Reduction, Rows, Tables
from assistant.resources import kept_place, read_grammar

if TYPE_CHECKING:
    from pathlib import Path

    from lark import Lark

CACHE_FORMAT: Final = 1
"""Of what is kept; another one is made anew."""


@dataclass(frozen=True, slots=True)
class Terminal:
    """A terminal of a grammar.

    pattern: what the grammar says, a text as it is written if `plain`, else a regular expression.
    regexp: a regular expression with its flags, for both.
    """

    name: str
    pattern: str
    plain: bool
    regexp: str


@dataclass(frozen=True, slots=True)
class Grammar:
    """terminals: by name, in the order of the grammar. order: their names in the order in which
    they are tried on a text. tables: by start rule.
    """

    terminals: Mapping[str, Terminal]
    order: tuple[str, ...]
    tables: Mapping[str, Tables]

    @property
    def words(self) -> dict[str, tuple[str, ...]]:
        """Words of the language in lower case → the terminals that each may be."""
        found: dict[str, tuple[str, ...]] = {}
        for name, terminal in self.terminals.items():
            pattern = terminal.pattern.removesuffix(r"\b")
            if pattern.startswith("(?:"):
                pattern = pattern[3:-1]
            if _WORDS.fullmatch(pattern):
                for word in pattern.split("|"):
                    found[word] = (*found.get(word, ()), name)
        return found

    @property
    def marks(self) -> dict[str, str]:
        """What stands for each terminal that is no word and written in one way, in backticks."""
        plain = ((t.name, t.pattern) for t in self.terminals.values() if t.plain)
        return {name: f"`{text}`" for name, text in plain if not _WORDS.fullmatch(text)}


_WORDS: Final = re.compile(r"#?[a-z]+(?:[ |][a-z]+)*")
"""A terminal that is one word or several."""


def load(name: str, starts: tuple[str, ...]) -> Grammar:
    """The grammar of a file in `grammars`, for some start rules."""
    text = read_grammar(name)
    place = kept_place(name, ".lalr")
    if place is not None:
        with suppress(OSError, ValueError, TypeError, LookupError):
            kept = json.loads(place.read_bytes())
            if kept["of"] == [CACHE_FORMAT, text, *starts]:
                return _unpacked(kept)
    packed = _packed(_treeless(text, starts), starts)
    if place is not None:
        _keep(place, json.dumps({"of": [CACHE_FORMAT, text, *starts], **packed}).encode())
    return _unpacked(packed)


def lark(text: str, starts: tuple[str, ...], **options: Any) -> Lark:
    """The parser that lark makes of a grammar. options: more of lark's own."""
    from lark import Lark

    return Lark(
        text,
        parser="lalr",
        lexer="contextual",
        start=list(starts),
        maybe_placeholders=True,
        **{"propagate_positions": True, **options},
    )


@cache
def acceptor(name: str, starts: tuple[str, ...]) -> Lark:
    """Return lark's own parser for a grammar file, which accepts a text or raises.

    It builds no trees, since nobody asks for them.
    """
    import lark as package
    from lark.grammar import Rule
    from lark.lexer import TerminalDef

    text = read_grammar(name)
    of = [CACHE_FORMAT, package.__version__, text, *starts]
    place = kept_place(name, ".lark")
    if place is not None:
        with suppress(OSError, EOFError, ValueError, TypeError, LookupError, AttributeError):
            kept = marshal.loads(place.read_bytes())  # noqa: S302  # beside bytecode, which it is
            if kept["of"] == of:
                kept["data"]["options"]["tree_class"] = _no_tree
                return package.Lark.load(kept)
    made = _treeless(text, starts)
    if place is not None:
        data, memo = made.memo_serialize([TerminalDef, Rule])
        data["options"]["tree_class"] = None
        _keep(place, marshal.dumps({"of": of, "data": data, "memo": memo}))
    return made


@cache
def _treeless(text: str, starts: tuple[str, ...]) -> Lark:
    """The parser of a grammar, worked out anew, at most once a process: it takes a while."""
    return lark(text, starts, propagate_positions=False, tree_class=_no_tree)


class _Nothing:
    """Stands for every tree."""

    @property
    def children(self) -> list[Any]:
        """A new list each time: lark adds to it."""
        return []


_NOTHING: Final = _Nothing()


def _no_tree(*_: Any) -> _Nothing:
    return _NOTHING


def _keep(place: Path, data: bytes) -> None:
    """Writes a file as a whole or not at all; where it cannot be written, nothing is kept."""
    written = place.with_suffix(f".{os.getpid()}")
    with suppress(OSError):
        written.write_bytes(data)
        written.replace(place)


def _packed(grammar: Lark, starts: tuple[str, ...]) -> dict[str, Any]:
    """A grammar as lists of numbers and texts.

    A row of the tables is a list of symbols and of what each of them does, by turns: a state to go
    to, or a rule, counted on from the states.
    """
    from lark.lexer import PatternStr

    confs = {s: grammar.parse_interactive("", start=s).parser_state.parse_conf for s in starts}
    states = confs[starts[0]].states
    symbols: dict[str, int] = {END: 0}
    rules: dict[Any, int] = {}
    rows: list[list[int]] = [[] for _ in states]
    leading = [""] * len(states)
    for state, actions in states.items():
        for symbol, (_, target) in actions.items():
            if isinstance(target, int):
                leading[target] = symbol if symbol.isupper() else ""
            else:
                target = len(states) + rules.setdefault(target, len(rules))
            rows[int(state)] += (symbols.setdefault(str(symbol), len(symbols)), target)
    for conf in confs.values():
        last = int(conf.end_state)
        rows[last] += (symbols[END], last)
    tried = sorted(
        grammar.terminals,
        key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name),
    )
    return {
        "terminals": [
            (t.name, t.pattern.value, isinstance(t.pattern, PatternStr), t.pattern.to_regexp())
            for t in grammar.terminals
        ],
        "order": [t.name for t in tried],
        "symbols": list(symbols),
        "rules": [Reduction.of(rule).packed() for rule in rules],
        "rows": rows,
        "leading": leading,
        "starts": {start: int(conf.start_state) for start, conf in confs.items()},
    }


def _unpacked(packed: Mapping[str, Any]) -> Grammar:
    symbols = packed["symbols"]
    rules = (Reduction.unpacked(rule) for rule in packed["rules"])
    actions = list(chain(range(len(packed["rows"])), rules))
    rows: Rows = [
        {
            symbols[symbol]: actions[action]
            for symbol, action in zip(row[::2], row[1::2], strict=True)
        }
        for row in packed["rows"]
    ]
    passing, leading = Passing(rows), tuple(packed["leading"])
    return Grammar(
        {name: Terminal(name, *rest) for name, *rest in packed["terminals"]},
        tuple(packed["order"]),
        {start: Tables(rows, first, passing, leading) for start, first in packed["starts"].items()},
    )
