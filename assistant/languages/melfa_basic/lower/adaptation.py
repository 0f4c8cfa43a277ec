"""Adaptation: the pseudo-program in a form that MELFA-BASIC can express, a finding for each change.

The result has the form that its text is read back as. Truths are numbers, and `not` becomes the
opposite comparison: the `Not` of the language works on bits. Channels get the numbers of files,
and ports of TCP/IP the communication lines that they are. Conditions that no step holds are
computed in several steps before the statement that asks. Vendor text of another dialect gets the
layout of this one, with the names that are written.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Protocol, TypeVar

from assistant.base.diagnostics import Declared, Diagnostic, Findings, Span, has_errors
from assistant.languages.computed_targets import with_computed_targets
from assistant.languages.language_types import Adapted
from assistant.languages.legalisation import PartLegaliser
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.convert.dialect_words import is_program_name
from assistant.languages.melfa_basic.lower.expressions import Expressions, Unsayable
from assistant.languages.melfa_basic.lower.names import Names, naming
from assistant.languages.melfa_basic.lower.program import UnitLines
from assistant.languages.melfa_basic.lower.statements import vendor_line
from assistant.languages.melfa_basic.reading.line import expression, statement
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.capabilities import capabilities, motions, positions
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.tables.variables import (
    ETHERNET_LINES,
    FILE_NUMBERS,
    LONGEST_FILE_NAME,
    MILLISECONDS,
    is_external,
    line_name,
)
from assistant.languages.melfa_basic.tables.vocabulary import function, status
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.step_numbers import steps_in
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program import undeclared_names
from assistant.program.analysis.io_use import channels_open_together, with_one_name
from assistant.program.analysis.motion_use import branches_by_frame
from assistant.program.analysis.uses import constant_numbers, shared_between_units
from assistant.program.geometry import BASE
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.passes.comments import (
    as_comment,
    comment_lines,
    plain_comment,
    with_blank_lines,
    with_comments_in_front,
)
from assistant.program.passes.expression_forms import (
    fixed_text,
    with_shift_parts,
    without_truth_values,
)
from assistant.program.passes.hoisted_statements import with_functions_before_moves
from assistant.program.passes.legalisation import (
    Changes,
    Legalisation,
    Pass,
    Rewording,
    legalise,
    pure,
    traced,
)
from assistant.program.passes.line_lengths import with_short_sums
from assistant.program.passes.loops import with_settled_loops
from assistant.program.passes.motions import ByValue
from assistant.program.passes.names import with_declared_names
from assistant.program.passes.parameters import with_sayable_procedures
from assistant.program.passes.positions import in_base
from assistant.program.passes.procedure_forms import (
    with_entry_first,
    with_fresh_variables,
    with_interrupts_first,
    with_units_together,
    without_recursion,
)
from assistant.program.passes.signals import (
    check_fit,
    end_for_good,
    wait_signal,
    wait_until,
    with_checked_outputs,
    with_few_pulses,
)
from assistant.program.passes.switches import plain_switch, with_single_reads
from assistant.program.passes.trigger_positions import (
    by_speed,
    with_constant_values,
    with_ends_apart,
    with_measured_places,
)
from assistant.program.passes.units import split
from assistant.program.passes.variables import (
    with_array_parameters,
    with_copied_arrays,
    with_filled_arrays,
    with_first_values,
    with_kept_values,
    with_taught_positions,
)
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.pseudo.expressions import expression_text
from assistant.program.rewriting import Body, map_bodies, records
from assistant.program.statement_index import statements_with_vendor_text

if TYPE_CHECKING:
    from assistant.robots import Robot


def _respelled_expression(value: e.Verbatim, dialect: Dialect) -> e.Verbatim:
    """The text as this dialect spells it, if it has all of it."""
    node = expression(value.text) if value.language in DIALECTS else None
    if node is None or not _dialect_has(node, dialect):
        return value
    return e.Verbatim(dialect.name, printer.expression(node, dialect.upper), effect=value.effect)


def _dialect_has(node: s.Expression, dialect: Dialect) -> bool:
    """True if the dialect has the functions, status variables and type marks of an expression."""
    for record in records(node):
        if isinstance(record, s.Variable):
            known = function(record.key) or status(record.key)
            if known is not None and dialect.level not in known.dialects:
                return False
        mark = record.suffix if isinstance(record, s.Variable | s.Number) else ""
        if mark not in ("", "$") and mark not in dialect.suffixes:
            return False
    return True


def _check_vendor_names(program: Program, names: Names, findings: Findings) -> None:
    """Complains of vendor text whose variables and labels are written under other names."""
    for procedure in program.procedures:
        for node, parts in statements_with_vendor_text(procedure):
            for kept in parts:
                if kept.language in DIALECTS:
                    read = statement if isinstance(kept, p.Opaque) else expression
                    renamed = sorted(set(_renamed_in_text(read(kept.text), procedure.name, names)))
                    if renamed:
                        with findings.at(node.span):
                            findings.append(rules.RENAMED_IN_TEXT(
                                text=kept.text, names=", ".join(f"`{name}`" for name in renamed)
                            ))  # fmt: skip


def _renamed_in_text(tree: s.Line | s.Expression | None, owner: str, names: Names) -> Iterator[str]:
    """Names in a text of a procedure, the owner, that are written otherwise elsewhere."""
    for node in records(tree):
        match node:
            case s.Variable(name=name) | s.FunctionParameter(name=name) | s.DefFunction(name=name):
                short = names.value(owner, name) if is_program_name(name) else None
            case s.Target(place=str() as name):
                short = names.label(owner, name.lstrip("*"))
            case _:
                continue
        if short is not None and short != name.lstrip("*").upper():
            yield name


class _PlainProgram(Rewording):
    """The parts of a program. constants: numbers of those that the procedure at hand sees."""

    def __init__(
        self, job: Legalisation, dialect: Dialect, robot: Robot | None, products: bool
    ) -> None:
        super().__init__(job)
        self.dialect, self.products, self.five_axes = dialect, products, job.can.five_axes
        self.written, self.motions = (
            PartLegaliser(job, positions(robot)),
            ByValue(job, motions(robot)),
        )
        self.constants: Mapping[str, e.Number] = {}
        origin = job.program.origin
        self.of_kin = origin is not None and origin.language in job.can.kin
        """True for a program of a dialect: what its controller makes of a value stays."""

    def program(self) -> Program:
        program, written = self.job.program, self.written
        for declaration in program.declarations:
            with self.job.findings.at(declaration.span):
                self.job.cannot(
                    what=f"the {declaration.language} declaration `{declaration.text[:40]}`",
                    cure="leave it out or say it in plain statements",
                )
        return replace(
            program,
            tools=written.tools(program.tools),
            frames=written.frames(program.frames),
            speeds={},
            blends={},
            targets=written.targets(program.targets),
            joint_targets=written.joint_targets(program.joint_targets),
            variables={n: self.variable(v, n) for n, v in program.variables.items()},
            procedures=tuple(map(self.procedure, program.procedures)),
        )

    def procedure(self, procedure: Procedure) -> Procedure:
        self.constants = constant_numbers(self.job.program, procedure)
        self.enter(procedure)
        body = self.body(procedure.body)
        # The end of a procedure returns anyway, and the text is read back without it.
        while body and body[-1] == p.Return():
            body = body[:-1]
        variables = {n: self.variable(v, n) for n, v in procedure.variables.items()}
        return replace(procedure, body=body, local=False, variables=variables)

    def variable(self, variable: Variable, name: str, owner: str = "") -> Variable:
        with self.job.findings.at(variable.span):
            return super().variable(variable, name, owner)

    def expression(self, x: e.Expression) -> e.Expression:
        match x:
            case e.Truth() | e.Unary():
                return without_truth_values(x)
            case e.Here(tool, frame):
                return self.here(e.Here(self.motions.tool(tool), self.motions.frame(frame)))
            # A timer is read back in seconds, so the comparison is brought to seconds as well.
            case e.Binary(operator, e.Binary("*", e.Elapsed() as timer, e.Number(1000)), limit) if (
                operator in e.RELATIONS and isinstance(limit, e.Number)
            ):
                return e.Binary(operator, timer, _seconds(limit))
            case e.Binary(operator, limit, e.Binary("*", e.Elapsed() as timer, e.Number(1000))) if (
                operator in e.RELATIONS and isinstance(limit, e.Number)
            ):
                return e.Binary(operator, _seconds(limit), timer)
            case e.Apply("relative" | "offset"):
                return with_shift_parts(x)
            case e.Apply("fixed", (number, e.Number(places))) if not math.isnan(places):
                # `Str$` writes no fixed number of decimals; the value is rounded instead.
                if places > 0:
                    self.job.findings.append(rules.ROUNDED_TEXT())
                return fixed_text(number, places)
            case e.Text(text):
                return self.text(text)
            case e.Verbatim():
                return _respelled_expression(x, self.dialect)
            case e.TargetValue(target):
                return e.TargetValue(self.written.target(target, "a target", "a target"))
            case e.JointValue(joints):
                what = "a joint target"
                return e.JointValue(self.written.joints(joints, what, what))
        return x

    def here(self, value: e.Here) -> e.Here:
        """The present position; an error in a frame that `Base` is not set to."""
        if value.frame != BASE and (self.products or self.five_axes is not None):
            how = "frames as products" if self.five_axes is None else "five axes"
            self.job.cannot(
                what=f"the present position in `{value.frame}`, with {how}",
                cure="write frames as base" if self.five_axes is None else "read it in the base",
            )
        return value

    def text(self, text: str) -> e.Text:
        """Without quotes, which end a text, and control characters."""
        plain = "".join(c if c.isprintable() else " " for c in text).replace('"', "'")
        if plain != text:
            self.job.findings.append(rules.TEXT_CHANGED(given=repr(text), text=repr(plain)))
        return e.Text(plain)

    def move(self, node: Any) -> Iterator[p.Statement]:
        joint = isinstance(node, p.MoveJoints) or getattr(node, "kind", "") == "joint"
        triggers = tuple(with_constant_values(one, self.constants) for one in node.triggers)
        motion = self.motions.motion(node.motion, joint)
        speed = motion.speed if isinstance(motion.speed, Speed) and not joint else None
        triggers = tuple(by_speed(self.job, one, speed) for one in triggers)
        for one in triggers:
            check_fit(self, one.signal, one.value)
        said = replace(node, motion=motion, triggers=triggers)
        if isinstance(motion.blend, p.ComputedBlend) and motion.blend.stops is not None:
            yield self._by_corner(said, motion.blend, motion.blend.stops)
        else:
            yield from with_ends_apart(self.job, said)

    def _by_corner(
        self, move: p.MoveStatement, blend: p.ComputedBlend, stops: e.Expression
    ) -> p.Statement:
        """A move that stops at its target or does not, whichever holds where it begins."""

        def ending(corner: Blend | p.ComputedBlend) -> tuple[p.Statement, ...]:
            one = replace(move, motion=replace(move.motion, blend=corner))
            return tuple(with_ends_apart(self.job, one))

        branch = p.Branch(stops, ending(FINE))
        return p.If((branch,), ending(replace(blend, stops=None)))

    def assign(self, node: p.Assign) -> Iterator[p.Statement]:
        yield node if self.of_kin else _by_comparison(node, node.value)

    def signal(self, node: p.SetSignal) -> Iterator[p.Statement]:
        check_fit(self, node.signal, node.value)
        yield node if self.of_kin else _by_comparison(node, node.value)

    def give_back(self, node: p.Return) -> Iterator[p.Statement]:
        chosen = node if self.of_kin or node.value is None else _by_comparison(node, node.value)
        if isinstance(chosen, p.If):
            yield replace(chosen, otherwise=())
            yield from chosen.otherwise
        else:
            yield chosen

    def call(self, node: p.Call) -> Iterator[p.Statement]:
        truths = [at for at, given in enumerate(node.arguments) if _compares(given)]
        if self.of_kin or len(truths) != 1:
            yield node
            return
        at = truths[0]
        one, zero = (
            replace(node, arguments=(*node.arguments[:at], e.Number(n), *node.arguments[at + 1 :]))
            for n in (1, 0)
        )
        yield p.If((p.Branch(node.arguments[at], (one,)),), (zero,), span=node.span)

    def follow(self, node: p.Follow) -> Iterator[p.Statement]:
        if len(node.path):
            yield replace(node, path=self.motions.path(self.written.path(node.path), node.row_span))

    def opaque(self, node: p.Opaque) -> Iterator[p.Statement]:
        """The vendor text in its canonical layout, if this language has it."""
        line = vendor_line(node, self.dialect)
        if line is not None:
            text = printer.line(line, self.dialect.upper)
            node = replace(node, language=self.dialect.name, text=text)
        yield node

    changes: ClassVar[Changes] = {
        p.Move: move,
        p.MoveCircular: move,
        p.MoveJoints: move,
        p.Follow: follow,
        p.Assign: assign,
        p.Return: give_back,
        p.Call: call,
        p.SetSignal: signal,
        p.WaitSignal: wait_signal,
        p.WaitUntil: wait_until,
        p.Switch: plain_switch,
        p.Stop: end_for_good,
        p.Comment: plain_comment,
        p.Message: as_comment,
        p.Opaque: opaque,
    }


_Giving = TypeVar("_Giving", p.Assign, p.Return, p.SetSignal)


def _by_comparison(node: _Giving, value: e.Expression) -> p.Statement:
    """A statement with 1 or 0 for a value that compares, as a choice between the two.

    No manual at hand states which number a comparison gives.
    """
    if not _compares(value):
        return node
    one, zero = (replace(node, value=e.Number(n)) for n in (1, 0))
    return p.If((p.Branch(value, (one,)),), (zero,), span=node.span)


def _compares(value: e.Expression) -> bool:
    """True for a comparison, and for a truth that is made of one."""
    match value:
        case e.Binary(operator, left, right) if operator in e.LOGICAL:
            return _compares(left) or _compares(right)
    return isinstance(value, e.Binary) and value.operator in e.RELATIONS


def _seconds(milliseconds: e.Number) -> e.Number:
    return e.number_of(milliseconds.value / MILLISECONDS)


def _with_channels(job: Legalisation) -> Program:
    """The program with numbered channels to lines and files."""
    program = job.program
    if not undeclared_names.channels(program):
        return program
    reworded = _NumberedChannels(job)
    procedures = tuple(map(reworded.procedure, program.procedures))
    made = replace(program, procedures=procedures)
    numbers = undeclared_names.numbered_channels(made, FILE_NUMBERS, channels_open_together)
    return undeclared_names.with_channels_renamed(
        made, {n: undeclared_names.name_of_channel(k) for n, k in numbers.items()}
    )


class _NumberedChannels(Rewording):
    """lines: those of channels that no line was stated for, by the channel's lower-case name."""

    def __init__(self, job: Legalisation) -> None:
        super().__init__(job)
        self.numbers = undeclared_names.numbered_channels(
            job.program, FILE_NUMBERS, channels_open_together
        )
        self.lines: dict[str, int] = {}
        self.told: set[str] = set()
        places = ((x.kind, x.place) for x in job.program.statements() if isinstance(x, p.Attach))
        self.taken = set[int]()
        for place in places:
            match place:
                case (("line" | "serial"), (e.Number(number),)):
                    self.taken.add(int(number))

    def attach(self, node: p.Attach) -> Iterator[p.Statement]:
        if node.channel.lower() not in self.numbers:
            self.job.cannot(f"more than {len(FILE_NUMBERS)} channels at once", "open fewer of them")
        match node.kind, node.place:
            case "file", (place,):
                yield p.Attach(node.channel, "file", (self.file(place),), node.mode)
            case "serial", (e.Number(number),):
                role = "is serial, as the other controller's is"
                self.tell(node.channel, int(number), role, 'COMDEV(n)="RS232" and its speed')
                yield p.Attach(node.channel, "line", node.place)
            case "server", (port, *_):
                role = f"listens at port {expression_text(port)}"
                yield self.line(node, role, "1", port)
            case "client", (host, port):
                role = f"connects to {expression_text(host)}, port {expression_text(port)}"
                where = f"0, NETHSTIP(n)={expression_text(host)}"
                yield self.line(node, role, where, port)
            case _:
                yield node

    def file(self, place: e.Expression) -> e.Expression:
        """Return the name of a file without its folder; the controller has no folders."""
        if not isinstance(place, e.Text):
            self.told_once(rules.FILE_NAMED(given=expression_text(place), name="that text"))
            return place
        # Folders of both kinds of separators, and a drive.
        name = place.value.replace("\\", "/").rpartition("/")[2].rpartition(":")[2].upper()
        if not 0 < len(name) <= LONGEST_FILE_NAME:
            what = (
                f"a file named `{place.value}`, whose name has not 1 to {LONGEST_FILE_NAME} letters"
            )
            self.job.cannot(what, "give it a shorter name")
        if name != place.value:
            self.told_once(rules.FILE_NAMED(given=place.value, name=f"`{name}`"))
        return e.Text(name)

    def line(self, node: p.Attach, role: str, mode: str, port: e.Expression) -> p.Statement:
        """A communication line for a port, with the parameters that make it one."""
        key = node.channel.lower()
        if key not in self.lines:
            free = (n for n in ETHERNET_LINES if n not in {*self.taken, *self.lines.values()})
            number = next(free, None)
            if number is None:
                self.job.cannot(f"more than {len(ETHERNET_LINES)} ports", "open fewer of them")
                return node
            self.lines[key] = number
        number = self.lines[key]
        parameters = 'COMDEV(n)="OPT1n", CPRCE1n=2, NETMODE(n)='
        parameters += f"{mode}, NETPORT({number + 1})={expression_text(port)}"
        self.tell(node.channel, number, role, parameters)
        return p.Attach(node.channel, "line", (e.Number(number),))

    def tell(self, channel: str, number: int, role: str, parameters: str) -> None:
        """parameters: with n for the number of the line."""
        # The letter `n` after `(` or `1`, as in `COMDEV(n)` and `OPT1n`: the number of the line.
        said = re.sub(r"(?<=[(1])n", str(number), parameters)
        com = line_name(number)
        self.told_once(rules.LINE(name=channel, com=com, role=role, parameters=said))

    def told_once(self, finding: Diagnostic) -> None:
        if finding.message not in self.told:
            self.told.add(finding.message)
            self.job.findings.append(finding)

    changes: ClassVar[Changes] = {p.Attach: attach}


_VARIABLE_ROOM: Final = 30
"""Bytes of a step that are left for the variable which the parts of a condition go to."""

_FEW_RECORDS: Final = 6
"""Records of a condition, its names and numbers among them: of two comparisons there are 7."""


def _with_short_conditions(
    program: Program, dialect: Dialect, robot: Robot | None, *, products: bool
) -> Program:
    """The program with a variable for each condition that is too long for a step.

    All parts are worked out in their order, as the one step would do it.
    """
    if not dialect.blocks or not any(map(_may_be_long, program.statements())):
        return program
    names = naming(program, dialect, products)
    said = Expressions(program, dialect, names, robot, lambda: names.position)
    taken = TakenNames((program.name, *program.variables, *program.signals, *program.targets))
    taken.update((*program.joint_targets, *program.tools, *program.frames))
    for q in program.procedures:
        taken.update((q.name, *q.variables, *(one.name for one in q.parameters)))
    # Room for the longest step number and its blank.
    most = dialect.line - len(f"{LAST_STEP} ")

    def fits(value: e.Expression, target: e.Name | None = None, /, *, more: int = 0) -> bool:
        try:
            step: s.Statement = s.If(said.of(value), None)
            room = _VARIABLE_ROOM + more
            if target is not None:
                step, room = s.Assign(said.place(target), said.of(value)), 0
        except Unsayable:
            return True  # which is told where it is written
        return len(printer.line(s.Line(statement=step), dialect.upper).encode()) + room <= most

    procedures = []
    for procedure in program.procedures:
        said.procedure = procedure
        procedures.append(_ConditionShortening(procedure, fits, taken).procedure())
    same = all(a is b for a, b in zip(procedures, program.procedures, strict=True))
    return program if same else replace(program, procedures=tuple(procedures))


def _may_be_long(node: p.Statement) -> bool:
    """True if a statement's condition or value is so large that its length needs a check."""
    match node:
        case p.If((p.Branch(asked), *_)) | p.Return(asked) | p.Assign(_, asked):
            return isinstance(asked, e.Binary) and sum(1 for _ in records(asked)) > _FEW_RECORDS
    return False


class _FitsStep(Protocol):
    """True if a condition fits into a step: as that of an `If`, or assigned to a variable.

    more: bytes that stand there as well.
    """

    def __call__(
        self, value: e.Expression, target: e.Name | None = None, /, *, more: int = 0
    ) -> bool: ...


class _ConditionShortening:
    """One procedure. taken: names, with those made here."""

    def __init__(self, owner: Procedure, fits: _FitsStep, taken: TakenNames) -> None:
        self.owner, self.fits, self.taken = owner, fits, taken
        self.new: dict[str, Variable] = {}

    def procedure(self) -> Procedure:
        body = self.body(self.owner.body)
        if not self.new:
            return self.owner
        return replace(self.owner, body=body, variables={**self.owner.variables, **self.new})

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            inner = map_bodies(node, self.body)
            match inner:
                case p.If((first, *others)):
                    asked = self.asked(first.condition, inner, made)
                    if asked is not None:
                        branches = (replace(first, condition=asked), *others)
                        inner = replace(inner, branches=branches)
                # A value that fits with its own target needs no room for a further variable.
                case p.Assign(e.Name() as target, value) if self.fits(value, target):
                    pass
                case p.Return(e.Binary() as value) | p.Assign(_, e.Binary() as value):
                    asked = self.asked(value, inner, made)
                    inner = inner if asked is None else replace(inner, value=asked)
            made.append(inner)
        return tuple(made)

    def asked(
        self, whole: e.Expression, node: p.Statement, made: list[p.Statement]
    ) -> e.Expression | None:
        """The variable that is asked instead of what is too long; None where nothing is to do."""
        match whole:
            case e.Binary("and" | "or" as word) if not self.fits(whole):
                parts = [*_chain_operands(whole, word)]
            case _:
                return None
        # Splitting helps only if each part fits alone.
        if not all(map(self.fits, parts)):
            return None
        name = identifier("condition", self.taken)
        self.taken.add(name)
        self.new[name] = Variable("truth")
        before: e.Expression | None = None
        # Fill each step with as many parts as fit; the order of evaluation stays.
        value, *left = parts
        for part in left:
            longer = e.Binary(word, value, part)
            # What a step goes on from stands in it too, where its value is chosen by an `If`.
            if self.fits(longer, more=0 if before is None else _VARIABLE_ROOM):
                value = longer
                continue
            made.append(_by_comparison_of(name, _joined_chain(word, before, value), node))
            before, value = e.Name(name), part
        made.append(_by_comparison_of(name, _joined_chain(word, before, value), node))
        return e.Name(name)


def _by_comparison_of(name: str, value: e.Expression, origin: p.Statement) -> p.Statement:
    return _by_comparison(p.Assign(e.Name(name), value, span=origin.span), value)


def _joined_chain(
    word: Literal["and", "or"], before: e.Expression | None, value: e.Expression
) -> e.Expression:
    """A chain of one operator behind what it goes on from."""
    match value:
        case _ if before is None:
            return value
        case e.Binary(operator, left, right) if operator == word:
            return e.Binary(word, _joined_chain(word, before, left), right)
    return e.Binary(word, before, value)


def _chain_operands(value: e.Expression, word: str) -> Iterator[e.Expression]:
    """Yield the operands of a chain of one operator, in order."""
    match value:
        case e.Binary(operator, left, right) if operator == word:
            yield from _chain_operands(left, word)
            yield right
        case _:
            yield value


def adapt(
    program: Program,
    robot: Robot | None,
    dialect_name: str,
    most_targets: int | None = None,
    products: bool = False,
) -> Adapted:
    """The program in this dialect's terms; idempotent.

    products: targets are multiplied by their frames, else `Base` is set.
    """
    dialect, findings = DIALECTS[dialect_name], Findings()
    program = replace(program, robot=robot.name if robot is not None else program.robot)
    job = Legalisation(program, capabilities(dialect, robot, most_targets), findings)
    comments = tuple(line for text in program.comments for line in comment_lines(text, job))
    job = replace(job, program=replace(program, comments=comments))
    job = replace(job, program=legalise(job, _FIRST_PASSES))
    plain = _PlainProgram(job, dialect, robot, products)
    job = replace(job, program=traced("sayable", plain.program()))
    adapted = legalise(job, _LAST_PASSES)
    adapted = _with_short_conditions(adapted, dialect, robot, products=products)
    if adapted.procedures and adapted.entry is None:
        findings.append(rules.NO_ENTRY(name=adapted.name))
    findings += _unshared_variables(adapted)
    findings += _too_long_names(adapted, dialect)
    names = naming(adapted, dialect, products)
    trees, wanting = _written_units(adapted, robot, dialect, names, findings)
    if plain.written.unstated:
        findings.append(rules.NO_CONFIGURATION(count=plain.written.unstated))
    if plain.motions.named:
        findings.append(rules.NAMED(count=plain.motions.named))
    # A program with errors is not written, so no file is taken for complete.
    trees = {} if has_errors(findings) else trees
    return Adapted(adapted, tuple(findings), trees, tuple(wanting))


_FIRST_PASSES: Final[tuple[Pass, ...]] = (
    _with_channels,
    pure(with_entry_first),
    with_taught_positions,
    with_kept_values,
    with_first_values,
    with_few_pulses,
    with_interrupts_first,
    with_single_reads,
    with_array_parameters,
    with_checked_outputs,
    pure(with_fresh_variables),
    with_filled_arrays,
    with_copied_arrays,
    pure(with_settled_loops),
    without_recursion,
    with_sayable_procedures,
    with_short_sums,
    with_measured_places,
    pure(with_functions_before_moves),
    pure(with_computed_targets),
    in_base,
    pure(with_declared_names),
    pure(with_one_name),
)
"""Variables, arrays, loops, procedures, places and targets as the dialects have them, in order."""

_LAST_PASSES: Final[tuple[Pass, ...]] = (
    split,
    pure(with_units_together),
    pure(with_comments_in_front),
    pure(with_blank_lines),
)
"""Plain statements, which paths become, as they stood."""


def _unshared_variables(program: Program) -> Iterator[Diagnostic]:
    """Variables that several programs use, which each of them would have for itself."""
    for name in shared_between_units(program):
        variable = program.variables[name]
        if variable.storage != "constant" and not is_external(name, variable):
            yield rules.LOCAL_DATA(name=name, about=Declared(name, "variables"))


def _too_long_names(program: Program, dialect: Dialect) -> Iterator[Diagnostic]:
    """External variables whose names, which stay, are longer than the controller takes."""
    for name, variable in program.variables.items():
        if is_external(name, variable) and len(name) > dialect.longest:
            about = Declared(name, "variables")
            yield rules.LONG_NAME(name=name, most=dialect.longest, about=about, span=variable.span)


def _written_units(
    program: Program, robot: Robot | None, dialect: Dialect, names: Names, findings: Findings
) -> tuple[dict[str | None, s.File], list[Diagnostic]]:
    """The units that can be written; what is found as they are is added to the findings.

    With them what is wanting, see `Adapted`.
    """
    trees: dict[str | None, s.File] = {}
    wanting: list[Diagnostic] = []
    _check_vendor_names(program, names, findings)
    if names.products:
        flags = branches_by_frame(program, partial(poses.flags_of, robot=robot))
        for name, branches in flags.items():
            if name != BASE and len(branches) > 1:
                about = Declared(name, "frames")
                findings.append(rules.SHARED_BRANCH(name=name, about=about))
    for unit in dict.fromkeys([None, *(q.unit for q in program.procedures)]):
        writing = UnitLines(program, dialect, names, robot, unit)
        code = writing.code()
        findings += writing.findings
        wanting += writing.wanting
        findings += _too_long_lines(code, dialect, writing.spans)
        if (count := steps_in(code)) > LAST_STEP:
            name, most = names.units[unit], LAST_STEP
            about = Declared(name)
            findings.append(rules.TOO_MANY_STEPS(name=name, count=count, most=most, about=about))
        if not has_errors(findings):
            trees[unit] = writing.tree(code)
    return trees, wanting


def _too_long_lines(
    code: Iterable[s.Item], dialect: Dialect, spans: Mapping[int, Span]
) -> Iterator[Diagnostic]:
    """Lines that a step cannot hold, such as long conditions. spans: see Writer."""
    most = dialect.line - len(f"{LAST_STEP} ")
    for item in code:
        if isinstance(item, s.Line) and (text := printer.line(item, dialect.upper)):
            length = len(text.encode("utf-8"))
            if length > most:
                place = text[:40] + "..."
                yield rules.LONG_LINE(
                    length=length, most=most, place=place, span=spans.get(id(item))
                )
