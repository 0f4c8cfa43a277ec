"""Expressions of the pseudo-program as RAPID's, with parentheses where its priorities need them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from assistant.languages.patterns import Writing
from assistant.languages.rapid import rules
from assistant.languages.rapid.lower.names import Naming
from assistant.languages.rapid.tables import functions
from assistant.languages.rapid.tables.operators import (
    AND,
    BINARY,
    OR,
    PRIMARY,
    SUM,
    TERM,
)
from assistant.languages.rapid.tables.words import (
    COMPONENTS,
    LONGEST_STRING,
    UNUSED,
)
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import function_call
from assistant.languages.rapid.tree.runs import (
    JOINT_PLACES,
    PARTS,
    POSITION_PLACES,
    QUATERNION_PLACES,
)
from assistant.program import expressions as e
from assistant.program.diagnostics import Refused, Rule
from assistant.program.geometry import JointTarget, Pose, Target
from assistant.program.path import configuration_row
from assistant.robots.configurations import to_confdata


def refuse(rule: Rule, **fields: Any) -> Refused:
    return Refused(rule(**fields))


class Expressions:
    """names: of the whole program. value: RAPID's name of a variable, target or signal."""

    def __init__(self, names: Naming, value: Callable[[str], str]) -> None:
        self._names, self._value = names, value
        self.writing: Writing[s.Expression] = Writing(
            {
                "value": lambda x, _: self.lower(x),
                "position": lambda x, _: s.Component(self._variable(x), "trans"),
                "timer": lambda x, _: s.NameRef(names.get("timers", x)),
                "tool": lambda x, _: s.NameRef(names.get("tools", x)),
                "frame": lambda x, _: s.NameRef(names.get("frames", x) or "wobj0"),
            },
            function_call,
            lambda value: number(value)[0],
        )

    def lower(self, expression: e.Expression, level: int = OR) -> s.Expression:
        """Raises Refused for what RAPID cannot say."""
        node, own = self._lower(expression)
        return node if own >= level else s.Group(node)

    def _lower(self, x: e.Expression) -> tuple[s.Expression, int]:
        match x:
            case e.Number(value):
                return number(value)
            case e.Truth(value):
                return s.BoolLiteral(value), PRIMARY
            case e.Text(value):
                return text(value), PRIMARY
            case e.Name(name):
                return s.NameRef(self._value(name)), PRIMARY
            case e.TargetValue(target):
                return target_node(target), PRIMARY
            case e.JointValue(joints):
                return joints_node(joints), PRIMARY
            case e.PoseValue(pose):
                return pose_node(pose), PRIMARY
            case e.Aggregate(items):
                return s.AggregateNode(tuple(self.lower(i) for i in items)), PRIMARY
            case e.Member(value, name):
                node = self._variable(value)
                for part in COMPONENTS.get(name, (name,)):
                    node = s.Component(node, part)
                return node, PRIMARY
            case e.Index(value, indices):
                node = self._variable(value)
                return s.Element(node, tuple(self.lower(i) for i in indices)), PRIMARY
            case e.Unary("not", operand):
                return s.Prefix("NOT", self.lower(operand, AND)), OR
            case e.Unary(_, operand):
                return s.Prefix("-", self.lower(operand, TERM)), SUM
            case e.Binary(operator, left, right) if operator in BINARY:
                name, own, first, second = BINARY[operator]
                return s.Infix(name, self.lower(left, first), self.lower(right, second)), own
            case e.Binary() | e.Apply() | e.Elapsed() | e.Here():
                call = functions.ROWS.write(x, self.writing)
                if call is not None:
                    return function_call(call), PRIMARY
                assert isinstance(x, e.Apply)
                return self._apply(x.function, x.arguments), PRIMARY
            case e.Verbatim():
                return self._verbatim(x)

    def _variable(self, x: e.Expression) -> s.Variable:
        node = self.lower(x, PRIMARY)
        if isinstance(node, s.NameRef | s.Component | s.Element):
            return node
        raise refuse(
            rules.NO_MEANING,
            what="a component of an expression",
            cure="put the value into a variable first",
        )

    def _apply(self, function: str, given: tuple[e.Expression, ...]) -> s.FunctionCall:
        if function in e.FUNCTIONS:
            raise refuse(
                rules.NO_MEANING,
                what=f"the function `{function}` of {len(given)} arguments",
                cure="compute the value otherwise",
            )
        name = self._names.get("procedures", function)
        return s.FunctionCall(name, tuple(s.Positional(self.lower(a)) for a in given))

    def _verbatim(self, x: e.Verbatim) -> tuple[s.Expression, int]:
        if x.language != verbatim.LANGUAGE:
            raise refuse(rules.OTHER_LANGUAGE, **verbatim.foreign(x))
        node = verbatim.expression(x.text)
        return node, OR if isinstance(node, s.Prefix | s.Infix) else PRIMARY


def number(value: float) -> tuple[s.Expression, int]:
    if not math.isfinite(value):
        raise refuse(rules.NOT_FINITE, what="an expression")
    size = abs(value)
    written = str(int(size)) if size == int(size) and size < 1e15 else repr(float(size))
    literal = s.NumberLiteral("9E9" if size == UNUSED else written)
    if math.copysign(1.0, value) < 0 and value != 0:
        return s.Prefix("-", literal), SUM
    return literal, PRIMARY


def text(value: str) -> s.StringLiteral:
    if len(value) > LONGEST_STRING:
        raise Refused(rules.LONG_STRING(length=len(value), place=value[:20]))
    if any(ord(c) > 255 for c in value):
        raise refuse(
            rules.NO_MEANING,
            what=f"the characters of {value[:30]!a}",
            cure="use letters of Latin-1 only",
        )
    return s.StringLiteral(value)


def numbers_node(values: list[float], places: int) -> s.AggregateNode:
    """Rounded numbers in brackets; 9E9 for NaN."""
    items: list[s.Expression] = []
    for value in values:
        if value != value:
            items.append(s.NumberLiteral("9E9"))
        else:
            items.append(number(float(np.round(value, places)) + 0.0)[0])
    return s.AggregateNode(tuple(items))


def target_values(target: Target) -> list[float]:
    """The 17 numbers of a target, rounded as they are printed, 9E9 for unused axes."""
    numbers = [
        *np.round(target.pose.position, POSITION_PLACES),
        *np.round(target.pose.quaternion, QUATERNION_PLACES),
        *to_confdata([configuration_row(target.configuration)])[0],
        *np.round([9e9 if v != v else v for v in target.external], JOINT_PLACES),
    ]
    finite([float(v) for v in numbers], "a target")
    return [float(v) + 0.0 for v in numbers]


def finite(values: list[float], what: str) -> None:
    if not all(math.isfinite(v) for v in values):
        raise refuse(rules.NOT_FINITE, what=what)


def target_node(target: Target) -> s.AggregateNode:
    values = target_values(target)
    return s.AggregateNode(tuple(_group(values[a:b]) for a, b in PARTS))


def _group(values: list[float]) -> s.AggregateNode:
    return s.AggregateNode(
        tuple(s.NumberLiteral("9E9") if v == 9e9 else number(v)[0] for v in values)
    )


def joints_node(target: JointTarget) -> s.AggregateNode:
    finite(list(target.joints), "a joint target")
    return s.AggregateNode(
        (
            numbers_node(list(target.joints), JOINT_PLACES),
            numbers_node(list(target.external), JOINT_PLACES),
        )
    )


def pose_node(pose: Pose) -> s.AggregateNode:
    finite([*pose.position, *pose.quaternion], "a pose")
    return s.AggregateNode(
        (
            numbers_node(list(pose.position), POSITION_PLACES),
            numbers_node(list(pose.quaternion), QUATERNION_PLACES),
        )
    )
