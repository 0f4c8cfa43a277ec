"""Terminals and parser tables of a grammar, and a scanner made of its terminals.

lark works the tables out once. That takes longer than everything else done with a small program,
so they are stored where Python stores the bytecode of the package: who can write there can change
the program as well. lark is loaded only if the grammar changed or nothing can be stored; the proof
parses with lark itself, whose parser is stored in the same place. `WordScanner` reads
the words of a text with one regular expression that tries the terminals in order. `Shortened` is a
text for the grammar with a mark in place of each run of like lines that is read otherwise; it maps
offsets both ways.
"""

from __future__ import annotations

import json
import marshal
import os
import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import field
from functools import cache
from itertools import accumulate, chain
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar

from assistant.base.data_classes import dataclass
from assistant.languages.lalr import END, Passing, Reduction, Rows, Tables, Word
from assistant.resources import kept_place, read_grammar

if TYPE_CHECKING:
    from pathlib import Path

    from lark import Lark


_CACHE_FORMAT: Final = 1
"""Format of the cache; a cache of another format is built anew."""


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
            # Several spellings of one word are a group in the grammar.
            if pattern.startswith("(?:"):
                pattern = pattern[3:-1]
            if _WORDS.fullmatch(pattern):
                for word in pattern.split("|"):
                    found[word] = (*found.get(word, ()), name)
        return found

    @property
    def marks(self) -> dict[str, str]:
        """The text, in backticks, of each terminal that has one spelling and is not a word."""
        plain = ((t.name, t.pattern) for t in self.terminals.values() if t.plain)
        return {name: f"`{text}`" for name, text in plain if not _WORDS.fullmatch(text)}


_WORDS: Final = re.compile(r"#?[a-z]+(?:[ |][a-z]+)*")
"""A terminal that is one word or several."""


def load(name: str, starts: tuple[str, ...]) -> Grammar:
    """The grammar of a file in `grammars`, for some start rules."""
    text = read_grammar(name)
    place = kept_place(name, ".lalr")
    if place is not None:
        # A damaged or foreign file is the same as none: the tables are worked out again.
        with suppress(OSError, ValueError, TypeError, LookupError):
            kept = json.loads(place.read_bytes())
            # The whole grammar is the key, so that no change of it can go unnoticed.
            if kept["of"] == [_CACHE_FORMAT, text, *starts]:
                return _unpacked(kept)
    packed = _packed(_treeless(text, starts), starts)
    if place is not None:
        _keep(place, json.dumps({"of": [_CACHE_FORMAT, text, *starts], **packed}).encode())
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
    # The data that lark stores depends on its version.
    of = [_CACHE_FORMAT, package.__version__, text, *starts]
    place = kept_place(name, ".lark")
    if place is not None:
        with suppress(OSError, EOFError, ValueError, TypeError, LookupError, AttributeError):
            kept = marshal.loads(place.read_bytes())  # noqa: S302  # beside bytecode, which it is
            if kept["of"] == of:
                # A class cannot be stored, so it is put back here.
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
    # Written beside and renamed: another process never sees half a file. The process number keeps
    # two writers apart.
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
    # All start rules share one table of states.
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
    # lark ends at a state; here END leads to itself, so that the driver needs no special case.
    for conf in confs.values():
        last = int(conf.end_state)
        rows[last] += (symbols[END], last)
    tried = sorted(
        grammar.terminals,
        # The order in which lark's own lexer tries terminals.
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


def terminals_pattern(
    grammar: Grammar,
    frequent: Iterable[str] = (),
    before: Mapping[str, str] | None = None,
    behind: Mapping[str, str] | None = None,
    without: Set[str] = frozenset(),
) -> re.Pattern[str]:
    """The terminals of a grammar, each a group, in the order in which they are tried.

    frequent: terminals tried first. before, behind: other groups, tried before and behind the rest.
    """
    known = {name: grammar.terminals[name].regexp for name in grammar.order}
    first = {name: known[name] for name in frequent}
    # A name that is in several tables keeps its first place and gets its last pattern, which is the
    # same.
    rows = {**first, **(before or {}), **known, **(behind or {})}
    listed = (f"(?P<{name}>{regexp})" for name, regexp in rows.items() if name not in without)
    return re.compile("|".join(listed), re.MULTILINE)


@dataclass(frozen=True, slots=True)
class WordScanner:
    """Reads words for the tables of a grammar.

    scanner: has a group for each terminal and finds something at every place. ignored: terminals
    between words. noted: ignored where there is no room for them. made: patterns of some terminals.
    """

    grammar: Grammar
    scanner: re.Pattern[str]
    ignored: Set[str]
    noted: Set[str]
    made: dict[frozenset[str | None], re.Pattern[str]] = field(default_factory=dict)

    def sound(self, text: str, rows: Rows, states: list[int]) -> Iterator[Word]:
        """The words of a text that is thought to be sound.

        states: of the stack that they are read on.
        """
        ignored, noted = self.ignored, self.noted
        for match in self.scanner.finditer(text):
            type = match.lastgroup or ""
            # A note is a word only where the grammar has room for one.
            if type in ignored or (type in noted and type not in rows[states[-1]]):
                continue
            yield type, match[0], match.start(), match.end()
        yield END, "", len(text), len(text)

    def fitting(self, text: str, at: int, rows: Rows, states: list[int]) -> Iterator[Word]:
        """The words behind an offset, each as what there is room for, if it can be read so."""
        while match := self.scanner.match(text, at):
            type = match.lastgroup or ""
            row = rows[states[-1]]
            at = match.end()
            if type in self.ignored or (type in self.noted and type not in row):
                continue
            # As in a contextual lexer: among the terminals that fit, another may match here.
            if type not in row and (fits := self._only(row).match(text, match.start())):
                match, type, at = fits, fits.lastgroup or "", fits.end()
            yield type, match[0], match.start(), at
        yield END, "", len(text), len(text)

    def _only(self, terminals: Iterable[str | None]) -> re.Pattern[str]:
        """Some terminals, in the order in which they are tried."""
        wanted = frozenset(terminals)
        if wanted not in self.made:
            others = frozenset(self.grammar.order) - wanted
            # `(?!)` never matches; without it the pattern of no terminals would match the empty
            # text.
            self.made[wanted] = terminals_pattern(
                self.grammar, without=others, behind={"NOTHING": r"(?!)"}
            )
        return self.made[wanted]


class TextSpan(Protocol):
    """Lines of a text. start, end: offsets."""

    @property
    def start(self) -> int: ...
    @property
    def end(self) -> int: ...


R = TypeVar("R", bound=TextSpan)


@dataclass(frozen=True, slots=True)
class RunInTheWay:
    """A run that the text before it wants the first row of."""

    number: int


@dataclass(frozen=True, slots=True)
class Shortened:
    """Shortened text for the grammar, with the mapping between its offsets and those of the source.

    begins, shifts: offsets in the short text, and the distance by which positions from there on are
    farther on in the source.
    """

    text: str
    runs: Sequence[TextSpan]
    begins: list[int]
    shifts: list[int]

    @staticmethod
    def of(text: str, runs: Sequence[R], marks: Callable[[R], tuple[str, str]]) -> Shortened:
        """marks: characters around the number of a run, which the text does not have."""
        pieces, at = [], 0
        lengths, removed = [], []
        for number, run in enumerate(runs):
            opening, closing = marks(run)
            mark = f"{opening}{number}{closing}\n"
            pieces += [text[at : run.start], mark]
            lengths.append(run.start - at + len(mark))
            removed.append(run.end - run.start - len(mark))
            at = run.end
        pieces.append(text[at:])
        begins = list(accumulate(lengths, initial=0))
        return Shortened("".join(pieces), runs, begins, list(accumulate(removed, initial=0)))

    def offset(self, short: int) -> int:
        """Offset in the source."""
        return short + self.shifts[bisect_right(self.begins, short) - 1]

    def back(self, offset: int) -> int:
        """Offset in the short text; of its mark for one in a run."""
        row = bisect_right(self.runs, offset, key=lambda run: run.start) - 1
        if row < 0:
            return offset
        run = self.runs[row]
        if offset < run.end:
            return run.start - self.shifts[row]
        return offset - self.shifts[row + 1]

    def run_around(self, text: str, offset: int) -> int | None:
        """Number of the run that an offset of the source lies inside of, behind its first word."""
        row = bisect_right(self.runs, offset, key=lambda run: run.start) - 1
        if row < 0 or offset >= self.runs[row].end:
            return None
        return row if text[self.runs[row].start : offset].strip() else None


def number_of(mark: str) -> int:
    """The number of the run that a mark stands for."""
    return int(mark[1:-1])
