r"""Typed trees printed by templates: a row says what stands in the text of one kind of node.

    FOR <variable> FROM <first> TO <last>[[ STEP <step>]] DO\n<body+>ENDFOR

`<name>` is a field: a text as it is, a node by its own row, several with commas between them,
nothing for None. Behind the name, `^` makes a word of the language of it, `?` says it where it is
not None even if it is empty, `*` says several nodes one behind the other, `+` stands for a block of
nodes one step deeper, `=` for one as deep, and `:text` for that text where the field is true.
`[[…]]` is left out where a field in it says nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from typing import Any, Final

from assistant.languages.texts.printed_blocks import Block

Said = str | list[str | Block]
"""What a node says: a text, or texts with the blocks between them."""
Part = Callable[[Any], Said | None]
"""What a part of a template says of a node, None for nothing."""

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
        """What a node says that holds no block; also several, with commas between them."""
        text: str = self._says[node.__class__](node)
        return text

    def sketch(self, node: Any) -> list[str | Block]:
        """What a node says, with the blocks that it holds."""
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
        """What a template says from an offset to the end of its brackets.

        Also the offset behind these, and whether it holds blocks.
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
    form = "".join(p.replace("%", "%%") if isinstance(p, str) else "%s" for p in parts)
    says = [part for part in parts if not isinstance(part, str)]
    if optional:

        def whole(node: Any) -> str | None:
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
    """Prints nodes that stand on lines of their own, and the blocks in them.

    indent: one step. tables: of nodes of many lines, their text with an indentation and line ends.
    trails: whether a node stands behind another on its line. stands_apart: whether a blank line
    stands before a node that is not the first of its block.
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
        """What a node says, as `Templates.sketch` does, a table as its lines."""
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
