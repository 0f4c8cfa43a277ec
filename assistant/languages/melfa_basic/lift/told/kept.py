"""Texts that stay in MELFA-BASIC, and what their statements are to other languages."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Findings
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lift.told.signals import (
    HAND_STATEMENTS,
    AnyNumber,
    NumberedSignals,
)
from assistant.languages.melfa_basic.lift.told.supplied import LibraryProcedures
from assistant.languages.melfa_basic.lift.told.turned import with_turned_positions
from assistant.languages.melfa_basic.lift.values.pallets import ANGLE_DIVIDING
from assistant.languages.melfa_basic.lift.values.symbols import SIGNAL_VARIABLES, VENDOR_ONLY_NAME
from assistant.languages.melfa_basic.tables.library import library
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import Body, head, map_bodies, map_expressions, map_head, records

STATE_EQUIVALENTS: Final[Mapping[str, tuple[str, e.Expression, str, str]]] = {
    "M_SVO": (
        "M_Svo", e.Number(1),
        "the motors are taken to be on, as a program of the other controller only runs then",
        "none is needed",
    ),
    "M_OPOVRD": (
        "M_OPovrd", e.Number(100),
        "the speed that the operator has set on the panel is taken to be 100 %",
        "let the program ask for it as the other controller tells it, if it has to make up for it",
    ),
}  # fmt: skip
"""States of the controller: as they are written, what they are elsewhere, what is lost, a cure."""
OVERRIDE_STATUS: Final = "M_OVRD"
"""The percentage of speed that `Ovrd` has set."""
_DIVIDED_ANGLES: Final = (
    "the angles of its places are divided between its corners, as the manual CR1D states alone"
)
_UNDIVIDED_CURE: Final = "teach all corners with one posture, or give direction 11, 12 or 13"
_VENDOR_ONLY_PREFIX: Final = VENDOR_ONLY_NAME.format("")


def with_told(program: Program, findings: Findings) -> Program:
    """The program with other words for texts, where there are some; tells what they leave out."""
    if not any(
        isinstance(one, e.Verbatim | p.Opaque) and one.told for one in records(program.procedures)
    ):
        return program
    telling = _VendorLowering(NumberedSignals(program, findings), findings)
    procedures = tuple(map(telling.procedure, program.procedures))
    program = telling.numbered.added(replace(program, procedures=procedures))
    if telling.override:
        program = _with_override(program, telling.override)
    if telling.held:
        variables = {**program.variables, telling.held: Variable("position")}
        program = replace(program, variables=variables)
    return telling.supplied.added(program)


def _with_override(program: Program, name: str) -> Program:
    """With a variable that each statement sets which sets the percentage, and a cycle's begin."""

    def body(statements: Body) -> Body:
        return tuple(made for one in statements for made in told(map_bodies(one, body)))

    def told(one: p.Statement) -> Body:
        if isinstance(one, p.SetOverride):
            return one, p.Assign(e.Name(name), one.percent, span=one.span)
        return (one,)

    full = e.Number(100)
    begun: Body = (p.Assign(e.Name(name), full),)
    procedures = tuple(
        replace(one, body=(*(begun if one.name == program.entry else ()), *body(one.body)))
        for one in program.procedures
    )
    variables = {**program.variables, name: Variable("number", full)}
    return replace(program, procedures=procedures, variables=variables)


class _VendorLowering:
    """The procedures of a program."""

    def __init__(self, numbered: NumberedSignals, findings: Findings) -> None:
        self.numbered, self.findings = numbered, findings
        self.supplied = LibraryProcedures(numbered.free)
        self.held = self.override = ""
        self.divided = False

    def procedure(self, procedure: Procedure) -> Procedure:
        def told(x: e.Expression) -> e.Expression:
            match x:
                case e.Verbatim(told=meant) if meant is not None:
                    try:
                        return map_expressions(meant, told)
                    except AnyNumber:
                        return x
                case e.Apply(function, given) if function.startswith(_VENDOR_ONLY_PREFIX):
                    return self._state(function.removeprefix(_VENDOR_ONLY_PREFIX), given, procedure)
            return x

        def body(statements: Body) -> Body:
            return tuple(one for node in statements for one in said(node))

        def inside(node: p.Statement) -> p.Statement:
            """A statement with what it holds, in which a loop counts through known numbers."""
            counting = self.numbered.counting
            if isinstance(node, p.For):
                self.numbered.counting = (*counting, node)
            made: p.Statement = map_bodies(node, body)
            self.numbered.counting = counting
            return made

        def said(node: p.Statement) -> Body:
            with self.findings.at(node.span):
                made = node.told if isinstance(node, p.Opaque) and node.told else (node,)
                if made != (node,) and (loss := _lost_effects(node, made)) is not None:
                    what, cure = loss
                    text = getattr(node, "text", "").strip()
                    self.findings.append(rules.LEFT_OUT(what=text, loss=what, cure=cure))
                try:
                    made = tuple(whole(one, node, told) for one in made)
                except AnyNumber:
                    made = (node,)
                turned = with_turned_positions(made, self._held)
                made = (node,) if turned is None else turned
                if any(map(_counts_axis, made)):
                    self.findings.append(rules.SLIDES())
                return tuple(map(inside, made))

        def whole(
            node: p.Statement, origin: p.Statement, change: Callable[[e.Expression], e.Expression]
        ) -> p.Statement:
            node = map_head(replace(node, span=origin.span), change)
            match node:
                case p.Call(name, (hand,)) if (
                    name.removeprefix(_VENDOR_ONLY_PREFIX) in HAND_STATEMENTS
                ):
                    key = name.removeprefix(_VENDOR_ONLY_PREFIX)
                    gripped = self.numbered.gripped(key, hand, procedure, origin)
                    return replace(gripped, span=origin.span)
                case p.Call(name, given) if name.startswith(_VENDOR_ONLY_PREFIX):
                    made = self.numbered.switched(
                        name.removeprefix(_VENDOR_ONLY_PREFIX), given, procedure, origin
                    )
                    return replace(made, span=origin.span)
            return node

        return replace(procedure, body=body(procedure.body))

    def _held(self) -> e.Name:
        """A position that is worked out in front of the statement that names it."""
        if not self.held:
            self.held = self.numbered.free("worked_out")
        return e.Name(self.held)

    def _override(self) -> str:
        """The variable that holds the percentage of speed that the program has set last."""
        self.override = self.override or self.numbered.free("current_override")
        return self.override

    def _state(
        self, key: str, given: tuple[e.Expression, ...], procedure: Procedure
    ) -> e.Expression:
        if key in SIGNAL_VARIABLES:
            return self.numbered.read(key, given[0], procedure)
        if key in ANGLE_DIVIDING and not self.divided:
            self.divided = True
            self.findings.append(
                rules.LEFT_OUT(what="Plt", loss=_DIVIDED_ANGLES, cure=_UNDIVIDED_CURE)
            )
        if key in library():
            return e.Apply(self.supplied.name(key), given)
        if key == OVERRIDE_STATUS:
            return e.Name(self._override())
        what, value, loss, cure = STATE_EQUIVALENTS[key]
        self.findings.append(rules.LEFT_OUT(what=what, loss=loss, cure=cure))
        return value


_FORCED_HAND: Final = re.compile(r"HOpen\s+[^,]+,", re.IGNORECASE)
_OPEN_CORNER: Final = re.compile(r"Cnt\s+1", re.IGNORECASE)


def _lost_effects(node: p.Statement, made: Body) -> tuple[str, str] | None:
    """Effects that the replacement of a text loses, with their cures."""
    text = getattr(node, "text", "").strip()
    if text.upper() == "RETURN":
        return (
            "the program ends there for good, and no error (3840) is on the controller",
            "end the lines above the subroutine with End",
        )
    if _FORCED_HAND.match(text):
        return (
            "the hand is opened, with no force and no time of its own",
            "set both on the gripper, and wait for it below",
        )
    if _OPEN_CORNER.fullmatch(text):
        radius = next((one.value for one in made if isinstance(one, p.Assign)), None)
        value = radius.value if isinstance(radius, e.Number) else 0
        return (
            f"the size of the corner, which the controller chooses, is {value:g} mm",
            "state it: Cnt 1,10,10",
        )
    return None


def _counts_axis(statement: p.Statement) -> bool:
    """Whether a place of an additional axis is more than copied: in mm, or in radian."""
    if isinstance(statement, p.Assign) and _is_axis(statement.value):
        return False
    return any(map(_is_axis, records(head(statement))))


def _is_axis(record: Any) -> bool:
    return isinstance(record, e.Member) and record.field in e.EXTERNAL
