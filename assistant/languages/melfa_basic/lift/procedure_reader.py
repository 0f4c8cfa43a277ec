"""Reader of the procedures of one file, once for each form that settings give them.

A form is a procedure under the settings of one path that leads to it. The result is a list of
statements: notes, labels, paths of moves, blocks, and the result of a function.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.base.diagnostics import Span
from assistant.languages import vendor_statements
from assistant.languages.melfa_basic.lift import simple_statements
from assistant.languages.melfa_basic.lift.paths import Values
from assistant.languages.melfa_basic.lift.procedures import Region
from assistant.languages.melfa_basic.lift.settings import (
    FRAME,
    TCP,
    TOOL,
    mount_text,
    setting_number,
    with_followed_settings,
)
from assistant.languages.melfa_basic.lift.statements import COMMAND_LIFTS, STATEMENT_LIFTS, Control
from assistant.languages.melfa_basic.tables.variables import ARC_START
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.control_flow import labels_of
from assistant.languages.settings_flow import UNKNOWN
from assistant.languages.settings_forms import Form, PassLabels
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import TakenNames, identifier, last_statement
from assistant.program.rewriting import head, records


class Reader(Control):
    """Reads the procedures of one file.

    own_labels: those of the lines that are read, upper case → name.
    """

    lifts, commands = STATEMENT_LIFTS, COMMAND_LIFTS
    names: PassLabels | None = None
    own_labels: Mapping[str, str]

    # ---------------------------------------------------------------------- procedures

    def read(self, form: Form) -> tuple[p.Statement, ...]:
        """The body of a procedure as it is called in one way."""
        self.form, region = form, self.regions[form.procedure]
        self.region = region
        self.runs.previous, self.runs.arc_pending = None, False
        made: list[p.Statement] = []
        for at in range(*region.notes):
            made += self.note(at)
        if form.passes:
            made += self.in_passes(form)
        else:
            self._take_labels(region)
            if region.before[1] > 0:
                made += self.statements(*region.before)
            made += self.statements(region.low, region.high)
        made += self.ending(region)
        return tuple(made)

    def _take_labels(self, region: Region) -> None:
        taken = TakenNames()
        self.label_names = {}
        for low, high in (region.before, (region.low, region.high)):
            for label in sorted(labels_of(self.code, range(low, high))):
                given = self.symbols.header.names["label"].get(label)
                name = given or identifier(self._spelled(label), taken)
                self.label_names[label] = name
                taken.add(name)
        self.own_labels = self.label_names

    # Each pass is a part of the procedure under its settings, with its own labels.
    def in_passes(self, head: Form) -> list[p.Statement]:
        """The statements of a divided procedure."""
        order = head.in_order()
        self.names = PassLabels(order, self._labels)
        made: list[p.Statement] = []
        for one, below in zip(order, (*order[1:], None), strict=True):
            self.form, self.runs.arc_pending = one, False
            self.runs.forget()
            self.own_labels = self.names.of(one)
            # names made for blocks are unique among all passes
            self.label_names = {f"**{n}": n for n in self.names.taken} | self.own_labels
            high = one.places[-1] + 1
            made += self.statements(one.places[0], high)
            self.names.taken.update(self.label_names.values())
            if _never_continues(made) or one.falls is below:
                continue
            if one.falls is not None:
                made.append(p.Goto(self._label_at(one.falls)))
            elif high == self.region.high:
                made.append(self.result_returned())
        self.form = head
        return made

    def _labels(self, one: Form) -> dict[str, str]:
        return {key: self._spelled(key) for key in sorted(labels_of(self.code, one.places))}

    def _label_at(self, one: Form) -> str:
        label = self.code[one.places[0]].label
        assert self.names is not None and label is not None
        return self.names.of(one)[label.upper()]

    def _spelled(self, label: str) -> str:
        return self.code[self.labels[label]].label or label

    def ending(self, region: Region) -> list[p.Statement]:
        """Return the statements after a body: the comment of its last word, and a stored result."""
        made: list[p.Statement] = []
        if region.high < len(self.code) and self.code[region.high].statement in _BODY_ENDS:
            made += self.note(region.high)
        for at in range(*region.behind):
            made += self.note(at)
        returned = self.result_returned()
        if returned.value is not None:
            made.append(returned)
        return made

    def result_returned(self) -> p.Return:
        """The way back to the caller, with a result that was kept."""
        inside = self.symbols.inside
        result = None if inside is None else inside.result
        return p.Return(None if result is None else e.Name(result))

    def body(self, low: int, high: int) -> tuple[p.Statement, ...]:
        # A block may be entered and left on several ways, so where the robot is is not known.
        self.runs.forget()
        made = tuple(self.statements(low, high))
        self.runs.forget()
        return made

    def statements(self, low: int, high: int) -> list[p.Statement]:
        """The statements of a range of the code."""
        made: list[p.Statement] = []
        at = low
        while at < high:
            at = self.entry(at, high, made)
        self.runs.flush(made)
        return made

    # ---------------------------------------------------------------------------- a line

    def enter(self, at: int) -> Values:
        """Sets what holds where a line begins."""
        self.at = at
        values = self.values
        self.symbols.placing = values[TOOL], values[FRAME]
        told = with_followed_settings(values, self.followed)
        self.symbols.placing_told = mount_text(told[TOOL]), mount_text(told[FRAME])
        self.symbols.speed = mount_text(told[TCP])
        assert self.form is not None
        called = self.form.called.get(at, {}).items()
        functions = ((self.regions[callee].function, made.name) for callee, made in called)
        self.symbols.variants = {f.name.upper(): name for f, name in functions if f is not None}
        # Jumps from this line lead to the pass that has its settings.
        for to in self.form.goes.get(at, {}).values():
            label = self.code[to.places[0]].label
            if label is not None:
                self.label_names[label.upper()] = self._label_at(to)
        return values

    def entry(self, at: int, high: int, made: list[p.Statement]) -> int:
        """Reads one entry, or a whole block; gives the place after it."""
        item = self.code[at]
        values = self.enter(at)
        if isinstance(item, MoveRows):
            self.runs.rows(item, values, made)
            return at + 1
        # A comment stays at its place, so the path of moves ends before it.
        if item.comment is not None:
            self.runs.flush(made)
            text = simple_statements.comment_text(item.comment)
            if isinstance(item.statement, s.Const):
                # Declared elsewhere, it would leave its comment to the statement below.
                text = f"{item.statement.variable.name}: {text}"
            if item.statement is not None or text not in self.path_notes:
                made.append(p.Comment(text, span=item.span))
        # A wait takes several lines, so the check for it precedes that for the first line alone.
        found = simple_statements.wait_at(self.code, at, high, self.expressions, self.named)
        if found is not None:
            self.runs.flush(made)
            made.append(simple_statements.with_span(found[0], item.span))
            return found[1]
        if item.label is not None:
            self.runs.flush(made)
            self.runs.forget()
            made.append(p.Label(self.own_labels[item.label.upper()], span=item.span))
        if item.statement is None or self.absorbed(item.statement, at):
            return at + 1
        if isinstance(item.statement, s.Motion):
            if self.runs.motion(item.statement, values, item.span, made):
                return at + 1
        self.runs.flush(made)
        after = self.block(at, high, made) or self.result(at, item.statement, made)
        if after:
            return after
        made += self.one(item.statement, at, item.span)
        return at + 1

    def absorbed(self, node: s.Statement, at: int) -> bool:
        """Takes in what only the moves that follow say: their settings, where an arc begins."""
        if isinstance(node, s.Assign) and node.target.key == ARC_START:
            here = isinstance(node.value, s.Variable) and node.value.key == "P_CURR"
            self.runs.arc_pending = here
            return here
        effect = self.effect(node)
        made = effect is not None and (isinstance(node, s.Command) or effect[1] is not UNKNOWN)
        return made and at not in self.kept

    def one(self, node: s.Statement, at: int, span: Span | None) -> list[p.Statement]:
        """Lift a statement that is not a block, or return it as vendor text."""
        if at in self.kept and not isinstance(node, s.If):
            told = self.expressions.told(lambda: self.simple(node))
            lost = told is None and setting_number(node) in self.followed
            reason = None if lost else vendor_statements.DEPENDED_ON
            lifted: list[p.Statement] = [self.opaque(node, reason, told or ())]
        else:
            lifted = self.or_text(node, lambda: self.simple(node), self.refused.get(at))
        # An expression that stays vendor text depends on the settings as a statement does.
        if not isinstance(node, s.Motion) and _has_vendor_expression(lifted):
            self.note_dependence(node)
        return [simple_statements.with_span(statement, span) for statement in lifted]

    # ------------------------------------------------------------------------- functions

    def result(self, at: int, node: s.Statement, made: list[p.Statement]) -> int:
        """Lift the result of a function, and the exit after it; return the place after both, or
        0.
        """
        inside = self.symbols.inside
        if inside is None or not isinstance(node, s.Assign) or node.target.key != inside.key:
            return 0
        if node.target.arguments is not None or node.target.component:
            return 0
        value = self.expressions.of(node.value)
        span = self.code[at].span
        if inside.result is not None:
            made.append(p.Assign(e.Name(inside.result), value, span=span))
            return at + 1
        made.append(p.Return(value, span=span))
        after = at + 1
        if after < self.region.high:
            made += self.note(after)
            after += 1  # `Exit Function`
        return after


_BODY_ENDS: Final = (s.Command("End"), s.Command("Return"), s.Command("FEnd"))


def _has_vendor_expression(statements: list[p.Statement]) -> bool:
    return any(isinstance(part, e.Verbatim) for node in statements for part in records(head(node)))


def _never_continues(body: list[p.Statement]) -> bool:
    """True if control never continues below the last statement."""
    last = last_statement(body)
    if isinstance(last, p.Opaque):
        return last.text.strip().lower() == "end"
    return isinstance(last, p.Goto | p.Return)
