"""The typed tree of a MELFA-BASIC file: lines, statements and expressions.

A file is a row of items, most of them one line each. The two things that come in
thousands, position lines and moves to numbered positions, stand in columns instead:
`PositionRows` and `MoveRows` (see columnar).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.expressions import (
    Binary as Binary,
    Channel as Channel,
    Constant as Constant,
    Expression as Expression,
    Number as Number,
    Opening as Opening,
    Pallet as Pallet,
    String as String,
    Target as Target,
    Unary as Unary,
    Variable as Variable,
    Word as Word,
)
from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText

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
"""What the code of a program is made of."""
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
