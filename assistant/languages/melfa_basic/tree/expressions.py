"""The part of the tree of MELFA-BASIC that has values: expressions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from assistant.base.diagnostics import Span


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
