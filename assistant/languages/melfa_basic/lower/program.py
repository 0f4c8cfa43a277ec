"""An adapted program as the tree of one of its units: heading, code lines and position lines.

The heading comments hold what the code cannot express (see text.header). Vendor text depends on the
settings of the lines before it; lines that set an already active value again are omitted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from assistant.base.diagnostics import Declared, Refused
from assistant.languages.melfa_basic.lift.program import settings_already_set
from assistant.languages.melfa_basic.lift.settings import FRAME, TOOL, needed_settings
from assistant.languages.melfa_basic.lift.symbols import signal_comment, signal_names
from assistant.languages.melfa_basic.lower.expressions import joint_constant, position_constant
from assistant.languages.melfa_basic.lower.mounts import (
    are_unchanged_by_interrupts,
    mounted_once,
    walk_without_ends,
)
from assistant.languages.melfa_basic.lower.names import counted, mark, naming
from assistant.languages.melfa_basic.lower.statements import STATEMENTS, write_interrupt_answers
from assistant.languages.melfa_basic.lower.writer import Writer, marked
from assistant.languages.melfa_basic.reading.parser import statement as read_statement
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP
from assistant.languages.melfa_basic.tables.variables import (
    ARC_START,
    LETTERS,
    PARAMETERS,
    is_of_controller,
    parameter_position,
)
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.text.header import parameter_value
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.melfa_basic.tree.line_tables import gathered
from assistant.languages.step_numbers import with_ascending_steps
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.motion_use import branches_by_frame
from assistant.program.passes.procedure_forms import notes_and_body
from assistant.program.passes.variables import values_by_place
from assistant.program.program import Parameter, Procedure, Program, ValueType, Variable
from assistant.program.rewriting import head, records
from assistant.program.undeclared_names import interrupt_names, timers

if TYPE_CHECKING:
    from assistant.robots import Robot


_TYPES_WITHOUT_LETTER: Final[tuple[ValueType, ...]] = ("truth", "integer", "pose")
"""Types whose letter is that of another one."""


def heading(w: Writer) -> list[s.Item]:
    """The lines; the unit's code has been written already."""
    head, names, program = headers.Header(), w.names, w.program
    first, others = w.procedures()
    head.program, head.robot, head.unit = program.name, program.robot, w.unit
    if w.unit is None:
        head.entry = first.name if first else "-"
        units = dict.fromkeys(p.unit for p in program.procedures if p.unit is not None)
        head.names["unit"] = {names.units[u]: u for u in units}
        head.names["first"] = {
            names.units[u]: next(p.name for p in program.procedures if p.unit == u) for u in units
        }
    elif first is not None:
        head.names["first"] = {names.units[w.unit]: first.name}
    for procedure in others:
        short = names.procedures[procedure.name.lower()]
        head.names["procedure"][short] = procedure.name
        if procedure.result in _TYPES_WITHOUT_LETTER and w.functions:
            head.names["result"][short] = procedure.result
    head.names["timer"] = {
        str(names.timers[t.lower()]): t for t in timers(program) if t.lower() in names.timers
    }
    if w.unit is None:
        head.names["interrupt"] = interrupt_names(program, names.interrupts)
    _note_labels(w, head)
    for kind, table, given in _named_members(w):
        head.names[kind] = {table[n.lower()]: n for n in given}
    for word, _, number, name in counted(program, w.dialect, names.products):
        short = parameter_position(PARAMETERS[word].format(number=number))
        tool = word == "Tool"
        pose = program.tools[name].tip if tool else program.frames[name].pose
        head.there.append(parameter_value(short, poses.plain_values(pose)))
    for owner, name, variable in w.variables():
        short = names.variables[owner, name.lower()]
        head.variables[short] = _declared_variable(w, owner, name, variable)
    head.signals = dict(program.signals)
    head.arc_start = any(
        isinstance(item, s.Line)
        and isinstance(item.statement, s.Assign)
        and item.statement.target.key == ARC_START
        for item in w.items
    )
    head.products = names.products
    inline = w.expressions.inline
    head.paths = [(k, k + len(p) - 1, p.name) for k, p in w.paths if len(p)]
    numbers = [f"P{k}" for k, _ in inline.positions] + [f"J{k}" for k, _ in inline.joints]
    head.inline = dict.fromkeys(numbers)
    above = program.comments if w.unit is None else ()
    texts = [*above, *headers.header_lines(head, w.dialect.name)]
    return [s.Line(comment="' " + text if text else "'") for text in texts]


def _named_members(w: Writer) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Kind, names and members of the declared things that this unit holds."""
    p, n, used = w.program, w.names, w.used
    for kind, table, given in (
        ("target", n.targets, p.targets),
        ("joints", n.joints, p.joint_targets),
        ("tool", n.tools, p.tools),
        ("frame", n.frames, p.frames),
    ):
        yield kind, table, [m for m in given if w.unit is None or table[m.lower()] in used]


def _declared_variable(
    w: Writer, owner: str, name: str, variable: Variable | Parameter
) -> headers.Declared:
    procedure = w.program.procedure(owner)
    whose = "" if procedure is None else procedure.name
    if isinstance(variable, Parameter):
        extents = (0,) * variable.dimensions
        return headers.Declared(name, variable.type, "parameter", whose, size=extents)
    return headers.Declared(
        name, variable.type, variable.storage, whose,
        variable.local, variable.initial is not None and not _is_listed(variable), variable.size,
        _is_listed(variable),
    )  # fmt: skip


def _is_listed(variable: Variable) -> bool:
    """True for an array whose values are in the list of positions: others are assigned theirs."""
    return bool(variable.size) and variable.initial is not None


def _note_labels(w: Writer, head: headers.Header) -> None:
    mine = {p.name.lower() for p in w.program.procedures if p.unit == w.unit}
    for (owner, _), short in w.names.labels.items():
        original = w.names.original_labels[short]
        if owner in mine and short != original:
            head.names["label"][short] = original
    for (owner, _), short in w.names.loops.items():
        if owner in mine:
            head.names["loop"][short] = w.names.original_loops[short]


def settings_for_vendor_text(program: Program) -> frozenset[int]:
    """Return the settings, by number, that vendor text of a program in one unit depends on.

    The result is empty for several units, because the changes by other units are unknown. It has
    tool and base only for a program that was read in MELFA-BASIC: without a line for them the
    controller's own values apply there; a program from elsewhere has none.
    """
    found: frozenset[int] = frozenset()
    if any(procedure.unit is not None for procedure in program.procedures):
        return found
    for node in program.statements():
        texts = list(_vendor_texts(node))
        for text in texts:
            line = read_statement(text)
            if line is not None and line.statement is not None:
                found |= needed_settings(line.statement)
        if texts and any(isinstance(part, e.Here) for part in records(head(node))):
            found |= {TOOL, FRAME}  # the statement is one line with the text
    read = program.origin is not None and program.origin.language in DIALECTS
    return found if read else found - {TOOL, FRAME}


def _is_plain(program: Program) -> bool:
    """True if only the lines of moves and calls depend on tool and base, and set them.

    False for several units, whose calls may change them, and with stops that the program continues
    after: somebody may set another tool there, or write lines in place of what a draft lacks.
    """
    if any(procedure.unit is not None for procedure in program.procedures):
        return False
    if any(True for node in program.statements() for _ in _vendor_texts(node)):
        return False
    return are_unchanged_by_interrupts(program) and not any(
        isinstance(node, p.Stop)
        for procedure in program.procedures
        for node in walk_without_ends(procedure.body)
    )


def _vendor_texts(node: p.Statement) -> Iterator[str]:
    """The texts that a statement keeps, as statements."""
    for part in records(head(node)):
        if isinstance(part, p.Opaque) and part.language in DIALECTS:
            yield part.text
        elif isinstance(part, e.Verbatim) and part.language in DIALECTS:
            # An assignment makes a statement of the expression, which the reader takes.
            yield f"M1={part.text}"


_DEFINITION_WORDS: Final[dict[ValueType, str]] = {
    "number": "Float", "truth": "Float", "integer": "Inte", "text": "Char",
    "position": "Pos", "pose": "Pos", "joints": "Jnt",
}  # fmt: skip
"""The word after `Def` for variables that all Functions of a file share. A truth has the type of
undefined variables, as parameters do: an argument by reference must have the same type.
"""


def build(
    program: Program,
    robot: Robot | None,
    unit: str | None,
    dialect_name: str,
    products: bool = False,
) -> s.File:
    """Build the tree of one unit; raises Refused with findings for constructs without equivalent.

    products: targets are multiplied by their frames, else `Base` is set.
    """
    dialect = DIALECTS[dialect_name]
    lines = UnitLines(program, dialect, naming(program, dialect, products), robot, unit)
    code = lines.code()
    findings = [f for f in lines.findings if f.severity == "error"]
    if findings:
        raise Refused(*findings)
    return lines.tree(code)


class UnitLines(Writer):
    """The code lines and the variable lines of a unit."""

    write = STATEMENTS

    def code(self) -> list[s.Item]:
        """The code lines without step numbers."""
        first, others = self.procedures()
        if first is None and not others:
            self.definitions()
            self.initial_values()
            return [*heading(self), *self.items] if self.has_heading() else []
        if self.functions:
            self.as_functions(first, others)
        else:
            self.as_subroutines(first, others)
        if first is not None and not self.remounts and _is_plain(self.program):
            self.items = mounted_once(self.program, self.items, self.parts, self.settings)
        self.name_signals()
        return [*heading(self), *self.items]

    def name_signals(self) -> None:
        """Write the names of signals behind the lines that address them by number."""
        known = signal_names(self.program.signals)
        items, self.items = self.items, []
        for item in items:
            self.items.append(item)
            if not isinstance(item, s.Line):
                continue
            names = p.Comment(signal_comment(item.statement, known))
            if names.text and item.comment is None:
                self.behind(len(self.items) - 1, names)
            elif names.text and item.comment == marked(names):
                # A comment of the source would not be read back from the end of this line.
                plain = self.replaced(item, replace(item, comment=None))
                self.items[-1:] = [s.Line(comment=item.comment), plain]

    def tree(self, code: list[s.Item]) -> s.File:
        """The file of its code lines, which it gave before, and its variable lines."""
        data = list(gathered(list(self.data())))
        depended = settings_for_vendor_text(self.program)
        if depended:
            code = self._without_settings_that_hold(code, data, depended)
        steps = gathered(with_ascending_steps(code, self.dialect.step, LAST_STEP))
        return s.File(self.dialect.name, (*steps, *data))

    def _without_settings_that_hold(
        self, code: list[s.Item], data: Sequence[s.Item], depended: frozenset[int]
    ) -> list[s.Item]:
        """Return the lines without those that set an already active value, for settings that vendor
        text depends on.

        Otherwise such a text would depend on the line written for a move, no longer on its original
        line.
        """
        tree = s.File(self.dialect.name, (*code, *data))
        # By identity: other lines that look alike set something.
        again = self.settings.intersection(map(id, settings_already_set(tree, depended)))
        return [item for item in code if id(item) not in again]

    def as_subroutines(self, first: Procedure | None, others: list[Procedure]) -> None:
        """The first procedure, and what it calls behind its end."""
        if first is not None and first.parameters:
            self.add(s.FPrm(tuple(self.variable(first, q) for q in first.parameters)))
        self.definitions()
        self.initial_values()
        if first is not None:
            self.enter(first)
            self.body(first.body)
        self.add(s.Command("End"))
        write_interrupt_answers(self)
        for procedure in others:
            self.label(self.names.procedures[procedure.name.lower()])
            self.enter(procedure)
            self.body(procedure.body)
            if procedure.parameters or procedure.result is not None:
                self.cannot(f"parameters or the result of `{procedure.name}`", "use variables")
            self.add(s.Command("Return"))

    def as_functions(self, first: Procedure | None, others: list[Procedure]) -> None:
        """Write the definitions that all Functions share, the entry as `Main`, and the others."""
        self.definitions()
        for procedure in [*([first] if first else []), *others]:
            notes, body = notes_and_body(procedure.body)
            self.body(notes)
            self.add(self.head(procedure, procedure is first))
            if procedure is first:
                self.initial_values()
            self.enter(procedure)
            self.body(body)
            # Control must not run on into the lines of the interrupts.
            if self.answers:
                self.add(s.Command("End"))
                write_interrupt_answers(self)
            self.add(s.Command("FEnd"))

    def head(self, procedure: Procedure, main: bool) -> s.Function:
        name = "Main" if main else self.names.procedures[procedure.name.lower()]
        letter = "V" if procedure.result is None else LETTERS[procedure.result]
        suffix = "$" if procedure.result == "text" else ""
        parameters = []
        for q in procedure.parameters:
            variable = self.variable(procedure, q)
            mode: Literal["ByVal", "ByRef"] = "ByVal" if q.mode == "in" else "ByRef"
            whole = q.dimensions > 0
            parameters.append(s.FunctionParameter(mode, variable.name, variable.suffix, whole))
        return s.Function(letter + suffix, name, "", tuple(parameters))

    def variable(self, procedure: Procedure, parameter: Parameter) -> s.Variable:
        short = self.names.variables[procedure.name.lower(), parameter.name.lower()]
        return _variable_named(short)

    def has_heading(self) -> bool:
        """True if a file without code needs a heading."""
        told = self.program
        data = told.targets, told.joint_targets, told.tools, told.frames, told.variables
        return any(map(bool, (*data, told.signals, told.comments)))

    def definitions(self) -> None:
        """Write the definitions of typed variables and arrays, by type in the order of the heading.

        Functions see only those variables of others that are defined before them.
        """
        lines: dict[str, list[s.Variable]] = {}
        arrays = []
        for owner, name, variable in self.variables():
            if not isinstance(variable, Variable):
                continue
            whole = _variable_named(self.names.variables[owner, name.lower()])
            if is_of_controller(whole.name):
                continue
            shared = not owner or variable.initial is not None  # which it gets in the first one
            if variable.size:
                extents = tuple(s.Number(n) for n in variable.size)
                arrays.append(s.Dim((replace(whole, arguments=extents),)))
            elif variable.type == "integer" or (self.functions and shared):
                lines.setdefault(_DEFINITION_WORDS[variable.type], []).append(whole)
        for word, variables in lines.items():
            for at in range(0, len(variables), _MOST_DEFINED):
                self.add(s.DefNames(word, tuple(variables[at : at + _MOST_DEFINED])))
        for dim in arrays:
            self.add(dim)

    def initial_values(self) -> None:
        """First values of the variables, in the order of the heading."""
        for owner, name, variable in self.variables():
            if not isinstance(variable, Variable) or _is_listed(variable):
                continue
            if variable.initial is not None:
                whole = _variable_named(self.names.variables[owner, name.lower()])
                of = next((q for q in self.program.procedures if q.name.lower() == owner), None)
                about = Declared(name, "variables", of.name if of else "", in_full=True)
                with self.findings.at(variable.span), self.saying(about):
                    self.add(s.Assign(whole, self.expressions.of(variable.initial)))

    # ---------------------------------------------------------------------------- data

    def data(self) -> Iterator[s.Item]:
        """The variable lines: named positions first, then those of the paths."""
        for kind, table, members in _named_members(self):
            for name in members:
                if table[name.lower()] in self.names.numbers:
                    continue
                yield s.Data(s.Variable(table[name.lower()]), self._constant(kind, name))
        yield from self._elements()
        inline = self.expressions.inline
        for number, target in inline.positions:
            yield s.Data(s.Variable(f"P{number}"), position_constant(target, self.robot))
        for number, joints in inline.joints:
            yield s.Data(s.Variable(f"J{number}"), joint_constant(joints, self.robot))
        for first, path in self.paths:
            yield PositionRows(
                "P",
                first + np.arange(len(path), dtype=np.int64),
                poses.to_values(path.positions, path.quaternions, path.external, self.robot),
                poses.flags_of(path.configurations, self.robot),
            )

    def _elements(self) -> Iterator[s.Data]:
        """A line for each element of the arrays that are listed."""
        for owner, name, variable in self.variables():
            if not isinstance(variable, Variable) or not _is_listed(variable):
                continue
            short = self.names.variables[owner, name.lower()]
            for place, value in values_by_place(variable):
                element = s.Variable(short, "", tuple(map(s.Number, place)))
                if isinstance(value, e.TargetValue):
                    yield s.Data(element, position_constant(value.target, self.robot))
                elif isinstance(value, e.JointValue):
                    yield s.Data(element, joint_constant(value.target, self.robot))

    def _constant(self, kind: str, name: str) -> s.Constant:
        program = self.program
        if kind == "target":
            return position_constant(program.targets[name], self.robot)
        if kind == "joints":
            return joint_constant(program.joint_targets[name], self.robot)
        if kind == "tool":
            return s.Constant(poses.plain_values(program.tools[name].tip), (0, 0))
        pose = program.frames[name].pose
        if not self.names.products:
            return s.Constant(poses.plain_values(pose.inverse()), (0, 0))
        # The product takes its flags from the frame, so they have to be those of its targets.
        flags = branches_by_frame(program, partial(poses.flags_of, robot=self.robot))
        first, second = next(iter(flags.get(name.lower(), ())), _USUAL_FLAGS)
        return s.Constant(poses.plain_values(pose), (first, second))


_USUAL_FLAGS: Final = (7, 0)
"""Flags of most positions: right, above, not flipped."""
_MOST_DEFINED: Final = 8
"""Names of one `Def` line."""


def _variable_named(short: str) -> s.Variable:
    return s.Variable(short, mark(short))
