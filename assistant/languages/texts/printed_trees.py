"""Typed trees printed by templates, and printed trees compared with the source they came from.

    FOR <variable> FROM <first> TO <last>[[ STEP <step>]] DO⏎<body+>ENDFOR

⏎ stands for a line feed. `<name>` is a field: a text as it is, a node by its own row, several with
commas between them, nothing for None. After the name, `^` makes a word of the language of it, `?`
prints it where it is not None even if it is empty, `*` prints several nodes one after the other,
`+` stands for a block of nodes one step deeper, `=` for one as deep, and `:text` for that text
where the field is true. `[[…]]` is left out where a field in it prints nothing. A printed node is a
sketch, text and blocks of children; `Layout` states how a language prints, `aligned` finds which
nodes of a changed list stay, changed or are new.
"""

from __future__ import annotations

import abc
import re
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from difflib import SequenceMatcher
from functools import partial
from operator import attrgetter
from typing import Any, Final, NamedTuple

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.languages.texts.words import Word

_MOST_COMPARED: Final = 1 << 20
"""Pairs of a stretch that are compared in full; longer stretches only from both ends."""
_MOST_RELATED: Final = 1 << 12
"""Most pairs of a stretch that are compared for likeness; longer stretches are paired in order."""


def same(a: object, b: object) -> bool:
    return a is b or a == b


def common_ends(old: Sequence[Any], new: Sequence[Any]) -> tuple[int, int]:
    """Return how many items at the beginning and at the end are the same objects."""
    most = min(len(old), len(new))
    head = 0
    while head < most and old[head] is new[head]:
        head += 1
    tail = 0
    while tail < most - head and old[-1 - tail] is new[-1 - tail]:
        tail += 1
    return head, tail


def aligned(
    old: Sequence[Any], new: Sequence[Any], says: Callable[[Any], object] | None = None
) -> list[int | None]:
    """For each new node the index of the old one that it came from, None for one that is new.

    Indices rise. The same object comes first, then an equal one, then one that is alike; what
    is left over takes the place of what is left over, whatever it is.
    says: what has to be equal of two nodes that are, the whole node if not given; hashable.
    """
    partner: list[int | None] = [None] * len(new)
    places = {id(node): at for at, node in enumerate(old)}
    for j, i in _rising([(j, places[id(n)]) for j, n in enumerate(new) if id(n) in places]):
        partner[j] = i
    mine, theirs = (nodes if says is None else list(map(says, nodes)) for nodes in (old, new))
    for step, before, after in ((_equal, mine, theirs), (_alike, old, new), (_in_order, old, new)):
        for (i1, i2), (j1, j2) in list(_unpaired_stretches(partner, len(old))):
            for i, j in step(before[i1:i2], after[j1:j2]):
                partner[j1 + j] = i1 + i
    return partner


def _rising(pairs: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """The longest choice of the pairs whose second numbers rise."""
    # ends: the least last number of a chain of each length; chosen: the pair that it ends with.
    ends: list[int] = []
    chosen: list[int] = []
    before: list[int] = []
    for at, (_, i) in enumerate(pairs):
        length = bisect_left(ends, i)
        before.append(chosen[length - 1] if length else -1)
        ends[length : length + 1] = [i]
        chosen[length : length + 1] = [at]
    out = []
    at = chosen[-1] if chosen else -1
    while at >= 0:
        out.append(pairs[at])
        at = before[at]
    return out[::-1]


def _unpaired_stretches(
    partner: Sequence[int | None], length: int
) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """The stretches of old and new between partners, where both have something."""
    i1 = j1 = 0
    for j, i in [*enumerate(partner), (len(partner), length)]:
        if i is None:
            continue
        if i1 < i and j1 < j:
            yield (i1, i), (j1, j)
        i1, j1 = i + 1, j + 1


def _equal(old: Sequence[Any], new: Sequence[Any]) -> Iterator[tuple[int, int]]:
    # Equal ends first: the comparison of the rest takes quadratic time.
    most = min(len(old), len(new))
    head = tail = 0
    while head < most and old[head] == new[head]:
        yield head, head
        head += 1
    while tail < most - head and old[-1 - tail] == new[-1 - tail]:
        tail += 1
        yield len(old) - tail, len(new) - tail
    old, new = old[head : len(old) - tail], new[head : len(new) - tail]
    if len(old) * len(new) <= _MOST_COMPARED:
        for block in SequenceMatcher(None, old, new, autojunk=False).get_matching_blocks():
            for k in range(block.size):
                yield head + block.a + k, head + block.b + k


def _alike(old: Sequence[Any], new: Sequence[Any]) -> Iterator[tuple[int, int]]:
    # The same number of nodes is paired in order, by the next step.
    if len(old) == len(new) or len(old) * len(new) > _MOST_RELATED:
        return
    at = 0
    for j, node in enumerate(new):
        scores = [_likeness(other, node) for other in old[at:]]
        best = max(scores, default=0)
        if best:
            at += scores.index(best)
            yield at, j
            at += 1


def _in_order(old: Sequence[Any], new: Sequence[Any]) -> Iterator[tuple[int, int]]:
    return iter([(k, k) for k in range(min(len(old), len(new)))])


def _likeness(a: object, b: object) -> int:
    """Return how many fields two nodes of one kind share; empty ones do not count."""
    if type(a) is not type(b) or not is_dataclass(a):
        return 0
    count = 0
    for field in fields(a):
        if field.compare:
            mine, other = getattr(a, field.name), getattr(b, field.name)
            if isinstance(mine, np.ndarray):
                count += np.array_equal(mine, other)
            # Tuples of nodes are alike if they share a node; comparing them in full is expensive.
            elif mine and isinstance(mine, tuple) and isinstance(other, tuple):
                count += not {id(x) for x in mine}.isdisjoint(id(x) for x in other)
            else:
                count += bool(mine) and same(mine, other)
    return count


MOST_WORDS: Final = 1 << 14
"""Words of one node that are compared; a longer one that changed is printed as a whole."""


@dataclass(frozen=True, slots=True)
class Block:
    """Children on separate lines, `depth` steps deeper than the node that holds them."""

    children: tuple[Any, ...]
    depth: int = 1


Sketch = Sequence["str | Block"]
"""Printed form of a node: lines that end with a line feed, with its blocks between them."""


class Extent(NamedTuple):
    """Offsets in the source."""

    start: int
    end: int


class Layout(abc.ABC):
    """Text layout of one vendor language.

    spelled: kinds of words with several spellings. indent: one step of the printer's indentation.
    """

    spelled: frozenset[str]
    indent: str

    @abc.abstractmethod
    def words(self, text: str, start: int, end: int) -> Iterator[Word]:
        """The words between two offsets that have to be those of the tree."""

    @abc.abstractmethod
    def noted(self, gap: str) -> bool:
        """True if the gap between two words has a comment."""

    @abc.abstractmethod
    def sketch(self, node: Any) -> Sketch:
        """The canonical text of a node, without outer indentation."""

    @abc.abstractmethod
    def extent(self, text: str, node: Any) -> Extent | None:
        """Return the extent of a node of a block, without outer blanks; None without a position."""

    @abc.abstractmethod
    def line_ends(self, before: Any, after: Any) -> int | None:
        """Return the number of line ends that two neighbours of a block need.

        0 if they must share a line, 1 if they must not, 2 if a blank line looks well between new
        ones, None without a rule. before, after: None at the ends of the block.
        """

    def spread(self, text: str, old: Sequence[Any], new: Sequence[Any]) -> Spread | None:  # noqa: ARG002
        """Return nodes that represent many lines as nodes of one line each; None without any."""
        return None


@dataclass(frozen=True, slots=True)
class Spread:
    """Two lists for the comparison. extents: of the nodes of `old`."""

    old: Sequence[Any]
    extents: Sequence[Extent]
    new: Sequence[Any]


@dataclass(slots=True)
class Piece:
    """A word or a block. gap: text printed in front of it. start, end: in the source.

    A block's extent runs from the word before it to the word after it.
    """

    what: str | Block
    kind: str
    gap: str = ""
    start: int = -1
    end: int = -1
    key: object = None


def pieces_of(layout: Layout, sketch: Sketch) -> list[Piece]:
    pieces = []
    for part in sketch:
        if isinstance(part, Block):
            pieces.append(Piece(part, "block"))
            continue
        at = 0
        for word in layout.words(part, 0, len(part)):
            pieces.append(Piece(word.text, word.kind, part[at : word.start]))
            at = word.end
    return pieces


def same_word(layout: Layout, piece: Piece, word: Word) -> bool:
    """True if a word of the source may be another spelling of a printed word."""
    if str(piece.what).casefold() == word.text.casefold():
        return True
    return word.kind == piece.kind and piece.kind in layout.spelled


def spelling(piece: Piece) -> str | None:
    return piece.what if isinstance(piece.what, str) else None


def equal_sketches(a: Sketch, b: Sketch) -> bool:
    if len(a) != len(b):
        return False
    return all(
        x is y or (x == y if isinstance(x, str) else isinstance(y, Block) and _same_block(x, y))
        for x, y in zip(a, b, strict=True)
    )


def _same_block(a: Block, b: Block) -> bool:
    return len(a.children) == len(b.children) and all(map(same, a.children, b.children))


def name_blocks(before: list[Piece], after: list[Piece]) -> None:
    """Gives blocks that belong together the same key, words their own text."""
    for piece in [*before, *after]:
        piece.key = piece.what if isinstance(piece.what, str) else id(piece)
    had, has = ([p for p in pieces if isinstance(p.what, Block)] for pieces in (before, after))
    # The same number of blocks is paired in order.
    if len(had) == len(has):
        pairs = list(zip(had, has, strict=True))
    else:
        pairs = []
        for new in has:
            mine = {id(child) for child in new.what.children}  # type: ignore[union-attr]
            for old in had:
                theirs = (id(child) for child in old.what.children)  # type: ignore[union-attr]
                if not mine.isdisjoint(theirs) or new.what == old.what:
                    pairs.append((old, new))
                    had.remove(old)
                    break
    for old, new in pairs:
        new.key = old.key


def differences(
    before: list[Piece], after: list[Piece]
) -> Iterator[tuple[str, int, int, int, int]]:
    """Like difflib's opcodes, equal ends first, which also settles which of alike words stay."""
    most = min(len(before), len(after))
    head = tail = 0
    while head < most and before[head].key == after[head].key:
        head += 1
    while tail < most - head and before[-1 - tail].key == after[-1 - tail].key:
        tail += 1
    a = [p.key for p in before[head : len(before) - tail]]
    b = [p.key for p in after[head : len(after) - tail]]
    yield "equal", 0, head, 0, head
    if len(a) * len(b) > MOST_WORDS * 64:
        yield "replace", head, head + len(a), head, head + len(b)
    else:
        for kind, i1, i2, j1, j2 in SequenceMatcher(None, a, b, autojunk=False).get_opcodes():
            yield kind, head + i1, head + i2, head + j1, head + j2
    yield "equal", head + len(a), len(before), head + len(b), len(after)


Said = str | list[str | Block]
"""Text of a node: a text, or texts with the blocks between them."""
Part = Callable[[Any], Said | None]
"""Returns the text of a template part for a node, None for no text."""

_TOKEN: Final = re.compile(
    r"(?P<opens>\[\[)|(?P<closes>\]\])"
    r"|<(?P<field>[a-z]+)(?P<mark>[\^?*+=]?)(?::(?P<given>[^<>]*))?>"
)
_DEPTHS: Final = {"+": 1, "=": 0}
_BLOCKS: Final = frozenset("*+=")


class Templates:
    """Prints the nodes of one language.

    rows: for each kind of node its template, or a function of this printer and the node.
    word: spells the words of templates, and of fields that are words.
    """

    def __init__(
        self,
        rows: Mapping[type, str | Callable[[Templates, Any], Said]],
        word: Callable[[str], str] = str,
    ) -> None:
        self.word = word
        self._says: dict[type, Callable[[Any], Any]] = {
            str: str,
            int: str,
            type(None): lambda _: "",
            tuple: self.listed,
        }
        for kind, row in rows.items():
            self._says[kind] = self.template(row) if isinstance(row, str) else partial(row, self)

    def text(self, node: Any) -> str:
        """Return the text of a node without blocks, or of several with commas between them."""
        text: str = self._says[node.__class__](node)
        return text

    def sketch(self, node: Any) -> list[str | Block]:
        """Return the text of a node, with its blocks."""
        said = self._says[node.__class__](node)
        return [said] if isinstance(said, str) else said

    def listed(self, nodes: Sequence[Any]) -> str:
        """Several nodes with commas between them."""
        says = self._says
        return ",".join([says[node.__class__](node) for node in nodes])

    def template(self, template: str) -> Callable[[Any], Any]:
        """A function that says of a node what a template does."""
        return self._compiled(template, _TOKEN.finditer(template), 0, optional=False)[0]

    def _compiled(
        self, template: str, tokens: Iterator[re.Match[str]], at: int, *, optional: bool
    ) -> tuple[Part, int, bool]:
        """Compile a template from an offset to the end of its brackets.

        Return the part, the offset after the brackets, and true if it holds blocks.
        """
        parts: list[str | Part] = []
        blocks = False
        for token in tokens:
            parts.append(self.word(template[at : token.start()]))
            at = token.end()
            if token["closes"]:
                break
            if token["opens"]:
                part, at, inside = self._compiled(template, tokens, at, optional=True)
                blocks |= inside
            else:
                part = self._field(token["field"], token["mark"], token["given"])
                blocks |= token["mark"] in _BLOCKS
            parts.append(part)
        else:
            parts.append(self.word(template[at:]))
            at = len(template)
        return (_sketch_part if blocks else _text_part)(parts, optional), at, blocks

    def _field(self, name: str, mark: str, given: str | None) -> Part:
        get, says, word = attrgetter(name), self._says, self.word

        def field(node: Any) -> Said | None:
            value = get(node)
            return says[value.__class__](value) or None

        def stated(node: Any) -> Said | None:
            value = get(node)
            return None if value is None else says[value.__class__](value)

        def block(node: Any) -> Said | None:
            value = get(node)
            return None if value is None else [Block(value, _DEPTHS[mark])]

        if given is not None:
            return lambda node: given if get(node) else None
        match mark:
            case "":
                return field
            case "?":
                return stated
            case "^":
                return lambda node: word(get(node)) or None
            case "*":
                return lambda node: [p for one in get(node) for p in self.sketch(one)]
        return block


def _text_part(parts: Sequence[str | Part], optional: bool) -> Part:
    # A text with `%s` for each field is filled in one step; other percent signs are doubled.
    form = "".join(p.replace("%", "%%") if isinstance(p, str) else "%s" for p in parts)
    says = [part for part in parts if not isinstance(part, str)]
    if optional:

        def whole(node: Any) -> str | None:
            # One field without a text leaves the whole part out.
            said = tuple([say(node) for say in says])
            return None if None in said else form % said

        return whole
    if form == "%s":
        (only,) = says
        return lambda node: only(node) or ""
    return lambda node: form % tuple([say(node) or "" for say in says])


def _sketch_part(parts: Sequence[str | Part], optional: bool) -> Part:
    def sketch(node: Any) -> list[str | Block] | None:
        out: list[str | Block] = []
        for part in parts:
            said = part if isinstance(part, str) else part(node)
            if said is None and optional:
                return None
            out += [said] if isinstance(said, str) else said or ()
        return joined_texts(out)

    return sketch


def joined_texts(parts: Iterable[str | Block]) -> list[str | Block]:
    """The same sketch with texts that follow each other as one."""
    out: list[str | Block] = []
    for part in parts:
        if isinstance(part, str) and out and isinstance(out[-1], str):
            out[-1] += part
        elif part:
            out.append(part)
    return out


@dataclass(frozen=True, slots=True)
class BlockPrinter:
    """Prints nodes on separate lines, and the blocks in them.

    indent: one step. tables: by type, the text of a node of many lines with an indentation and line
    ends. trails: true if a node follows another on its line. stands_apart: true if a blank line
    precedes a node that is not the first of its block.
    """

    templates: Templates
    indent: str
    tables: Mapping[type, Callable[[Any, str, str], str]]
    trails: Callable[[Any], bool]
    stands_apart: Callable[[Any], bool]

    def text(self, nodes: Sequence[Any], newline: str) -> str:
        """The lines of some nodes."""
        out: list[str] = []
        self._write(nodes, "", newline, out)
        return "".join(out)

    def sketch(self, node: Any) -> list[str | Block]:
        """Return the text of a node, as `Templates.sketch` does, for a table its lines."""
        table = self.tables.get(type(node))
        return self.templates.sketch(node) if table is None else [table(node, "", "\n")]

    def _write(self, nodes: Sequence[Any], indent: str, newline: str, out: list[str]) -> None:
        for at, node in enumerate(nodes):
            if at and self.stands_apart(node):
                out.append(newline)
            if (table := self.tables.get(type(node))) is not None:
                out.append(table(node, indent, newline))
                continue
            begin = indent
            if self.trails(node):
                begin = out.pop().removesuffix(newline) + " " if out else ""
            for part in self.templates.sketch(node):
                if isinstance(part, Block):
                    self._write(part.children, indent + self.indent * part.depth, newline, out)
                    continue
                for line in part.removesuffix("\n").split("\n"):
                    out.append(begin + line + newline)
                    begin = indent
