"""Contacts and small clearances of a program on its way through a cell."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    Rule,
    Severity,
    Span,
    Stretch,
    error,
    info,
    warning,
)
from assistant.base.length_units import length_text
from assistant.program.statements import Follow
from assistant.robots import SolvedProgram

if TYPE_CHECKING:
    from assistant.cell.clearances import Closeness
    from assistant.cell.scene import Scene
    from assistant.robots.robot import Robot
    from assistant.robots.timing import Simulation

TOUCHES: Final = error(
    "CK421",
    "`{one}` {touches} `{other}` after {time:.2f} s of `{procedure}`, at {point} mm, on the way to "
    "{label}; {deep} mm deep, and the shortest way out for `{one}` is along {out}",
    "go round it, move the target or the body; two that may touch stand under `allowed` of [world]",
)
NEAR: Final = warning(
    "CK422",
    "`{one}` comes within {least} of `{other}` after {time:.2f} s of `{procedure}`, on the "
    "way to {label}; the margin is {margin:g} mm",
    "keep away from it, or state a smaller margin in the cell file",
)
_NOT_PROVEN: Final = warning(
    "CK428",
    "`{one}` is not proven clear of `{other}` after {time:.2f} s of `{procedure}`, on the way to "
    "{label}: {least} mm are left, and the way of the joints is known to {doubt:.2g} mm there",
    "keep away from singularities there, or leave more room",
)
_NO_ROBOT: Final = error(
    "CK423",
    "no robot of the cell is a {robot}, which the program is for",
    "name it under [robots] of the cell file, or name another one with --robot",
)
_WHICH_ROBOT: Final = error(
    "CK425",
    "{names} of the cell are each a {robot}, and which one runs the program is not said",
    "name it as the cell does: --robot {first}",
)
_NOTHING_TAKEN: Final = warning(
    "CK426",
    "`{name}` = {value:g} takes something by the cell file, and nothing is at the tool then",
    "move the tool or the body, or state a larger margin of the body",
)
_BARE_TOOL: Final = warning(
    "CK427",
    "the tip of `{name}` is {far:.0f} mm from everything that the flange carries by the cell file: "
    "nothing is looked for that the tool touches",
    "write its body under [bodies], and name that as `tool` of the robot",
)
_UNKNOWN_SPACE: Final = error(
    "CK459",
    "`{name}` goes into space that nobody has explored after {time:.2f} s of `{procedure}`, at "
    "{point} mm, on the way to {label}",
    'explore it, go another way, or write unknown = "free" for the robot in the cell file',
)
_NOT_LOOKED: Final = info(
    "CK424",
    "{what}, so that collisions there are not looked for",
    "see docs/simulating.md for what is timed",
)


_UNSEEN: Final = (
    "not timed",
    "not followed",
    "only running the program tells where that is",
    "is a motion whose time is not known",
    "may move the arm",
    "are taken as the one before them",
    "is set by the program",
)
"""Words of what a simulation does not know by which ways of the arm are left out."""
_SHALLOW: Final = 0.05
"""Share of the radii of two links by which their capsules may overlap where the links may not: the
radii are not measured, and the capsules are thicker than the castings.
"""
_BARE: Final = 50.0
"""mm from a tip to the next body; from this distance on, the tool is assumed to have no body."""


def clearances(
    solution: SolvedProgram, scene: Scene | None = None, simulation: Simulation | None = None
) -> Iterator[Diagnostic]:
    """Contacts as errors, what is nearer than a margin as warnings: of two bodies and a statement
    the first place, with what is worst.

    scene: None for an arm without a cell, whose contacts with itself, its base and its tool count.
    simulation: of the solution, where there is one.
    """
    for finding, _ in placed_clearances(solution, scene, simulation):
        yield finding


def placed_clearances(
    solution: SolvedProgram, scene: Scene | None = None, simulation: Simulation | None = None
) -> Iterator[tuple[Diagnostic, Closeness | None]]:
    """The same, each with where in the scene it is; None for what is about no place."""
    from assistant.base.diagnostics import has_errors
    from assistant.cell.clearances import (
        CarriedBodies,
        beyond_bodies,
        closeness,
        own_contacts,
        robot_of,
    )
    from assistant.cell.link_bodies import arm_alone
    from assistant.robots.timing import simulate

    if has_errors(solution.findings):  # what cannot be reached is not gone through
        return
    if scene is None:
        done = simulation or simulate(solution)
        found = own_contacts(done, solution.tools)
        yield from _told_of(solution, arm_alone(solution.robot), found, alone=True)
        return
    try:
        placed = robot_of(scene, solution.robot)
    except LookupError:
        yield no_robot(solution.robot, scene), None
        return
    holding = CarriedBodies.at_first(scene, placed)
    # Carried bodies change what is close: a simulation without them does not serve.
    if simulation is None or holding.places:
        simulation = simulate(solution, carried=holding if holding.places else None)
    yield from _told_of(solution, scene, closeness(simulation, scene, placed.name))
    for name, tool in solution.tools.items():
        far = beyond_bodies(scene, placed, tool.tip) if tool.held else 0.0
        if far > _BARE:
            yield _BARE_TOOL(name=name, far=far, about=Declared(name, "tools")), None
    for name, value in sorted(holding.doubts.empty):
        yield _NOTHING_TAKEN(name=name, value=value), None
    for name in sorted(holding.doubts.lost):
        what = f"only running the program tells where `{name}` is after a while"
        yield _NOT_LOOKED(what=what), None
    for unknown in simulation.unknown:
        if any(words in unknown.what for words in _UNSEEN):
            yield _NOT_LOOKED(what=str(unknown)), None


def _told_of(
    solution: SolvedProgram, scene: Scene, found: Iterable[Closeness], *, alone: bool = False
) -> Iterator[tuple[Diagnostic, Closeness]]:
    """Keep the worst row of each two bodies and statement, contacts first.

    alone: of an arm in no cell.
    """
    near = list(found)
    told: list[tuple[Diagnostic, Closeness]] = []
    touched = _worst(solution, (one for one in near if one.touches))
    for one in touched.values():
        finding = _told(solution, scene, one, TOUCHES)
        if alone and _hardly(scene, one):
            finding = replace(finding, severity=Severity.WARNING)
        told.append((finding, one))
    for key, one in _worst(solution, (one for one in near if not one.touches)).items():
        # A contact makes the margin of the same two bodies irrelevant.
        if key not in touched:
            rule = _NOT_PROVEN if one.bound <= 0.0 else NEAR
            told.append((_told(solution, scene, one, rule), one))
    return _by_pairs(told)


def _by_pairs(
    told: Sequence[tuple[Diagnostic, Closeness]],
) -> Iterator[tuple[Diagnostic, Closeness]]:
    """The same findings, those of the same two bodies as one stretch of all moves."""
    for finding, one in told:
        least = one.bound if finding.code == _NOT_PROVEN.code else one.least
        key = " ".join((finding.code, one.contact.one, one.contact.other))
        yield replace(finding, stretch=Stretch(key, -round(least, 1))), one


def _hardly(scene: Scene, one: Closeness) -> bool:
    """True if links of an arm in no cell overlap by less than their capsules are too thick."""
    links = {body.name: body for body in scene.robots[0].links}
    parts = [links[n].parts for n in (one.contact.one, one.contact.other) if n in links]
    radii = [max(getattr(part.shape, "radius", 0.0) for part in some) for some in parts]
    return -one.least <= _SHALLOW * sum(radii)


_Key = tuple[str, int, Span | None, str, str]


def _worst(solution: SolvedProgram, found: Iterable[Closeness]) -> dict[_Key, Closeness]:
    """The nearest of each two bodies and motion statement, or line of one."""
    worst: dict[_Key, Closeness] = {}
    for one in found:
        span = _span(solution, one)
        key = (one.procedure, one.number, span, one.contact.one, one.contact.other)
        known = worst.get(key)
        if known is None or one.least < known.least:
            worst[key] = one
    return worst


def no_robot(robot: Robot, scene: Scene) -> Diagnostic:
    """Why `robot_of` finds none of the scene that runs a program for a robot."""
    alike = [placed.name for placed in scene.robots if placed.robot.name == robot.name]
    if scene.runs is not None or not alike:
        return _NO_ROBOT(robot=robot.title)
    names = ", ".join(f"`{name}`" for name in alike)
    return _WHICH_ROBOT(names=names, robot=robot.title, first=alike[0])


def _told(solution: SolvedProgram, scene: Scene, one: Closeness, rule: Rule) -> Diagnostic:
    contact = one.contact
    said: dict[str, Any] = {
        "one": contact.one,
        "other": contact.other,
        "time": one.time,
        "procedure": one.procedure,
        "label": one.label or "its target",
        "span": _span(solution, one),
    }
    leaves = _leaves_known_space(scene, contact.one, contact.other)
    if rule is TOUCHES and leaves is not None:
        del said["one"], said["other"]
        return _UNKNOWN_SPACE(name=leaves, point=_vector(contact.points[0], 1), **said)
    if rule is TOUCHES:
        deep = max(0.0, -min(one.least, contact.distance))
        return rule(
            touches="starts in contact with" if one.starts else "touches",
            point=_vector(contact.points[0], 1),
            deep=f"{'up to' if one.exact else 'at least'} {length_text(deep)}",
            out=_vector([-part for part in contact.normal], 2),
            **said,
        )
    if rule is _NOT_PROVEN:
        return rule(least=length_text(one.least), doubt=one.least - one.bound, **said)
    names = contact.one, contact.other
    margins = [body.margin for body in scene.all_bodies() if body.name in names]
    margin = max(scene.margin if m is None else m for m in margins)
    least = f"{length_text(min(one.least, margin))} mm"
    if not one.exact:
        least += f" or less (more than {length_text(one.bound)} mm)"
    return rule(least=least, margin=margin, **said)


def _leaves_known_space(scene: Scene, one: str, other: str) -> str | None:
    """Return the body that is in unknown space of a map, None if both are bodies."""
    from assistant.cell.scene import CORE_SUFFIX, UNKNOWN_SUFFIX

    for thin, space in ((one, other), (other, one)):
        if thin.endswith(CORE_SUFFIX) and space.endswith(UNKNOWN_SUFFIX):
            core = scene.body(thin)
            name = thin.removesuffix(CORE_SUFFIX)
            known = any(body.name == name for body in scene.all_bodies())
            return name if known or core is None else core.parent  # of what a program takes
    return None


def _span(solution: SolvedProgram, one: Closeness) -> Span | None:
    legs = solution.legs.get(one.procedure, ())
    if not 0 < one.number <= len(legs):
        return None
    statement = legs[one.number - 1].statement
    return statement.row_span(one.row) if isinstance(statement, Follow) else statement.span


def _vector(values: Sequence[float], digits: int) -> str:
    return f"({', '.join(f'{round(value, digits) + 0.0:.{digits}f}' for value in values)})"
