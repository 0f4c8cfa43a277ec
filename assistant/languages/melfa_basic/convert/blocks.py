"""Blocks written as jumps for MELFA-BASIC IV, and jumps made blocks again.

    IF M1>0 THEN *I1T1 ELSE *I1N1        If M1>0 Then
    *I1T1
    …                                      …
    GOTO *I1Z                            Else
    *I1N1
    …                                      …
    *I1Z                                 EndIf

An `ElseIf` is the next `IF`, to `*I1T2` and `*I1N2`. A `Wait` for any condition is a loop from
`*W1` to `*W1Z`; a `Break` jumps to the label `*B1Z` after what it leaves; a `Select` inside
another one is a row of `IF … THEN *S1C1`. On the way back only these very forms are taken, and
only if nothing else leads to their labels; every other jump stays as it is.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.languages.line_blocks import Block, Blocks
from assistant.languages.melfa_basic.lift.settings import SETTING_COMMANDS
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import EMITTED_LINE, Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import (
    blocks_of,
    is_plain_wait,
    jumping_ifs,
    jumps_to,
    labels_named,
    labels_of,
    lone_labels,
    read_waiting_loop,
    waiting_loop,
)
from assistant.languages.melfa_basic.tree.walk import nodes

Complain = Callable[[s.Item, str, str], None]
"""Function that reports a construct of a line without equivalent, and its cure."""

_NUMBERED_LABEL: Final = re.compile(r"[A-Z]\d+")

BlockPart = tuple[s.Line, range]
"""The line that begins a part of a block, and the places of those in it."""

WrittenPart = tuple[s.Line, list[s.Item]]
"""The same with the lines that its lines have become."""

_THEN_STATEMENTS: Final = (s.Assign, s.Jump, s.CallP, s.Print, s.Input, s.Open, s.Close, s.Command)
"""Statements that may follow `THEN` on its line."""


@dataclass(slots=True)
class BreakTarget:
    """Target of `Break`: the place after the innermost block.

    kind: of that block. selecting: it is a `Select`, or inside one. letter: first letter of the
    label. label: set once something jumps there, with its number.
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
        # Labels of one block share a letter and a number, so both have to be free together.
        self.begun = {m[0] for label in labels_of(items) if (m := _NUMBERED_LABEL.match(label))}
        """Beginnings of labels that have a letter and a number."""
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
        # A `Next` of several loops is written once, as the end of the outermost.
        last = block.words[-1]
        return _as_line(self.items[last]) if self.blocks.closing[last][-1] is block else None

    def kept(self, block: Block, leave: BreakTarget | None) -> list[s.Item]:
        """Write a block that remains a block; the target of `Break` follows it."""
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
            # A `Break` needs a label after the block, for which one line has no room.
            if short is not None and out.label is None:
                return [short]
            # The attempt took label numbers that no line has.
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
        # Room for a step number before the line.
        return line if len(text) < EMITTED_LINE - 10 else None

    @staticmethod
    def alone(body: Sequence[s.Item]) -> s.Statement | None:
        """Return the single statement of a body, if it may follow `THEN`."""
        if len(body) != 1 or not isinstance(body[0], s.Line):
            return None
        line = body[0]
        if line.label is not None or line.comment is not None:
            return None
        if not isinstance(line.statement, _THEN_STATEMENTS):
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
            # The jump to `Default` is unconditional, so cases after it would never be tested.
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
            # A `Break` at the end of a case is the jump to the end that each case gets anyway.
            while inner and inner[-1] == _goto(last):
                inner.pop()
            bodies += [s.Line(label=label), *inner, _goto(last)]
        if not default:
            made.append(_goto(last))
        # Lines above the first `Case` never run, nor do they after the jumps of all cases.
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
    """True if an expression calls a function."""
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
    """True if a case tests for single values only."""
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


_FIRST_CASE_LABEL: Final = re.compile(r"(S[0-9]+)C1")
_BREAK_LABEL: Final = re.compile(r"B[0-9]+Z")


def with_blocks(items: Sequence[s.Item], dialect: Dialect) -> list[s.Item]:
    """The lines with such jumps as the blocks of a dialect that has them."""
    lines = list(items)
    if dialect.wide_wait:
        lines = _with_waits(lines)
    chains: dict[int, str] = {}
    if dialect.nested_select:
        lines = _with_selects(lines, chains)
    refused: set[str] = set()
    # Turn all into blocks, then refuse those that do not work, until the result is sound.
    while dialect.blocks:
        made, ends = _with_ifs(lines, refused)
        blocks = blocks_of(made)
        if blocks.sound:
            if dialect.breaks:
                made = _with_breaks(made, blocks, ends | chains)
            # Labels that are gone although a jump still leads there: their block is refused.
            missing = (set(labels_named(made)) - labels_of(made).keys()) & labels_of(lines).keys()
            left = {
                name
                for name in ends.values()
                if name in missing or _is_partly_missing(name, missing)
            }
        else:
            # Refuse each `If` that crosses other blocks even if it is the only new block.
            known = {*ends.values(), *refused}
            left = {name for name in ends.values() if _crosses(lines, known - {name})}
            # None is at fault alone: which one to refuse is not clear, so all jumps stay.
            if not left:
                return lines
        if not left:
            return made
        refused |= left
    return lines


def _crosses(lines: Sequence[s.Item], refused: set[str]) -> bool:
    """True if an `If`, the only one that is not refused, crosses other blocks."""
    made, _ = _with_ifs(lines, refused)
    return not blocks_of(made).sound


def _is_partly_missing(end: str, missing: set[str]) -> bool:
    return any(re.fullmatch(end[:-1] + r"[TN][0-9]+", name) for name in missing)


# ---------------------------------------------------------------------------------- Wait


def _with_waits(items: list[s.Item]) -> list[s.Item]:
    counts = Counter(labels_named(items))
    made: list[s.Item] = []
    at = 0
    while at < len(items):
        found = read_waiting_loop(items[at : at + 3])
        # Only the loop itself may lead to its labels; another jump would enter the middle of a
        # `Wait`.
        if found is None or counts[found[0]] != 1 or counts[found[0] + "Z"] != 1:
            made.append(items[at])
            at += 1
            continue
        test = items[at + 1]
        if isinstance(test, s.Line):
            made.append(replace(test, statement=s.Command("Wait", (found[1],))))
        at += 3
    return made


# ------------------------------------------------------------------------------------ If


def _with_ifs(items: Sequence[s.Item], refused: set[str]) -> tuple[list[s.Item], dict[int, str]]:
    """The lines with `If` blocks, and by the identity of an `EndIf` the label that was there."""
    lines: list[s.Item | None] = list(items)
    ends: dict[int, str] = {}
    # By identity, as equal `EndIf` lines are several.
    for name, places in jumping_ifs(items).values():
        if name + "Z" not in refused:
            ends[id(_put_block_words(lines, items, places))] = name + "Z"
    return [line for line in lines if line is not None], ends


def _put_block_words(
    lines: list[s.Item | None], items: Sequence[s.Item], places: Sequence[int]
) -> s.Line:
    """Puts the words of a block where the jumps stand; gives the line that ends it."""
    *branches, end = places
    for first in range(0, len(branches), 3):
        at, jump, after = branches[first : first + 3]
        test, goto = items[at], items[jump]
        if not isinstance(test, s.Line) or not isinstance(test.statement, s.If):
            continue
        condition = test.statement.condition
        opening: s.Statement = s.ElseIf(condition) if first else s.If(condition, None)
        lines[at] = replace(test, statement=opening)
        lines[at + 1] = lines[after] = None
        comment = goto.comment if isinstance(goto, s.Line) else None
        is_last = first + 3 == len(branches)
        # An empty `Else` is left out, unless its comment has to stay.
        if is_last and (after + 1 < end or comment is not None):
            lines[jump] = s.Line(statement=s.Command("Else"), comment=comment)
        else:
            lines[jump] = s.Line(comment=comment) if comment is not None else None
    closing = s.Line(statement=s.Command("EndIf"))
    lines[end] = closing
    return closing


# -------------------------------------------------------------------------------- Select


def _with_selects(items: Sequence[s.Item], ends: dict[int, str]) -> list[s.Item]:
    """The lines with such rows as blocks. ends: gets the last label of each, by its line."""
    lines = list(items)
    at = 0
    while at < len(lines):
        made = _select_at(lines, at, ends)
        if made is not None:
            lines = made
        at += 1
    return lines


def _select_at(lines: list[s.Item], at: int, ends: dict[int, str]) -> list[s.Item] | None:
    """All lines with the row that begins here as a block, None if none begins here."""
    aimed = _aim_of(lines[at])
    found = _FIRST_CASE_LABEL.fullmatch(aimed[1]) if aimed is not None else None
    if found is None:
        return None
    name = found[1]
    labels = lone_labels(lines)
    last = labels.get(name + "Z", -1)
    row = _case_row(lines, at, name)
    if row is None:
        return None
    cases, subject, after, default = row
    heads = [s.Line(statement=case, comment=comment) for case, comment in cases]
    if default is not None:
        heads.append(s.Line(statement=s.Command("Default"), comment=default.comment))
    names = [f"{name}C{number}" for number in range(1, len(heads) + 1)]
    starts = [labels.get(one, -1) for one in names]
    edges = [*starts, last]
    if sorted(edges) != edges or edges[0] < after:
        return None
    bodies: list[list[s.Item]] = []
    for low, high in pairwise(edges):
        if not jumps_to(lines[high - 1], name + "Z") or high - 1 <= low:
            return None
        bodies.append(lines[low + 1 : high - 1])
    first = lines[at]
    head = s.Line(statement=s.Select(subject))
    before, behind = lines[:at], lines[last + 1 :]
    # The variable that only the conversion needed is taken out again.
    match before[-1] if before else None:
        case s.Line(label=None, statement=s.Assign(target=held, value=value)) as line if (
            held == s.Variable("M" + name) == subject
        ):
            head = replace(line, statement=s.Select(value))
            before.pop()
    if head.span is None:
        head = replace(head, span=first.span)
    block: list[s.Item] = [head, *lines[after : starts[0]]]
    for case, body in zip(heads, bodies, strict=True):
        block += [case, *body]
    closing = s.Line(statement=s.Command("End Select"))
    # A jump from elsewhere to one of the labels needs that label, which a block does not have.
    outside = labels_named([*before, *behind])
    if not {name + "Z", *names}.isdisjoint(outside) or set(names).intersection(labels_named(block)):
        return None
    ends[id(closing)] = name + "Z"
    return [*before, *block, closing, *behind]


def _aim_of(item: s.Item) -> tuple[s.Expression | None, str] | None:
    """Return the target of a jump, in upper case, and its condition; None for any other line."""
    match item:
        case s.Line(label=None, statement=s.If(condition, s.Target(place=str() as place), None)):
            return condition, place.upper()
        case s.Line(label=None, statement=s.Jump("GoTo", s.Target(place=str() as place))):
            return None, place.upper()
    return None


_CaseRow = tuple[list[tuple[s.Case, str | None]], s.Expression, int, s.Line | None]


def _case_row(lines: Sequence[s.Item], at: int, name: str) -> _CaseRow | None:
    """The cases, what is selected by, the place behind the row, the jump to the default."""
    cases: list[tuple[s.Case, str | None]] = []
    subject: s.Expression | None = None
    for behind, line in enumerate(lines[at:], at + 1):
        aimed = _aim_of(line)
        if aimed is None or not isinstance(line, s.Line):
            return None
        condition, label = aimed
        following = f"{name}C{len(cases) + 1}"
        if condition is None:
            if subject is None or label not in (following, name + "Z"):
                return None
            return cases, subject, behind, line if label == following else None
        tested = _case_of(condition)
        if tested is None or (subject is not None and tested[0] != subject):
            return None
        subject, item = tested
        if cases and label == f"{name}C{len(cases)}" and line.comment is None:
            old, said = cases[-1]
            cases[-1] = s.Case((*old.items, item)), said
        elif label == following:
            cases.append((s.Case((item,)), line.comment))
        else:
            return None
    return None


def _case_of(condition: s.Expression) -> tuple[s.Expression, s.CaseRange | s.CaseIs] | None:
    match condition:
        case s.Binary("AND", s.Binary(">=", left, low), s.Binary("<=", right, high)) if (
            left == right
        ):
            return left, s.CaseRange(low, high)
        case s.Binary("=", left, value):
            return left, s.CaseRange(value)
        case s.Binary("<>" | "><" | "<" | "<=" | "=<" | ">" | ">=" | "=>" as operator, left, value):
            return left, s.CaseIs(operator, value)
    return None


# --------------------------------------------------------------------------------- Break


def _with_breaks(items: Sequence[s.Item], blocks: Blocks, ends: Mapping[int, str]) -> list[s.Item]:
    """Jumps behind the innermost block made `Break`, without labels that nothing goes to then.

    ends: labels that were at the end of a block, by the identity of the line that ends it.
    """
    leaving: dict[int, str] = {}
    below: dict[int, str] = {}
    labels = {at: name for name, at in lone_labels(items).items() if _BREAK_LABEL.fullmatch(name)}
    for block in blocks.all:
        if block.last is None or blocks.closing[block.last][-1] is not block:
            continue  # the `Next` of an outer loop as well
        label = ends.get(id(items[block.last]))
        if label is None and block.last + 1 in labels:
            label = below[block.last + 1] = labels[block.last + 1]
        if label is not None:
            leaving[block.first] = label
    made: list[s.Item] = []
    for at, item in enumerate(items):
        inner = blocks.around[at]
        label = leaving.get(inner.first) if inner is not None and at not in inner.parts else None
        made.append(item if label is None else _break_line(item, label))
    wanted = set(labels_named(made))
    return [item for at, item in enumerate(made) if below.get(at, "") in {"", *wanted}]


def _break_line(node: s.Item, label: str) -> s.Item:
    if not isinstance(node, s.Line):
        return node
    if jumps_to(node, label):
        return replace(node, statement=s.Command("Break"))
    if isinstance(node.statement, s.If) and node.statement.then is not None:
        branches = [
            s.Command("Break") if b == s.Jump("GoTo", s.Target(label)) else b
            for b in (node.statement.then, node.statement.otherwise)
        ]
        return replace(node, statement=s.If(node.statement.condition, *branches))
    return node
