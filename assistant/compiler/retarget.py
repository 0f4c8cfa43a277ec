"""Retargeting: a program for the arm that will run it.

Joint angles that were taught on another arm become those that put this arm's flange at the same
pose. Free turns of tools are chosen for the arm and its cell. Joint speeds are converted between
languages that state percents and languages that state mm/s. `solve` returns the program as one arm
runs it, for timing, drawing and analysis.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant import robots
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    Refused,
    Rule,
    Span,
    error,
    fold,
    has_errors,
    info,
    warning,
)
from assistant.compiler.arms import InCell, known_robot, robot_of, teaching_arm, with_robot_of_cell
from assistant.compiler.loader import Loaded
from assistant.compiler.seen_frames import with_located_frames
from assistant.compiler.source_map import Places, at_moves
from assistant.compiler.travel import with_planned_travels
from assistant.compiler.work_locations import fold_unplaced_work, with_locations
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import names_in_vendor_texts
from assistant.program.geometry import JointTarget, Target
from assistant.program.motion import ComputedSpeed, Path, Speed, configuration_row
from assistant.program.program import Declaration, Program, Variable
from assistant.program.rewriting import head, records, rewrite
from assistant.program.statement_index import records_in_procedures, statements_with
from assistant.program.statements import Follow
from assistant.program.vendor_statements import effect_of

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.languages import Language
    from assistant.robots import Robot, SolvedProgram
    from assistant.robots.free_turns import ClearTest
    from assistant.robots.retargeting import SpeedChange


_JOINTS_CONVERTED = warning(
    "CO501",
    "{name} has joint angles of {source}, with its flange at ({there}) mm; on {arm} it becomes "
    "({joints}), with the flange at ({here}) mm",
    "look at the way there: between such targets each arm moves in its own way",
)
_JOINTS_OUT_OF_REACH = error(
    "CO502",
    "{name} has joint angles of {source}, with its flange at ({there}) mm, which {arm} cannot take",
    "teach it on {arm}, or move to a pose that both reach",
)
_JOINTS_OF_UNKNOWN_ARM = error(
    "CO503",
    "{name} has joint angles, and nothing says on which arm they were taught: on another one they "
    "lead to another place",
    "name the arm that they were taught on: `--from-robot`, or `robot` in the file{own}",
)
_OWN_ARM: Final = '; in the process file write `robot = "{arm}"` if that is the arm'
JOINTS_OF_OTHER_MAKER = error(
    "CO504",
    "{name} has joint angles of {source}, whose controller does not run {language}",
    "name the arm that will run the program: `--robot`",
)
_COMPUTED_JOINTS = error(
    "CO505",
    "{name} works with joint angles of {source}, which mean nothing on {arm}",
    "say it with poses, or with whole joint targets",
)
_JOINTS_IN_VENDOR_TEXT = warning(
    "CO506",
    "`{text}` keeps its text; joint angles in it would be those of {source}",
    "see that it speaks of none, or write it anew for {arm}",
)

_JOINTS_NOT_WRITTEN = warning(
    "CO510",
    "{name} has joint angles, which lead another arm to another place; nothing uses it, so it is "
    "not written",
    "to have it written, name the arms: `--from-robot` and `--robot`",
)

_BRANCHES_KEPT = warning(
    "CO513",
    "configurations are as they were on {source}, for {names}: what moves there is kept in the "
    "words of the source and not read, so nothing was chosen or checked for {arm}",
    "state speed, zone, tool and work object of these moves as constants, or teach the targets on "
    "{arm}",
)

_JOINT_COMPONENT: Final = re.compile(r"j\d+")
"""Components of joint targets."""


def for_arm(
    program: Program, source: Robot | None, arm: Robot
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program that was taught on one arm, or on nobody knows which, for another one.

    Arm branches are left open, to be chosen anew, but for targets that vendor text goes to: with
    which tool, nobody reads. Joint targets cross as where they put the flange, with a finding each,
    an error for what the arm cannot take.
    """
    if source is None or source.name == arm.name:
        return program, ()
    stated = list(_stated_joints(program))
    said: dict[str, Any] = {"source": source.name, "arm": arm.name}
    taken = _converted_joints([s.target for s in stated], source, arm)
    findings = []
    uses = _name_uses(program)
    for one in stated:
        crossing = taken[one.target]
        given = {"name": one.called, **said, **crossing.said}
        if crossing.target is None:
            findings += [_JOINTS_OUT_OF_REACH(**given, **where) for where in one.wherever(uses)]
        else:
            findings.append(_JOINTS_CONVERTED(**given, **one.where))
    findings += [
        _COMPUTED_JOINTS(name=name, **said, span=span) for name, span in _computed_joints(program)
    ]

    kept = _targets_in_texts(program)
    if kept:
        names = ", ".join(f"`{name}`" for name in kept)
        findings.append(_BRANCHES_KEPT(names=names, **said))
    held = {id(target) for targets in kept.values() for target in targets}

    def visit(part: Any) -> Any:
        if isinstance(part, JointTarget):
            return taken[part].target or part
        return part if id(part) in held else _without_branch(part)

    return rewrite(program, visit), tuple(findings)


def _targets_in_texts(program: Program) -> dict[str, list[Target]]:
    """The targets that vendor text alone goes to and that state how the arm reaches them, by their
    names.
    """
    inside = names_in_vendor_texts(program) - {
        part.name.lower()
        for one in program.statements()
        if isinstance(one, p.MoveStatement)
        for part in records(one)
        if isinstance(part, e.Name)
    }
    named = [*program.targets.items(), *program.variables.items()]
    found = {
        name: [one for one in records(value) if isinstance(one, Target) and one.configuration]
        for name, value in named
        if name.lower() in inside
    }
    return {name: targets for name, targets in found.items() if targets}


def without_unused_joint_targets(
    program: Program, language: Language[Any], source: Robot | None, arm: Robot | None
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """Return a program without the joint targets that `unsaid` refuses and no statement uses.

    In another dialect of the same family, and in a mere list of targets, all of them stay.
    """
    if _is_of_family(program, language) or not program.procedures:
        return program, ()
    if _refusal_rule(program, language, source, arm) is None:
        return program, ()
    declared = {name.lower() for name in (*program.joint_targets, *program.variables)}
    unused = declared - _used_names(program)
    idle: dict[str, _StatedJoints] = {}
    for one in _stated_joints(program):
        if one.name in unused:
            idle.setdefault(one.name, one)
    findings = tuple(_JOINTS_NOT_WRITTEN(name=one.called, **one.where) for one in idle.values())
    targets = {n: v for n, v in program.joint_targets.items() if n.lower() not in idle}
    variables = {n: v for n, v in program.variables.items() if n.lower() not in idle}
    return replace(program, joint_targets=targets, variables=variables), findings


def has_joint_angles(program: Program) -> bool:
    """True if a program states joint angles, or computes with them."""
    return any(True for _ in _stated_joints(program)) or any(
        True for _ in _computed_joints(program)
    )


def _used_names(program: Program) -> set[str]:
    """Names that the program uses, also in text that is kept, in lower case."""
    found: set[str] = set()
    kinds = e.Name, p.Opaque, e.Verbatim
    others = records((program.declarations, program.variables))
    for part in chain(records_in_procedures(program, *kinds), others):
        if isinstance(part, e.Name):
            found.add(part.name.lower())
        elif isinstance(part, p.Opaque | e.Verbatim | Declaration):
            found |= effect_of(part).names
    return found


def _is_of_family(program: Program, language: Language[Any]) -> bool:
    """True if a program was written in a language of the same family."""
    from assistant.compiler.loader import language_of

    origin = program.origin
    return origin is not None and language_of(origin.language).family == language.family


def _refusal_rule(
    program: Program, language: Language[Any], source: Robot | None, arm: Robot | None
) -> Rule | None:
    """Return the rule that forbids joint angles in a language on an arm, None if they are
    allowed.
    """
    own = _is_of_family(program, language)
    if source is None:
        return _JOINTS_OF_UNKNOWN_ARM if arm is not None or not own else None
    driven = arm is not None or own or language.name in source.languages
    return None if driven else JOINTS_OF_OTHER_MAKER


def joint_angle_errors(
    program: Program,
    language: Language[Any],
    source: Robot | None,
    arm: Robot | None,
) -> Iterator[Diagnostic]:
    """Yield errors for joint angles whose meaning is unknown in a language on an arm.

    arm: named to run it. In a language of the same family a program without a named arm stays with
    the arm that it has.
    """
    from assistant.compiler.loader import language_of

    uses = _name_uses(program)
    if (rule := _refusal_rule(program, language, source, arm)) is not None:
        arms: dict[str, Any] = {"language": language.name, "source": source and source.name}
        # Only drawings say whether they are placed; their joints are those of the process file.
        drawn = program.placed is not None
        arms["own"] = _OWN_ARM.format(arm=arm.name) if drawn and arm is not None else ""
        for one in _stated_joints(program):
            for where in one.wherever(uses):
                yield rule(name=one.called, **arms, **where)
        for name, span in _computed_joints(program) if source is None else ():
            yield rule(name=name, **arms, span=span)
    elif source is not None and arm is not None and arm.name != source.name:
        names = {one.name for one in _stated_joints(program)}
        others = records((program.declarations, program.variables))
        for part in chain(records_in_procedures(program, p.Opaque, e.Verbatim), others):
            if isinstance(part, p.Opaque | e.Verbatim | Declaration):
                spoken = language_of(part.language)
                named = not names.isdisjoint(effect_of(part).names)
                telling = spoken.joint_words.search(part.text) or named
                if spoken.family == language.family and telling:
                    span = getattr(part, "span", None)
                    text = " ".join(part.text.split())
                    yield _JOINTS_IN_VENDOR_TEXT(
                        text=text, source=source.name, arm=arm.name, span=span
                    )


_NameUses = Mapping[tuple[str, str], tuple[Span, ...]]
"""Procedure and name in lower case → statements of the procedure that name it."""


@dataclass(frozen=True, slots=True)
class _StatedJoints:
    """A joint target in a program.

    called: as a finding calls it. where: of the finding. name: its own in lower case, or that of
    the variable that holds it, empty for none; seen: in the procedures of these names.
    """

    called: str
    target: JointTarget
    where: Mapping[str, Any]
    name: str = ""
    seen: frozenset[str] = frozenset()

    def wherever(self, uses: _NameUses) -> Iterator[Mapping[str, Any]]:
        """Yield its position, and every statement that names it."""
        yield self.where
        for procedure in sorted(self.seen) if self.name else ():
            yield from ({"span": span} for span in uses.get((procedure, self.name), ()))


def _name_uses(program: Program) -> _NameUses:
    uses: dict[tuple[str, str], tuple[Span, ...]] = {}
    for procedure in program.procedures:
        for statement, parts in statements_with(procedure, e.Name):
            names = {part.name.lower() for part in parts}
            if statement.span is not None:
                for name in names:
                    key = procedure.name.lower(), name
                    uses[key] = (*uses.get(key, ()), statement.span)
    return uses


def _stated_joints(program: Program) -> Iterator[_StatedJoints]:
    own = {q.name.lower(): {n.lower() for n in q.variables} for q in program.procedures}
    for name, target in program.joint_targets.items():
        seen = frozenset(q for q, names in own.items() if name.lower() not in names)
        about = Declared(name, "joint_targets")
        yield _StatedJoints(f"`{name}`", target, {"about": about}, name.lower(), seen)
    for name, variable in program.variables.items():
        if not any(isinstance(part, JointTarget) for part in records(variable.initial)):
            continue
        seen = frozenset(q for q, names in own.items() if name.lower() not in names)
        yield from _joints_of_variable(
            name, variable, Declared(name, "variables", in_full=True), seen
        )
    for procedure in program.procedures:
        alone = frozenset({procedure.name.lower()})
        for name, variable in procedure.variables.items():
            about = Declared(name, "variables", procedure.name, in_full=True)
            yield from _joints_of_variable(name, variable, about, alone)
        for statement, parts in statements_with(procedure, JointTarget):
            where: dict[str, Any] = {"span": statement.span}
            if statement.span is None:
                where = {"about": Declared(procedure.name, "procedures", in_full=True)}
            for part in parts:
                yield _StatedJoints("the move", part, where)


def _joints_of_variable(
    name: str, variable: Variable, about: Declared, seen: frozenset[str]
) -> Iterator[_StatedJoints]:
    """The joint targets in the first value of a variable."""
    for part in records(variable.initial):
        if isinstance(part, JointTarget):
            where = {"about": about, "span": variable.span}
            yield _StatedJoints(f"`{name}`", part, where, name.lower(), seen)


def _computed_joints(program: Program) -> Iterator[tuple[str, Any]]:
    """Yield the name for a finding, and the span, of each statement that computes with the
    angles.
    """
    for statement, parts in statements_with(program, e.Member):
        for part in parts:
            if _JOINT_COMPONENT.fullmatch(part.field.lower()):
                value = part.value
                name = f"`{value.name}.{part.field}`" if isinstance(value, e.Name) else "it"
                yield name, statement.span
                break


@dataclass(frozen=True, slots=True)
class _ConvertedJoints:
    """A joint target on the other arm, None if it cannot reach it, and its description."""

    target: JointTarget | None
    said: Mapping[str, str]


def _converted_joints(
    targets: list[JointTarget], source: Robot, arm: Robot
) -> dict[JointTarget, _ConvertedJoints]:
    """Return the joints that another arm takes at the flange poses of one arm's targets."""
    from assistant.robots.retargeting import joints_on_other_arm

    own = {target: source.own_joints(target.joints) for target in targets}
    # Joints that are missing or not finite have no pose.
    whole = [t for t, j in own.items() if len(j) == len(source.axes) and np.isfinite(j).all()]
    out = {t: _ConvertedJoints(None, {"there": "not known"}) for t in own}
    if not whole:
        return out
    given = np.array([own[target] for target in whole])
    there, _ = source.flange_poses(given)
    joints = joints_on_other_arm(given, source, arm)
    # Targets out of reach are NaN: any pose will do, as none is shown for them.
    here, _ = arm.flange_poses(np.nan_to_num(joints))
    for row, target in enumerate(whole):
        said = {"there": _joints_text(there[row])}
        if not np.isfinite(joints[row]).all():
            out[target] = _ConvertedJoints(None, said)
            continue
        said |= {"here": _joints_text(here[row]), "joints": _joints_text(joints[row])}
        angles = tuple(float(v) + 0.0 for v in np.round(joints[row], 9))
        out[target] = _ConvertedJoints(replace(target, joints=angles), said)
    return out


def _joints_text(values: Any) -> str:
    return ", ".join(f"{v:g}" for v in np.round(np.asarray(values, dtype=np.float64), 2) + 0.0)


def _without_branch(part: Any) -> Any:
    """A target or path that states no branch."""
    if isinstance(part, Target) and part.configuration is not None:
        return replace(part, configuration=None)
    if isinstance(part, Path):
        unstated = np.broadcast_to(np.array(configuration_row(None), np.int8), (len(part), 6))
        return replace(part, configurations=unstated)
    return part


_NAME_OTHER_ARM: Final = "name the arm that the program was written for, `--from-robot`; or "
"""Begins the cure where a stated configuration may be one of another arm."""


def with_other_arm_named(
    findings: Iterable[Diagnostic], program: Program, arm: Robot
) -> Iterator[Diagnostic]:
    """Findings whose cures tell what to do if configurations were taught on the source's arm.

    arm: that will run the program, where no arm that it was written for is named. One that runs
    programs of the source's language may well be the one that they were taught on.
    """
    from assistant.compiler.loader import language_of
    from assistant.robots.findings import NOT_AS_STATED, OTHER_QUADRANT

    origin = program.origin
    other = origin is not None and language_of(origin.language).family not in {
        language_of(name).family for name in arm.languages
    }
    codes = (NOT_AS_STATED.code, OTHER_QUADRANT.code) if other else ()
    for one in findings:
        yield replace(one, cure=_NAME_OTHER_ARM + one.cure) if one.code in codes else one


def has_percent_joints(program: Program) -> bool:
    """True if a percentage, and nothing else, slows joint moves down."""
    slowed = any(
        one.percent != e.Number(100) for one in records_in_procedures(program, p.SetOverride)
    )
    for one in records(program):
        if isinstance(one, ComputedSpeed) and one.joint is not None:
            return True
        if isinstance(one, Speed) and one.joint is not None and math.isinf(one.tcp):
            if slowed or one.joint < 100.0:
                return True
    return False


_SPEED_FROM_PERCENT = warning(
    "CO507",
    "a joint move at {percent:g} %, which takes {seconds:.2f} s, is written with {tcp:g} mm/s and "
    "{rotation:g} degrees/s, and takes at least as long",
    "try it at a low override first",
)
_PERCENT_FROM_SPEED = warning(
    "CO508",
    "a joint move at {tcp:g} mm/s, which takes {seconds:.2f} s, is written with {percent:g} %, and "
    "takes at least as long",
    "try it at a low override first",
)
_SPEED_OF_PROCESS = warning(
    "CO509",
    "a joint speed of {percent} % is written as the {tcp:g} mm/s of `joint_speed`",
    "see that the arm is not faster there than it was",
)
_SPEED_LIMITED = warning(
    "CO512",
    "a joint move at {percent:g} % is written with {tcp:g} mm/s, as `joint_speed` says; "
    "{by_arms:g} mm/s would take as long as before",
    "if it may be faster, state a higher `joint_speed`",
)
_PERCENT_OF_PROCESS = info(
    "CO511",
    "joint moves that state mm/s get the {percent:g} % of the process file, `joint_percent`",
)


def with_converted_joint_speeds(
    solution: SolvedProgram,
    source: Program,
    taught: Robot | None,
    percent: bool,
    stated: float | None,
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program that was solved for the arm that will run it, its joint moves not faster there.

    source: the program before. taught: the arm that it was written for, None if nobody knows.
    percent: whether they are to be percents. stated: mm/s of joint moves with a percentage, which
    no such move exceeds; None if nobody states them.
    """
    from assistant import robots
    from assistant.robots.retargeting import convert_joint_speeds

    before = solution if taught is not None and taught.name == solution.robot.name else None
    # The times on the taught arm set the speeds: it is solved there if that is another arm.
    if before is None and taught is not None:
        before = robots.solve_program(replace(source, robot=taught.name), taught)
    most = math.inf if stated is None else stated
    program, changes = convert_joint_speeds(
        solution.program, solution, before, percent=percent, most=most
    )
    return program, tuple(
        _speed_findings(changes, _PERCENT_FROM_SPEED if percent else _SPEED_FROM_PERCENT)
    )


def _speed_findings(changes: tuple[SpeedChange, ...], rule: Rule) -> Iterator[Diagnostic]:
    """A finding for each statement: on its first change that a stated speed limits, else its first.

    rule: for changes without a limit.
    """
    told: dict[int, SpeedChange] = {}
    for change in changes:
        first = told.setdefault(id(change.statement), change)
        if change.limited and not first.limited:
            told[id(change.statement)] = change
    for change in told.values():
        to_percent = change.after.joint is not None
        physical = change.before if to_percent else change.after
        stated = change.after if to_percent else change.before
        yield (_SPEED_LIMITED if change.limited else rule)(
            percent=stated.joint,
            seconds=change.seconds,
            tcp=physical.tcp,
            rotation=physical.rotation,
            by_arms=change.by_arms,
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
            found.append(_SPEED_OF_PROCESS(percent=f"{percent:g}", tcp=tcp, span=statement.span))
        elif any(map(_is_computed, records(one))):
            found.append(_SPEED_OF_PROCESS(percent="any", tcp=tcp, span=statement.span))
    return rewrite(program, changed), tuple(found)


def _has_percent_only(part: Any) -> bool:
    return isinstance(part, Speed) and part.joint is not None and math.isinf(part.tcp)


def _is_computed(part: Any) -> bool:
    return isinstance(part, ComputedSpeed) and part.joint is not None


def with_joint_percent(program: Program, percent: float) -> tuple[Program, tuple[Diagnostic, ...]]:
    """Return a program whose joint moves without a percentage get the given one.

    Other moves keep their mm/s, as a speed holds both.
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
    return done, (_PERCENT_OF_PROCESS(percent=percent),) if given else ()


def has_free_turns(program: Program) -> bool:
    """True if any tool of the program has a free turn."""
    return any(tool.free_turn for tool in program.tools.values())


def with_chosen_turns(
    program: Program, arm: Robot | None, scene: Scene | None = None
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program whose tools have the turns that suit an arm best, where they are free.

    scene: of the cell, None without one: then nothing is there to be touched.
    """
    from assistant.robots.findings import NO_ARM
    from assistant.robots.free_turns import with_chosen_turns, without_free_turns

    if not has_free_turns(program):
        return program, ()
    if arm is None:
        return without_free_turns(program), (NO_ARM(),)
    return with_chosen_turns(program, arm, () if scene is None else _clear_of_scene(scene, arm))


def _clear_of_scene(scene: Scene, arm: Robot) -> tuple[ClearTest, ...]:
    """Return a test of the margins of a scene, and one of contacts only, with everything else at
    rest.
    """
    from assistant.cell.clearances import robot_of
    from assistant.cell.planning.space import Space

    try:
        placed = robot_of(scene, arm)
    except LookupError:  # which the check of the cell tells
        return ()
    return Space(scene, placed).clear, Space(scene, placed, margin=0.0).clear


_NO_ROBOT: Final = error(
    "CL010",
    "the program names no robot that it is for",
    "name one with --robot; `robot-assistant robots` lists them",
)


@dataclass(frozen=True, slots=True)
class Solved:
    """A program as the arm goes through it, in a scene if there is one, and where its parts are.

    program: as it was read, before ways were planned and turns chosen.
    """

    solution: SolvedProgram
    scene: Scene | None
    places: Places
    findings: list[Diagnostic]
    program: Program


def solve(
    loaded: Loaded, stands: InCell, source: str | None, from_robot: str | Robot | None = None
) -> Solved:
    """Solve a program for the arm that runs it. Raises Refused if no arm is named.

    stands: the cell, and the requested robot. source: the file of the findings.
    """
    arms = stands.beside(loaded.seen).arms(robot_of(from_robot))
    program: Program = loaded.program
    arms = with_robot_of_cell(program, arms)
    program, located = with_locations(program, arms)
    program, sights = with_located_frames(program, arms)
    arm = arms.robot or known_robot(program.robot)
    if arm is None:
        raise Refused(_NO_ROBOT(path=source), exit_status=2)
    program, changed = for_arm(program, teaching_arm(program, replace(arms, robot=arm)), arm)
    program, turned = with_chosen_turns(program, arm, arms.scene)
    changed += turned
    places = Places(loaded.program, loaded.text)
    ways = with_planned_travels(program, arm, arms.scene, places)
    solution = robots.solve_program(replace(ways.program, robot=arm.name), arm)
    # Without planned travels, findings would be about moves that are not made.
    also = () if has_errors(ways.findings) else solution.findings
    changed = (*located, *sights, *changed, *map(places.finding, ways.findings))
    at_lines = map(places.finding, at_moves(also, solution.program, places))
    found = (*loaded.findings, *changed, *fold_unplaced_work(program, arm, at_lines))
    said = [*stands.findings, *fold(f.within(source) for f in found)]
    return Solved(solution, arms.scene, places, said, loaded.program)
