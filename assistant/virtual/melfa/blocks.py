"""Blocks: If, For, While and Select, and how they are left."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import expressions
from assistant.virtual.melfa.code import LOOPS, Block, nodes
from assistant.virtual.melfa.operators import RELATIONS, SPELLINGS, binary
from assistant.virtual.melfa.stops import Failed, Unknown, open_point
from assistant.virtual.melfa.values import Value, holds, number

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Loop, Machine


def enter_if(m: Machine, node: s.If) -> None:
    """Goes to the first part whose condition is met."""
    block = m.code.opened[m.here]
    check_depth(block)
    if holds(expressions.value(m, node.condition)):
        m.took(0)
        return
    for way, part in enumerate(block.parts, 1):
        statement = m.code.rows[part].statement
        m.at = part + 1
        if not isinstance(statement, s.ElseIf) or holds(expressions.value(m, statement.condition)):
            m.took(way)
            return
    m.took(len(block.parts) + 1)
    m.at = block.end + 1


def check_depth(block: Block) -> None:
    """Raises Failed where blocks stand too deep in each other."""
    if block.loops > MOST_LOOPS:
        raise Failed(3240, f"more than {MOST_LOOPS} loops in each other")
    if block.branches > MOST_BRANCHES:
        raise Failed(3253, f"more than {MOST_BRANCHES} If in each other")


MOST_LOOPS: Final = 16
MOST_BRANCHES: Final = 8
"""CR1D 4-151 and 4-208."""


def skip_rest(m: Machine, _: Any) -> None:
    """A part that another one ends in: behind the whole block."""
    m.at = m.code.parted[m.here].end + 1


def leave_block(m: Machine, _: s.Command) -> None:
    """`Break`: behind the innermost block, and M_BrkCq tells of it (CR1D 4-208)."""
    block = m.code.inside[m.here]
    if m.world.options.breaks == "If and Select":
        while block is not None and block.kind in LOOPS:
            block = m.code.inside[block.start]
    if block is None or block.kind == "Function":
        raise Failed(4220, "Break outside of a block")
    m.at = block.end + 1
    m.world.left = True


# -------------------------------------------------------------------------------------- loops


def begin_for(m: Machine, node: s.For) -> None:
    """Bounds are worked out once; a loop without a turn is passed (COSIROP: FOR)."""
    from assistant.virtual.melfa.machine import Loop

    check_depth(m.code.opened[m.here])
    first = expressions.plain(m, node.first, "the first value of a loop")
    last, step = _loop_bounds(m, node)
    place, index = expressions.reference(m, node.variable)
    place.set(first, index)
    m.frame.loops[m.here] = Loop(last, step)
    runs = _loop_continues(number(place.get(index)), last, step)
    m.took(0 if runs else 1)
    if not runs:
        block = m.code.opened[m.here]
        m.at = block.end + 1


def _loop_bounds(m: Machine, node: s.For) -> tuple[float, float]:
    last = expressions.plain(m, node.last, "the last value of a loop")
    step = 1 if node.step is None else expressions.plain(m, node.step, "the step of a loop")
    if step == 0:
        raise Unknown("a loop of step 0")
    return last, step


def next_turn(m: Machine, _: s.Next) -> None:
    """Counts on and goes back to the first statement of the loop, or on behind it."""
    for closed in m.code.closed[m.here]:
        statement = m.code.rows[closed.start].statement
        assert isinstance(statement, s.For)
        loop = m.frame.loops.get(closed.start)
        if loop is None:
            raise Failed(3230, "Next without its For")
        _follow_bounds(m, statement, loop)
        place, index = expressions.reference(m, statement.variable)
        place.set(number(place.get(index)) + loop.step, index)
        if _loop_continues(number(place.get(index)), loop.last, loop.step):
            m.at = closed.start + 1
            return


def _follow_bounds(m: Machine, node: s.For, loop: Loop) -> None:
    """Whether bounds that change while the loop runs still count is an option."""
    way = m.world.options.bounds
    if isinstance(node.last, s.Number) and (node.step is None or isinstance(node.step, s.Number)):
        return
    if way == "each":
        loop.last, loop.step = _loop_bounds(m, node)
    elif (
        way is None
        and not _calls_function(m, node)
        and _loop_bounds(m, node) != (loop.last, loop.step)
    ):
        raise open_point("a loop whose bounds change while it runs", "bounds")


def _calls_function(m: Machine, node: s.For) -> bool:
    """Whether a bound calls a function of the program, which is not worked out once more."""
    return any(
        isinstance(part, s.Variable) and part.key in m.code.functions
        for part in nodes((node.last, node.step))
    )


def _loop_continues(value: float, last: float, step: float) -> bool:
    return value <= last if step > 0 else value >= last


def test_while(m: Machine, node: s.Command) -> None:
    check_depth(m.code.opened[m.here])
    met = holds(expressions.value(m, node.arguments[0]))
    m.took(0 if met else 1)
    if not met:
        m.at = m.code.opened[m.here].end + 1


def back_to_while(m: Machine, _: s.Command) -> None:
    (block,) = m.code.closed[m.here]
    m.at = block.start


# ------------------------------------------------------------------------------------- Select


def choose_case(m: Machine, node: s.Select) -> None:
    """The first part that fits, Default where none does; lines before the first never run."""
    block = m.code.opened[m.here]
    subject = expressions.value(m, node.subject)
    for way, part in enumerate(block.parts):
        statement = m.code.rows[part].statement
        if not isinstance(statement, s.Case) or any(
            _case_fits(m, item, subject) for item in statement.items
        ):
            m.took(way)
            m.at = part + 1
            return
    m.took(len(block.parts))
    m.at = block.end + 1


def _case_fits(m: Machine, item: s.CaseRange | s.CaseIs, subject: Value) -> bool:
    if isinstance(item, s.CaseIs):
        sign = SPELLINGS.get(item.operator, item.operator)
        return _case_compared(m, sign, subject, expressions.value(m, item.value))
    first = expressions.value(m, item.first)
    if item.last is None:
        return _case_compared(m, "=", subject, first)
    last = expressions.value(m, item.last)
    return _case_compared(m, ">=", subject, first) and _case_compared(m, "<=", subject, last)


def _case_compared(m: Machine, sign: str, left: Value, right: Value) -> bool:
    if sign not in RELATIONS:
        raise Failed(4220, f"Case Is {sign}")
    return bool(binary(m, sign, left, right))
