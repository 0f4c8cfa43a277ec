"""Random trees of RAPID: whatever a text can be read as, every kind of node and field.

Trees are shallow and drawn in few choices, so that thousands are made in a minute and a
failing one is small.
"""

from __future__ import annotations

import string
from collections.abc import Iterable
from itertools import chain, pairwise
from typing import Any, Final, TypeVar

from hypothesis import strategies as st

from assistant.languages.rapid.tables.constants import LONGEST_NAME, RESERVED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import gathered

DEPTH: Final = 2
"""Blocks, and operators of an expression, inside each other."""

T = TypeVar("T")

# Words

LETTERS: Final = string.ascii_letters + "ÀÖØöøÿÑß"
ODD_NAMES: Final = (
    *("IFx", "ENDIFx", "to_1", "NOTa", "xor1", "DIVx", "forward", "switch", "num", "robtarget"),
    *("e1", "E9", "x0F", "p_10", "p007", "MoveL", "Größe", "Ñ", "öre", "orä", "v100", "tool0"),
    *("A" * LONGEST_NAME, "z_" * (LONGEST_NAME // 2), "<ID>"),
)
USUAL_NAMES: Final = (*string.ascii_lowercase[:8], "reg1", "nCount", "bDone", "stMsg", "wobj0")


def names() -> st.SearchStrategy[str]:
    """Identifiers of up to 32 characters."""
    made = st.builds(
        str.__add__,
        st.sampled_from(LETTERS),
        st.text(LETTERS + string.digits + "_", max_size=LONGEST_NAME - 1),
    ).filter(lambda name: name.lower() not in RESERVED)
    return st.one_of(st.sampled_from(USUAL_NAMES), st.sampled_from(ODD_NAMES), made)


NAMES: Final = names()
NUMBERS: Final = st.one_of(
    st.integers(0, 10**9).map(str),
    st.floats(0, 1e12, allow_nan=False).map(repr),
    st.sampled_from(
        (
            "0",
            "5.",
            ".5",
            "9E9",
            "9E+09",
            "1.2e-05",
            "5.E3",
            "0x1F",
            "0XfF",
            "0o17",
            "0b101",
            "0d12",
        )
    ),
)
UNSEEN: Final = ("Cf", "Zl", "Zp")
"""What ends lines and paragraphs, or hides what stands beside it: a finding in a text, and beyond
what `\\xx` says in a string."""
STRINGS: Final = st.one_of(
    st.sampled_from(("", 'say "x"', "C:\\x", "\r\n", "\x00\t", "! no comment", "%%%", "1;", "é")),
    st.text(st.characters(max_codepoint=0xFF), max_size=12),
    st.text(st.characters(exclude_categories=["Cs", *UNSEEN]), max_size=4),
)
COMMENTS: Final = st.one_of(
    st.sampled_from(("", "!", "note", "a:=1;", 'it"s', "tab\tinside", "ENDPROC", "%%%", "Größe")),
    st.text(st.characters(exclude_categories=["Cs", "Cc", *UNSEEN]), max_size=12),
).map(str.strip)
HEADERS: Final = st.one_of(
    st.sampled_from(
        ("", " VERSION:1 LANGUAGE:ENGLISH ", "\n  VERSION:1\n  LANGUAGE:ENGLISH\n", "%a", "! x")
    ),
    st.text(st.sampled_from('%AZ:19 \n!";'), max_size=8),
).filter(lambda text: "%%%" not in text and not text.endswith("%"))


def some(items: st.SearchStrategy[T], least: int = 0, most: int = 3) -> st.SearchStrategy[Any]:
    return st.lists(items, min_size=least, max_size=most).map(tuple)


def or_none(strategy: st.SearchStrategy[T]) -> st.SearchStrategy[T | None]:
    return st.none() | strategy


# Expressions, one level of priority after the other

OPERATORS: Final = {
    "sum": ("+", "-"),
    "term": ("*", "/", "DIV", "MOD"),
    "relation": ("<", "<=", "=", ">", ">=", "<>"),
    "conjunction": ("AND",),
    "disjunction": ("OR", "XOR"),
}

EXP: Final = s.Placeholder("<EXP>")
ARG: Final = s.Placeholder("<ARG>")
VAR: Final = s.Placeholder("<VAR>")

LITERALS: Final = st.one_of(
    NUMBERS.map(s.NumberLiteral), STRINGS.map(s.StringLiteral), st.booleans().map(s.BoolLiteral)
)
REFERENCES: Final = NAMES.map(s.NameRef)
LEAVES: Final = st.one_of(REFERENCES, LITERALS)


def expressions(depth: int = DEPTH) -> st.SearchStrategy[s.Expression]:
    """Whatever may stand where a value is wanted."""
    return _EXPRESSIONS[depth]


def references(depth: int = DEPTH) -> st.SearchStrategy[Any]:
    """Names with components and elements; what may be assigned to."""
    return _REFERENCES[depth]


def arguments(depth: int = DEPTH) -> st.SearchStrategy[tuple[s.Argument, ...]]:
    """Arguments of a call."""
    return _ARGUMENTS[depth]


def _infix(
    left: st.SearchStrategy[Any], level: str, right: st.SearchStrategy[Any]
) -> st.SearchStrategy[Any]:
    return st.builds(s.Infix, operator=st.sampled_from(OPERATORS[level]), left=left, right=right)


def _deeper_references(inner: st.SearchStrategy[Any], depth: int) -> st.SearchStrategy[Any]:
    index = st.one_of(_EXPRESSIONS[depth - 1], st.just(s.Whole()))
    return st.one_of(
        REFERENCES,
        st.builds(s.Component, value=inner, name=NAMES),
        st.builds(s.Element, value=inner, indices=some(index, 1)),
    )


def _deeper_arguments(depth: int) -> st.SearchStrategy[Any]:
    value = _EXPRESSIONS[depth - 1] if depth else LEAVES
    variable = _REFERENCES[max(depth - 1, 0)]
    one = st.one_of(
        st.builds(s.Positional, value=value),
        st.builds(s.Positional, value=value, name=or_none(NAMES)),
        st.builds(s.Option, name=NAMES, value=or_none(value)),
        st.builds(s.Conditional, name=NAMES, variable=variable | st.just(VAR)),
        st.just(s.Positional(ARG)),
    )
    return some(one)


def _deeper_expressions(depth: int) -> st.SearchStrategy[Any]:
    whole = _EXPRESSIONS[depth - 1]
    primary: st.SearchStrategy[Any] = st.one_of(
        LEAVES,
        _REFERENCES[depth],
        st.builds(s.AggregateNode, some(whole, 1)),
        st.builds(s.Group, whole),
        st.builds(s.FunctionCall, name=NAMES, arguments=_ARGUMENTS[depth]),
    )
    term = st.one_of(primary, _infix(primary, "term", primary))
    term = st.one_of(term, _infix(term, "term", primary))
    signed = st.builds(s.Prefix, operator=st.sampled_from("+-"), operand=term)
    first = st.one_of(term, signed)
    sum_ = st.one_of(first, _infix(first, "sum", term))
    relation = st.one_of(sum_, _infix(sum_, "relation", sum_))
    conjunction = st.one_of(relation, _infix(relation, "conjunction", relation))
    conjunction = st.one_of(conjunction, _infix(conjunction, "conjunction", relation))
    negation = st.builds(s.Prefix, operator=st.just("NOT"), operand=conjunction)
    negatable = st.one_of(conjunction, negation)
    disjunction = st.one_of(negatable, _infix(negatable, "disjunction", conjunction))
    return st.one_of(LEAVES, primary, disjunction, st.just(EXP))


_EXPRESSIONS: Final[list[st.SearchStrategy[Any]]] = [LEAVES]
_REFERENCES: Final[list[st.SearchStrategy[Any]]] = [REFERENCES]
_ARGUMENTS: Final[list[st.SearchStrategy[Any]]] = [_deeper_arguments(0)]
for _depth in range(1, DEPTH + 1):
    _REFERENCES.append(_deeper_references(_REFERENCES[-1], _depth))
    _ARGUMENTS.append(_deeper_arguments(_depth))
    _EXPRESSIONS.append(_deeper_expressions(_depth))

VALUES: Final = _EXPRESSIONS[DEPTH]
SHORT: Final = _EXPRESSIONS[1]
TARGETS: Final = _REFERENCES[DEPTH] | st.just(VAR)

# Long runs, which are read as columns

PLAIN_NAMES: Final = st.one_of(
    st.builds("{}{}".format, st.sampled_from(("p", "seam_", "q1_")), st.integers(0, 99)),
    st.sampled_from(("home", "p007", "p_", "x" * LONGEST_NAME)),
)
COORDINATES: Final = st.one_of(
    st.sampled_from(("0", "1", "9E9", "9E+09", "0.7071068", "1.5", ".25", "7.", "1e-05")),
    st.integers(0, 9999).map(str),
    st.floats(0, 1e5, allow_nan=False).map(repr),
)


def _signed(text: str, sign: str) -> s.Expression:
    value = s.NumberLiteral(text)
    return s.Prefix(sign, value) if sign else value  # type: ignore[arg-type]


def _pose(values: list[tuple[str, str]]) -> s.AggregateNode:
    signed = [_signed(*value) for value in values]
    cuts = (0, 3, 7, 11, 17)
    parts = [tuple(signed[a:b]) for a, b in pairwise(cuts)]
    return s.AggregateNode(tuple(map(s.AggregateNode, parts)))


def poses() -> st.SearchStrategy[s.AggregateNode]:
    """Robtargets that are written out; their numbers come from one short list."""
    few = st.lists(st.tuples(COORDINATES, SIGNS), min_size=1, max_size=4)
    return few.map(lambda some: _pose([some[(k * k) % len(some)] for k in range(17)]))


SIGNS: Final = st.sampled_from(("", "-", "", "+"))
POSES: Final = poses()
ROWS: Final = st.sampled_from((1, 2, 3, 7, 8, 9, 12))
"""Fewer than make a run and more."""


def _repeated(rows: list[T], count: int) -> list[T]:
    return (rows * count)[:count]


TARGET_ROWS: Final = st.builds(
    lambda scope, rows, count: [
        s.Data(scope, "CONST", "robtarget", name, (), value)
        for name, value in _repeated(rows, count)
    ],
    st.sampled_from(("", "LOCAL", "", "TASK")),
    st.lists(st.tuples(PLAIN_NAMES, POSES), min_size=1, max_size=2),
    ROWS,
)


def _move(kind: str, points: tuple[Any, Any], words: tuple[str, ...], frame: bool) -> Any:
    through = points if kind == "MoveC" else points[:1]
    given: list[s.Argument] = [s.Positional(p) for p in through]
    given += [s.Positional(s.NameRef(word)) for word in words]
    if frame:
        given.append(s.Option("WObj", s.NameRef("wobj1")))
    return s.ProcedureCall(kind, tuple(given))


def _moves(point: st.SearchStrategy[Any]) -> st.SearchStrategy[list[Any]]:
    kinds = st.sampled_from(("MoveL", "MoveJ", "MoveL", "MoveC", "movel", "MoveAbsJ"))
    words = st.sampled_from((("v100", "fine", "tool0"), ("v5", "z1", "Greifer")))
    one = st.builds(_move, kinds, st.tuples(point, point), words, st.booleans())
    return st.builds(_repeated, st.lists(one, min_size=1, max_size=2), ROWS)


MOVE_ROWS: Final = st.one_of(_moves(PLAIN_NAMES.map(s.NameRef)), _moves(POSES))

# Statements

SIMPLE: Final = st.one_of(
    st.builds(s.Assignment, target=TARGETS, value=VALUES),
    st.builds(s.ProcedureCall, name=NAMES, arguments=_ARGUMENTS[DEPTH]),
    st.builds(s.ProcedureCall, name=NAMES, arguments=_ARGUMENTS[1]),
    st.builds(s.ProcedureCall, name=SHORT, arguments=_ARGUMENTS[1]),
    st.builds(s.GotoLabel, label=NAMES),
    st.builds(s.ReturnFrom, value=or_none(VALUES)),
    st.builds(s.RaiseError, value=or_none(VALUES)),
    st.sampled_from(("EXIT", "RETRY", "TRYNEXT")).map(s.Word),
    st.builds(s.Connect, interrupt=_REFERENCES[1] | st.just(VAR), trap=NAMES),
)
SMT: Final = s.Placeholder("<SMT>")
DDN: Final = s.Placeholder("<DDN>")

DATA: Final = st.builds(
    s.Data,
    scope=st.sampled_from(("", "LOCAL", "TASK")),
    storage=st.sampled_from(("VAR", "PERS", "CONST")),
    type=NAMES,
    name=NAMES,
    dimensions=some(SHORT),
    value=or_none(VALUES),
)


def statements(depth: int = DEPTH) -> st.SearchStrategy[s.StatementNode]:
    """Any one statement, comments, runs and declarations aside."""
    return _STATEMENTS[depth]


def blocks(depth: int = DEPTH) -> st.SearchStrategy[tuple[Any, ...]]:
    """Statements and declarations with comments between and behind them."""
    return _BLOCKS[depth]


def _compound(block: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    otherwise = or_none(block)
    branch = st.builds(s.IfBranch, condition=SHORT, body=block)
    case = st.builds(s.TestCase, values=some(SHORT, 1), body=block)
    return st.one_of(
        st.builds(
            lambda first, rest, otherwise: s.IfThen((first, *rest), otherwise),
            branch,
            some(st.one_of(branch, st.just(s.IfBranch(None, ()))), most=2),
            otherwise,
        ),
        st.builds(
            s.ForLoop, variable=NAMES, first=SHORT, last=SHORT, step=or_none(SHORT), body=block
        ),
        st.builds(s.WhileLoop, condition=VALUES, body=block),
        st.builds(
            s.TestOf,
            subject=VALUES,
            cases=some(st.one_of(case, st.just(s.TestCase((), ()))), most=2),
            otherwise=otherwise,
        ),
    )


def _noted(parts: Iterable[Iterable[Any]], follows: bool) -> tuple[Any, ...]:
    """A block that can be read: a comment trails only what is none.

    follows: something stands in front of the first node on its line.
    """
    out: list[Any] = []
    for node in chain.from_iterable(parts):
        if isinstance(node, s.CommentLine) and node.trailing:
            behind = not isinstance(out[-1], s.CommentLine) if out else follows
            out.append(s.CommentLine(node.text, behind))
        else:
            out.append(node)
    return gathered(out)


COMMENT: Final = st.builds(s.CommentLine, text=COMMENTS, trailing=st.booleans())


def _block(statement: st.SearchStrategy[Any], most: int) -> st.SearchStrategy[tuple[Any, ...]]:
    one = st.one_of(
        statement.map(lambda node: [node]),
        statement.map(lambda node: [node]),
        COMMENT.map(lambda node: [node]),
        st.one_of(DATA, st.sampled_from((SMT, DDN))).map(lambda node: [node]),
        st.one_of(MOVE_ROWS, TARGET_ROWS),
    )
    return st.lists(one, max_size=most).map(lambda parts: _noted(parts, True))


LABELS: Final = NAMES.map(s.LabelMark)
COMPACT: Final = st.builds(s.CompactIf, condition=VALUES, statement=SIMPLE | st.just(SMT))
_STATEMENTS: Final[list[st.SearchStrategy[Any]]] = [st.one_of(SIMPLE, LABELS)]
_BLOCKS: Final[list[st.SearchStrategy[Any]]] = [_block(_STATEMENTS[0], 2)]
for _depth in range(1, DEPTH + 1):
    _STATEMENTS.append(st.one_of(SIMPLE, LABELS, COMPACT, _compound(_BLOCKS[-1])))
    _BLOCKS.append(_block(_STATEMENTS[-1], 2 * _depth))

# Routines, modules, files

DIMENSIONS: Final = st.sampled_from((0, 0, 0, 1, 2, 3, -1))
PARAMETER: Final = st.builds(
    s.ParameterNode,
    mode=st.sampled_from(("", "VAR", "PERS", "INOUT")),
    type=NAMES,
    name=NAMES,
    dimensions=DIMENSIONS,
)
GROUP: Final = st.one_of(
    st.one_of(PARAMETER, st.just(s.Placeholder("<PAR>"))).map(
        lambda one: s.ParameterGroup(False, (one,))
    ),
    some(st.one_of(PARAMETER, st.just(s.Placeholder("<ALT>"))), 1).map(
        lambda several: s.ParameterGroup(True, several)
    ),
)
HANDLER: Final = st.one_of(
    st.builds(s.Handler, kind=st.sampled_from(("BACKWARD", "ERROR", "UNDO")), body=_BLOCKS[1]),
    st.builds(s.Handler, kind=st.just("ERROR"), body=_BLOCKS[1], numbers=some(SHORT)),
)


def routines() -> st.SearchStrategy[s.Routine]:
    shared = {
        "local": st.booleans(),
        "name": NAMES,
        "body": _BLOCKS[DEPTH],
        "handlers": some(HANDLER, most=2),
    }
    parameters = some(GROUP)
    return st.one_of(
        st.builds(s.Routine, kind=st.just("PROC"), parameters=parameters, **shared),
        st.builds(s.Routine, kind=st.just("FUNC"), type=NAMES, parameters=parameters, **shared),
        st.builds(s.Routine, kind=st.just("TRAP"), **shared),
    )


def items() -> st.SearchStrategy[tuple[s.Item, ...]]:
    """What stands in a module."""
    single = st.one_of(
        routines(),
        DATA,
        st.builds(
            s.Record, local=st.booleans(), name=NAMES, components=some(st.tuples(NAMES, NAMES), 1)
        ),
        st.builds(s.Alias, local=st.booleans(), type=NAMES, name=NAMES),
        st.sampled_from([s.Placeholder(text) for text in ("<TDN>", "<DDN>", "<RDN>")]),
        COMMENT,
    )
    one = st.one_of(single.map(lambda node: [node]), TARGET_ROWS)
    return st.lists(one, max_size=5).map(lambda parts: _noted(parts, True))


ATTRIBUTES: Final = st.sampled_from(("SYSMODULE", "NOVIEW", "NOSTEPIN", "VIEWONLY", "READONLY"))


def modules() -> st.SearchStrategy[s.Module]:
    return st.builds(s.Module, name=NAMES, attributes=some(ATTRIBUTES), items=items())


def files() -> st.SearchStrategy[s.File]:
    """Whole files: a module with comments around it, seldom several, seldom a header."""
    module = modules()
    return st.builds(
        lambda header, *parts: s.File(_noted(parts, header is not None), header),
        or_none(HEADERS),
        st.lists(COMMENT, max_size=1),
        st.tuples(module),
        st.lists(st.one_of(COMMENT, COMMENT, module), max_size=2),
    )
