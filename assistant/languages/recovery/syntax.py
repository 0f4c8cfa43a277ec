"""What a language says of itself so that damaged texts of it are read: tables, no behaviour.

Terminals have the names of its grammar. Marks have those that lark gives them: `SEMICOLON`,
`COMMA`, `LPAR` and `RPAR`, `LSQB` and `RSQB`, `LBRACE` and `RBRACE`, `COLON`, `DOT`; a value is
made of `NAME`, `NUMBER`, `STRING` and others.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Set
from dataclasses import dataclass

from assistant.languages.recovery.layout import Layout
from assistant.languages.recovery.lexemes import Holes, Scanner

Types = tuple[str, ...]
"""Terminals in a row."""


@dataclass(frozen=True, slots=True)
class HalfHead:
    """A head of a block that is a whole statement where its last word is forgotten.

    opener: its first word. last: the forgotten one. word: that one as it is written, in lower
    case. wanted: what stands in such a block only. comment: regular expression.
    """

    opener: str
    last: str
    word: str
    wanted: Set[str]
    comment: re.Pattern[str]


@dataclass(frozen=True, slots=True)
class Blocks:
    """What opens, divides and closes.

    ends: the word that opens a block → the one that closes it. clauses: words that divide one.
    scopes: blocks that no statement goes on behind. unit: the block that a file consists of,
    whose begin, end and the begin of whose items are regular expressions. starts: words that only
    a whole statement, item or unit may begin with. heads: what stands behind a word that opens a
    block or a part of one. last: words that end a head. braces: what other languages open a block
    with, and what is meant by it.
    """

    ends: Mapping[str, str]
    clauses: Set[str]
    scopes: Set[str]
    unit: str
    unit_begin: re.Pattern[str]
    unit_end: re.Pattern[str]
    item: re.Pattern[str]
    starts: Set[str]
    heads: Mapping[str, Types]
    last: Set[str]
    braces: Mapping[str, Types]
    half: HalfHead


@dataclass(frozen=True, slots=True)
class Changes:
    """What people forget, confuse and take from elsewhere.

    inserted: words before one that does not fit. openers: words that a statement or declaration
    begins with; needs: those of which it has one, most likely. alike: groups of words that are
    written for each other; unmeant: those that nobody means. wraps: what is missing around
    statements and items. reserved: words of the language in lower case → terminal. foreign: words
    of other languages → those meant. strings, comments: types of what other languages write so.
    used: words behind a name that is used. table: values in one word.
    """

    inserted: tuple[Types, ...]
    openers: Types
    needs: Mapping[str, Set[str]]
    alike: tuple[Types, ...]
    unmeant: Set[str]
    wraps: tuple[Types, ...]
    reserved: Mapping[str, str]
    foreign: Mapping[str, Types]
    strings: Set[str]
    comments: Set[str]
    used: Set[str]
    table: str


@dataclass(frozen=True, slots=True)
class Syntax:
    """assign: the word between a variable and its value. value: the hole for a value. data: words
    that a declaration begins with. statement_holes, data_holes: what stands for one that is left
    out. glue: words that a line may end or begin with in the middle of a statement. runs: marks of
    what was read before → words that each could begin with.
    """

    scanner: Scanner
    holes: Holes
    blocks: Blocks
    changes: Changes
    layout: Layout
    assign: str
    value: str
    data: Set[str]
    statement_holes: Types
    data_holes: Types
    glue: Set[str]
    runs: Mapping[str, Types]
