"""Blocks, branches and jumps."""

from __future__ import annotations

import itertools
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, Final

from assistant.languages.melfa_basic.lift.statements import channels, data, interrupts, waits
from assistant.languages.melfa_basic.lift.statements.lines import (
    OpenBlock,
    StatementLift,
    Statements,
)
from assistant.languages.melfa_basic.lift.structure.regions import next_word
from assistant.languages.melfa_basic.lift.values import pallets
from assistant.languages.melfa_basic.lift.values.operators import operator_name
from assistant.languages.melfa_basic.lift.values.reasons import (
    FRACTIONAL_STEP,
    NO_LABEL,
    NO_PROCEDURE,
)
from assistant.languages.melfa_basic.lift.values.symbols import Unliftable
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import block_word
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.switches import SELECTED, Test, chosen
from assistant.program.program import Variable, identifier
from assistant.program.rewriting import is_steady, records

DEEPEST: Final = 50
"""Blocks inside one another that are read as such; controllers stop at 16."""


class Control(Statements):
    """Lifts what decides the order of the lines; raises Unliftable."""

    @abstractmethod
    def body(self, low: int, high: int) -> tuple[p.Statement, ...]:
        """The statements of a range of lines."""

    @abstractmethod
    def enter(self, at: int) -> Any:
        """Sets what holds where a line begins."""

    # ------------------------------------------------------------------------------ blocks

    def block(self, at: int, high: int, made: list[p.Statement]) -> int:
        """A whole block that begins here; gives the place after it, 0 if there is none."""
        found, item = self.blocks.get(at), self.code[at]
        if found is None or found[-1] > high or len(self.leaving) > DEEPEST:
            return 0
        self.leaving.append(OpenBlock(block_word(item.statement).opens, found[1:]))
        try:
            statement = self.whole(item.statement, found)
        except Unliftable as found_why:
            statement = None
            self.refused[at] = found_why.reason
        block = self.leaving.pop()
        if statement is None:
            return 0
        parts = statement if isinstance(statement, tuple) else (statement,)
        made += (waits.with_span(part, item.span) for part in parts)
        if block.label is not None:
            made.append(p.Label(block.label))
        if found[-1] < high:  # else it is the last word of the outer block as well
            made += self.note(found[-1])
        return found[-1] + 1

    def whole(
        self, node: s.Statement | None, places: list[int]
    ) -> p.Statement | tuple[p.Statement, ...] | None:
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
                if self.expressions.type_of(variable) == "integer" and not _may_be_whole(counted):
                    raise Unliftable(FRACTIONAL_STEP)
                limits = of(first), of(last)
                inside = self.body(places[0] + 1, places[-1])
                return p.For(name.name, *limits, inside, counted)
            case s.Select(subject=subject):
                return self.select(subject, places)
        return None

    def note(self, at: int) -> list[p.Statement]:
        """The comment behind a word of a block."""
        item = self.code[at]
        if item.comment is None:
            return []
        return [p.Comment(waits.comment_text(item.comment), span=item.span)]

    def part(self, place: int, following: int) -> tuple[p.Statement, ...]:
        """What stands below a word that divides a block."""
        return (*self.note(place), *self.body(place + 1, following))

    def if_block(self, places: list[int]) -> p.If:
        branches: list[p.Branch] = []
        otherwise: tuple[p.Statement, ...] = ()
        for place, following in itertools.pairwise(places):
            node = self.code[place].statement
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
            node = self.code[test].statement
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

    # ------------------------------------------------------------------------------ Select

    def select(self, subject: s.Expression, places: list[int]) -> tuple[p.Statement, ...]:
        """A choice; a value that the next reading may find changed is read into a variable."""
        value = self.expressions.of(subject)
        if any(self.code[at].statement for at in range(places[0] + 1, places[1])):
            raise Unliftable  # lines that never run
        cases: list[tuple[s.Case, tuple[p.Statement, ...]]] = []
        otherwise: tuple[p.Statement, ...] = ()
        above = self.body(places[0] + 1, places[1])
        for place, following in itertools.pairwise(places[1:]):
            node = self.code[place].statement
            inside = (*above, *self.part(place, following))
            above = ()
            if isinstance(node, s.Case):
                cases.append((node, inside))
            elif following != places[-1]:
                raise Unliftable  # a Default before other cases
            else:
                otherwise = inside
        single = all(_is_single_value(item) for case, _ in cases for item in case.items)
        read: tuple[p.Statement, ...] = ()
        if not single and not self._is_steady(value):
            if any(isinstance(part, e.Verbatim) for part in records(value)):
                raise Unliftable
            name = self.symbols.free(SELECTED)
            self.symbols.variables[name] = Variable(self.expressions.type_of(subject))
            read, value = (p.Assign(e.Name(name), value),), e.Name(name)
        made = chosen(value, [(self._tests(case), inside) for case, inside in cases], otherwise)
        return (*read, made)

    def _is_steady(self, value: e.Expression) -> bool:
        """True if a value is the same at each read: only this program changes it."""
        changing = {name.lower() for name in self.symbols.signals}
        names = {part.name.lower() for part in records(value) if isinstance(part, e.Name)}
        return is_steady(value, changing) and not any(name[1:2] == "_" for name in names)

    def _tests(self, case: s.Case) -> list[Test]:
        """What a case asks of the value: one of these."""
        plain = self.expressions.plain
        found: list[Test] = []
        for item in case.items:
            if isinstance(item, s.CaseIs):
                found.append(((operator_name(item.operator), plain(item.value)),))
            elif item.last is None:
                found.append((("=", plain(item.first)),))
            else:
                found.append(((">=", plain(item.first)), ("<=", plain(item.last))))
        return found

    # ------------------------------------------------------------------------------- jumps

    def one_line_if(self, node: s.If) -> list[p.Statement]:
        if node.then is None:
            raise Unliftable
        condition = self.expressions.condition(node.condition)
        then = self.branch(node.then)
        otherwise = () if node.otherwise is None else self.branch(node.otherwise)
        self.runs.forget()
        return [p.If((p.Branch(condition, then),), otherwise)] if then or otherwise else []

    def branch(self, node: s.Statement | s.Target) -> tuple[p.Statement, ...]:
        if isinstance(node, s.Target):
            node = s.Jump("GoTo", node)
        return tuple(self.single(node))

    def jump(self, node: s.Jump) -> list[p.Statement]:
        return [self.go(node.keyword, node.target)]

    def go(self, keyword: str, target: s.Target) -> p.Statement:
        """`GoTo` or `GoSub`."""
        place = str(target.place).upper()
        if keyword == "GoSub":
            callee = self.by_label.get(place)
            if callee is None:
                raise Unliftable(NO_PROCEDURE)
            assert self.form is not None
            self.runs.forget()
            return p.Call(self.form.called[self.at][callee].name)
        if isinstance(target.place, int) or place not in self.label_names:
            raise Unliftable(NO_LABEL)
        return p.Goto(self.label_names[place])

    def on_jump(self, node: s.OnJump) -> list[p.Statement]:
        """`On n GoTo` and `On n GoSub`; a number that there is none for goes on below."""
        subject = self.expressions.rounded(node.subject)
        if any(target is None for target in node.targets):
            raise Unliftable
        cases = tuple(
            p.Case((e.Number(k),), (self.go(node.keyword, target),))
            for k, target in enumerate(node.targets, 1)
            if target is not None
        )
        self.runs.forget()
        return [p.Switch(subject, cases)]

    def broken(self, _: s.Command) -> list[p.Statement]:
        """`Break`: out of the innermost block; at the end of a branch it says nothing."""
        if not self.leaving or self.asks_for_breaks:
            raise Unliftable
        block = self.leaving[-1]
        if block.kind in ("If", "Select") and next_word(self.code, self.at) in block.places:
            return []
        if block.label is None:
            block.label = identifier("leave", set(self.label_names.values()))
            self.label_names[f"*{block.label}"] = block.label  # no label of the file's own
        return [p.Goto(block.label)]


def _is_single_value(item: s.CaseRange | s.CaseIs) -> bool:
    """Whether it asks for one value."""
    return item.operator == "=" if isinstance(item, s.CaseIs) else item.last is None


STATEMENT_LIFTS: Final[Mapping[type, StatementLift]] = {
    s.Motion: lambda reader, node: reader.moves.move(node, reader.values),
    s.Command: Statements.command,
    s.Assign: lambda reader, node: data.lift_assignment(node, reader.expressions, reader.runs),
    s.Open: lambda reader, node: channels.lift_open(node, reader.expressions),
    s.Close: lambda reader, node: channels.lift_close(node, reader.expressions),
    s.Print: lambda reader, node: channels.lift_print(node, reader.expressions),
    s.Input: lambda reader, node: channels.lift_input(node, reader.expressions, reader.runs),
    s.If: Control.one_line_if,
    s.Jump: Control.jump,
    s.OnJump: Control.on_jump,
    s.Call: Statements.call,
    s.CallP: Statements.callp,
    s.DefNames: lambda reader, node: data.declare_variables(node.variables, reader.expressions),
    s.Dim: lambda reader, node: data.declare_variables(node.variables, reader.expressions),
    s.Static: lambda reader, node: data.declare_variables(
        node.definition.variables, reader.expressions
    ),
    s.Const: lambda reader, node: data.lift_constant(node, reader.expressions),
    s.DefIo: lambda reader, node: data.lift_known_definition(
        node.variable.key in reader.symbols.io
    ),
    s.DefOther: lambda reader, node: pallets.define_pallet(node, reader.expressions),
    s.DefAct: interrupts.define_interrupt,
    s.DefFunction: lambda reader, node: data.lift_known_definition(
        node.name.upper() in reader.symbols.routines
    ),
}
COMMAND_LIFTS: Final[Mapping[str, tuple[int, StatementLift]]] = {
    "Wait": (1, Statements.wait),
    "End": (0, Statements.end),
    "Return": (0, Statements.returned),
    "Exit Function": (0, Statements.left),
    "Break": (0, Control.broken),
    "Act": (1, interrupts.switch_interrupt),
    "SetMoTrg": (1, interrupts.watch_mo_triggers),
}


def _may_be_whole(step: e.Expression) -> bool:
    """Whether a step may be a whole number, for all that its text says."""
    return not isinstance(step, e.Number) or float(step.value).is_integer()
