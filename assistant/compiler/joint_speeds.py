"""Speeds of joint moves between a language that states percents and one that states mm/s."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from assistant.base.diagnostics import Diagnostic, Rule, info, warning
from assistant.program.motion import ComputedSpeed, Path, Speed
from assistant.program.program import Program
from assistant.program.rewriting import head, records, rewrite
from assistant.program.statements import Follow

if TYPE_CHECKING:
    from assistant.robots import Robot, SolvedProgram
    from assistant.robots.retargeting import SpeedChange

SPEED_FROM_PERCENT = warning(
    "CO507",
    "a joint move at {percent:g} %, which takes {seconds:.2f} s, is written with {tcp:g} mm/s and "
    "{rotation:g} degrees/s, and takes at least as long",
    "try it at a low override first",
)
PERCENT_FROM_SPEED = warning(
    "CO508",
    "a joint move at {tcp:g} mm/s, which takes {seconds:.2f} s, is written with {percent:g} %, and "
    "takes at least as long",
    "try it at a low override first",
)
SPEED_OF_PROCESS = warning(
    "CO509",
    "a joint speed of {percent} % is written as the {tcp:g} mm/s of the process file",
    "see that the arm is not faster there than it was",
)

PERCENT_OF_PROCESS = info(
    "CO511",
    "joint moves that state mm/s get the {percent:g} % of the process file, `joint_percent`",
)


def with_converted_joint_speeds(
    solution: SolvedProgram, source: Program, taught: Robot | None, percent: bool
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program that was solved for the arm that will run it, its joint moves not faster there.

    source: the program before. taught: the arm that it was written for, None if nobody knows.
    percent: whether they are to be percents.
    """
    from assistant import robots
    from assistant.robots.retargeting import convert_joint_speeds

    before = solution if taught is not None and taught.name == solution.robot.name else None
    if before is None and taught is not None:
        before = robots.solve_program(replace(source, robot=taught.name), taught)
    program, changes = convert_joint_speeds(solution.program, solution, before, percent=percent)
    return program, tuple(
        _speed_findings(changes, PERCENT_FROM_SPEED if percent else SPEED_FROM_PERCENT)
    )


def _speed_findings(changes: tuple[SpeedChange, ...], rule: Rule) -> Iterator[Diagnostic]:
    """A finding for the first change of each statement."""
    seen: set[int] = set()
    for change in changes:
        if id(change.statement) not in seen:
            seen.add(id(change.statement))
            physical = change.before if rule is PERCENT_FROM_SPEED else change.after
            stated = change.after if rule is PERCENT_FROM_SPEED else change.before
            yield rule(
                percent=stated.joint,
                seconds=change.seconds,
                tcp=physical.tcp,
                rotation=physical.rotation,
                span=change.statement.span,
            )


def with_joint_speed(program: Program, tcp: float) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program with that many mm/s where a joint move states a percentage alone."""

    def changed(part: Any) -> Any:
        if _has_percent_only(part):
            return replace(part, tcp=tcp, joint=None)
        if _is_computed(part):
            return Speed(tcp)
        if isinstance(part, Path):
            return replace(part, speeds=tuple(map(changed, part.speeds)))
        return part

    found = []
    for statement in program.statements():
        one = head(statement)
        parts = one.path.speeds if isinstance(one, Follow) else records(one)
        percent = next(
            (x.joint for x in parts if isinstance(x, Speed) and _has_percent_only(x)), None
        )
        if percent is not None:
            found.append(SPEED_OF_PROCESS(percent=f"{percent:g}", tcp=tcp, span=statement.span))
        elif any(map(_is_computed, records(one))):
            found.append(SPEED_OF_PROCESS(percent="any", tcp=tcp, span=statement.span))
    return rewrite(program, changed), tuple(found)


def _has_percent_only(part: Any) -> bool:
    return isinstance(part, Speed) and part.joint is not None and math.isinf(part.tcp)


def _is_computed(part: Any) -> bool:
    return isinstance(part, ComputedSpeed) and part.joint is not None


def with_joint_percent(program: Program, percent: float) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program whose joint moves are at that percentage where they state none.

    Other moves keep their mm/s, as both stand in a speed.
    """
    given = False

    def changed(part: Any) -> Any:
        nonlocal given
        if isinstance(part, Speed) and part.joint is None:
            given = True
            return replace(part, joint=percent)
        if isinstance(part, Path):
            return replace(part, speeds=tuple(map(changed, part.speeds)))
        return part

    done = rewrite(program, changed)
    return done, (PERCENT_OF_PROCESS(percent=percent),) if given else ()
