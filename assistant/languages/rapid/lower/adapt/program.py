"""A pseudo-program as RAPID can say it: what is rewritten, and a finding for each change."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.base.diagnostics import Diagnostic, Findings, Refused, has_errors
from assistant.languages.language_types import Adapted
from assistant.languages.legalisation import PartLegaliser
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.declared_data import fixed_target
from assistant.languages.rapid.lift.expressions import with_own_dates
from assistant.languages.rapid.lift.vendor_effects import with_places
from assistant.languages.rapid.lower.adapt.breaking import with_breaks
from assistant.languages.rapid.lower.adapt.channels import with_channels
from assistant.languages.rapid.lower.adapt.data import POSITIONS
from assistant.languages.rapid.lower.adapt.interrupts import with_interrupts
from assistant.languages.rapid.lower.adapt.motions import MotionAdapter
from assistant.languages.rapid.lower.adapt.mounts import with_set_mounts
from assistant.languages.rapid.lower.adapt.pulses import with_pulses
from assistant.languages.rapid.lower.adapt.statements import StatementAdapter
from assistant.languages.rapid.lower.names import NAMES
from assistant.languages.rapid.lower.program import build
from assistant.languages.rapid.tables.capabilities import capabilities
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import File
from assistant.program import statements as p
from assistant.program.analysis.io_use import signal_uses, with_used_signals
from assistant.program.geometry import BASE, FLANGE, JointTarget, Target
from assistant.program.passes.expression_forms import with_one_kind_of_numbers, with_rounded_values
from assistant.program.passes.legalisation import Legalisation, Pass, legalise, pure
from assistant.program.passes.loops import counted_loops, with_directions
from assistant.program.passes.operator_texts import comment_lines, with_comments_behind
from assistant.program.passes.paths import split, with_paths
from assistant.program.passes.positions import with_named_places, with_whole_angles
from assistant.program.passes.procedure_forms import (
    units,
    with_interrupts_first,
    with_results_taken,
)
from assistant.program.passes.signals import find_outputs_of_two_names
from assistant.program.passes.switches import with_floors_read_once
from assistant.program.passes.trigger_positions import with_measured_places
from assistant.program.program import Declaration, Procedure, Program
from assistant.program.rewriting import map_bodies


def adapt(program: Program, most_targets: int | None = None) -> Adapted:
    """most_targets: of one module, None for MOST_TARGETS."""
    findings = Findings()
    try:
        job = Legalisation(program, capabilities(most_targets), findings)
        adapted = legalise(job, PASSES)
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
    motions = MotionAdapter(job, written)
    statements = StatementAdapter(job, motions, written)
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
    entry = program.entry
    if entry is not None and program.procedure(entry) is None:
        entry = None
    frames = {n: f for n, f in program.frames.items() if n.lower() != BASE}
    tools = {n: t for n, t in program.tools.items() if n.lower() != FLANGE}
    return replace(
        program,
        entry=entry,
        comments=tuple(line for text in program.comments for line in comment_lines(text, job)),
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
        declarations=tuple(sorted(program.declarations, key=_declaration_rank)),
    )


def _declaration_rank(declaration: Declaration) -> int:
    """Where it stands in a module: types, then data, then routines, whatever came first."""
    try:
        items = verbatim.items(declaration.text)
    except Refused:
        return 0
    ranks = {s.Record: 0, s.Alias: 0, s.Routine: 2}
    return max((ranks.get(type(item), 1) for item in items), default=0)


PASSES: Final[tuple[Pass, ...]] = (
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
    with_pulses,
    with_breaks,
    with_interrupts,
    pure(with_own_dates),
    pure(with_places),
    pure(with_directions),
    counted_loops,
    pure(with_paths),
    split,
    pure(with_comments_behind),
)
"""Parts of a program as RAPID has them, and then what it says in other words, in this order."""


def _built_units(program: Program, findings: Findings) -> dict[str | None, File]:
    """The units, or a finding for each procedure or declaration that cannot be built."""
    whole: tuple[Diagnostic, ...] = ()
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
