"""One line of a program: its words, the grammar that reads them, and the node that results.

`*` begins a label or multiplies, `Tool` is a statement or a name: the lexer decides by the words
that the grammar has room for. The grammar itself is `melfa_basic.lark`.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.languages import nodes
from assistant.languages.grammar import Grammar, acceptor, load
from assistant.languages.line_grammar import ContextualLexer, LineGrammar
from assistant.languages.melfa_basic.tables.variables import keyword_spelling
from assistant.languages.melfa_basic.tables.vocabulary import words
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import FLAGS
from assistant.languages.nodes import Children, Place, row, without_place
from assistant.languages.recovery.syntax import Lexeme, Stop

if TYPE_CHECKING:
    from lark import Lark


_INTEGER_LIMIT: Final = 15


def _number_of(text: str, suffix: str = "") -> s.Number:
    """A number literal of any base; raises ValueError for one that is too large."""
    mark = text[:2].upper()
    if mark == "&H":
        return s.Number(_whole(text[2:], 16), 16, suffix)
    if mark == "&B":
        return s.Number(_whole(text[2:], 2), 2, suffix)
    # Longer numbers are not all exact in double precision, so they are read as floats.
    if text.isdigit() and len(text) <= _INTEGER_LIMIT:
        return s.Number(int(text), 10, suffix)
    return s.Number(_finite(text), 10, suffix)


def _constant_of(text: str, span: Span | None = None) -> s.Constant:
    """A position or joint constant from its text; raises ValueError as number_of does."""
    values, _, flags = text.partition(")")
    # Adding 0.0 makes 0.0 of -0.0.
    elements = tuple(_finite(e) + 0.0 if e else None for e in _elements(values))
    if "(" not in flags:
        return s.Constant(elements, None, span)
    one, two = (_flag(f) for f in _elements(flags.rstrip().rstrip(")")))
    return s.Constant(elements, (one, two), span)


def _whole(digits: str, base: int) -> int:
    value = int(digits, base)
    # Later steps calculate with floats, which the value has to fit into.
    if value > sys.float_info.max:
        raise ValueError(f"{digits} is too large")
    return value


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is too large")
    return value


def _elements(text: str) -> list[str]:
    return [part.strip() for part in text.strip().lstrip("(").split(",")]


def _flag(text: str) -> int | None:
    if not text:
        return None
    value = int(_number_of(text).value) if text[0] == "&" else int(text)
    if value not in FLAGS:
        raise ValueError(f"{text} is too large")
    return value


def _label_of(text: str) -> str:
    """A label's name without its mark."""
    return text.lstrip("*").strip()


def _unquoted(text: str) -> str:
    return text[1:-1]


_LIST_ROWS: Final = dict.fromkeys(
    ("arguments", "given", "type", "parameters", "printed"), without_place(tuple)
)
_NODE_ROWS: Final = {
    **_LIST_ROWS,
    "later_arguments": without_place(lambda children: (None, *children)),
    # expressions
    "number": without_place(lambda children: _number_of(*filter(None, children))),
    "string": row(s.String, value=_unquoted),
    "variable": row(s.Variable, "name suffix? arguments"),
    "empty_call": row(s.Variable, "name suffix? _", arguments=()),
    "component": row(s.Variable, "name arguments component", component=str.upper),
    "binary": row(s.Binary, "left operator right", operator=str.upper),
    "power": row(s.Binary, "left right", operator="^"),
    "unary": row(s.Unary, operator=str.upper),
    "pallet": row(s.Pallet),
    "word": row(s.Word, text=str.capitalize),
    "channel": row(s.Channel),
    "opening": row(s.Opening),
    # statements
    "command": row(s.Command, "keyword arguments?", keyword=keyword_spelling),
    "word_alone": row(s.Command, "keyword", keyword=keyword_spelling),
    "end_select": row(s.Command, "_", keyword="End Select"),
    "exit_function": row(s.Command, "", keyword="Exit Function"),
    "motion": row(s.Motion, "keyword arguments? type append", keyword=keyword_spelling),
    "append": row(s.Append),
    "append_if": row(s.Append, "condition statement"),
    "assign": row(s.Assign, "target value _ delay"),
    "label": row(s.Target, place=_label_of),
    "step": row(s.Target, place=int),
    "data": row(s.Data, "type? variable value", type=keyword_spelling),
    "if": row(s.If, "condition then _ otherwise"),
    "if_jump": row(s.If, "condition _ then _ otherwise"),
    "elseif": row(s.ElseIf),
    "for": row(s.For),
    "next": row(s.Next, "*variables"),
    "select": row(s.Select),
    "case_range": row(s.CaseRange),
    "case_is": row(s.CaseIs),
    "case": row(s.Case, "*items"),
    "jump": row(s.Jump, keyword=keyword_spelling),
    "on_jump": row(s.OnJump, "_ subject keyword *targets", keyword=keyword_spelling),
    "on_com": row(s.OnCom, "_ line _ target"),
    "com": row(s.Com, state=str.capitalize),
    "callp": row(s.CallP, "program *arguments"),
    "fprm": row(s.FPrm, "*variables"),
    "def_names": row(s.DefNames, "type *variables", type=keyword_spelling),
    "def_io": row(s.DefIo, type=str.capitalize),
    "def_fn": row(s.DefFunction, "name suffix? *parameters value"),
    "def_other": row(s.DefOther, kind=keyword_spelling),
    "def_act": row(
        s.DefAct,
        "_ number condition keyword target stop?",
        keyword=keyword_spelling,
        stop=str.upper,
    ),
    "dim": row(s.Dim, "*variables"),
    "const": row(s.Const, "type? variable value", type=keyword_spelling),
    "static": row(s.Static),
    "include": row(s.Include, program=_unquoted),
    "result": without_place(lambda children: "".join(filter(None, children))),
    "function": row(s.Function, "result? name suffix? parameters"),
    "parameter": row(s.FunctionParameter, "mode? name suffix? array?", mode=keyword_spelling),
    "open": row(s.Open, "name mode? number", mode=str.capitalize),
    "close": row(s.Close, "*numbers"),
    "print": row(s.Print, "number *items"),
    "input": row(s.Input, "number *variables"),
    # lines
    "line": row(s.Line, "label statement comment", label=_label_of, comment=str.rstrip),
}
"""Rules whose children are the fields of a node."""


class Nodes(nodes.Nodes, rows=_NODE_ROWS):
    """And the others."""

    def signed(self, _: Place, children: Children) -> s.Number | s.Unary:
        sign, text, suffix = children
        number = _number_of(text, suffix or "")
        return number if sign is None else s.Unary(sign, number)

    def position(self, place: Place, children: Children) -> s.Constant:
        return _constant_of(children[0], self.span(place))

    def call(self, place: Place, children: Children) -> s.Call:
        name, suffix, arguments = children
        return s.Call(s.Variable(name, suffix or "", arguments or (), span=self.span(place)))


_GRAMMAR_FILE: Final = "melfa_basic.lark"
_GRAMMAR_STARTS: Final = ("line", "data", "start")


@cache
def grammar() -> Grammar:
    """The rules of a code line (start `line`), a variable line (`data`) and a file (`start`)."""
    return load(_GRAMMAR_FILE, _GRAMMAR_STARTS)


def by_lark() -> Lark:
    """Return lark's own parser for the same grammar."""
    return acceptor(_GRAMMAR_FILE, _GRAMMAR_STARTS)


@cache
def _never_names() -> frozenset[str]:
    """Words in upper case that are never names, even where the rules have no room for them."""
    # The words that the pattern of NAME excludes in front.
    listed = re.search(r"\(\?!\(\?:([a-z|]+)\)", grammar().terminals["NAME"].pattern)
    return frozenset(listed[1].upper().split("|")) if listed else frozenset()


@cache
def keywords() -> Mapping[str, tuple[str, ...]]:
    """The terminals that a word in upper case may be; the first that has room is meant."""
    found = {word.upper(): terminals for word, terminals in grammar().words.items()}
    found["ELSEIF"] = found["ELSE IF"] = ("_ELSEIF",)
    for word in words("motion"):
        # A word that may begin a move is a move before it is anything else.
        found[word.upper()] = ("MOTION", *found.get(word.upper(), ()))
    for word in words("command"):
        found[word.upper()] = (*found.get(word.upper(), ()), "COMMAND")
    return found


_SPECIAL_WORDS: Final = {
    "FN": ("FN_NAME", re.compile(r"FN.+")),
    "MX": ("COMMAND", re.compile(r"MXT(?=[0-9]+\Z)")),
}
"""Functions of the program, `FNAREA`, and the one command with its number, `MXT1`."""


def lexer() -> ContextualLexer:
    return ContextualLexer(
        grammar(),
        {**keywords(), "END IF": keywords()["ENDIF"]},
        plain=("NUMBER", "STRING", "COMMENT", "COMPARISON", "SHIFT", "SIGN", "TIMES"),
        firm=_never_names(),
        longer={
            "(": ("POSITION", "EMPTY"),
            "*": ("LABEL",),
            "&": ("HEX", "BINARY"),
            "#": ("_INCLUDE",),
            "REM": ("REM",),
        },
        joined=dict.fromkeys("$%!&#", "SUFFIX"),
        instead={"NUMBER": "STEP"},
        special=_SPECIAL_WORDS,
    )


_BLANKS: Final = " \t\f\x1a"
"""Characters of a line without content; the last one ends files of old systems."""
_MOST_WORDS: Final = 256
"""Words of a line that are read: no controller takes a step of more bytes."""
_MOST_NESTING: Final = 60
"""Brackets inside each other that are read. Controllers take 16."""

# No controller has steps of more digits, and the possessive blanks cannot be tried again.
_STEP: Final = re.compile(r"[ \t]*+([0-9]{1,9})(?=[ \t*']|$)")
_DECLARED: Final = re.compile(
    r"[ \t]*DEF[ \t]+(?:POS|JNT|INTE|LONG|FLOAT|DOUBLE|CHAR)[ \t]+[A-Z][A-Z0-9_]*+"
    r"[$%&!#]?[ \t]*(?:\([0-9, \t]*\))?[ \t]*=",
    re.IGNORECASE,
)
"""A line of a position list: `DEF POS P1=(…)(6,0)`."""


@dataclass(frozen=True, slots=True)
class TooLarge:
    """A line that has a number which no variable takes."""


@cache
def line_grammar() -> LineGrammar:
    return LineGrammar(grammar().tables, lexer().next, _MOST_WORDS, 2 * _MOST_NESTING)


@cache
def _nodes() -> Nodes:
    return Nodes()


def read_line(
    text: str, start: int, end: int, behind: int
) -> s.Line | s.Data | s.Blank | Stop | TooLarge:
    """Return the node for the text between two offsets, or why it cannot be read.

    behind: offset after the line end.
    """
    span = Span(start, behind)
    if not text[start:end].strip(_BLANKS):
        return s.Blank(span)
    number, at, rule = split_step(text, start, end)
    try:
        node = line_grammar().read(text, at, end, rule, _nodes(), None)
    # The only cause is a number that is too large.
    except ValueError:
        return TooLarge()
    return node if isinstance(node, Stop) else placed(node, number, span)


def placed(node: s.Line | s.Data, number: int | None, span: Span | None) -> s.Line | s.Data:
    """Return the node that the grammar built from a line, with its step number and its span."""
    if isinstance(node, s.Line):
        return s.Line(number, node.label, node.statement, node.comment, span)
    return replace(node, span=span)


def split_step(text: str, start: int, end: int) -> tuple[int | None, int, str]:
    """Return the step number of a line, the offset of the code after it, and the rule of the
    grammar for that.
    """
    step = _STEP.match(text, start, end)
    at = step.end() if step else start
    rule = "data" if _DECLARED.match(text, at, end) else "line"
    return int(step[1]) if step else None, at, rule


def statement(text: str) -> s.Line | None:
    """One code line without a step number, None if it is not MELFA-BASIC."""
    # A line end would make two lines of the text.
    if "\n" in text or "\r" in text or _STEP.match(text):
        return None
    node = read_line(text, 0, len(text), len(text))
    return node if isinstance(node, s.Line) else None


def expression(text: str) -> s.Expression | None:
    """Read an expression; None if the text is not an expression."""
    # The grammar has no rule for an expression alone: read it as the value of an assignment.
    line = statement("M0=" + text)
    if line is None or line.comment is not None:
        return None
    match line.statement:
        case s.Assign(value=value, delay=None):
            return value
    return None


def lexemes(text: str, start: str = "line") -> tuple[Lexeme, ...]:
    """The words of a line without its step number, as far as it is MELFA-BASIC.

    start: the rule of the grammar, `line` or `data`.
    """
    words: list[Lexeme] = []
    line_grammar().read(text, 0, len(text), start, _Nothing(), words)
    return tuple(words)


class _Nothing(Nodes):
    """Makes no nodes."""

    def __getattribute__(self, name: str) -> object:
        return _no_node


def _no_node(_: Span | None, __: list[object]) -> None:
    return None
