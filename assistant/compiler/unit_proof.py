"""Long paths in many units: each unit is printed and proven alone, by several processes.

A controller loads such a unit beside the main one, calls its procedure and unloads it. So each is
checked, lifted and compared beside the data of the main unit; the main unit, with procedures that
do nothing in place of the others, comes last. Path names that differ keep the names of targets in
different units apart. If there is anything to report, all units are proven once more together, so
that the findings read as those of a shorter program.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.budgets import PRINTING, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.worker_processes import Processes, process_count
from assistant.compiler.read_back_proof import Proof, prove_read_back
from assistant.languages.lark_parsing import WHOLE, Parsed, Spacing
from assistant.program.motion import Kind
from assistant.program.program import Program
from assistant.program.statements import Follow

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.languages.language_types import Adapted
    from assistant.program.comparison import Comparison
    from assistant.robots import Robot

_MOST_BESIDE: Final = 500
"""Declarations and procedures of a main unit that each other unit is proven beside."""
_TABLES: Final = (
    *("frames", "tools", "speeds", "blends", "signals"),
    *("targets", "joint_targets", "variables", "declarations"),
)


@dataclass(frozen=True, slots=True)
class _Unit:
    """A unit to print and prove.

    program: as adapted, with the procedures of this unit alone. tree: as built. main: stands for
    the tree of the main unit.
    """

    language: Language[Any]
    program: Program
    name: str
    tree: Any
    main: Any
    robot: Robot | None
    spacing: Spacing


@dataclass(frozen=True, slots=True)
class _Proven:
    """A unit that was proven. shell: stands for its tree beside the main unit."""

    data: bytes
    comparison: Comparison
    grammar: Parsed | None
    shell: Any


@dataclass(frozen=True, slots=True)
class ProvenFiles:
    """Files by name, and the proof of all of them."""

    files: dict[str, bytes]
    proof: Proof


def prove_by_unit(
    language: Language[Any], adapted: Adapted, robot: Robot | None, jobs: int | None
) -> ProvenFiles | None:
    """Return the files of an adapted program and their proof, unit by unit.

    jobs: processes that share the work, None for the usual number. None if the program has not
    many units of paths alone, or if there is anything to report about one.
    """
    program = adapted.program
    names = _path_units(program)
    if not names:
        return None
    with within(PRINTING, None, program.size()):
        main = language.encode(language.built(adapted, robot))
    main_name = language.file_name(program)
    tree = language.parse(language.decode(main, main_name))
    around = language.shell(tree, data=True)
    if around is None:
        return None
    spacing = Spacing.of([size for _, path in _paths(program) for size in path])
    units = [
        _Unit(
            language,
            _part(program, name),
            language.file_name(program, name),
            language.built(adapted, robot, name),
            around,
            robot,
            spacing,
        )
        for name in names
    ]
    count = process_count(len(units), jobs)
    # A unit at which processes die is proven here, in the end.
    found = (
        Processes(count).answers(_proven, units, lambda unit, _: _proven(unit))
        if count > 1
        else map(_proven, units)
    )
    done: list[_Proven] = []
    for one in found:
        if one is None:
            return None
        done.append(one)
    files = {main_name: main} | {unit.name: one.data for unit, one in zip(units, done, strict=True)}
    whole = prove_read_back(
        language,
        program,
        {main_name: main},
        robot,
        reduced=partial(_without_content, units=frozenset(names)),
        beside=[one.shell for one in done],
        spacing=spacing,
    )
    if not whole.holds or whole.findings or whole.comparison is None:
        return None
    each = (whole.grammar, *(one.grammar for one in done))
    parsed = [one for one in each if one is not None]
    grammar = Parsed(sum(one.lines for one in parsed), sum(one.total for one in parsed))
    proof = Proof(
        _joined(whole.comparison, [one.comparison for one in done], program),
        read=partial(_read_again, language, files, robot),
        grammar=grammar if parsed else None,
    )
    return ProvenFiles(files, proof)


def _path_units(program: Program) -> list[str]:
    """Return the units besides the main one if they do nothing but follow long paths."""
    units = dict.fromkeys(q.unit for q in program.procedures if q.unit is not None)
    inside = [q for q in program.procedures if q.unit is not None]
    plain = all(
        not (q.parameters or q.variables or q.result)
        and all(isinstance(node, Follow) for node in q.body)
        for q in inside
    )
    # A program from another language may have modules that its task holds all at once.
    if not plain or program.origin is not None:
        return []
    paths = list(_paths(program))
    declared = sum(len(getattr(program, table)) for table in _TABLES)
    beside = declared + len(program.procedures) - len(inside)
    rows = sum(len(node.path) for q in inside for node in q.body if isinstance(node, Follow))
    alike = len({name.lower() for name, _ in paths}) < len(paths)
    return [] if alike or beside > _MOST_BESIDE or rows <= WHOLE else list(units)


def _paths(program: Program) -> Iterator[tuple[str, tuple[int, int]]]:
    """Yield the name of each path, and the numbers of its targets and of its moves."""
    for node in program.statements():
        if isinstance(node, Follow):
            moves = len(node.path) - int(np.count_nonzero(node.path.kinds == Kind.VIA))
            yield node.path.name, (len(node.path), moves)


def _part(program: Program, unit: str) -> Program:
    """Return a program with the procedures of one unit, which uses no signals."""
    kept = tuple(q for q in program.procedures if q.unit == unit)
    return replace(program, procedures=kept, signals={}, origin=None)


def _without_content(program: Program, units: frozenset[str]) -> Program:
    """Return a program whose procedures in these units do nothing."""
    return replace(
        program,
        procedures=tuple(replace(q, body=()) if q.unit in units else q for q in program.procedures),
    )


def _proven(unit: _Unit) -> _Proven | None:
    """Print and prove a unit, also in a worker process; None if there is anything to report."""
    # Checks and lifting leave objects that refer to each other. They are few, so that without this
    # the columns of many units would gather before the collector runs.
    gc.collect(1)
    language, (first, *_) = unit.language, unit.program.procedures
    try:
        with within(PRINTING, None, unit.program.size()):
            data = language.encode(unit.tree)
        proof = prove_read_back(
            language,
            unit.program,
            {unit.name: data},
            unit.robot,
            reduced=lambda program: _part(program, first.unit or ""),
            beside=[unit.main],
            spacing=unit.spacing,
        )
    except Refused:
        return None
    lifted, compared = proof.lifted, proof.comparison
    if not proof.holds or proof.findings or compared is None or lifted is None:
        return None
    assert lifted.origin is not None
    shell = language.shell(lifted.origin.trees[0], data=False)
    return _Proven(data, compared, proof.grammar, shell)


def _joined(main: Comparison, units: Sequence[Comparison], program: Program) -> Comparison:
    """Return the comparison of all units; each has compared the targets of the main one as well."""
    worst = max((main, *units), key=lambda one: one.position)
    rows = sum(
        sum(path[0] for _, path in _paths(_part(program, unit)))
        for unit in dict.fromkeys(q.unit for q in program.procedures)
        if unit is not None
    )
    return replace(
        worst,
        statements=main.statements + sum(one.statements for one in units),
        targets=main.targets + rows,
        angle=max(one.angle for one in (main, *units)),
    )


def _read_again(
    language: Language[Any], files: Mapping[str, bytes], robot: Robot | None
) -> Program:
    trees = [language.parse(language.decode(data, name)) for name, data in files.items()]
    return language.lift(trees, robot)
