"""A program in the form that its text is read back as: data, statements and expressions.

Truth values are numbers, and `not` is turned into its opposite: the language's own works on bits.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

from assistant.languages.legalisation import PartLegaliser
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.vendor_text import respelled_expression
from assistant.languages.melfa_basic.lower.statements import vendor_line
from assistant.languages.melfa_basic.tables.capabilities import motions, positions
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.tables.vocabulary.timers import MILLISECONDS
from assistant.languages.melfa_basic.text import printer
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.passes.expression_forms import (
    fixed_text,
    with_shift_parts,
    without_truth_values,
)
from assistant.program.passes.legalisation import Changes, Legalisation, Rewording
from assistant.program.passes.motions import ByValue
from assistant.program.passes.operator_texts import as_comment, plain_comment
from assistant.program.passes.signals import (
    check_fit,
    end_for_good,
    set_signal,
    wait_signal,
    wait_until,
)
from assistant.program.passes.switches import plain_switch
from assistant.program.passes.trigger_positions import (
    by_speed,
    constant_numbers,
    with_constant_values,
    with_ends_apart,
)
from assistant.program.program import Procedure, Program, Variable

if TYPE_CHECKING:
    from assistant.robots import Robot


class PlainProgram(Rewording):
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
                if places > 0:
                    self.job.findings.append(rules.ROUNDED_TEXT())
                return fixed_text(number, places)
            case e.Text(text):
                return self.text(text)
            case e.Verbatim():
                return respelled_expression(x, self.dialect)
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
        p.SetSignal: set_signal,
        p.WaitSignal: wait_signal,
        p.WaitUntil: wait_until,
        p.Switch: plain_switch,
        p.Stop: end_for_good,
        p.Comment: plain_comment,
        p.Message: as_comment,
        p.Opaque: opaque,
    }


def _seconds(milliseconds: e.Number) -> e.Number:
    return e.number_of(milliseconds.value / MILLISECONDS)
