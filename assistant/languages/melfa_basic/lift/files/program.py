"""From the trees of a program's files to the pseudo-program."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING

from assistant import robots
from assistant.base.source_text import starts_of
from assistant.languages.melfa_basic.lift.files.file import Unit
from assistant.languages.melfa_basic.lift.files.parts import (
    SourceFile,
    changed_settings,
    settings_of_interrupts,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.analysis.integer_inference import without_needless_rounding
from assistant.program.program import Program, identifier
from assistant.program.rewriting import with_spans_from

if TYPE_CHECKING:
    from assistant.robots import Robot


def lift(trees: Sequence[s.File], robot: Robot | None = None, *, divide: bool = True) -> Program:
    """The pseudo-program of a main program and the programs that it calls.

    divide: procedures in which settings differ with the way are read once for each way.
    """
    program, followed = _lifted_files(trees, robot, divide, frozenset())
    if followed and len(trees) > 1:  # what one file needs to know of a setting, all have to tell
        program, _ = _lifted_files(trees, robot, divide, followed)
    return program


def _lifted_files(
    trees: Sequence[s.File], robot: Robot | None, divide: bool, following: frozenset[int]
) -> tuple[Program, frozenset[int]]:
    """The program, and the settings that some of its files follow. following: that all follow."""
    files = [SourceFile(tree) for tree in trees]
    if not files:
        return Program("empty", entry=None), following
    main = next((f for f in files if f.header.unit is None), files[0])
    if robot is None:
        robot = _robot_named(main.header.robot)
    order = list(main.header.names["unit"].values())
    rest = [f for f in files if f is not main]
    rest.sort(key=lambda f: order.index(f.header.unit) if f.header.unit in order else len(order))
    name = main.header.program or file_stem(main.tree) or "program"
    comments = (*main.comments, *(text for file in rest for text in _comments_of(file)))
    program = Program(
        name, robot=main.header.robot, comments=comments, signals=dict(main.header.signals)
    )
    names = [(file_stem(f.tree) or f"-{k}").upper() for k, f in enumerate(files)]
    named = dict(zip(names, files, strict=True))
    touched = changed_settings(named)
    interrupted = settings_of_interrupts(named, touched)
    elsewhere = {id(f): interrupted[name] for name, f in zip(names, files, strict=True)}
    called = frozenset(name for f in files for name in f.called() if name is not None)
    programs = {name: file_stem(named[name].tree) if name in named else None for name in called}
    starts = dict(zip(map(id, files), starts_of(f.tree.source for f in files), strict=True))
    followed: dict[int, str] = {}
    for file in [main, *rest]:
        known = program.procedures
        unit = None if file is main else (file.header.unit or file_stem(file.tree) or "unit")
        program = Unit(
            program, file, main, unit, robot, touched, elsewhere[id(file)], programs,
            following, followed,
        ).added(divide)  # fmt: skip
        added = program.procedures[len(known) :]
        counted = (with_spans_from(procedure, starts[id(file)]) for procedure in added)
        program = replace(program, procedures=(*known, *counted))
    if not any(file.own for file in files):
        program = without_needless_rounding(program)
    return program, frozenset(followed)


def _comments_of(file: SourceFile) -> Iterator[str]:
    """The comments that a called program begins with, the first one behind its name."""
    named = file.own
    for text in file.comments:
        if not named and any(map(str.isalnum, text)):
            named = True
            yield f"{file_stem(file.tree)}: {text}"
        else:
            yield text


def settings_already_set(tree: s.File, wanted: frozenset[int]) -> Iterator[s.Entry]:
    """Lines of a program in one file that set what holds there already, see `Unit`."""
    file, name = SourceFile(tree), "-"
    program = Program(name, signals=dict(file.header.signals))
    touched = changed_settings({name: file})
    robot = _robot_named(file.header.robot)
    called = {name: None for name in file.called() if name is not None}
    unit = Unit(program, file, file, None, robot, touched, frozenset(), called)
    return unit.settings_that_hold(wanted)


def _robot_named(name: str | None) -> Robot | None:
    try:
        return None if name is None else robots.get(name)
    except KeyError:
        return None


def file_stem(tree: s.File) -> str | None:
    path = tree.source.path if tree.source else None
    return identifier(PurePath(path).stem) if path and path != "-" else None
