"""Blocks, branches and jumps."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import Any, Final

from assistant.languages.melfa_basic.lift.statements import waits
from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.operators import operator_name
from assistant.languages.melfa_basic.lift.values.reasons import NO_LABEL
from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import block_word
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import identifier
from assistant.program.rewriting import is_repeatable

DEEPEST: Final = 50
"""Blocks inside one another that are read as such; controllers stop at 16."""

Body = Callable[[int, int], tuple[p.Statement, ...]]
Single = Callable[[s.Statement], list[p.Statement]]


class Control:
    """Lifts what decides the order of the lines; raises Unliftable.

    body: lifts a range of lines. single: lifts one statement, the branch of an `If`. enter: sets
    what holds where a line begins.
    labels: those of the procedure that is read, upper case → name. refused: why blocks, by their
    first line, stay as their text.
    """

    def __init__(
        self,
        code: Code,
        structure: Mapping[int, list[int]],
        expressions: Expressions,
        body: Body,
        single: Single,
        enter: Callable[[int], Any],
        asks_for_breaks: bool,
    ) -> None:
        self.code, self.structure, self.expressions = code, structure, expressions
        self.body, self.single, self.enter = body, single, enter
        self.labels: dict[str, str] = {}
        self.refused: dict[int, p.Reason | None] = {}
        self.depth = 0
        self.leaving: list[_Block] = []
        self.asks_for_breaks = asks_for_breaks

    @property
    def symbols(self) -> Symbols:
        return self.expressions.m

    # ------------------------------------------------------------------------------ blocks

    def block(self, at: int, high: int, made: list[p.Statement]) -> int:
        """A whole block that begins here; gives the place after it, 0 if there is none."""
        found = self.structure.get(at)
        if found is None or found[-1] > high or self.depth > DEEPEST:
            return 0
        item = self.code[at]
        if not isinstance(item, s.Line):
            return 0
        self.leaving.append(_Block(block_word(item.statement).opens, set(found[1:])))
        self.depth += 1
        try:
            statement = self.whole(item.statement, found)
        except Unliftable as found_why:
            statement = None
            self.refused[at] = found_why.reason
        self.depth -= 1
        block = self.leaving.pop()
        if statement is None:
            return 0
        made.append(waits.spanned(statement, item.span))
        if block.label is not None:
            made.append(p.Label(block.label))
        if found[-1] < high:  # else it is the last word of the outer block as well
            made += self.note(found[-1])
        return found[-1] + 1

    def whole(self, node: s.Statement | None, places: list[int]) -> p.Statement | None:
        """A block from the places of its keywords."""
        of, condition_of = self.expressions.of, self.expressions.condition
        match node:
            case s.If(then=s.Target()):
                return self.jumping_if(places)
            case s.If():
                return self.if_block(places)
            case s.Command(keyword="While", arguments=(condition,)) if condition is not None:
                test = condition_of(condition)
                return p.While(test, self.body(places[0] + 1, places[-1]))
            case s.For(variable=variable, first=first, last=last, step=step):
                name = self.expressions.plain(variable)
                if not isinstance(name, e.Name):
                    raise Unliftable
                counted = p.ONE if step is None else of(step)
                limits = of(first), of(last)
                inside = self.body(places[0] + 1, places[-1])
                return p.For(name.name, *limits, inside, counted)
            case s.Select(subject=subject):
                return self.select(subject, places)
        return None

    def note(self, at: int) -> list[p.Statement]:
        """The comment behind a word of a block."""
        item = self.code[at]
        if not isinstance(item, s.Line) or item.comment is None:
            return []
        return [p.Comment(waits.comment_text(item.comment), span=item.span)]

    def part(self, place: int, following: int) -> tuple[p.Statement, ...]:
        """What stands below a word that divides a block."""
        return (*self.note(place), *self.body(place + 1, following))

    def if_block(self, places: list[int]) -> p.If:
        branches: list[p.Branch] = []
        otherwise: tuple[p.Statement, ...] = ()
        for place, following in itertools.pairwise(places):
            node = self.statement_at(place)
            inside = self.part if branches else lambda a, b: self.body(a + 1, b)
            if isinstance(node, s.If | s.ElseIf):
                condition = self.condition_at(place, node)
                branches.append(p.Branch(condition, inside(place, following)))
            else:
                otherwise = inside(place, following)
        return p.If(tuple(branches), otherwise)

    def jumping_if(self, places: list[int]) -> p.If:
        """`If` and jumps to made labels: condition, then, jump and next label by turns, end."""
        branches = []
        for i in range(0, len(places) - 1, 3):
            test, jump, _ = places[i : i + 3]
            node = self.statement_at(test)
            if not isinstance(node, s.If):
                raise Unliftable
            condition = self.condition_at(test, node)
            branches.append(p.Branch(condition, self.body(test + 2, jump)))
        otherwise = self.body(places[-2] + 1, places[-1])
        return p.If(tuple(branches), otherwise)

    def condition_at(self, place: int, node: s.If | s.ElseIf) -> e.Expression:
        """The condition of a line of an `If`, under what holds there."""
        self.enter(place)
        return self.expressions.condition(node.condition)

    def statement_at(self, place: int) -> s.Statement | None:
        item = self.code[place]
        return item.statement if isinstance(item, s.Line) else None

    # ------------------------------------------------------------------------------ Select

    def select(self, subject: s.Expression, places: list[int]) -> p.Switch | p.If:
        value = self.expressions.of(subject)
        if any(self.statement_at(at) for at in range(places[0] + 1, places[1])):
            raise Unliftable  # lines that never run
        cases: list[tuple[s.Case, tuple[p.Statement, ...]]] = []
        otherwise: tuple[p.Statement, ...] = ()
        above = self.body(places[0] + 1, places[1])
        for place, following in itertools.pairwise(places[1:]):
            node = self.statement_at(place)
            inside = (*above, *self.part(place, following))
            above = ()
            if isinstance(node, s.Case):
                cases.append((node, inside))
            elif following != places[-1]:
                raise Unliftable  # a Default before other cases
            else:
                otherwise = inside
        if all(_single(item) is not None for case, _ in cases for item in case.items):
            made = tuple(p.Case(self._singles(case), inside) for case, inside in cases)
            return p.Switch(value, made, otherwise)
        if not is_repeatable(value):
            raise Unliftable
        branches = tuple(p.Branch(self._test(value, case), inside) for case, inside in cases)
        return p.If(branches, otherwise)

    def _singles(self, case: s.Case) -> tuple[e.Expression, ...]:
        values = map(_single, case.items)
        return tuple(self.expressions.plain(value) for value in values if value is not None)

    def _test(self, value: e.Expression, case: s.Case) -> e.Expression:
        """Whether a value is what a case asks for."""
        tests = [self._one_test(value, item) for item in case.items]
        condition = tests[0]
        for test in tests[1:]:
            condition = e.Binary("or", condition, test)
        return condition

    def _one_test(self, value: e.Expression, item: s.CaseRange | s.CaseIs) -> e.Expression:
        plain = self.expressions.plain
        if isinstance(item, s.CaseIs):
            operator: Any = operator_name(item.operator)
            return e.Binary(operator, value, plain(item.value))
        first = plain(item.first)
        if item.last is None:
            return e.Binary("=", value, first)
        last = plain(item.last)
        return e.Binary("and", e.Binary(">=", value, first), e.Binary("<=", value, last))

    # ------------------------------------------------------------------------------- jumps

    def one_line_if(self, node: s.If) -> list[p.Statement]:
        if node.then is None:
            raise Unliftable
        condition = self.expressions.condition(node.condition)
        then = self.branch(node.then)
        otherwise = () if node.otherwise is None else self.branch(node.otherwise)
        if not then and not otherwise:
            return []
        return [p.If((p.Branch(condition, then),), otherwise)]

    def branch(self, node: s.Statement | s.Target) -> tuple[p.Statement, ...]:
        if isinstance(node, s.Target):
            node = s.Jump("GoTo", node)
        return tuple(self.single(node))

    def goto(self, target: s.Target) -> p.Statement:
        place = target.place
        if isinstance(place, int) or place.upper() not in self.labels:
            raise Unliftable(NO_LABEL)
        return p.Goto(self.labels[place.upper()])

    def on_jump(self, node: s.OnJump, go: Callable[[s.Target], p.Statement]) -> list[p.Statement]:
        """`On n GoTo` and `On n GoSub`; a number that there is none for goes on below."""
        subject = self.expressions.rounded(node.subject)
        if any(target is None for target in node.targets):
            raise Unliftable
        cases = tuple(
            p.Case((e.Number(k),), (go(target),))
            for k, target in enumerate(node.targets, 1)
            if target is not None
        )
        return [p.Switch(subject, cases)]

    def left(self, at: int) -> list[p.Statement]:
        """`Break`: out of the innermost block; at the end of a branch it says nothing."""
        if not self.leaving or self.asks_for_breaks:
            raise Unliftable
        block = self.leaving[-1]
        if block.kind in ("If", "Select") and self._next_word(at) in block.places:
            return []
        if block.label is None:
            block.label = identifier("leave", set(self.labels.values()))
            self.labels[f"*{block.label}"] = block.label  # no label of the file's own
        return [p.Goto(block.label)]

    def _next_word(self, at: int) -> int:
        """The next line that is more than a comment."""
        at += 1
        while at < len(self.code):
            item = self.code[at]
            if not isinstance(item, s.Line) or item.statement or item.label:
                break
            at += 1
        return at


class _Block:
    """kind: its word. places: of the words that divide and end it. label: behind it."""

    def __init__(self, kind: str, places: set[int]) -> None:
        self.kind, self.places = kind, places
        self.label: str | None = None


def _single(item: s.CaseRange | s.CaseIs) -> s.Expression | None:
    """The one value that a case asks for, None if there are others."""
    if isinstance(item, s.CaseIs):
        return item.value if item.operator == "=" else None
    return item.first if item.last is None else None
