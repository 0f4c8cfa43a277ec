"""Changes of a module: made in its tree, written into its text, and found between two texts.

Lifting and building lose layout, order and spelling. So a changed program is built twice, as it was
lifted and as it is now: `merge` makes in the tree what differs between the two, and leaves the rest
as people wrote it. `render` writes a changed tree; unchanged parts keep their bytes.

A controller keeps the words of a loaded module, but not its layout, and prints data anew with the
present value: a num with six digits at most (`0.0142213`, `1264.86`), whole numbers without a
point, `9E+09`. So `module_pieces` compares the numbers of data by six digits (15 of a dnum), whole
numbers and those of statements exactly, and leaves comments out.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from typing import Any, Final

from assistant.languages.rapid.reading.scanner import words
from assistant.languages.rapid.text.printer import INDENT, PRINTER
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import plain_row
from assistant.languages.texts import lossless, tree_merge
from assistant.languages.texts.lossless import Block, Extent, Sketch
from assistant.languages.texts.words import Word

_ItemKey = tuple[str, str]


def merge(tree: s.File, before: s.File, after: s.File) -> s.File:
    """The tree with everything changed that differs between two built trees.

    `after` itself where a change is in something that the tree does not have in that form.
    """
    if not all(len(file.modules) == 1 for file in (tree, before, after)):
        return after
    (module,), (old,), (new,) = tree.modules, before.modules, after.modules
    merged = tree_merge.merged_by_key(
        module.items, old.items, new.items, _item_key, changed=_merged_routine, place=_place_of_item
    )
    if merged is None:
        return after
    items = _with_comments(merged, _comment_texts(old.items), _comment_texts(new.items))
    name = module.name if old.name == new.name else new.name
    changed = replace(module, name=name, items=items)
    return replace(tree, parts=tuple(changed if part is module else part for part in tree.parts))


def _item_key(item: Any) -> _ItemKey | None:
    """Kind and lower-case name of what a module declares; a run is known by its first row."""
    match item:
        case s.TargetRunNode(_, run):
            return "data", run.names.name(0).lower()
        case s.Data(name=name):
            return "data", name.lower()
        case s.Routine(name=name):
            return "routine", name.lower()
        case s.Record(name=name) | s.Alias(name=name):
            return "type", name.lower()
    return None


def _merged_routine(here: Any, old: Any, new: Any) -> Any:
    """The new item, in a routine with the statements that did not change as they stand here."""
    # Statements are matched by position, which holds only if reading and lifting kept their number.
    if not isinstance(here, s.Routine) or len(here.body) != len(old.body):
        return new
    # `autojunk` would ignore statements that occur often in bodies of 200 or more.
    steps = SequenceMatcher(None, old.body, new.body, autojunk=False).get_opcodes()
    body: list[s.StatementNode] = []
    for step, first, last, start, stop in steps:
        body += here.body[first:last] if step == "equal" else new.body[start:stop]
    heads = (replace(old, body=()), replace(new, body=()))
    return replace(here if heads[0] == heads[1] else new, body=tuple(body))


def _place_of_item(items: Sequence[s.Item], new: Any) -> int:
    """Return the position of a new item: after the last item of its kind; data before the first
    routine.
    """
    data = isinstance(new, s.Data | s.TargetRunNode)
    kinds: Any = (s.Data, s.TargetRunNode) if data else type(new)
    places = [at + 1 for at, item in enumerate(items) if isinstance(item, kinds)]
    if places:
        return places[-1]
    routines = [at for at, item in enumerate(items) if isinstance(item, s.Routine)]
    return routines[0] if routines and not isinstance(new, s.Routine) else len(items)


def _comment_texts(items: Iterable[s.Item]) -> list[str]:
    return [item.text for item in items if isinstance(item, s.CommentLine)]


def _with_comments(items: Sequence[s.Item], old: list[str], new: list[str]) -> tuple[s.Item, ...]:
    """Comments that came stand first; those that went are gone wherever they stood."""
    gone = [text for text in old if text not in new]
    came = [s.CommentLine(text) for text in new if text not in old]
    kept = [i for i in items if not (isinstance(i, s.CommentLine) and i.text in gone)]
    return (*came, *kept)


_NEXT_OPTION: Final = re.compile(r"(?:[ \t\f\r\n]|![^\r\n]*)*\\")
"""Start of an optional argument, which a comma may precede."""
_ENDED_BY_SEMICOLON: Final = (
    *(s.Assignment, s.ProcedureCall, s.GotoLabel, s.ReturnFrom, s.RaiseError, s.Word),
    *(s.Connect, s.CompactIf, s.MoveRunNode),
)
"""Statements that end with a semicolon, which their span may leave out."""
_SEMICOLON: Final = re.compile(r"(?:[ \t\f\r\n]|![^\r\n]*)*;")
_FILE_HEADER: Final = re.compile(r"\s*%%%(.*?)%%%", re.DOTALL)


def render(file: s.File, origin: s.Origin) -> str:
    """The text of a file; what is as it was read keeps its bytes."""
    begin = _FILE_HEADER.match(origin.source.text)
    # A damaged file has no parts; its header stays part of the text.
    header = begin[1] if begin and origin.parts else None
    # Identity, not equality: an unchanged tree is the one that was read.
    if file.parts is origin.parts and file.header == header:
        return origin.source.text
    old = s.File(origin.parts, header)
    text = lossless.render(origin.source, old, replace(file, header=header), _FileLayout())
    if file.header == header:
        return text
    newline = origin.source.newline
    new = "" if file.header is None else f"%%%{file.header}%%%"
    if begin is None:
        return new + newline + text
    rest = text[begin.end() :]
    return new + rest if new else re.sub(r"^[ \t]*\r?\n", "", rest)


class _FileLayout(lossless.RunLayout):
    """RAPID: statements end with `;`, comments with their line."""

    spelled = frozenset(("string", "number"))
    indent = INDENT
    row_end = ";"
    note = "!"

    def words(self, text: str, start: int, end: int) -> Iterator[Word]:
        for word in words(text, start, end):
            if word.kind not in ("comment", "newline"):
                # The comma before an option is optional, so that `p,\x` and `p\x` are the same
                # words.
                if word.text != "," or not _NEXT_OPTION.match(text, word.end, end):
                    yield word

    def noted(self, gap: str) -> bool:
        return any(word.kind == "comment" for word in words(gap))

    def sketch(self, node: Any) -> Sketch:
        match node:
            case s.File():
                header = () if node.header is None else (f"%%%{node.header}%%%\n",)
                return (*header, Block(node.parts, 0))
            case lossless.RunRow(text=text):
                return (text,)
        return PRINTER.sketch(node)

    def extent(self, text: str, node: Any) -> Extent | None:
        if node.span is None:
            return None
        start, end = node.span.start, node.span.end
        # The grammar's spans may include blanks at both ends, which belong to the layout.
        while start < end and text[start].isspace():
            start += 1
        while start < end and text[end - 1].isspace():
            end -= 1
        if isinstance(node, _ENDED_BY_SEMICOLON) and text[end - 1] != ";":
            if semicolon := _SEMICOLON.match(text, end):
                end = semicolon.end()
        return Extent(start, end)

    def line_ends(self, before: Any, after: Any) -> int | None:
        if isinstance(before, s.CommentLine):
            return 1
        if isinstance(after, s.CommentLine) and before is not None:
            return 0 if after.trailing else 1
        blank = isinstance(before, s.Routine) or isinstance(after, s.Routine)
        return 2 if blank and before is not None and after is not None else None

    def is_run(self, node: Any) -> bool:
        return isinstance(node, s.TargetRunNode | s.MoveRunNode)

    def may_be_row(self, node: Any) -> bool:
        return plain_row(node) is not None


_UNCOMPARED: Final = frozenset({"comment", "header", "newline"})
_SCOPES: Final = frozenset({"local", "task"})
_STORAGES: Final = frozenset({"const", "pers", "var"})
_PIECE_BEGINS: Final = frozenset(
    (
        *("module", "endmodule", "proc", "endproc", "func", "endfunc", "trap", "endtrap"),
        *("record", "endrecord", "alias", "if", "elseif", "else", "endif", "for", "endfor"),
        *("while", "endwhile", "test", "case", "default", "endtest", "error", "undo", "backward"),
    )
)
"""Words that begin a piece, where no bracket is open."""
_PIECE_ENDS: Final = frozenset({";", "then", "do", "else"})
"""Words that end one."""
_DIGITS: Final = 6
_DIGITS_OF: Final = {"dnum": 15}
_BEFORE_SIGN: Final = frozenset({"[", "(", ",", ":="})
"""Before a `-` that is the sign of a number."""


def module_pieces(text: str) -> Iterator[tuple[str, str]]:
    """Yield the declarations and statements of a text: the compared form and the source text of
    each.
    """
    piece: list[Word] = []
    depth = 0
    for word in words(text):
        if word.kind in _UNCOMPARED:
            continue
        low = word.text.lower()
        begins = low in _PIECE_BEGINS or low in _SCOPES or low in _STORAGES
        # A piece begins at `LOCAL` or `TASK`, not once more at the word that follows it.
        if piece and depth == 0 and begins and piece[-1].text.lower() not in _SCOPES:
            yield _piece(piece, text)
            piece = []
        piece.append(word)
        # A stray closing bracket must not hide the ends of all later pieces.
        depth = max(0, depth + (low in "([{") - (low in ")]}")) if word.kind == "mark" else depth
        if low in _PIECE_ENDS and depth == 0:
            yield _piece(piece, text)
            piece = []
    if piece:
        yield _piece(piece, text)


def _piece(piece: list[Word], text: str) -> tuple[str, str]:
    last = piece[-1]
    return _compared_form(piece), text[piece[0].start : last.start + len(last.text)]


def _compared_form(piece: list[Word]) -> str:
    lows = [word.text.lower() for word in piece]
    kind = next((i for i in (0, 1) if i < len(lows) and lows[i] in _STORAGES), None)
    data = kind is not None and ":=" in lows
    # Statements keep their spelling on the controller; data is printed anew from its value.
    digits = 0
    if data and kind is not None:
        digits = _DIGITS_OF.get(lows[kind + 1], _DIGITS)
    found: list[str] = []
    for i, word in enumerate(piece):
        if word.kind == "string":
            found.append(word.text)
        elif word.kind == "number":
            value = _compared_number(lows[i], digits)
            if value == "0" and len(found) > 1 and found[-1] == "-" and found[-2] in _BEFORE_SIGN:
                found.pop()  # `-0.00` is printed for what is nothing
            found.append(value)
        elif lows[i] == "," and i + 1 < len(lows) and lows[i + 1] == "\\":
            continue  # that comma may be left out
        else:
            found.append(lows[i])
    return " ".join(found)


def _compared_number(text: str, digits: int) -> str:
    """digits: that count of one with a point or an exponent; 0 for all of them."""
    # Other bases are whole numbers.
    if text.startswith(("0x", "0b", "0o")):
        return str(int(text, 0))
    plain = text.removeprefix("0d")
    value = float(plain)
    if plain.isdecimal() and math.isfinite(value):
        return str(int(plain))
    # The controller prints a num from its single precision value, so both sides are rounded to
    # that.
    if digits == 0 or digits > _DIGITS:
        shown = f"{value:.{digits}G}" if digits else repr(value)
    else:
        shown = f"{_as_num(value):.{digits}G}"
    # Whole numbers compare alike with and without a point; above 1E15 `int` would show digits that
    # the value does not have.
    back = float(shown)
    return str(int(back)) if back.is_integer() and abs(back) < 1e15 else repr(back)


def _as_num(value: float) -> float:
    """Round a value to the precision of a num."""
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return value
