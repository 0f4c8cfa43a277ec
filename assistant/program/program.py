"""The pseudo-program: what a robot should do, in no vendor's words, and its interface to a cell."""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import field
from typing import Any, Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span, info
from assistant.base.source_text import plain_letters
from assistant.lazy import pictured
from assistant.program.expressions import Effect, Expression
from assistant.program.geometry import Frame, JointTarget, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.statements import (
    Comment,
    Follow,
    For,
    If,
    Label,
    Opaque,
    Spanned,
    Statement,
    Switch,
    While,
)


@dataclass(frozen=True, slots=True)
class Interface:
    """Requirements of an existing cell for a program's names.

    called: the name by which others call it, "" for the name of its entry. main: False if it has no
    routine that runs all of it, and others call its procedures. prefix: precedes every name that it
    declares but that one. local: True if procedures that no other program calls are visible in
    their module only. there: tools and frames by lower-case name that exist on the controller; they
    are named and not written, with their numbers if the controller counts them.
    """

    called: str = ""
    main: bool = True
    prefix: str = ""
    local: bool = False
    there: Mapping[str, int | None] = field(default_factory=dict)


STANDALONE = Interface()
"""Interface of a program without requirements."""


IDENTIFIER: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
MANGLED = info("NM001", "the name {given!r} is written `{name}`")
NAME_TAKEN = info(
    "NM002",
    "the name {given!r} is written `{name}`, as something else has the name `{plain}`, such as a"
    " tool, a frame, a signal or a procedure",
    "give one of the two another name",
)


class TakenNames(set[str]):
    """Names that are taken while many more are chosen: none of these choices looks at all of them.

    Names are added, never taken back.
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        super().__init__()
        self.lower: set[str] = set()
        self.counts: dict[Hashable, int] = {}
        """By the parts of a name, the first number that may be free as a suffix."""
        self._stems: set[str] = set()
        self._unread: list[str] = []
        self.update(names)

    def add(self, name: str) -> None:
        super().add(name)
        self.lower.add(name.lower())
        self._unread.append(name)

    def update(self, *names: Iterable[str]) -> None:
        for some in map(tuple, names):
            super().update(some)
            self.lower.update(map(str.lower, some))
            self._unread += some

    @property
    def stems(self) -> Set[str]:
        """Return the parts before the numbers of names, in lower case: `a_1` and `a` of `A_1_2`."""
        for name in self._unread:
            stem = name.lower()
            while (shorter := _NUMBERED.sub("", stem)) != stem:
                stem = shorter
                self._stems.add(stem)
        self._unread.clear()
        return self._stems


_NUMBERED: Final = re.compile(r"_[0-9]+\Z")


def identifier(given: str, taken: set[str] | frozenset[str] = frozenset()) -> str:
    """Return a name made of letters, digits and `_` that is close to the given one and not taken.

    Letters beyond ASCII become their usual replacements, see `plain_letters`. Names are compared
    without case, as both vendors' languages do.
    """
    name = re.sub(r"[^A-Za-z0-9_]+", "_", plain_letters(given)).strip("_")[:64] or "unnamed"
    if not name[0].isalpha():
        name = "n_" + name
    known = taken if isinstance(taken, TakenNames) else TakenNames(taken)
    free, key = name, name.lower()
    if key in known.lower:
        count = known.counts.get(key, 2)
        while (free := f"{name}_{count}").lower() in known.lower:
            count += 1
        known.counts[key] = count
    return free


def renamed(given: str, name: str, plain: str | None = None, **where: Any) -> Diagnostic:
    """Return the finding about a name that is written otherwise: its letters, or it was taken.

    plain: what it is written as where it is not taken, if that is not its identifier.
    """
    plain = plain or identifier(given)
    if name == plain:
        return MANGLED(**where, given=given[:80], name=name)
    return NAME_TAKEN(**where, given=given[:80], name=name, plain=plain)


@dataclass(frozen=True, slots=True)
class Signal:
    """An input or output.

    number: its first bit on controllers that count signals (MELFA-BASIC), None if unknown.
    bits: width of a group.
    """

    kind: Literal["digital", "analog", "group"]
    direction: Literal["input", "output"]
    number: int | None = None
    bits: int = 1


ValueType = Literal["number", "integer", "truth", "text", "position", "pose", "joints"]


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable or constant.

    initial: None for the type's own default. size: extents of an array, () for none.
    storage: `constant`; `variable`, fresh at each start from the top, kept from one cycle to the
    next; `persistent`, kept over starts.
    local: seen in its own unit only. span: where in a source text it stood.
    """

    type: ValueType
    initial: Expression | None = None
    size: tuple[int, ...] = ()
    storage: Literal["constant", "variable", "persistent"] = "variable"
    local: bool = False
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Parameter:
    """mode: `in` is a copy, `inout` the caller's own variable.

    dimensions: of an array of any extents, 0 for a single value.
    """

    name: str
    type: ValueType
    mode: Literal["in", "inout"] = "in"
    dimensions: int = 0


@dataclass(frozen=True, slots=True)
class Procedure:
    """A procedure. result: its type if it returns a value.

    unit: the program unit (module, program file) that holds it; None for the main one. A program
    longer than the controller's limit is spread over units that are loaded when called. span: its
    position in a source text; not part of its meaning. known: the index of its body from
    `contents`, empty until it is requested.
    """

    name: str
    body: tuple[Statement, ...]
    parameters: tuple[Parameter, ...] = ()
    variables: dict[str, Variable] = field(default_factory=dict)
    result: ValueType | None = None
    unit: str | None = None
    local: bool = False
    span: Span | None = field(default=None, compare=False, repr=False)
    known: list[Any] = field(default_factory=list, init=False, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Declaration(Spanned):
    """A declaration that only one vendor language can express, as its text.

    effect: its effect, None if it was not analysed; not part of its meaning.
    """

    language: str
    text: str
    effect: Effect | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Origin:
    """The trees of a vendor language that a program was lifted from.

    lifted: their program; the present program may have been changed since. robot: the robot that
    they were read for, None without a robot. called: names in lower case of procedures that the
    controller calls.
    """

    language: str
    trees: tuple[Any, ...]
    lifted: Program
    robot: Any = None
    called: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, weakref_slot=True)
class Program:
    """A whole program.

    name: identifier. robot: name in the catalogue it is meant for, None if not stated.
    entry: the procedure that runs first, None for a mere list of targets.
    speeds, blends: named ones that moves refer to by `Name`.
    comments: the lines above the program.
    origin: lets its own language give back what was not changed as it stood; it is not part
    of what the program says. interface: what others of its controller know of it; nor is that.
    placed: of a drawing, whether something says where it stands; None for other programs.
    Names of one kind are unique without regard to case.
    """

    name: str
    procedures: tuple[Procedure, ...] = ()
    entry: str | None = "main"
    robot: str | None = None
    comments: tuple[str, ...] = ()
    frames: dict[str, Frame] = field(default_factory=dict)
    tools: dict[str, Tool] = field(default_factory=dict)
    speeds: dict[str, Speed] = field(default_factory=dict)
    blends: dict[str, Blend] = field(default_factory=dict)
    signals: dict[str, Signal] = field(default_factory=dict)
    targets: dict[str, Target] = field(default_factory=dict)
    joint_targets: dict[str, JointTarget] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)
    declarations: tuple[Declaration, ...] = ()
    origin: Origin | None = field(default=None, compare=False, repr=False)
    interface: Interface | None = field(default=None, compare=False, repr=False)
    placed: bool | None = field(default=None, compare=False, repr=False)
    _by_name: dict[str, Procedure] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )

    def __repr__(self) -> str:
        rows = [len(s.path) for s in self.statements() if isinstance(s, Follow)]
        statements = sum(1 for s in self.statements() if not isinstance(s, Follow)) + sum(rows)
        counts = {"procedure": len(self.procedures), "statement": statements}
        # Points of paths are targets too, although no table of the program holds them.
        counts["target"] = len(self.targets) + len(self.joint_targets) + sum(rows)
        told = ", ".join(f"{count} {what}{'s' * (count != 1)}" for what, count in counts.items())
        return f"<Program {self.name}: {told}>"

    def _repr_html_(self) -> str:
        return pictured(self)

    def procedure(self, name: str) -> Procedure | None:
        """The first procedure of a name, in any case."""
        if not self._by_name:
            self._by_name.update({p.name.lower(): p for p in reversed(self.procedures)})
        return self._by_name.get(name.lower())

    def statements(self) -> Iterator[Statement]:
        """Every statement, nested ones after the one that holds them."""
        for procedure in self.procedures:
            yield from walk(procedure.body)

    def size(self) -> int:
        """Its statements, those of a path counted one by one, and what it declares."""
        said = sum(len(one.path) if isinstance(one, Follow) else 1 for one in self.statements())
        declared = len(self.targets) + len(self.joint_targets) + len(self.variables)
        return said + declared + len(self.declarations)


def walk(body: tuple[Statement, ...]) -> Iterator[Statement]:
    """The statements of a body in order of text, nested ones included."""
    for statement in body:
        yield statement
        for inner in bodies(statement):
            yield from walk(inner)


def last_statement(statements: Sequence[Statement]) -> Statement | None:
    """The last statement that is not a comment, if there is one."""
    return next((one for one in reversed(statements) if not isinstance(one, Comment)), None)


def labels_in_texts(body: tuple[Statement, ...]) -> frozenset[str]:
    """The labels of a body that occur in statements kept in a robot language's own text."""
    texts = [one.text.upper() for one in walk(body) if isinstance(one, Opaque)]
    labels = (one.name for one in walk(body) if isinstance(one, Label))
    return frozenset(name for name in labels if any(name.upper() in text for text in texts))


def bodies(statement: Statement) -> tuple[tuple[Statement, ...], ...]:
    """The bodies that a statement holds, in order of text."""
    match statement:
        case If(branches=branches, otherwise=otherwise):
            return (*(branch.body for branch in branches), otherwise)
        case While(body=body) | For(body=body):
            return (body,)
        case Switch(cases=cases, otherwise=otherwise):
            return (*(case.body for case in cases), otherwise)
    return ()
