"""Typed tree of a MELFA-BASIC file: lines, statements and expressions.

A file is a sequence of items, most of them one line each. The two kinds of lines that appear in
thousands, position lines and moves to numbered positions, are held in columns instead:
`PositionRows` and `MoveRows` (see columnar).
"""

from __future__ import annotations

from assistant.base.data_classes import dataclass
from dataclasses import field
from typing import Literal
from assistant.base.diagnostics import Span
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.base.diagnostics import Diagnostic
from assistant.base.source_text import SourceText


@dataclass(frozen=True, slots=True)
class Number:
    """base: 10, 16 for `&H`, 2 for `&B`. suffix: a type mark, empty for none."""

    value: int | float
    base: Literal[2, 10, 16] = 10
    suffix: str = ""


@dataclass(frozen=True, slots=True)
class String:
    value: str


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable, status variable, array element, component, or function call.

    arguments: None without brackets, () for empty ones. component: `X`, `J1`, … or empty.
    """

    name: str
    suffix: str = ""
    arguments: tuple[Expression | None, ...] | None = None
    component: str = ""
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def key(self) -> str:
        """The name as the controller compares it."""
        return self.name.upper()

    @property
    def marked(self) -> str:
        """The name with the mark of its type."""
        return self.name + self.suffix


@dataclass(frozen=True, slots=True)
class Constant:
    """A position or joint constant; None for what is left out.

    values: mm and degrees. flags: structure and multi-rotation flag, None without the group.
    """

    values: tuple[float | None, ...]
    flags: tuple[int | None, int | None] | None = None
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Unary:
    operator: str
    operand: Expression


@dataclass(frozen=True, slots=True)
class Binary:
    """operator: upper case as printed."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Pallet:
    """A grid point: `(Plt number, point)`."""

    number: Expression
    point: Expression


@dataclass(frozen=True, slots=True)
class Word:
    """A bare `On` among the arguments of a statement."""

    text: str


@dataclass(frozen=True, slots=True)
class Channel:
    """The number of a camera or line among the arguments of a statement: `#1`."""

    number: Expression


@dataclass(frozen=True, slots=True)
class Opening:
    """A line that a statement opens, and the number that it has from then on: `"COM2:" As #1`."""

    name: Expression
    number: Expression


@dataclass(frozen=True, slots=True)
class Target:
    """Destination of a jump, or a label among the arguments: a label's name or a step number."""

    place: str | int
    span: Span | None = field(default=None, compare=False, repr=False)


Expression = (
    Number | String | Variable | Constant | Unary | Binary | Pallet | Word | Channel | Opening
    | Target
)  # fmt: skip


# ---------------------------------------------------------------------------- statements


@dataclass(frozen=True, slots=True)
class Command:
    """A word and its arguments: settings, Dly, Wait, HOpen, End, Return, EndIf and so on."""

    keyword: str
    arguments: tuple[Expression | None, ...] = ()


@dataclass(frozen=True, slots=True)
class Append:
    """`Wth` and `WthIf`: what happens during the move."""

    statement: Statement
    condition: Expression | None = None


@dataclass(frozen=True, slots=True)
class Motion:
    """keyword: `Mov`, `Mvs`, `Mvr` and the rest of their family."""

    keyword: str
    arguments: tuple[Expression | None, ...]
    type: tuple[Expression, Expression] | None = None
    append: Append | None = None


@dataclass(frozen=True, slots=True)
class Assign:
    """delay: seconds of a pulse."""

    target: Variable
    value: Expression
    delay: Expression | None = None


@dataclass(frozen=True, slots=True)
class If:
    """then: None opens a block."""

    condition: Expression
    then: Statement | Target | None
    otherwise: Statement | Target | None = None


@dataclass(frozen=True, slots=True)
class ElseIf:
    condition: Expression


@dataclass(frozen=True, slots=True)
class For:
    variable: Variable
    first: Expression
    last: Expression
    step: Expression | None = None


@dataclass(frozen=True, slots=True)
class Next:
    variables: tuple[Variable, ...] = ()


@dataclass(frozen=True, slots=True)
class Select:
    subject: Expression


@dataclass(frozen=True, slots=True)
class CaseRange:
    first: Expression
    last: Expression | None = None


@dataclass(frozen=True, slots=True)
class CaseIs:
    operator: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Case:
    items: tuple[CaseRange | CaseIs, ...]


@dataclass(frozen=True, slots=True)
class Jump:
    """`GoTo` or `GoSub`."""

    keyword: Literal["GoTo", "GoSub"]
    target: Target


@dataclass(frozen=True, slots=True)
class OnJump:
    subject: Expression
    keyword: Literal["GoTo", "GoSub"]
    targets: tuple[Target | None, ...]


@dataclass(frozen=True, slots=True)
class OnCom:
    line: Expression | None
    target: Target


@dataclass(frozen=True, slots=True)
class CallP:
    program: Expression
    arguments: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Call:
    """A Function of MELFA-BASIC VI, called as a statement."""

    function: Variable


@dataclass(frozen=True, slots=True)
class FPrm:
    variables: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class DefNames:
    """type: `Inte`, `Long`, `Float`, `Double`, `Char`, `Pos`, `Jnt` or `Work`."""

    type: str
    variables: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class DefIo:
    variable: Variable
    type: str
    number: Expression
    mask: Expression | None = None


@dataclass(frozen=True, slots=True)
class DefFunction:
    name: str
    suffix: str
    parameters: tuple[Variable, ...]
    value: Expression


@dataclass(frozen=True, slots=True)
class DefOther:
    """`Def Plt`, `Def Arch` and others that are a list of arguments."""

    kind: str
    arguments: tuple[Expression | None, ...]


@dataclass(frozen=True, slots=True)
class DefAct:
    number: Expression
    condition: Expression
    keyword: Literal["GoTo", "GoSub"]
    target: Target
    stop: str = ""


@dataclass(frozen=True, slots=True)
class Dim:
    variables: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class Const:
    type: str
    variable: Variable
    value: Expression


@dataclass(frozen=True, slots=True)
class Static:
    definition: DefNames | Dim


@dataclass(frozen=True, slots=True)
class Include:
    program: str


@dataclass(frozen=True, slots=True)
class FunctionParameter:
    mode: str
    name: str
    suffix: str = ""
    array: bool = False


@dataclass(frozen=True, slots=True)
class Function:
    result: str
    name: str
    suffix: str = ""
    parameters: tuple[FunctionParameter, ...] | None = None


@dataclass(frozen=True, slots=True)
class Open:
    name: Expression
    mode: str
    number: Expression


@dataclass(frozen=True, slots=True)
class Close:
    numbers: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Print:
    """items: each mark (`,` or `;`) with what follows it."""

    number: Expression
    items: tuple[tuple[str, Expression | None], ...] = ()


@dataclass(frozen=True, slots=True)
class Input:
    number: Expression
    variables: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class Com:
    line: Expression | None
    state: str


Statement = (
    Command | Motion | Assign | If | ElseIf | For | Next | Select | Case | Jump | OnJump | OnCom
    | CallP | Call | FPrm | DefNames | DefIo | DefFunction | DefOther | DefAct | Dim | Const
    | Static | Include | Function | Open | Close | Print | Input | Com
)  # fmt: skip

# --------------------------------------------------------------------------------- lines


@dataclass(frozen=True, slots=True)
class Line:
    """A code line.

    number: step number, None where a source has none. comment: with its mark, None for none.
    """

    number: int | None = None
    label: str | None = None
    statement: Statement | None = None
    comment: str | None = None
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Data:
    """A variable line: a position, joints, a number or a text.

    type: of the `DEF` before it in a position list, empty for none.
    """

    variable: Variable
    value: Constant | Number | Unary | String
    type: str = ""
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Unread:
    """A line that is not MELFA-BASIC, as its text without the line end."""

    text: str
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Blank:
    """An empty line."""

    span: Span | None = field(default=None, compare=False, repr=False)


Entry = Line | MoveRows
"""An item of a program's code."""
Item = Line | Data | PositionRows | MoveRows | Unread | Blank


@dataclass(frozen=True, slots=True)
class File:
    """A MELFA-BASIC program or position list.

    dialect: name of the language it is read or written as.
    source, parsed: the text and the items that came from it, which print as they stood there.
    """

    dialect: str
    items: tuple[Item, ...]
    findings: tuple[Diagnostic, ...] = field(default=(), compare=False)
    source: SourceText | None = field(default=None, compare=False, repr=False)
    parsed: tuple[Item, ...] = field(default=(), compare=False, repr=False)

    @property
    def code(self) -> list[Entry]:
        """The lines and moves of the program, without the variables of the file."""
        return [item for item in self.items if isinstance(item, Entry)]
