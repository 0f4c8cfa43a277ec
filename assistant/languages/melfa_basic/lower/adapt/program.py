"""A program as MELFA-BASIC will say it: what is said differently is a finding."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Declared, Diagnostic, Findings, Span, has_errors
from assistant.languages.computed_targets import with_computed_targets
from assistant.languages.language_types import Adapted
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.channels import with_channels
from assistant.languages.melfa_basic.lower.adapt.long_conditions import with_short_conditions
from assistant.languages.melfa_basic.lower.adapt.statements import PlainProgram
from assistant.languages.melfa_basic.lower.adapt.vendor_text import check_vendor_names
from assistant.languages.melfa_basic.lower.names import Names, naming
from assistant.languages.melfa_basic.lower.program import UnitLines
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.capabilities import capabilities
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.tables.variables import is_external
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.step_numbers import steps_in
from assistant.program.analysis.io_use import with_one_name
from assistant.program.analysis.motion_use import branches_by_frame
from assistant.program.analysis.uses import shared_between_units
from assistant.program.geometry import BASE
from assistant.program.passes.hoisted_statements import with_functions_before_moves
from assistant.program.passes.legalisation import Legalisation, Pass, legalise, pure, traced
from assistant.program.passes.line_lengths import with_short_sums
from assistant.program.passes.loops import with_settled_loops
from assistant.program.passes.names import with_declared_names
from assistant.program.passes.operator_texts import (
    comment_lines,
    with_blank_lines,
    with_comments_in_front,
)
from assistant.program.passes.parameters import with_sayable_procedures
from assistant.program.passes.paths import split
from assistant.program.passes.positions import in_base
from assistant.program.passes.procedure_forms import (
    with_entry_first,
    with_fresh_variables,
    with_interrupts_first,
    with_units_together,
    without_recursion,
)
from assistant.program.passes.signals import with_checked_outputs, with_few_pulses
from assistant.program.passes.switches import with_single_reads
from assistant.program.passes.trigger_positions import with_measured_places
from assistant.program.passes.variables import (
    with_array_parameters,
    with_copied_arrays,
    with_filled_arrays,
    with_first_values,
    with_kept_values,
)
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.robots import Robot


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
    job = replace(job, program=legalise(job, FIRST_PASSES))
    plain = PlainProgram(job, dialect, robot, products)
    job = replace(job, program=traced("sayable", plain.program()))
    adapted = legalise(job, LAST_PASSES)
    adapted = with_short_conditions(adapted, dialect, robot, products=products)
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
    trees = {} if has_errors(findings) else trees
    return Adapted(adapted, tuple(findings), trees, tuple(wanting))


FIRST_PASSES: Final[tuple[Pass, ...]] = (
    with_channels,
    pure(with_entry_first),
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

LAST_PASSES: Final[tuple[Pass, ...]] = (
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
    check_vendor_names(program, names, findings)
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
