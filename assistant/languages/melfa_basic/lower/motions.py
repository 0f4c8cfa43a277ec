"""Moves and paths as lines: what a move needs to hold, and the move."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Declared
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.expressions import Unsayable
from assistant.languages.melfa_basic.lower.triggers import appended_statement
from assistant.languages.melfa_basic.tables.words import ARC_START
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MOV, MVR, MVS, MoveRows
from assistant.languages.melfa_basic.tree.line_tables import rows_as_lines
from assistant.languages.runs.paths import setting_codes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE
from assistant.program.motion import Blend, Kind, Path, Speed

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.writer import Writer


def write_move(w: Writer, node: p.Move) -> None:
    target = _move_arguments(w, node.target, node.motion.frame)
    _write_motion_settings(w, node.motion)
    append = appended_statement(w, node)
    w.add(s.Motion("Mov" if node.kind == "joint" else "Mvs", target, append=append))
    _remember_place(w, target, node)


def write_joint_move(w: Writer, node: p.MoveJoints) -> None:
    target = w.expressions.target(node.target)
    _write_motion_settings(w, node.motion)
    w.add(s.Motion("Mov", (target,), append=appended_statement(w, node)))
    w.previous = None


def write_circular_move(w: Writer, node: p.MoveCircular) -> None:
    frame = node.motion.frame
    via, target = w.expressions.target(node.via), w.expressions.target(node.target)
    _write_motion_settings(w, node.motion)
    start = _arc_start(w, node.motion.tool, frame)
    points = start, _target_in_frame(w, via, frame), _target_in_frame(w, target, frame)
    w.add(s.Motion("Mvr", points, append=appended_statement(w, node)))
    _remember_place(w, (target,), node)


def write_path(w: Writer, node: p.Follow) -> None:
    path = node.path
    if not len(path):
        raise Unsayable(f"the empty path `{path.name}`", "leave it out")
    first = w.number
    w.number += len(path)
    w.paths.append((first, path))
    for start, stop in path_segments(path):
        _write_segment(w, path, start, stop, first)
    w.previous = None
    if path.kinds[-1] != Kind.VIA:
        last = len(path) - 1
        tool, frame = path.tools[path.tool[last]], path.frames[path.frame[last]]
        w.previous = f"P{first + last}", tool, frame


def _write_motion_settings(w: Writer, motion: p.Motion) -> None:
    _write_settings(w, motion.speed, motion.blend, motion.tool, motion.frame)


def _write_settings(
    w: Writer,
    speed: Speed | p.ComputedSpeed | e.Name,
    blend: Blend | p.ComputedBlend | e.Name,
    tool: str,
    frame: str,
) -> None:
    """Writes what does not hold already."""
    if isinstance(speed, e.Name) or isinstance(blend, e.Name):
        raise Unsayable("a speed or blend by name", "declare its value")
    w.mount(tool, frame)
    w.move_by(speed, blend)


def _target_in_frame(w: Writer, target: s.Expression, frame: str) -> s.Expression:
    """A target in its frame: as it stands where `Base` is the frame, else multiplied by it."""
    if not w.names.products or frame.lower() == BASE:
        return target
    name = w.names.frames.get(frame.lower())
    if name is None:
        raise Unsayable(f"a target in `{frame}`, whose place is not known", "declare the frame")
    return s.Binary("*", s.Variable(name), target)


def _move_arguments(w: Writer, value: e.Expression, frame: str) -> tuple[s.Expression, ...]:
    """The arguments of a move; a distance along the tool has a form of its own."""
    match value:
        case e.Apply(function="relative", arguments=(base, x, y, z)) if (
            e.plain_number(x) == 0 and e.plain_number(y) == 0
        ):
            return _target_in_frame(w, w.expressions.target(base), frame), w.expressions.of(z)
    return (_target_in_frame(w, w.expressions.target(value), frame),)


def _remember_place(
    w: Writer, target: tuple[s.Expression, ...], node: p.Move | p.MoveCircular
) -> None:
    """Where the robot stands, if the next arc may name it."""
    w.previous, motion = None, node.motion
    if node.until is not None:
        return
    match target:
        case (s.Binary("*", s.Variable(), inner),) if (
            _target_in_frame(w, inner, motion.frame) == target[0]
        ):
            target = (inner,)
    match target:
        case (s.Variable(name=name, arguments=None, component=""),) if "_" not in name:
            w.previous = name, motion.tool, motion.frame


def _arc_start(w: Writer, tool: str, frame: str) -> s.Expression:
    """The position that an arc starts at; read from the robot if it is not known."""
    if w.previous is not None and w.previous[1:] == (tool, frame):
        return _target_in_frame(w, s.Variable(w.previous[0]), frame)
    name = w.owner.name if w.owner else "main"
    w.report(rules.ARC_AT_START(name=name, about=Declared(name, "procedures", in_full=True)))
    start = s.Variable(ARC_START)
    w.add(s.Assign(start, s.Variable(w.expressions.word("P_Curr"))))
    return start


def _write_segment(w: Writer, path: Path, start: int, stop: int, first: int) -> None:
    """Rows under the same settings."""
    speed, blend = path.speeds[path.speed[start]], path.blends[path.blend[start]]
    tool, frame = path.tools[path.tool[start]], path.frames[path.frame[start]]
    _write_settings(w, speed, blend, tool, frame)
    kinds = path.kinds[start:stop]
    if kinds[0] == Kind.VIA:
        known = f"P{first + start - 1}"
        if start == 0 or w.previous != (known, tool, frame):
            begin = _arc_start(w, tool, frame)
            numbers = (first + start, first + start + 1)
            ends = (_target_in_frame(w, s.Variable(f"P{n}"), frame) for n in numbers)
            w.add(s.Motion("Mvr", (begin, *ends)))
            start += 2
            kinds = kinds[2:]
    if start < stop:
        rows = _move_rows(kinds, first + start)
        w.items += (
            [rows] if frame.lower() == BASE or not w.names.products else _write_rows(w, rows, frame)
        )
    w.previous = f"P{first + stop - 1}", tool, frame


def _write_rows(w: Writer, rows: MoveRows, frame: str) -> Iterator[s.Line]:
    """Moves in columns as lines, each target in its frame."""
    for line in rows_as_lines(rows):
        if isinstance(line, s.Line) and isinstance(line.statement, s.Motion):
            targets = (
                _target_in_frame(w, a, frame) for a in line.statement.arguments if a is not None
            )
            yield s.Line(statement=replace(line.statement, arguments=tuple(targets)))


def path_segments(path: Path) -> Iterator[tuple[int, int]]:
    """Ranges of rows under the same settings; an arc's two rows are never apart."""
    codes = setting_codes(path)
    differs = (codes[1:] != codes[:-1]) & (path.kinds[1:] != Kind.END)
    edges = [0, *(np.flatnonzero(differs) + 1).tolist(), len(path)]
    yield from itertools.pairwise(edges)


_ROW_KINDS: Final = np.array([MOV, MVS, -1, MVR], dtype=np.int64)


def _move_rows(kinds: Any, first: int) -> MoveRows:
    """The moves through P<first> … of rows of these kinds; an arc's two rows are one move."""
    ends = np.flatnonzero(kinds != Kind.VIA)
    code = _ROW_KINDS[kinds[ends]]
    number = first + ends.astype(np.int64)
    arc = code == MVR
    return MoveRows(
        "P",
        np.zeros(len(ends), dtype=np.int64),
        code,
        np.where(arc, number - 2, -1),
        np.where(arc, number - 1, -1),
        number,
    )
