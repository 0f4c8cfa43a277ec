"""The typed tree of RAPID: one small frozen record a construct, columns for long runs.

A node's span is where it is in the text; it does not count when trees are compared.
Declared robtargets and plain moves that follow each other in the text are held in columns: a
`TargetRun` or a `MoveRun`, which this module also writes as text. A robtarget has 17 numbers:
position in mm, quaternion, confdata, external axes (9E9 for an unused one).
"""

from __future__ import annotations

from collections.abc import Sequence
from assistant.base.data_classes import dataclass
from typing import Final
from typing import NamedTuple
from numpy.typing import NDArray
from assistant.base.arrays import Floats
from assistant.base.columns import Chosen
from assistant.base.columns import Piece
from assistant.base.columns import rows_text
from assistant.languages.rapid.tables.constants import UNUSED
from assistant.languages.runs.columns import Entries
from assistant.languages.runs.columns import Names
from assistant.languages.runs.columns import Run
from assistant.languages.runs.row_text import FewestDecimals
from assistant.languages.runs.row_text import Groups
import numpy as np
from dataclasses import field
from typing import Literal
from assistant.base.arrays import Rows
from assistant.base.diagnostics import Diagnostic
from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText


FEWEST_IN_RUN: Final = 8
"""Rows that make a run; fewer are cheap as ordinary nodes."""

POSITION_PLACES: Final = 4
QUATERNION_PLACES: Final = 9
JOINT_PLACES: Final = 6
"""Decimals of joints and external axes, degrees or mm."""
SIZES_PLACES: Final = 6
"""Decimals of masses, inertias, speeds and zone sizes."""
TARGET_DECIMALS: Final = FewestDecimals((0, POSITION_PLACES, QUATERNION_PLACES), {UNUSED: b"9E9"})
TARGET_PARTS: Final = ((0, 3), (3, 7), (7, 11), (11, 17))
"""Columns of position, quaternion, confdata and external axes."""
TARGET_GROUPS: Final = Groups(
    tuple(stop - start for start, stop in TARGET_PARTS),
    *(b"[[", b"],[", b"]]"),
    known=tuple((text, UNUSED) for text in (b"9E9", b"9E+09", b"9E+9")),
)
"""A robtarget that is written out."""
PLAIN_MOVES: Final = ("MoveJ", "MoveL", "MoveC")
JOINT, LINEAR, CIRCULAR = range(3)


@dataclass(frozen=True, slots=True, eq=False)
class TargetRun(Run):
    """n declared robtargets.

    values: (n, 17) position mm, quaternion, confdata, external axes with 9E9 for unused ones.
    """

    names: Names
    values: Floats

    @classmethod
    def of(cls, rows: Sequence[tuple[str, list[float]]]) -> TargetRun:
        """rows: the name and the 17 numbers of each."""
        names, values = zip(*rows, strict=True)
        return cls(Names.of(names), np.array(values, dtype=np.float64))


@dataclass(frozen=True, slots=True)
class MotionNames:
    """Names after the target of a plain move; frame empty without WObj."""

    speed: str
    zone: str
    tool: str
    frame: str = ""


class MoveRow(NamedTuple):
    """A plain move: a row of PLAIN_MOVES, and the name or the 17 numbers of its target.

    via: empty for a move that is not circular.
    """

    kind: int
    target: str | list[float]
    via: str
    motion: MotionNames

    @property
    def is_written(self) -> bool:
        return not isinstance(self.target, str)


@dataclass(frozen=True, slots=True, eq=False)
class MoveRun(Run):
    """n plain moves, either all to targets with a name or all to targets that are written out.

    kinds: (n,) uint8, rows of PLAIN_MOVES. names: the n targets; none if they are written out.
    vias: none of moves that are not circular. values: (n, 17) as of a TargetRun, of targets
    without a name.
    """

    kinds: NDArray[np.uint8]
    names: Names
    vias: Names
    motions: Entries[MotionNames]
    values: Floats | None = None

    @classmethod
    def of(cls, rows: Sequence[MoveRow]) -> MoveRun:
        none = Names.none(len(rows))
        return cls(
            np.array([row.kind for row in rows], dtype=np.uint8),
            none if rows[0].is_written else Names.of([str(row.target) for row in rows]),
            Names.of([row.via for row in rows]) if any(row.via for row in rows) else none,
            Entries.of(row.motion for row in rows),
            np.array([row.target for row in rows]) if rows[0].is_written else None,
        )


# Writing


def targets_text(run: TargetRun, scope: str, indent: str, newline: str) -> str:
    """The declarations of a run; every value comes back as the very same double."""
    head = f"{indent}{scope + ' ' if scope else ''}CONST robtarget "
    pieces: list[Piece] = [
        head.encode("ascii"),
        *run.names.pieces(),
        b":=",
        *_target_pieces(run.values),
    ]
    pieces.append(b";" + newline.encode("ascii"))
    return rows_text(pieces, len(run)).decode("ascii")


def _target_pieces(values: Floats) -> list[Piece]:
    return TARGET_GROUPS.pieces([TARGET_DECIMALS.pieces(column) for column in values.T])


def moves_text(run: MoveRun, indent: str, newline: str) -> str:
    circular = run.kinds == CIRCULAR
    kinds = tuple(f"{indent}{kind} ".encode("ascii") for kind in PLAIN_MOVES)
    tails = tuple(
        # `chr(92)` is the backslash, which an f-string expression cannot hold before Python 3.12.
        f",{m.speed},{m.zone},{m.tool}{chr(92) + 'WObj:=' + m.frame if m.frame else ''};{newline}"
        for m in run.motions.table
    )
    pieces: list[Piece] = [Chosen(run.kinds, kinds)]
    if circular.any():
        # Only arcs have a via point, and a comma after it.
        pieces += [*run.vias.pieces(), Chosen(circular.astype(np.int64), (b"", b","))]
    pieces += run.names.pieces() if run.values is None else _target_pieces(run.values)
    pieces += [Chosen(run.motions.index, tuple(t.encode("ascii") for t in tails))]
    return rows_text(pieces, len(run)).decode("ascii")


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    # Without the place of a node, a built tree equals the one that its text is read as.
    span: Span | None = field(default=None, compare=False, repr=False)


# Expressions


@dataclass(frozen=True, slots=True)
class NumberLiteral(Node):
    """text: as written, `9E9` or `0x1F`; without a sign, which is an operator."""

    text: str


@dataclass(frozen=True, slots=True)
class StringLiteral(Node):
    """value: the text of the literal, escapes undone."""

    value: str


@dataclass(frozen=True, slots=True)
class BoolLiteral(Node):
    value: bool


@dataclass(frozen=True, slots=True)
class NameRef(Node):
    name: str


@dataclass(frozen=True, slots=True)
class Component(Node):
    value: Variable
    name: str


@dataclass(frozen=True, slots=True)
class Whole(Node):
    """The `*` that stands for every index."""


@dataclass(frozen=True, slots=True)
class Element(Node):
    value: Variable
    indices: tuple[Expression | Whole, ...]


@dataclass(frozen=True, slots=True)
class AggregateNode(Node):
    items: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Group(Node):
    """An expression in parentheses."""

    inner: Expression


@dataclass(frozen=True, slots=True)
class FunctionCall(Node):
    name: str
    arguments: tuple[Argument, ...] = ()


@dataclass(frozen=True, slots=True)
class Prefix(Node):
    operator: Literal["+", "-", "NOT"]
    operand: Expression


@dataclass(frozen=True, slots=True)
class Infix(Node):
    """operator: upper case; `OR XOR AND < <= = > >= <> + - * / DIV MOD`."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Placeholder(Node):
    """A hole that the pendant left, `<SMT>`; also where a statement or an item may stand."""

    text: str


Variable = NameRef | Component | Element | Placeholder
Expression = (
    NumberLiteral
    | StringLiteral
    | BoolLiteral
    | NameRef
    | Component
    | Element
    | AggregateNode
    | Group
    | FunctionCall
    | Prefix
    | Infix
    | Placeholder
)


@dataclass(frozen=True, slots=True)
class Positional(Node):
    """name: of the parameter, if it is written out."""

    value: Expression
    name: str | None = None


@dataclass(frozen=True, slots=True)
class Option(Node):
    r"""`\name:=value`, or the mere switch `\name`."""

    name: str
    value: Expression | None = None


@dataclass(frozen=True, slots=True)
class Conditional(Node):
    r"""`\name?variable`: hands an optional parameter on if it is there."""

    name: str
    variable: Variable


Argument = Positional | Option | Conditional


# Statements


@dataclass(frozen=True, slots=True)
class CommentLine(Node):
    """text: after the `!`, without outer blanks. trailing: follows something else on its line."""

    text: str
    trailing: bool = False


@dataclass(frozen=True, slots=True)
class Assignment(Node):
    target: Variable
    value: Expression


@dataclass(frozen=True, slots=True)
class ProcedureCall(Node):
    """name: of an instruction or procedure; an expression for late binding, `%"name"%`."""

    name: str | Expression
    arguments: tuple[Argument, ...] = ()


@dataclass(frozen=True, slots=True)
class GotoLabel(Node):
    label: str


@dataclass(frozen=True, slots=True)
class LabelMark(Node):
    name: str


@dataclass(frozen=True, slots=True)
class ReturnFrom(Node):
    value: Expression | None = None


@dataclass(frozen=True, slots=True)
class RaiseError(Node):
    value: Expression | None = None


@dataclass(frozen=True, slots=True)
class Word(Node):
    """A statement of one word."""

    word: Literal["EXIT", "RETRY", "TRYNEXT"]


@dataclass(frozen=True, slots=True)
class Connect(Node):
    interrupt: Variable
    trap: str


@dataclass(frozen=True, slots=True)
class IfBranch(Node):
    """condition: None where the pendant left a whole branch to be filled in."""

    condition: Expression | None
    body: tuple[StatementNode, ...]


@dataclass(frozen=True, slots=True)
class IfThen(Node):
    """otherwise: None without ELSE."""

    branches: tuple[IfBranch, ...]
    otherwise: tuple[StatementNode, ...] | None = None


@dataclass(frozen=True, slots=True)
class CompactIf(Node):
    condition: Expression
    statement: StatementNode


@dataclass(frozen=True, slots=True)
class ForLoop(Node):
    variable: str
    first: Expression
    last: Expression
    step: Expression | None
    body: tuple[StatementNode, ...]


@dataclass(frozen=True, slots=True)
class WhileLoop(Node):
    condition: Expression
    body: tuple[StatementNode, ...]


@dataclass(frozen=True, slots=True)
class TestCase(Node):
    """values: empty where the pendant left a whole case to be filled in."""

    __test__ = False  # not for pytest

    values: tuple[Expression, ...]
    body: tuple[StatementNode, ...]


@dataclass(frozen=True, slots=True)
class TestOf(Node):
    """otherwise: None without DEFAULT."""

    __test__ = False

    subject: Expression
    cases: tuple[TestCase, ...]
    otherwise: tuple[StatementNode, ...] | None = None


# Declarations


@dataclass(frozen=True, slots=True)
class Data(Node):
    """scope: `LOCAL`, `TASK` or empty. storage: `VAR`, `PERS` or `CONST`."""

    scope: str
    storage: str
    type: str
    name: str
    dimensions: tuple[Expression, ...] = ()
    value: Expression | None = None


@dataclass(frozen=True, slots=True)
class RunNode(Node):
    """Many lines that are alike.

    rows: (n, 2) where each begins and ends, counted from the begin of the node; None in a tree
    that was built.
    """

    rows: Rows | None = field(default=None, compare=False, repr=False, kw_only=True)

    @property
    def lines(self) -> Rows | None:
        """(n, 2) where each line is in the text; None in a tree that was built."""
        return None if self.span is None or self.rows is None else self.rows + self.span.start

    def row_span(self, row: int) -> Span | None:
        """The source location of one row: that of the node which its line alone is read as."""
        if self.span is None or self.rows is None:
            return self.span
        start, end = self.rows[row].tolist()
        return Span(self.span.start + start, self.span.start + end)


@dataclass(frozen=True, slots=True)
class TargetRunNode(RunNode):
    """Many `CONST robtarget` declarations in a row. scope: `LOCAL` or empty."""

    scope: str
    run: TargetRun


@dataclass(frozen=True, slots=True)
class MoveRunNode(RunNode):
    """Many plain moves to declared targets in a row."""

    run: MoveRun


@dataclass(frozen=True, slots=True)
class Record(Node):
    """components: (type, name) each."""

    local: bool
    name: str
    components: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Alias(Node):
    local: bool
    type: str
    name: str


@dataclass(frozen=True, slots=True)
class ParameterNode(Node):
    """mode: `VAR`, `PERS`, `INOUT` or empty. dimensions: 0 for a single value, -1 for `<DIM>`."""

    mode: str
    type: str
    name: str
    dimensions: int = 0


@dataclass(frozen=True, slots=True)
class ParameterGroup(Node):
    """One required parameter, or optional ones that exclude each other."""

    optional: bool
    alternatives: tuple[ParameterNode | Placeholder, ...]


@dataclass(frozen=True, slots=True)
class Handler(Node):
    """kind: `BACKWARD`, `ERROR` or `UNDO`. numbers: the errors that an ERROR handler is for."""

    kind: str
    body: tuple[StatementNode, ...]
    numbers: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Routine(Node):
    """kind: `PROC`, `FUNC` or `TRAP`. type: what a FUNC gives back.

    known: the nodes inside it, empty until somebody went through them.
    """

    kind: str
    local: bool
    name: str
    body: tuple[StatementNode, ...]
    type: str = ""
    parameters: tuple[ParameterGroup, ...] = ()
    handlers: tuple[Handler, ...] = ()
    known: list[Node] = field(default_factory=list, init=False, compare=False, repr=False)


StatementNode = (
    Assignment | ProcedureCall | GotoLabel | LabelMark | ReturnFrom | RaiseError | Word | Connect
    | IfThen | CompactIf | ForLoop | WhileLoop | TestOf | CommentLine | Placeholder | MoveRunNode
    | Data | TargetRunNode
)  # fmt: skip
"""Statements and declarations in the body of a routine."""

Item = Record | Alias | Data | TargetRunNode | Routine | CommentLine | Placeholder


@dataclass(frozen=True, slots=True)
class Module(Node):
    """attributes: upper case, in the order written."""

    name: str
    attributes: tuple[str, ...]
    items: tuple[Item, ...]


@dataclass(frozen=True, slots=True)
class Origin:
    """Source text of a tree, with the parts read from it: other parts are new."""

    source: SourceText
    parts: tuple[Module | CommentLine, ...]


@dataclass(frozen=True, slots=True)
class File:
    """A file of RAPID: a module, seldom several.

    header: what stands between `%%%` and `%%%`, None without.
    """

    parts: tuple[Module | CommentLine, ...]
    header: str | None = None
    origin: Origin | None = field(default=None, compare=False, repr=False)
    findings: tuple[Diagnostic, ...] = field(default=(), compare=False)

    @property
    def modules(self) -> tuple[Module, ...]:
        return tuple(part for part in self.parts if isinstance(part, Module))

    @property
    def source(self) -> SourceText | None:
        return self.origin.source if self.origin else None

    @property
    def path(self) -> str | None:
        return self.origin.source.path if self.origin else None
