"""Random files of MELFA-BASIC IV, V and VI: every statement that a version has.

They are well formed: blocks are closed, labels and steps that are jumped to are there, and so
are the functions that are called.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import chain
from typing import Any, Final

from hypothesis import strategies as st

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.line_tables import gathered
from tests.languages.melfa_basic.statements import (
    FUNCTIONS,
    command,
    definitions,
    simple,
)
from tests.languages.melfa_basic.values import (
    COORDINATES,
    FULL,
    JOINTS,
    LEVELS,
    USER_FUNCTIONS,
    Strategy,
    conditions,
    expressions,
    labels,
    names,
    or_none,
    some,
    variables,
)

COMMENTS: Final = st.one_of(
    st.sampled_from(("'", "' note", "'10 END", "'it\"s", "Rem", "Rem text", "REM *L", "'ロボット")),
    st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=12).map("'".__add__),
).map(str.rstrip)


def line(statement: s.Statement | None = None, label: str | None = None) -> s.Line:
    return s.Line(None, label, statement)


Lines = tuple[s.Line, ...]

# -------------------------------------------------------------------------------- blocks


@cache
def bodies(level: int, depth: int) -> Strategy:
    """Lines of code, with blocks inside each other to some depth."""
    one = st.one_of(
        simple(level).map(lambda statement: (line(statement),)),
        st.builds(_noted, simple(level), COMMENTS),
        COMMENTS.map(lambda text: (s.Line(comment=text),)),
        st.builds(_labelled, labels(level), or_none(simple(level)), or_none(COMMENTS)),
        moves(level),
        *([blocks(level, depth)] if depth else []),
    )
    return st.lists(one, max_size=4 * depth + 2).map(lambda parts: tuple(chain(*parts)))


def _noted(statement: s.Statement, comment: str) -> Lines:
    return (s.Line(None, None, statement, comment),)


def _labelled(label: str, statement: s.Statement | None, comment: str | None) -> Lines:
    return (s.Line(None, label, statement, comment),)


@cache
def moves(level: int) -> Strategy:
    """Fewer moves than make a table and more, through positions of one name."""

    def row(keyword: str, stem: str, number: int) -> s.Line:
        count = 3 if keyword == "Mvr" else 1
        ends = tuple(s.Variable(f"{stem}{number + k}") for k in range(count))
        return line(s.Motion(keyword, ends))

    keywords = st.lists(st.sampled_from(("Mov", "Mvs", "Mvr")), min_size=1, max_size=5)
    stems = st.sampled_from(("P", "PA", "P_"))
    return st.builds(
        lambda words, stem, first: tuple(row(w, stem, first + k) for k, w in enumerate(words)),
        keywords,
        stems,
        st.integers(0, 99),
    )


@cache
def blocks(level: int, depth: int) -> Strategy:
    """Loops, selections and, where there are any, If blocks."""
    body, condition = bodies(level, depth - 1), conditions(level)
    made = [
        st.builds(_for, _loops(level), body, st.integers(0, 2)),
        st.builds(lambda c, inner: (line(s.Command("While", (c,))), *inner, WEND), condition, body),
    ]
    if LEVELS[level].nested_select or depth > 1:
        made.append(_selections(level, depth))
    if LEVELS[level].blocks:
        made.append(
            st.builds(_if, condition, body, some(st.tuples(condition, body)), or_none(body))
        )
    return st.one_of(made)


WEND: Final = line(s.Command("WEnd"))


def _loops(level: int) -> Strategy:
    number = expressions("M", level, 1)
    return st.builds(s.For, variables("M", level), number, number, or_none(number))


def _for(head: s.For, body: Lines, named: int) -> Lines:
    return (line(head), *body, line(s.Next((head.variable,) if named else ())))


def _if(condition: Any, body: Lines, others: Sequence[Any], otherwise: Lines | None) -> Lines:
    out = [line(s.If(condition, None)), *body]
    for one, inner in others:
        out += [line(s.ElseIf(one)), *inner]
    if otherwise is not None:
        out += [line(s.Command("Else")), *otherwise]
    return (*out, line(s.Command("EndIf")))


def _selections(level: int, depth: int) -> Strategy:
    body = bodies(level, 0) if level == 4 else bodies(level, depth - 1)
    number = expressions("M", level, 1)
    relations = st.sampled_from(("=", "<>", "<", "<=", ">", ">="))
    case = st.one_of(
        st.builds(s.CaseRange, number, or_none(number)), st.builds(s.CaseIs, relations, number)
    )
    cases = some(st.tuples(case, body, st.booleans()), 1)
    return st.builds(_select, expressions("M", level), cases, or_none(body))


def _select(subject: Any, cases: Sequence[Any], otherwise: Lines | None) -> Lines:
    out = [line(s.Select(subject))]
    for case, body, left in cases:
        out += [line(s.Case((case,))), *body, *([line(s.Command("Break"))] if left else [])]
    if otherwise is not None:
        out += [line(s.Command("Default")), *otherwise]
    return (*out, line(s.Command("End Select")))


# --------------------------------------------------------------------------------- data


@cache
def data(level: int) -> Strategy:
    """Variable lines: tables of positions, elements, joints, numbers and texts."""
    stems = st.sampled_from(("P", "PA", "P_"))
    table = st.builds(
        lambda stem, first, values: tuple(
            s.Data(s.Variable(f"{stem}{first + k}"), value) for k, value in enumerate(values)
        ),
        stems,
        st.integers(0, 99),
        st.lists(FULL, min_size=1, max_size=4),
    )
    index = some(st.integers(1, 20).map(s.Number), 1)
    element = st.builds(s.Variable, names("P", level), st.just(""), index)
    odd = st.builds(
        s.Constant,
        some(or_none(COORDINATES), 2, 8),
        st.tuples(or_none(st.integers(0, 7)), st.none()),
    )
    lone = st.one_of(
        st.builds(s.Data, variables("P", level) | element, FULL | odd),
        st.builds(s.Data, variables("J", level), JOINTS),
    ).map(lambda one: (one,))
    return st.lists(table | lone, max_size=4).map(lambda parts: tuple(chain(*parts)))


@cache
def position_lists(level: int) -> Strategy:
    """Files that hold declared positions and nothing else."""
    row = st.one_of(
        st.builds(s.Data, variables("P", level), FULL, st.just("Pos")),
        st.builds(s.Data, variables("J", level), JOINTS, st.just("Jnt")),
    )
    return some(row, 1).map(lambda rows: s.File(LEVELS[level].name, rows))


# --------------------------------------------------------------------------------- files


@cache
def files(level: int) -> Strategy:
    """Whole programs, numbered in one of several ways or, where that is read, not at all."""
    main = st.tuples(definitions(level), bodies(level, 2), or_none(command("End")))
    written = st.builds(
        _file,
        st.just(level),
        main,
        data(level),
        st.sampled_from((10, 1, 10, 7) if level == 4 else (1, 10, 3, 0)),
        st.booleans() if level == 6 else st.just(False),
        st.lists(st.integers(0, 30), max_size=2),
    )
    return written


def _file(
    level: int,
    main: tuple[Lines, Lines, s.Statement | None],
    rows: tuple[s.Data, ...],
    step: int,
    functions: bool,
    blanks: list[int],
) -> s.File:
    head, body, end = main
    code = [*map(line, head), *_once_labelled(body)]
    targets = {t.place for t in of_type(code, s.Target) if isinstance(t.place, str)}
    there = {row.label for row in code if row.label is not None}
    code += [line(label=place) for place in sorted(targets - there)]
    if end is not None or not step:
        code.append(line(end or s.Command("End")))
    code = [*_user_functions(code), *code]
    if functions:
        code = [line(s.Function("", "Main")), *code, line(s.Command("FEnd"))]
    code += _functions(code)
    if level == 4:
        code = list(_labels_alone(code))
    numbered = list(_numbered(code, step))
    with_blanks: list[s.Item] = [*numbered]
    for at in blanks:
        with_blanks.insert(at % (len(with_blanks) + 1), s.Blank())
    items = [*with_blanks, *rows]
    return s.File(LEVELS[level].name, tuple(gathered(items) if step else _data_gathered(items)))


def _data_gathered(items: Iterable[s.Item]) -> Iterator[s.Item]:
    """Moves without step numbers stay lines."""
    items = list(items)
    first = next((k for k, item in enumerate(items) if isinstance(item, s.Data)), len(items))
    yield from items[:first]
    yield from gathered(items[first:])


def _once_labelled(code: Lines) -> Iterator[s.Line]:
    """Of two lines with one label the second loses it."""
    seen: set[str] = set()
    for row in code:
        if row.label is not None and row.label.upper() in seen:
            row = replace(row, label=None)
            if row.statement is None and row.comment is None:
                continue
        elif row.label is not None:
            seen.add(row.label.upper())
        yield row


def _labels_alone(code: Iterable[s.Line]) -> Iterator[s.Line]:
    """MELFA-BASIC IV has no statement behind a label."""
    for row in code:
        if row.label is not None and row.statement is not None:
            yield line(label=row.label)
            row = replace(row, label=None)
        yield row


def _user_functions(code: Iterable[s.Line]) -> Iterator[s.Line]:
    called = {v.name for v in of_type(code, s.Variable)}
    for one in USER_FUNCTIONS:
        if one.name in called:
            yield line(one)


def _functions(code: Iterable[s.Line]) -> Iterator[s.Line]:
    """The functions that are called, after the rest of the program."""
    called = {v.name for v in of_type(code, s.Variable)}
    for name, (head, body) in FUNCTIONS.items():
        if name in called:
            yield from map(line, (head, *body, s.Command("FEnd")))


def _numbered(code: Sequence[s.Line], step: int) -> Iterator[s.Line]:
    """With step numbers and jumps to those that are there; step: 0 for none."""
    for at, row in enumerate(code, start=1):

        def placed(node: Any) -> Any:
            if isinstance(node, s.Target) and isinstance(node.place, int):
                if not step:
                    return s.Target("L1")
                return s.Target((node.place % len(code) + 1) * step)
            return node

        yield replace(row, number=at * step or None, statement=rebuilt(row.statement, placed))


def of_type(node: Any, kind: Any) -> Iterator[Any]:
    """Every node of a type, from the outside in."""
    if isinstance(node, kind):
        yield node
    if isinstance(node, tuple | list):
        for part in node:
            yield from of_type(part, kind)
    elif is_dataclass(node):
        for field in fields(node):
            yield from of_type(getattr(node, field.name), kind)


def rebuilt(node: Any, change: Callable[[Any], Any]) -> Any:
    """A node with its parts changed, and then itself."""
    if isinstance(node, tuple):
        return tuple(rebuilt(part, change) for part in node)
    if is_dataclass(node) and not isinstance(node, type):
        inner = {f.name: rebuilt(getattr(node, f.name), change) for f in fields(node) if f.init}
        return change(replace(node, **inner))
    return node
