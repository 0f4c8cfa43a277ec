"""Blocks as MELFA-BASIC IV says them: with `IF … THEN` and jumps to labels.

    IF M1>0 THEN *I1T1 ELSE *I1N1        If M1>0 Then
    *I1T1
    …                                      …
    GOTO *I1Z                            Else
    *I1N1
    …                                      …
    *I1Z                                 EndIf

An `ElseIf` is the next `IF`, to `*I1T2` and `*I1N2`. A `Wait` for any condition is a loop from
`*W1` to `*W1Z`; what `Break` leaves has the label `*B1Z` behind it; a `Select` inside another one
is a row of `IF … THEN *S1C1`.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from assistant.languages.line_blocks import Block, Blocks
from assistant.languages.melfa_basic.lift.settings.held import SETTING_COMMANDS
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import EMITTED_LINE, Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.jumping import is_plain_wait, waiting_loop
from assistant.languages.melfa_basic.tree.targets import labels_of
from assistant.languages.melfa_basic.tree.walk import nodes

Complain = Callable[[s.Item, str, str], None]
"""Says of a line what cannot be said, and what to do."""

_NUMBERED_LABEL: Final = re.compile(r"[A-Z]\d+")

BlockPart = tuple[s.Line, range]
"""The line that begins a part of a block, and the places of those in it."""

WrittenPart = tuple[s.Line, list[s.Item]]
"""The same with the lines that its lines have become."""

THEN_STATEMENTS: Final = (s.Assign, s.Jump, s.CallP, s.Print, s.Input, s.Open, s.Close, s.Command)
"""Statements that may follow `THEN` on its line."""


@dataclass(slots=True)
class BreakTarget:
    """Where `Break` goes: behind the innermost block.

    kind: of that block. selecting: it is a `Select`, or inside one. letter: that the label
    begins with. label: once something goes there, with its number.
    """

    kind: str
    selecting: bool
    letter: str
    label: str | None = None


class Jumps:
    """Writes the blocks of one program, which are sound."""

    def __init__(
        self, items: Sequence[s.Item], blocks: Blocks, dialect: Dialect, complain: Complain
    ) -> None:
        self.items, self.dialect, self.complain = items, dialect, complain
        self.blocks, self.opened = blocks, {block.first: block for block in blocks.all}
        self.begun = {m[0] for label in labels_of(items) if (m := _NUMBERED_LABEL.match(label))}
        """How labels begin that have a letter and a number."""
        self.counts: dict[str, int] = {}
        self.variables: list[str] = []

    def name(self, letter: str) -> str:
        """The beginning of labels that nothing else begins with: `I1`, `W2` …"""
        while True:
            number = self.counts[letter] = self.counts.get(letter, 0) + 1
            made = f"{letter}{number}"
            if made not in self.begun:
                return made

    def lines(self, places: range, leave: BreakTarget | None = None) -> list[s.Item]:
        """The lines at some places, blocks whole among them."""
        made: list[s.Item] = []
        at = places.start
        while at < places.stop:
            block = self.opened.get(at)
            if block is None:
                made += self.line(self.items[at], leave)
                at += 1
                continue
            if block.kind == "If" and not self.dialect.blocks:
                made += self.if_block(block, _selecting(leave))
            elif block.kind == "Select" and _selecting(leave) and not self.dialect.nested_select:
                made += self.chain(block)
            else:
                made += self.kept(block, leave)
            at = block.words[-1] + 1
        return made

    def parts(self, block: Block) -> list[BlockPart]:
        """The lines that begin the parts of a block, and the places that each holds."""
        return [
            (_as_line(self.items[at]), range(at + 1, end))
            for at, end in itertools.pairwise(block.words)
        ]

    def end(self, block: Block) -> s.Line | None:
        """The line that ends a block; None for a loop whose `Next` ends an outer one as well."""
        last = block.words[-1]
        return _as_line(self.items[last]) if self.blocks.closing[last][-1] is block else None

    def kept(self, block: Block, leave: BreakTarget | None) -> list[s.Item]:
        """A block that stays one; behind it the place that `Break` goes to."""
        out = BreakTarget(block.kind, _selecting(leave) or block.kind == "Select", "B")
        made: list[s.Item] = []
        for head, inside in self.parts(block):
            made += [head, *self.lines(inside, out)]
        end = self.end(block)
        if end is not None:
            made.append(end)
        elif out.label is not None:
            self.complain(
                self.items[block.first],
                "a `Break` out of a loop whose `Next` ends several loops",
                "write a `Next` for each loop",
            )
        if out.label is not None:
            made.append(s.Line(label=out.label))
        return made

    # ----------------------------------------------------------------------------- If

    def if_block(self, block: Block, selecting: bool) -> list[s.Item]:
        """An `If` block on one line if it fits there, else with jumps."""
        parts = self.parts(block)
        if all(len(inside) == 1 for _, inside in parts):
            counts, out = dict(self.counts), BreakTarget("If", selecting, "I")
            short = self.on_one_line(block, [(head, self.lines(x, out)) for head, x in parts])
            if short is not None and out.label is None:
                return [short]
            self.counts = counts
        last = self.name("I") + "Z"
        out = BreakTarget("If", selecting, "I", last)
        written = [(head, self.lines(inside, out)) for head, inside in parts]
        return [*self.jumping(last, written), *_end_comment(self.end(block))]

    def jumping(self, last: str, parts: Sequence[WrittenPart]) -> list[s.Item]:
        """The lines of an `If` with jumps. last: the label at its end, `I1Z`."""
        name = last[:-1]
        made: list[s.Item] = []
        branch = 0
        for head, body in parts:
            node = head.statement
            if isinstance(node, s.If | s.ElseIf):
                branch += 1
                then, other = f"{name}T{branch}", f"{name}N{branch}"
                test = s.If(node.condition, s.Target(then), s.Target(other))
                made += [replace(head, statement=test), s.Line(label=then), *body]
                made += [_goto(last), s.Line(label=other)]
            else:  # its comment goes to the jump, which stands where the word stood
                made[-2:] = [replace(_goto(last), comment=head.comment), made[-1], *body]
        return [*made, s.Line(label=last)]

    def on_one_line(self, block: Block, parts: Sequence[WrittenPart]) -> s.Line | None:
        (head, _), *others = parts
        words = [*(line for line, _ in others), _as_line(self.items[block.words[-1]])]
        plain = [line.statement for line, _ in others] in ([], [s.Command("Else")])
        if not plain or not isinstance(head.statement, s.If) or any(w.comment for w in words):
            return None
        branches = [self.alone(body) for _, body in parts]
        if None in branches:
            return None
        line = replace(head, statement=s.If(head.statement.condition, *branches))
        text = printer.line(line, self.dialect.upper)
        return line if len(text) < EMITTED_LINE - 10 else None

    @staticmethod
    def alone(body: Sequence[s.Item]) -> s.Statement | None:
        """The one statement of a body, if it may stand behind `THEN`."""
        if len(body) != 1 or not isinstance(body[0], s.Line):
            return None
        line = body[0]
        if line.label is not None or line.comment is not None:
            return None
        if not isinstance(line.statement, THEN_STATEMENTS):
            return None
        if isinstance(line.statement, s.Command) and line.statement.keyword in SETTING_COMMANDS:
            return None  # it holds for the moves below, and keeps a line of its own
        return line.statement

    # ------------------------------------------------------------------- nested Select

    def chain(self, block: Block) -> list[s.Item]:
        """A `Select` inside another one, its cases found by a row of `IF`."""
        (head, above), *cases = self.parts(block)
        name = self.name("S")
        last = name + "Z"
        out = BreakTarget("chain", True, "S", last)
        made: list[s.Item] = []
        selected = head.statement
        if not isinstance(selected, s.Select):
            return made
        subject = selected.subject
        status = isinstance(subject, s.Variable) and vocabulary.status(subject.name) is not None
        if _calls_function(subject) and not all(_has_single_values(case) for case, _ in cases):
            self.complain(
                head,
                "a `Select` on the value of a function inside another one",
                "assign the value to a variable in front of it",
            )
        if not isinstance(subject, s.Variable) or subject.arguments is not None or status:
            variable = s.Variable("M" + name)  # a value that may change is looked at once
            self.variables.append(variable.name)
            made.append(s.Line(statement=s.Assign(variable, subject), comment=head.comment))
            subject = variable
        elif head.comment is not None:
            made.append(s.Line(comment=head.comment))
        bodies: list[s.Item] = []
        default = False
        for number, (case, inside) in enumerate(cases, 1):
            node, comment = case.statement, case.comment
            label = f"{name}C{number}"
            if default:
                self.complain(case, "a `Case` behind `Default`", "move `Default` to the end")
            if isinstance(node, s.Case):
                for item in node.items:
                    jump = s.If(_case_test(subject, item), s.Target(label))
                    made.append(s.Line(statement=jump, comment=comment))
                    comment = None
            else:
                default = True
                goto = s.Jump("GoTo", s.Target(label))
                made.append(s.Line(statement=goto, comment=comment))
            inner = self.lines(inside, out)
            while inner and inner[-1] == _goto(last):
                inner.pop()
            bodies += [s.Line(label=label), *inner, _goto(last)]
        if not default:
            made.append(_goto(last))
        made += [*self.lines(above, out), *bodies, s.Line(label=last)]
        return [*made, *_end_comment(self.end(block))]

    # ----------------------------------------------------------------------- one line

    def line(self, item: s.Item, leave: BreakTarget | None) -> list[s.Item]:
        if not isinstance(item, s.Line):
            return [item]
        match item.statement:
            case s.Command(keyword="Break"):
                return [replace(item, statement=self.left(item, leave))]
            case s.Command(keyword="Wait", arguments=(condition,)) if (
                condition is not None
                and not self.dialect.wide_wait
                and not is_plain_wait(condition)
            ):
                return [*waiting_loop(self.name("W"), condition, item)]
            case s.If(then=then) if then is not None and not self.dialect.blocks:
                return self.one_line_if(item, item.statement, leave)
        return [item]

    def left(self, item: s.Line, leave: BreakTarget | None) -> s.Statement:
        if leave is None:
            self.complain(item, "a `Break` outside of every block", "take it out")
            return s.Command("Break")
        if leave.kind == "Select":
            return s.Command("Break")
        if leave.label is None:
            leave.label = self.name(leave.letter) + "Z"
        return s.Jump("GoTo", s.Target(leave.label))

    def one_line_if(self, item: s.Line, node: s.If, leave: BreakTarget | None) -> list[s.Item]:
        """An `If` of one line; as a block where a branch needs several."""
        given = [b for b in (node.then, node.otherwise) if b is not None]
        bodies: list[list[s.Item]] = []
        for branch in given:
            goto = s.Jump("GoTo", branch) if isinstance(branch, s.Target) else branch
            bodies.append(self.line(s.Line(statement=goto, span=item.span), leave))
        if any(len(body) > 1 for body in bodies):
            heads = [item, s.Line(statement=s.Command("Else"))]
            return self.jumping(self.name("I") + "Z", list(zip(heads, bodies, strict=False)))
        branches = [
            branch
            if isinstance(branch, s.Target) or not isinstance(line, s.Line)
            else line.statement
            for branch, (line,) in zip(given, bodies, strict=True)
        ]
        changed = s.If(node.condition, *branches)
        return [item if changed == node else replace(item, statement=changed)]


def _selecting(leave: BreakTarget | None) -> bool:
    return leave is not None and leave.selecting


def _end_comment(end: s.Line | None) -> list[s.Item]:
    """The comment of a line that ends a block."""
    return [] if end is None or end.comment is None else [s.Line(comment=end.comment)]


def _goto(label: str) -> s.Line:
    return s.Line(statement=s.Jump("GoTo", s.Target(label)))


def _calls_function(value: s.Expression) -> bool:
    """Whether a function is called to work it out."""
    return any(
        isinstance(node, s.Variable)
        and node.arguments is not None
        and (node.key.startswith("FN") or vocabulary.function(node.name) is not None)
        for node in nodes(value)
    )


def _as_line(item: s.Item) -> s.Line:
    assert isinstance(item, s.Line)
    return item


def _has_single_values(case: s.Line) -> bool:
    """Whether a case asks for single values only."""
    node = case.statement
    return not isinstance(node, s.Case) or all(
        isinstance(item, s.CaseRange) and item.last is None for item in node.items
    )


def _case_test(subject: s.Expression, item: s.CaseRange | s.CaseIs) -> s.Expression:
    if isinstance(item, s.CaseIs):
        return s.Binary(item.operator, subject, item.value)
    if item.last is None:
        return s.Binary("=", subject, item.first)
    low, high = s.Binary(">=", subject, item.first), s.Binary("<=", subject, item.last)
    return s.Binary("AND", low, high)
