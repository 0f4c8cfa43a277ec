"""Legalisation: a pseudo-program within the capabilities of RAPID, a finding for each change.

`_PASSES` lists the passes in their order; `sayable` is the one that goes through every part of a
program: procedures, variables, statements, speeds, blends, motions and paths.

Pulses that `PulseDO` with `High` does not have (to 0, or to a value that is computed): the output
is set, and set back by `SetDO` with `SDelay` while the program goes on. Reference manual of
instructions: SetDO, PulseDO.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.diagnostics import Declared, Diagnostic, Findings, Refused, Span, has_errors
from assistant.languages.language_types import Adapted
from assistant.languages.legalisation import PartLegaliser
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.declared_data import fixed_target
from assistant.languages.rapid.lift.expressions import (
    frame_name,
    lift_expression,
    negated,
    tool_name,
    with_own_dates,
    with_own_radian,
)
from assistant.languages.rapid.lift.statements import statements_of
from assistant.languages.rapid.lift.vendor_effects import with_places
from assistant.languages.rapid.lower.channels import with_channels
from assistant.languages.rapid.lower.data import POSITIONS, with_set_mounts
from assistant.languages.rapid.lower.expressions import NAMES, Expressions
from assistant.languages.rapid.lower.interrupts import with_breaks, with_interrupts
from assistant.languages.rapid.lower.program import build
from assistant.languages.rapid.tables.constants import (
    LEAST_ACCELERATION,
    LONGEST_NAME,
    LONGEST_PULSE,
    LONGEST_STRING,
    MOST_TARGETS,
    SHORTEST_PULSE,
    UNUSED,
)
from assistant.languages.rapid.tables.equivalents import (
    BLENDS,
    SPEEDS,
    corner_of,
    sayable_blend,
    sayable_speed,
    speed_name,
    zone_name,
)
from assistant.languages.rapid.tables.signals import TRIGGER_MEASURES, gripper
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import File
from assistant.languages.records import aggregate
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import is_position, is_truth
from assistant.program.analysis.io_use import signal_uses, with_used_signals
from assistant.program.analysis.uses import changed_by_others
from assistant.program.geometry import BASE, FLANGE, JointTarget, Target, Tool
from assistant.program.motion import FINE, Blend, Path, Speed
from assistant.program.passes.comments import comment_lines, plain_comment, with_comments_behind
from assistant.program.passes.expression_forms import (
    as_truth,
    compared,
    floor,
    two_at_a_time,
    with_conditions,
    with_one_kind_of_numbers,
    with_rounded_values,
    with_shift_parts,
)
from assistant.program.passes.legalisation import (
    Acceleration,
    Capabilities,
    Changes,
    Comments,
    Corners,
    Legalisation,
    Loops,
    Outputs,
    Pass,
    Rewording,
    Units,
    legalise,
    pure,
)
from assistant.program.passes.loops import counted_loops, with_directions, without_counters
from assistant.program.passes.motions import (
    CornerSizes,
    NamedValues,
    declared_value,
    one_acceleration,
)
from assistant.program.passes.operator_texts import short_messages
from assistant.program.passes.paths import move_at, reported_at_lines, with_paths
from assistant.program.passes.positions import with_named_places, with_whole_angles
from assistant.program.passes.procedure_forms import (
    units,
    with_interrupts_first,
    with_results_taken,
)
from assistant.program.passes.signals import find_outputs_of_two_names
from assistant.program.passes.switches import plain_switch, with_floors_read_once
from assistant.program.passes.trigger_positions import with_measured_places
from assistant.program.passes.units import split
from assistant.program.program import Declaration, Procedure, Program, Variable, identifier
from assistant.program.rewriting import (
    is_repeatable,
    is_steady,
    map_bodies,
    map_expressions,
    records,
)
from assistant.program.statement_index import records_in_procedures

_UNITS: Final = Units(
    most=MOST_TARGETS,
    least_most=5,  # room to cut between arcs
    least=2,  # of one target there is no path
    counted="unit",
    part="{:.20}_part{}",
    unit="{:.20}_unit{}",
    path="{}_p",
    straight=False,
    split=rules.SPLIT,
    packed=rules.PACKED,
)
_ACCELERATION: Final = Acceleration(
    least=LEAST_ACCELERATION,
    cure="AccSet has one value for both",
    cure_of_least="AccSet has one value of 20 percent or more",
)
_CORNERS: Final = Corners(size=corner_of, name=zone_name)
_LOOPS: Final = Loops(
    refused=rules.COUNTER,
    changed=rules.CHANGED,
    cure="a loop of RAPID has a variable of its own; use another name if that is meant",
)


_OUTPUTS: Final = Outputs(
    measures=frozenset(TRIGGER_MEASURES.values()),
    known=True,
    unlike=rules.PLACE_UNLIKE,
    pulse=rules.PULSE_UNLIKE,
    scaled=rules.REGISTER_UNITS,
)


def capabilities(most_targets: int | None = None) -> Capabilities:
    """most_targets: of one module, None for MOST_TARGETS."""
    return Capabilities(
        kin=frozenset({"rapid"}),
        cannot_say=rules.NO_MEANING,
        changed=rules.CHANGED,
        loops=_LOOPS,
        outputs=_OUTPUTS,
        comments=Comments(ascii=True),
        acceleration=_ACCELERATION,
        longest_message=LONGEST_STRING,
        units=replace(_UNITS, most=most_targets) if most_targets else _UNITS,
    )


_PERCENT_CURE: Final = (
    "name both arms, or state `joint_speed` (mm/s) in the process file or the cell file (--cell)"
)
"""Speed in mm/s that corresponds to one percent."""
_SPEED_CURE: Final = "state a speed in mm/s"
_JOINT_SPEED_CURE: Final = (
    "state `joint_speed` (mm/s) in the process file or the cell file if that is too fast"
)


class _MotionAdapter:
    """The motions of a program. speeds, blends: what moves call them, filled as they are met."""

    def __init__(self, job: Legalisation, written: PartLegaliser) -> None:
        self._job, self._written, self._sizing = job, written, CornerSizes(job, _CORNERS)
        program = job.program
        # An override other than 100 percent slows the arm; VelSet does so only for speeds of the
        # tool.
        overrides = (s.percent for s in program.statements() if isinstance(s, p.SetOverride))
        self._slowed = any(percent != e.Number(100) for percent in overrides)
        self.speeds = NamedValues(SPEEDS, program.speeds, self._speed, LONGEST_NAME)
        self.blends = NamedValues(BLENDS, program.blends, self._blend, LONGEST_NAME)

    def motion(self, motion: p.Motion) -> p.Motion:
        speed, blend = motion.speed, motion.blend
        if not isinstance(blend, p.ComputedBlend):
            # A computed speed is not known here; at 0 the chosen corner is the smallest.
            known = Speed(0.0) if isinstance(speed, p.ComputedSpeed) else speed
            blend = self.blends.said(self._sizing.blend(blend, known))
        if not isinstance(speed, p.ComputedSpeed):
            speed = self.speeds.said(speed)
        elif speed.tcp is None or speed.joint is not None:
            cure = _PERCENT_CURE
            self._job.cannot("a joint speed in percent that is worked out", cure)
        return p.Motion(speed, blend, tool_name(motion.tool), frame_name(motion.frame))

    def path(self, path: Path, line: Callable[[int], Span | None]) -> Path:
        """line: where the move to a row is in the source text."""
        path = self._written.path(self._sizing.path(path))

        def said(index: NDArray[np.int32], table: Sequence[Any], names: NamedValues[Any]) -> Any:
            used = set(np.unique(index).tolist())
            return tuple(
                reported_at_lines(
                    self._job.findings, line, index, lambda i: names.said(table[i]), entry
                )
                if entry in used
                else names.said(table[entry])
                for entry in range(len(table))
            )

        return replace(
            path,
            speeds=said(path.speed, path.speeds, self.speeds),
            blends=said(path.blend, path.blends, self.blends),
            tools=tuple(tool_name(t) for t in path.tools),
            frames=tuple(frame_name(f) for f in path.frames),
        )

    def _speed(self, speed: Speed, name: str | None) -> Speed:
        said, changed = sayable_speed(speed)
        about = None if name is None else Declared(name, "speeds")
        if self._only_percent(speed):
            cure = _PERCENT_CURE
            self._job.cannot(f"a joint speed of {speed.joint:g} % alone", cure, about)
        elif changed:
            asks = _JOINT_SPEED_CURE if math.isinf(speed.tcp) and speed.joint else _SPEED_CURE
            self._job.changed(changed, speed_name(said), asks, about)
        # Written as a negation, so that NaN is refused too.
        if not all(v > 0 for v in (said.tcp, said.rotation)) or said.tcp != said.tcp:
            self._job.cannot(f"a speed of {said.tcp} mm/s", "state a speed above 0", about)
        return said

    def _only_percent(self, speed: Speed) -> bool:
        """True if a speed is less than the full axis speeds, which RAPID cannot express.

        An override has the same effect: RAPID's override reduces only the speed of the tool.
        """
        if speed.joint is None or math.isfinite(speed.tcp):
            return False
        return speed.joint < 100.0 or self._slowed

    def _blend(self, blend: Blend, name: str | None) -> Blend:
        said, changed = sayable_blend(blend)
        about = None if name is None else Declared(name, "blends")
        if changed:
            self._job.changed(changed, zone_name(said), "state one radius in mm", about)
        # Written as a negation, so that NaN is refused too.
        if said.radius is not None and not said.radius >= 0:
            what = f"a corner radius of {said.radius} mm"
            self._job.cannot(what, "state 0 or more", about)
        return said


ON: Final = e.Number(1)


def _with_pulses(job: Legalisation) -> Program:
    """The program with such pulses as two instructions."""
    pulses = (
        one for one in records_in_procedures(job.program, p.SetSignal) if one.pulse is not None
    )
    if all(one.value == ON for one in pulses):
        return job.program
    said = _Pulses(job)
    return replace(job.program, procedures=tuple(map(said.procedure, job.program.procedures)))


class _Pulses(Rewording):
    def __init__(self, job: Legalisation) -> None:
        super().__init__(job)
        self.names = NAMES.naming(job.program)
        self.signals = {name.lower(): one for name, one in job.program.signals.items()}

    def pulse(self, node: p.SetSignal) -> Iterator[p.Statement]:
        signal = self.signals.get(node.signal.lower())
        plain = signal is None or signal.kind == "digital"
        seconds = None if node.pulse is None else e.plain_number(node.pulse)
        # A computed time is checked by the controller.
        short = seconds is None or SHORTEST_PULSE <= seconds <= LONGEST_PULSE
        plain = plain and short and self.is_steady(node.value)
        # A pulse without an equivalent stays as it is; `_check_pulse` refuses it when it is built.
        if node.pulse is None or node.value == ON or not plain:
            yield node
            return
        yield replace(node, pulse=None)
        back = e.Binary("-", ON, node.value)
        if isinstance(node.value, e.Number):
            # `e.Binary` and `e.Number` are both expressions; mypy keeps the type of the first.
            back = e.Number(1 - node.value.value)  # type: ignore[assignment]
        lower = Expressions(self.names, self.names.value).lower
        call = s.ProcedureCall(
            "SetDO",
            (
                s.Option("SDelay", lower(node.pulse)),
                s.Positional(s.NameRef(self.names.get("signals", node.signal))),
                s.Positional(lower(back)),
            ),
        )
        text = verbatim.of_node(call, "statements")
        yield p.Opaque(verbatim.LANGUAGE, text, span=node.span)

    def is_steady(self, value: e.Expression) -> bool:
        """True if the value may be worked out twice."""
        names = {x.name.lower() for x in records(value) if isinstance(x, e.Name)}
        return is_repeatable(value) and names.isdisjoint(self.signals)

    changes: ClassVar[Changes] = {p.SetSignal: pulse}


class _StatementAdapter(Rewording):
    """targets: those that paths of a single one become, filled as procedures are adapted."""

    def __init__(self, job: Legalisation, motions: _MotionAdapter, written: PartLegaliser) -> None:
        super().__init__(job)
        self.program, self.motions, self.written = job.program, motions, written
        self.signals = {n.lower(): g for n, g in job.program.signals.items()}
        self.targets: dict[str, Target] = {}
        self.changing = changed_by_others(job.program)
        starts = (x for x in job.program.statements() if isinstance(x, p.StartTimer))
        self.restarted = {x.timer.lower() for x in starts}

    def procedure(self, procedure: Procedure) -> Procedure:
        with self.job.findings.at(procedure.span):
            return super().procedure(procedure)

    def variable(self, variable: Variable, name: str, owner: str = "") -> Variable:
        """With a type that RAPID has."""
        if variable.storage == "constant" and variable.initial is None:
            about = Declared(name, "variables", owner)
            self.job.cannot(f"the constant `{name}` without a value", "give it one", about)
        if owner and variable.storage == "persistent":
            self.job.cannot(f"the persistent `{name}` inside a procedure", "declare it outside")
        initial = variable.initial
        # RAPID has no array without values, so a target that is never given gets one that no move
        # accepts.
        if variable.type == "position" and variable.size:
            initial = map_expressions(initial, _unset_target)
        if variable.type == "truth":
            initial = map_expressions(initial, as_truth)
        initial = map_expressions(initial, self.plain)
        return replace(variable, initial=initial, local=variable.local and not owner)

    def expression(self, x: e.Expression) -> e.Expression:
        match x:
            case e.Elapsed(timer) if timer.lower() not in self.restarted:
                self.job.cannot(f"the time of `{timer}`, which nothing restarts", "restart it")
            case e.Apply("floor", (inner,)) if is_steady(inner, self.changing):
                x = floor(inner)
            case e.Apply("floor"):
                cure = "assign the value to a variable first"
                self.job.cannot("the whole number below a value that is read once", cure)
            case e.Apply("inverse", (inner,)) if is_position(inner, self.known):
                self.job.cannot(
                    "the inverse of a target", "work it out beforehand, or take a pose for it"
                )
        return compared(self.plain(x), self.known)

    def plain(self, x: e.Expression) -> e.Expression:
        """An expression in the form that its text is read back as."""
        match x:
            case e.Unary("-", operand):
                return negated(operand)
            # `-0` is printed as `0` and would differ from what is read back.
            case e.Number(value) if value == 0:
                return e.Number(0)
            case e.Aggregate(items):
                # Numbers in the shape of a target are read back as one.
                made = aggregate(items)
                return x if isinstance(made, e.Aggregate) else self.plain(made)
            case e.TargetValue(target):
                what = "a written out target"
                return e.TargetValue(self.written.target(target, what, what))
            case e.JointValue(joints):
                what = "a written out joint target"
                return e.JointValue(self.written.joints(joints, what, what))
            case e.PoseValue(pose):
                return e.PoseValue(self.written.pose(pose, "a pose") or pose)
            case e.Apply("relative", given) if 4 < len(given) < 7:
                return with_shift_parts(x, 6)
            case e.Here(tool, frame):
                return e.Here(tool_name(tool), frame_name(frame))
            case e.Apply("min" | "max", (_, _, _, *_)):
                return two_at_a_time(x)
            case e.Verbatim(verbatim.LANGUAGE):
                return _understood(x)
        return x

    def whole(self, node: p.Statement) -> p.Statement:
        return with_conditions(node, self.known)


def _understood(x: e.Verbatim) -> e.Expression:
    try:
        known = lift_expression(verbatim.expression(x.text), str)
    except Refused:
        return x  # a finding when it is built
    return x if known == x else known


def _unset_target(x: e.Expression) -> e.Expression:
    """Return a target that no move accepts, like one without a value: its quaternion is zero."""
    if x != e.NEVER_GIVEN:
        return x
    parts = ([0] * 3, [0] * 4, [0] * 4, [UNUSED] * 6)
    return e.Aggregate(tuple(e.Aggregate(tuple(map(e.Number, part))) for part in parts))


_Adaptation = list[p.Statement]


def _motion(a: _StatementAdapter, x: Any) -> _Adaptation:
    triggers = tuple(replace(one, value=_bit_value(one.value)) for one in x.triggers)
    motion = a.motions.motion(_stopping_motion(a, x) if x.until is not None else x.motion)
    return [replace(x, motion=motion, triggers=triggers)]


def _stopping_motion(a: _StatementAdapter, x: p.MoveStatement) -> p.Motion:
    """The motion of a move that is broken off, which the program has to wait for."""
    if declared_value(x.motion.blend, a.program.blends) == FINE:
        return x.motion
    a.job.changed(
        "a corner behind a move that may be broken off", "a stop there",
        "let the robot stop at its end",
    )  # fmt: skip
    return replace(x.motion, blend=FINE)


def _follow(a: _StatementAdapter, x: p.Follow) -> _Adaptation:
    if not len(x.path):
        a.job.changed(f"the path `{x.path.name}`, which has no targets", "nothing", "leave it out")
        return []
    path = a.motions.path(x.path, x.row_span)
    # A path of one target becomes a move. After an error it stays: names and targets are not
    # reliable.
    if len(path) > 1 or has_errors(a.job.findings):
        return [replace(x, path=path)]
    name = identifier(f"{path.name}_1", {*a.program.targets, *a.targets, *a.program.variables})
    a.targets[name] = path.target(0)
    return [move_at(path, 0, e.Name(name))]


def _wait_signal(a: _StatementAdapter, x: p.WaitSignal) -> _Adaptation:
    value = _bit_value(x.value)
    signal = a.signals.get(x.signal.lower())
    # RAPID has no wait instruction for analog signals.
    if signal is not None and signal.kind == "analog":
        condition = e.Binary("=", e.Name(x.signal), value)
        return [p.WaitUntil(condition, x.timeout, span=x.span)]
    return [replace(x, value=value)]


def _bit_value(value: e.Expression) -> e.Expression:
    return e.Number(int(value.value)) if isinstance(value, e.Truth) else value


def _assign(a: _StatementAdapter, x: p.Assign) -> _Adaptation:
    return [replace(x, value=as_truth(x.value)) if is_truth(x.target, a.known) else x]


def _set_signal(_: _StatementAdapter, x: p.SetSignal) -> _Adaptation:
    value = _bit_value(x.value)
    # Reading the text gives a gripper, as RAPID has no other statement for it.
    hand = gripper(x.signal, value) if x.pulse is None else None
    if hand is not None:
        return [replace(hand, span=x.span)]
    return [replace(x, value=value)]


def _opaque(a: _StatementAdapter, x: p.Opaque) -> _Adaptation:
    if x.language != verbatim.LANGUAGE:
        a.job.findings.append(rules.OTHER_LANGUAGE(**verbatim.foreign(x)))
        return [x]
    return list(statements_of(x.text, a.program))


_StatementAdapter.changes = {
    p.Move: _motion,
    p.MoveCircular: _motion,
    p.MoveJoints: _motion,
    p.Follow: _follow,
    p.WaitSignal: _wait_signal,
    p.Assign: _assign,
    p.SetSignal: _set_signal,
    p.SetAcceleration: one_acceleration,
    p.Comment: plain_comment,
    p.Message: short_messages,
    p.Switch: plain_switch,
    p.Opaque: _opaque,
}


def adapt(program: Program, most_targets: int | None = None) -> Adapted:
    """most_targets: of one module, None for MOST_TARGETS."""
    findings = Findings()
    try:
        job = Legalisation(program, capabilities(most_targets), findings)
        adapted = legalise(job, _PASSES)
        findings += NAMES.findings(adapted)
        find_outputs_of_two_names(replace(job, program=adapted))
        trees = _built_units(adapted, findings)
    except Refused as refused:
        findings += refused.findings
        return Adapted(program, tuple(findings))
    return Adapted(adapted, tuple(findings), trees)


def sayable(job: Legalisation) -> Program:
    """The program with all its parts as RAPID has them."""
    program = job.program
    for declaration in program.declarations:
        if declaration.language != verbatim.LANGUAGE:
            with job.findings.at(declaration.span):
                job.findings.append(rules.OTHER_LANGUAGE(**verbatim.foreign(declaration)))
    written = PartLegaliser(job, POSITIONS)
    motions = _MotionAdapter(job, written)
    statements = _StatementAdapter(job, motions, written)
    targets, joints = written.targets(program.targets), written.joint_targets(program.joint_targets)
    variables = {n: statements.variable(v, n) for n, v in program.variables.items()}
    for name, variable in list(variables.items()):
        match None if variable.local else fixed_target(variable):
            case Target() as target:
                targets[name] = target
                del variables[name]
            case JointTarget() as joint_target:
                joints[name] = joint_target
                del variables[name]
    procedures = tuple(map(statements.procedure, program.procedures))
    # An entry that no procedure has would name a routine that is missing.
    entry = program.entry
    if entry is not None and program.procedure(entry) is None:
        entry = None
    # The controller has wobj0 and tool0 by itself; they are not declared.
    frames = {n: f for n, f in program.frames.items() if n.lower() != BASE}
    tools = {n: t for n, t in program.tools.items() if n.lower() != FLANGE}
    return replace(
        program,
        entry=entry,
        comments=tuple(
            line
            for text in (*program.comments, *_load_notes(tools, program.comments))
            for line in comment_lines(text, job)
        ),
        frames=written.frames(frames),
        tools=written.tools(tools),
        speeds=motions.speeds.table(),
        blends=motions.blends.table(),
        signals=with_used_signals(
            program.signals, signal_uses(replace(program, procedures=procedures).statements())
        ),
        targets={**targets, **statements.targets},
        joint_targets=joints,
        variables=variables,
        procedures=procedures,
        # The controller loads a module only in the order types, data, routines.
        declarations=tuple(sorted(program.declarations, key=_declaration_rank)),
    )


def _load_notes(tools: Mapping[str, Tool], said: Sequence[str]) -> list[str]:
    """What the module says of tools whose mass nobody stated, in the words of a draft's heading.

    said: comments that are there. With the least mass the controller moves the arm as if nothing
    was mounted.
    """
    unknown = [name for name, tool in tools.items() if tool.load is None]
    notes = (f"to be filled in: load of tool {n}; the least mass is a stand-in" for n in unknown)
    return [note for note in notes if note not in said]


def _declaration_rank(declaration: Declaration) -> int:
    """Return the position of a declaration in a module: types, then data, then routines, regardless
    of the original order.
    """
    try:
        items = verbatim.items(declaration.text)
    except Refused:
        return 0
    ranks = {s.Record: 0, s.Alias: 0, s.Routine: 2}
    return max((ranks.get(type(item), 1) for item in items), default=0)


_PASSES: Final[tuple[Pass, ...]] = (
    pure(with_rounded_values),
    with_interrupts_first,
    with_measured_places,
    with_named_places,
    with_whole_angles,
    pure(with_results_taken),
    with_floors_read_once,
    pure(with_one_kind_of_numbers),
    with_set_mounts,
    sayable,
    with_channels,
    _with_pulses,
    with_breaks,
    with_interrupts,
    pure(with_own_dates),
    pure(with_own_radian),
    pure(with_places),
    pure(with_directions),
    counted_loops,
    without_counters,
    pure(with_paths),
    split,
    pure(with_comments_behind),
)
"""Legalisation passes in order: first the parts of a program in RAPID's form, then constructs that
need another form.
"""


def _built_units(program: Program, findings: Findings) -> dict[str | None, File]:
    """The units, or a finding for each procedure or declaration that cannot be built."""
    whole: tuple[Diagnostic, ...] = ()
    # The complete build raises at its first fault. To report every fault, each procedure is then
    # built alone, and equal findings are listed once.
    if not has_errors(findings):
        try:
            return {unit: build(program, unit) for unit in (None, *units(program))}
        except Refused as refused:
            whole = refused.findings  # of the first place alone
    data = [] if has_errors(findings) else [replace(program, procedures=())]
    for tried in (*data, *(_single_procedure(program, q) for q in program.procedures)):
        try:
            for unit in (None, *units(tried)):
                build(tried, unit)
        except Refused as refused:
            known = {(f.code, f.message, f.span) for f in findings}
            findings += [f for f in refused.findings if (f.code, f.message, f.span) not in known]
    findings += () if has_errors(findings) else whole
    return {}


def _single_procedure(program: Program, procedure: Procedure) -> Program:
    """A program of one procedure, without its paths."""

    def few(body: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
        return tuple(map_bodies(x, few) for x in body if not isinstance(x, p.Follow))

    one = replace(procedure, body=few(procedure.body))
    return Program(program.name, (one,), procedure.name, signals=program.signals)
