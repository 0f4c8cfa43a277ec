"""Lines: step numbers, length and labels; rows of tables that need a line; damaged lines.

A table holds lines on which no single-line rule has a finding: moves in ascending steps to existing
positions, and positions with separate names. Any other row of a table is read as an ordinary line.
So a single-line rule never searches tables; only rules that compare lines with each other do.

A finding elsewhere must not follow from the unreadable content of a damaged line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from assistant.base.arrays import Ints, Truths
from assistant.base.diagnostics import Span
from assistant.base.source_text import with_line_feeds
from assistant.languages.checks import registry
from assistant.languages.checks.names import NameSet, repeated, repeated_rows
from assistant.languages.checks.registry import Damage, Found, Needs
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.file_view import Calls, Look, known_variables, names_of
from assistant.languages.melfa_basic.checks.values import before_last_step
from assistant.languages.melfa_basic.reading.parser import read_rows
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.tables.vocabulary import function, statements, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MVR, MoveRows, PositionRows, row_slice
from assistant.languages.melfa_basic.tree.control_flow import block_word, exits_of, statement_of
from assistant.languages.runs.columns import Names
from assistant.languages.step_numbers import places_of_steps

_NAME: Final = re.compile(r"[A-Z][A-Z0-9_]*")
_CODE: Final = re.compile(r"[ \t]*([0-9]{0,9})[ \t]*(.*)", re.DOTALL)
_PLAIN: Final = re.compile(r"[A-Z][A-Z0-9_]*[$%&!#]?(?:\(.*\))?(?:\.[A-Z0-9]+)?[ \t]*=")
"""Begin of an assignment."""
_LANGUAGE_WORDS: Final = frozenset(part.upper() for word in statements() for part in word.split())
_RUN_ON_WORDS: Final = frozenset(
    """
    ACCEL CMP COLCHK DLY ERROR FINE HCLOSE HOPEN HLT JOVRD LOADSET MOV MVA MVC MVR MVR2 MVR3 MVS
    OADL OVRD PRINT PREC SERVO SPD TORQ WAIT
    """.split()  # noqa: SIM905
)
"""Words of statements that run on to the next line and that no other line depends on."""
_STEERING_WORDS: Final = frozenset(
    """
    ACT BASE BREAK CALL CALLP CASE CLOSE CNT DEF DEFAULT ELSE ELSEIF END ENDIF EXIT FEND FOR
    FUNCTION GETM GOSUB GOTO IF INCLUDE NEXT ON OPEN RELM RETURN SELECT SKIP STEP THEN TO TOOL
    WEND WHILE XRUN
    """.split()  # noqa: SIM905
)
"""Words that others are paired with, that lead elsewhere, or that hold from there on."""


_BROKEN_NAME: Final = re.compile(
    r"(?![A-Z*])|\*[ \t]*(?![A-Z])|\*[ \t]*\w+[ \t]+\w|[A-Z]\w*[ \t]+\w+[ \t]*[(=]"
)
"""Begin of a line whose label or variable is left out, or parted by a blank."""
_DECLARING_WORDS: Final = frozenset("CONST DEF DIM FPRM FUNCTION INPUT STATIC".split())  # noqa: SIM905


def damage_of(trees: Sequence[s.File]) -> Damage | None:
    """Return the damage in the files of a program; None if they are undamaged."""
    return registry.damage_of(trees, _names_in)


def spoiled(trees: Sequence[s.File], damage: Damage | None) -> Needs:
    """Return what the files lack: `ORDER` if a damaged line can be a jump, a label, part of a block
    or a setting; `NAMES` if one can define something that it does not name.
    """
    if damage is None:
        return Needs.NOTHING
    code = [part[2] for part in _damaged_parts(damage)]
    spoils = Needs.WHOLE
    if not all(map(_runs_on, code)):
        spoils |= Needs.ORDER
    # A damaged head of a function moves the lines after it to another scope, with their names.
    hidden = Needs.ORDER in spoils and any(map(_has_functions, trees))
    if hidden or any("#" in line or _is_broken(line) for line in code):
        spoils |= Needs.NAMES
    return spoils


def _steps_of(damage: Damage | None) -> set[int]:
    """The step numbers of the damaged lines."""
    return set() if damage is None else {int(part[1]) for part in _damaged_parts(damage) if part[1]}


def _damaged_parts(damage: Damage) -> list[re.Match[str]]:
    return [part for text in damage.texts if (part := _CODE.match(text.upper()))]


def _names_in(text: str) -> Iterator[str]:
    """Yield the names in a text, without the words of the language, in upper case."""
    for word in _NAME.findall(text.upper()):
        if word not in _LANGUAGE_WORDS and status(word) is None and function(word) is None:
            yield word


def _is_broken(code: str) -> bool:
    """True if a damaged line may define something whose name is damaged as well."""
    first = _NAME.match(code)
    if first is not None and first[0] in _LANGUAGE_WORDS:
        return first[0] in _DECLARING_WORDS
    return _BROKEN_NAME.match(code) is not None


def _runs_on(code: str) -> bool:
    """True if a damaged line, in upper case and without its step number, runs on to the next."""
    words = _NAME.findall(code)
    leads = _PLAIN.match(code) is not None or (bool(words) and words[0] in _RUN_ON_WORDS)
    return leads and "*" not in code and _STEERING_WORDS.isdisjoint(words)


def _has_functions(tree: s.File) -> bool:
    return any(block_word(statement_of(item)).bounds for item in tree.items)


_NUMBER: Final = re.compile(r"[ \t]*([0-9]+)")


def step_order(look: Look) -> Found:
    """Step numbers ascend, fit, and stand at every line if at one."""
    numbered = any(isinstance(i, MoveRows) or i.number is not None for i in look.code)
    before = 0
    for item in look.code:
        if isinstance(item, MoveRows):
            before = int(item.steps[-1])  # in a table they ascend
        elif item.number is None:
            if numbered:
                what = "the line has no step number, but others have"
                yield look.finding(rules.NO_STEP_NUMBER, item, what=what)
        else:
            where = _step_number(look, item)
            if not 1 <= item.number <= LAST_STEP:
                yield look.finding(rules.STEP_RANGE, where, number=item.number, most=LAST_STEP)
            if item.number <= before:
                yield look.finding(rules.NOT_ASCENDING, where, number=item.number, before=before)
            before = item.number
    first = next((line for line in look.lines if line.statement or line.label), None)
    if first is not None and not numbered and look.dialect.steps_needed:
        what = f"{look.dialect.title} needs a step number at every line, and no line has one"
        yield look.finding(rules.NO_STEP_NUMBER, first, what=what)


def _step_number(look: Look, line: s.Line) -> Span | None:
    if line.span is None or look.source is None:
        return None
    found = _NUMBER.match(look.source.text, line.span.start)
    return Span(*found.span(1)) if found else line.span


def step_lengths(look: Look) -> Found:
    """Steps that are longer than a controller takes, in bytes of the file's own encoding."""
    source = look.source
    encoding = source.encoding if source is not None else "utf-8"
    most = look.dialect.line
    for line in look.lines:
        text = look.text_of(line)
        # A character has four bytes at most, so short lines need no encoding.
        if len(text) * 4 <= most:
            continue
        length = len(text.encode(encoding, "replace"))
        if length > most:
            yield look.finding(rules.LONG_LINE, line, length=length, most=most)


# --------------------------------------------------------------------------------------- labels


def jump_labels(look: Look) -> Found:
    """A label stands once, and what is jumped to is there; functions have their own."""
    for scope in look.scopes:
        lines = look.lines_of(scope)
        for line in repeated(lines, _label_of):
            yield look.at(rules.TWO_LABELS, line, f"*{line.label}", name=line.label)
        # Jumps inside of a function reach its own labels only.
        labels = set(map(_label_of, lines))
        for line in lines:
            yield from _missing_targets(look, line, labels, inside=scope.function is not None)


def _label_of(line: s.Line) -> str | None:
    return line.label.upper() if line.label is not None else None


def _missing_targets(look: Look, line: s.Line, labels: set[str | None], *, inside: bool) -> Found:
    for target in exits_of(line.statement).targets:
        if isinstance(target.place, int):
            if target.place not in look.once(_step_numbers):
                word = str(target.place)
                yield look.at(rules.NO_STEP, line, word, name=target.place)
            elif not look.dialect.line_targets:
                word, title = str(target.place), look.dialect.title
                yield look.at(rules.LINE_TARGET, line, word, name=target.place, title=title)
        elif target.place.upper() not in labels:
            other = target.place.upper() in look.once(_all_labels)
            where = ""
            if other:
                where = " in this Function" if inside else " outside of the Functions"
            yield look.at(rules.NO_LABEL, line, target, name=target.place, where=where)


def _step_numbers(look: Look) -> set[int]:
    return _steps_of(look.damage).union(places_of_steps(look.code))


def _all_labels(look: Look) -> set[str | None]:
    return set(map(_label_of, look.lines))


_RowTable = MoveRows | PositionRows


def with_single_rows(trees: Sequence[s.File], dialect: Dialect | None = None) -> tuple[s.File, ...]:
    """Return the files of a program with an ordinary line for each row of a table that is not
    plain.

    dialect: with the limits of a certain controller; if omitted, that of each file.
    """
    calls = Calls(trees)
    return tuple(
        _single_rows(Look(tree, dialect or DIALECTS[tree.dialect], calls)) for tree in trees
    )


def _single_rows(look: Look) -> s.File:
    tree, source = look.tree, look.source
    if source is None or not any(isinstance(item, _RowTable) for item in tree.items):
        return tree
    single = {**_irregular_moves(look), **_irregular_positions(look)}
    if not any(rows.any() for rows in single.values()):
        return tree
    text = with_line_feeds(source.text)
    items: list[s.Item] = []
    for item in tree.items:
        if isinstance(item, _RowTable) and item.places is not None and single[id(item)].any():
            items += _split_table(text, item, single[id(item)])
        else:
            items.append(item)
    return replace(tree, items=tuple(items))


def _split_table(text: str, rows: _RowTable, single: Truths) -> list[s.Item]:
    bounds = np.flatnonzero(single[1:] != single[:-1]) + 1
    found: list[s.Item] = []
    for first, stop in pairwise([0, *bounds.tolist(), len(single)]):
        if single[first]:
            chosen = np.zeros(len(single), dtype=bool)
            chosen[first:stop] = True
            found += read_rows(text, rows, chosen)
        else:
            found.append(row_slice(rows, first, stop))
    return found


def _irregular_moves(look: Look) -> dict[int, Truths]:
    """By the `id` of a table of moves, its rows (n,) that are not plain."""
    names, found, before = look.once(known_variables).given, dict[int, Truths](), 0
    zeros = _zero_positions(look)
    for item in look.code:
        if not isinstance(item, MoveRows):
            before = item.number or before
            continue
        # Steps go on ascending from the line before the table.
        steps = np.concatenate([[before], item.steps])
        single = (steps[1:] <= steps[:-1]) | (item.steps > LAST_STEP)
        arc = item.kinds == MVR
        for numbers, counts in ((item.end, ~arc | arc), (item.via, arc), (item.start, arc)):
            targets = Names.numbered(item.stem.encode("ascii"), numbers)
            odd = zeros.among(targets) | _too_long(look, item.stem, numbers)
            # Files that were not read may hold the position.
            if not look.has_strangers:
                odd |= ~names.among(targets)
            single |= counts & odd
        found[id(item)], before = single, int(item.steps[-1])
    return found


def _irregular_positions(look: Look) -> dict[int, Truths]:
    """The same of tables of positions."""
    tables = [item for item in look.data if isinstance(item, PositionRows)]
    found = {}
    # A position among the steps is a finding, which needs a line.
    among = {id(item) for item in before_last_step(look) if isinstance(item, PositionRows)}
    for rows in tables:
        zero = (rows.values == 0).all(axis=1)
        found[id(rows)] = _too_long(look, rows.stem, rows.numbers) | zero | (id(rows) in among)
    lines = [item.variable.key for item in look.data if isinstance(item, s.Data)]
    columns = [*map(names_of, tables), Names.of([name for name in lines if name.isascii()])]
    for pair in repeated_rows(columns):
        for at, row in pair:
            if at < len(tables):
                found[id(tables[at])][row] = True
    return found


def _too_long(look: Look, stem: str, numbers: Ints) -> Truths:
    """(n,) whether names are longer than the version takes."""
    # Numbers with more digits than the stem leaves room for.
    room = look.dialect.longest - len(stem)
    return np.asarray(numbers >= 10 ** max(room, 0))


def _zero_positions(look: Look) -> NameSet:
    """Positions whose numbers are all 0."""
    found = NameSet()
    for item in look.data:
        if isinstance(item, PositionRows):
            found.columns.append(names_of(item).rows((item.values == 0).all(axis=1)))
        elif isinstance(item.value, s.Constant) and not any(item.value.values):
            found.words.add(item.variable.key)
    return found
