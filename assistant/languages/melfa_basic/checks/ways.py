"""The ways through a part of a program: which line can follow which."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final

from assistant.languages.melfa_basic.checks.file_view import Look, Scope
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import closed, divided, opened
from assistant.languages.melfa_basic.tree.columnar import MoveRows


@dataclass(slots=True)
class Block:
    """A block by the places of its lines in `Look.code`.

    kind: `For`, `While`, `If` or `Select`. parts: of ElseIf, Else, Case and Default.
    last: of the closing word, None where it is missing. depth: blocks of this kind around it.
    """

    kind: str
    first: int
    around: Block | None
    parts: list[int] = field(default_factory=list)
    last: int | None = None

    @property
    def chain(self) -> Iterator[Block]:
        block: Block | None = self
        while block is not None:
            yield block
            block = block.around


@dataclass(frozen=True, slots=True)
class Misfit:
    """A closing or middle word that does not fit.

    kind: of the block that it belongs to. inside: the inner block that is still open there, None
    if no block of that kind is open at all.
    """

    at: int
    word: str
    kind: str
    inside: Block | None


@dataclass(slots=True)
class Blocks:
    """The blocks of one scope.

    around: place of a line → the innermost block that it stands in; opening and closing words
    stand in what is around their block.
    """

    all: list[Block] = field(default_factory=list)
    around: dict[int, Block | None] = field(default_factory=dict)
    wrong: list[Misfit] = field(default_factory=list)
    by_line: dict[int, Block] = field(default_factory=dict)
    """Place of any word of a block → the block."""
    closing: dict[int, list[Block]] = field(default_factory=dict)
    """Place of a closing word → the blocks that it closes, the innermost first."""

    @property
    def sound(self) -> bool:
        return not self.wrong and all(block.last is not None for block in self.all)


def blocks_of(look: Look, scope: Scope) -> Blocks:
    found = Blocks()
    inner: Block | None = None
    for at in scope.entries:
        item = look.code[at]
        statement = item.statement if isinstance(item, s.Line) else None
        kind = opened(statement)
        if kind:
            found.around[at] = inner
            inner = Block(kind, at, inner)
            found.all.append(inner)
            found.by_line[at] = inner
            continue
        kind = divided(statement)
        if kind:
            if inner is not None and inner.kind == kind:
                inner.parts.append(at)
                found.by_line[at] = inner
            else:
                found.wrong.append(_misfit(at, word_of(statement), kind, inner))
        for kind in closed(statement):
            if inner is not None and inner.kind == kind:
                inner.last = at
                found.by_line[at] = inner
                found.closing.setdefault(at, []).append(inner)
                inner = inner.around
            else:
                wrong = _misfit(at, word_of(statement), kind, inner)
                found.wrong.append(wrong)
                if wrong.inside is not None:
                    _close_outer(wrong.inside, wrong.kind, at)
        found.around[at] = inner
    return found


def _misfit(at: int, word: str, kind: str, inner: Block | None) -> Misfit:
    chain = inner.chain if inner is not None else ()
    return Misfit(at, word, kind, inner if any(block.kind == kind for block in chain) else None)


def _close_outer(inner: Block, kind: str, at: int) -> None:
    """Closes the block that a word is meant for, and leaves those inside of it open."""
    child = inner
    for block in inner.chain:
        if block.kind == kind:
            block.last, child.around = at, block.around
            return
        child = block


def word_of(statement: s.Statement | None) -> str:
    """The word that a statement begins with, as the tools spell it."""
    match statement:
        case s.Command(keyword=keyword) | s.Motion(keyword=keyword) | s.Jump(keyword=keyword):
            return keyword
        case s.Select():
            return "Select"
        case None | s.Assign():
            return ""
    return type(statement).__name__


# ------------------------------------------------------------------------------------ the graph


@dataclass(slots=True)
class Ways:
    """The ways through one scope.

    labels: upper case → place of its line. after: place → places that may follow it.
    calls: place of a line → labels' places that it calls with GoSub. handlers: label's place →
    the line that makes it an interrupt's, which calls it (True) or jumps to it (False).
    jumps: line → the places that it jumps to, not by running on.
    """

    scope: Scope
    labels: dict[str, int]
    after: dict[int, list[int]] = field(default_factory=dict)
    calls: dict[int, list[int]] = field(default_factory=dict)
    handlers: dict[int, tuple[int, bool]] = field(default_factory=dict)
    jumps: dict[int, list[int]] = field(default_factory=dict)

    @property
    def called(self) -> set[int]:
        """Labels' places that are called as subroutines."""
        return {place for places in self.calls.values() for place in places}

    def reached(self, starts: Iterable[int], *, through_calls: bool = False) -> set[int]:
        """Places that can be come to from some, themselves included."""
        found: set[int] = set()
        left = list(starts)
        while left:
            at = left.pop()
            if at in found:
                continue
            found.add(at)
            left += self.after.get(at, ())
            if through_calls:
                left += self.calls.get(at, ())
        return found


ENDS: Final = frozenset({"End", "Return", "Exit Function", "FEnd"})
"""Statements behind which nothing runs on."""


def labels_of(look: Look, scope: Scope) -> dict[str, int]:
    found: dict[str, int] = {}
    for at in scope.entries:
        item = look.code[at]
        if isinstance(item, s.Line) and item.label is not None:
            found.setdefault(item.label.upper(), at)
    return found


def steps_of(look: Look) -> dict[int, int]:
    """Step number → place of its line, of a run of moves its own; empty if no jump needs it."""
    found: dict[int, int] = {}
    if not any(isinstance(target.place, int) for _, target in look.all(s.Target)):
        return found
    for at, item in enumerate(look.code):
        if isinstance(item, MoveRows):
            found.update(dict.fromkeys(item.steps.tolist(), at))
        elif item.number is not None:
            found.setdefault(item.number, at)
    return found


def ways_of(look: Look, scope: Scope, blocks: Blocks) -> Ways:
    """The ways through a scope whose blocks are sound."""
    ways = Ways(scope, labels_of(look, scope))
    following = dict(zip(scope.entries, scope.entries[1:], strict=False))
    maker = _Maker(look, blocks, ways, following, look.once(steps_of))
    for at in scope.entries:
        maker.line(at)
    return ways


@dataclass(slots=True)
class _Maker:
    look: Look
    blocks: Blocks
    ways: Ways
    following: dict[int, int]
    steps: dict[int, int]

    def line(self, at: int) -> None:
        item = self.look.code[at]
        statement = item.statement if isinstance(item, s.Line) else None
        places = self.after(at, statement)
        self.ways.after[at] = list(dict.fromkeys(places))

    def on(self, at: int | None) -> list[int]:
        """Where control runs on behind a line."""
        if at is None or at not in self.following:
            return []
        place = self.following[at]
        block = self.blocks.by_line.get(place)
        if block is not None and place in block.parts:  # the end of a branch
            return [] if block.last is None else [block.last]
        return [place]

    def after(self, at: int, statement: s.Statement | None) -> list[int]:
        block = self.blocks.by_line.get(at)
        if block is not None and (opened(statement) or at in block.parts or closed(statement)):
            return self.in_block(at, statement, block)
        places, goes_on = self.of(at, statement)
        return [*places, *(self.on(at) if goes_on else ())]

    def of(self, at: int, statement: s.Statement | s.Target | None) -> tuple[list[int], bool]:
        """Where a statement jumps to, and whether control may run on behind it."""
        match statement:
            case s.Target():
                return self.jump(at, statement), False
            case s.Jump("GoTo", target):
                return self.jump(at, target), False
            case s.Jump("GoSub", target):
                self.call(at, target)
            case s.OnJump(_, keyword, targets):
                named = [t for t in targets if t is not None]
                if keyword == "GoTo":
                    return [place for t in named for place in self.jump(at, t)], True
                for t in named:
                    self.call(at, t)
            case s.OnCom(_, target):
                self.handler(at, target, True)
            case s.DefAct(_, _, keyword, target):
                self.handler(at, target, keyword == "GoSub")
            case s.If(_, then, otherwise):
                places, on = self.of(at, then)
                more, also = self.of(at, otherwise) if otherwise is not None else ([], True)
                return [*places, *more], on or also
            case s.Command(keyword="Break"):
                return self.left(at), False
            case s.Command(keyword=keyword) if keyword in ENDS:
                return [], False
        return [], True

    def place(self, target: s.Target) -> int | None:
        if isinstance(target.place, int):
            return self.steps.get(target.place)
        return self.ways.labels.get(target.place.upper())

    def jump(self, at: int, target: s.Target) -> list[int]:
        place = self.place(target)
        if place is None:
            return []
        self.ways.jumps.setdefault(at, []).append(place)
        return [place]

    def call(self, at: int, target: s.Target) -> None:
        place = self.place(target)
        if place is not None:
            self.ways.calls.setdefault(at, []).append(place)

    def handler(self, at: int, target: s.Target, called: bool) -> None:
        place = self.place(target)
        if place is not None:
            self.ways.handlers.setdefault(place, (at, called))

    def left(self, at: int) -> list[int]:
        """Behind the blocks around a Break; the manuals do not say which one it leaves."""
        inner = self.blocks.around.get(at)
        return [p for block in (inner.chain if inner else ()) for p in self.on(block.last)]

    def in_block(self, at: int, statement: s.Statement | None, block: Block) -> list[int]:
        """What follows an opening, middle or closing word."""
        match statement:
            case s.Next() | s.Command(keyword="WEnd"):
                # a Next of several variables goes back to any of its loops
                return [b.first for b in self.blocks.closing.get(at, ())]
            case s.Command(keyword="EndIf" | "End Select"):
                return self.on(at)
            case s.For():
                return [*self.inside(at), *self.on(block.last)]
            case s.Command(keyword="While", arguments=arguments):
                forever = arguments != () and _is_true(arguments[0])
                return [*self.inside(at), *(() if forever else self.on(block.last))]
            case s.Select():
                default = any(_is(self.look.code[p], "Default") for p in block.parts)
                return [*block.parts, *(() if default else self.ends(block))]
            case s.If() | s.ElseIf():
                later = [p for p in block.parts if p > at]
                return [*self.inside(at), *(later[:1] or self.ends(block))]
        behind = [p for p in block.parts if p > at] if block.kind == "If" else []
        return [*self.inside(at), *behind]  # branches behind Else are a finding of their own

    def inside(self, at: int) -> list[int]:
        """The first line of a branch, or what comes behind an empty one."""
        return self.on(at)

    def ends(self, block: Block) -> list[int]:
        return [] if block.last is None else [block.last]


def _is(item: object, keyword: str) -> bool:
    return (
        isinstance(item, s.Line)
        and isinstance(item.statement, s.Command)
        and item.statement.keyword == keyword
    )


def _is_true(value: s.Expression | None) -> bool:
    return isinstance(value, s.Number) and value.value != 0
