"""The motion that a page plays: samples of the arm, its moves, and a program without an arm.

Samples are time in seconds, joints (k, a) and poses of the tool; `_room_left` tells how near the
joints are to a limit. A move is known by its procedure and its number there. `StillMotion` and
`StillMoves` stand for a program that no arm runs.
"""

from __future__ import annotations

import base64
from collections.abc import Iterator, Sequence
from dataclasses import field, replace
from itertools import groupby, takewhile
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText, lines_of, visible
from assistant.cell.scene import PlacedRobot
from assistant.compiler.source_map import Places
from assistant.program.geometry import Pose
from assistant.program.motion import Kind
from assistant.program.program import Program, walk
from assistant.program.statements import Moving
from assistant.report.track import track
from assistant.robots.robot import Robot
from assistant.robots.solved_program import Leg, SolvedProgram
from assistant.robots.timing import Simulation
from assistant.robots.timing.course import Mount
from assistant.robots.timing.plan import Plan
from assistant.robots.timing.segments import History, Segment, label_of
from assistant.robots.timing.simulation import SAMPLE_PERIOD, samples_of
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop, stretches_of

_MOST_SAMPLES: Final = 20_000
"""Places of the arm that a page holds."""
_COARSEST: Final = 0.1
"""Seconds between them at most; a page plays no more of a program than that allows."""
_NEAR_JOINTS: Final = 0.5
"""Degrees (mm) that a place on the time line is away from joints that it stands for, at most."""
_NEAR_PATH: Final = 1.0
"""mm of a place from the path of the tool, by which the tool comes to it."""

Record = dict[str, Any]


def column_text(values: NDArray[Any]) -> str:
    """An array as base64 of its little-endian numbers: float32, or uint32 if it holds integers."""
    kind = "<u4" if np.issubdtype(values.dtype, np.integer) else "<f4"
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


class Motion:
    """The way that the page plays: k samples of time, joints and the tool.

    held: whether the tool is at the arm for all of it; else its path is that of the flange.
    whole: seconds of the program.
    """

    def __init__(self, simulation: Simulation, placed: PlacedRobot) -> None:
        self.whole = simulation.seconds
        seconds = min(self.whole, _COARSEST * (_MOST_SAMPLES - 1))
        period = max(SAMPLE_PERIOD, seconds / (_MOST_SAMPLES - 1))
        robot, start = simulation.robot, simulation.start
        samples = samples_of(simulation.history, seconds, period, robot, start)
        self.robot = placed.robot
        self.times, self.joints, self.speeds = samples.t, samples.joints, samples.tcp_speed
        self.held = tool_held(simulation)
        places = samples.position
        if not self.held:
            places = self.robot.link_frames(self.joints)[0][:, -1]
        self.places = placed.base.moved(places)

    def record(self) -> Record:
        room, axis = _room_left(self.robot, self.joints)
        return {
            "times": column_text(self.times),
            "joints": column_text(self.robot.chained(self.joints)),
            "places": column_text(self.places),
            "speeds": column_text(self.speeds),
            "room": column_text(room),
            "nearest": column_text(axis),
            "axes": len(self.robot.axes),
            "names": list(self.robot.axes),
            "halves": _half_ranges(self.robot),
            "units": list(self.robot.units),
            "held": self.held,
            "whole": self.whole,
        }

    @property
    def until(self) -> float:
        """Seconds up to which it is played."""
        return float(self.times[-1])

    def passing(self, place: Floats) -> float | None:
        """Seconds at which the path comes to a place (3,) in the world, None if it never does."""
        start = self.places[:-1]
        if not len(start):
            return None
        step = np.diff(self.places, axis=0)
        square = np.einsum("ij,ij->i", step, step)
        along = np.einsum("ij,ij->i", place - start, step)
        part = np.clip(along / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        off = norms(start + part[:, None] * step - place)
        if off.min() > _NEAR_PATH:
            return None
        at = int(np.flatnonzero(off <= off.min() + _NEAR_PATH / 10.0)[0])
        return float(self.times[at] + part[at] * (self.times[at + 1] - self.times[at]))

    def when(self, joints: Floats) -> float | None:
        """Seconds at which joints (a,) are first passed, None if they are not on this way."""
        start = self.joints[:-1]
        if not len(start):
            return None
        step = np.diff(self.joints, axis=0)
        square = np.einsum("ij,ij->i", step, step)
        along = np.einsum("ij,ij->i", joints - start, step)
        part = np.clip(along / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        off = np.abs(start + part[:, None] * step - joints).max(axis=1)
        if off.min() > _NEAR_JOINTS:
            return None
        at = int(np.flatnonzero(off <= off.min() + _NEAR_JOINTS / 10.0)[0])
        return float(self.times[at] + part[at] * (self.times[at + 1] - self.times[at]))


def _half_ranges(robot: Robot) -> list[float]:
    """Half of each axis' range; 0 of one that turns without end."""
    half = np.ptp(robot.limits, axis=1) / 2.0
    return [float(one) for one in np.where(np.isfinite(half), half, 0.0)]


def _room_left(robot: Robot, joints: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """(k, a) joints → (k,) how near they are to a limit, and (k,) of which axis.

    0 at a limit, 1 in the middle between both, of the axis that has the least: so degrees and mm
    of axes with wide and narrow ranges are compared.
    """
    low, high = robot.limits.T
    half = (high - low) / 2.0
    least = np.minimum(joints - low, high - joints)
    part = np.where(np.isfinite(half) & (half > 0.0), least / np.where(half > 0.0, half, 1.0), 1.0)
    axis = part.argmin(axis=1)
    return np.clip(part[np.arange(len(part)), axis], 0.0, 1.0), axis


def tool_held(simulation: Simulation) -> bool:
    """True if the arm holds the tool, and not the work piece, throughout the program."""
    return all(mount.tool.held and not mount.frame.held for mount in _tool_mounts(simulation))


def tool_tips(simulation: Simulation) -> list[Pose]:
    """Tips of the tools that the arm carries, without the bare flange."""
    found = {mount.tool.tip: None for mount in _tool_mounts(simulation) if mount.tool.held}
    return [tip for tip in found if tip != Pose()]


def _tool_mounts(simulation: Simulation) -> Iterator[Mount]:
    for passed in simulation.passed:
        for piece in passed.pieces:
            yield from piece.moves.mounts


def motion_stages(simulation: Simulation, until: float) -> Iterator[tuple[float, MovesWithoutStop]]:
    """Stretches of moves with the seconds at which each begins, those of a loop in each round.

    until: seconds; those that begin later are left out.
    """
    by_plan = {id(passed.plan): passed for passed in reversed(simulation.passed)}
    played = takewhile(lambda one: one[0] <= until, _stage_plans(simulation.history, 0.0))
    for start, plan in played:
        passed = by_plan.get(id(plan))
        if passed is not None:
            yield start, passed


def _stage_plans(history: History | None, start: float) -> Iterator[tuple[float, Plan]]:
    for node in () if history is None else history.chain():
        if isinstance(node.done, Plan):
            yield start + node.start, node.done
        elif isinstance(node.done, tuple):
            inner, count = node.done
            for i in range(count if inner.last is not None else 0):
                yield from _stage_plans(inner, start + node.start + i * inner.seconds)


MOST_MOVES: Final = 2_000
"""Motion statements in the list."""
_MOST_PLAYED: Final = 40_000
"""Passings of moves that the time line knows; loops have many."""
_MOST_TEXT: Final = 200
"""Characters of a statement that are shown."""
_MOST_LINE_TEXT: Final = 2_000
"""Characters of a line that are shown."""
_MOST_LINES: Final = 100_000
"""Lines of the program's texts."""

MoveKey = tuple[str, int]
"""Procedure, and number of a motion statement in it."""


def text_records(texts: Sequence[SourceText]) -> tuple[list[Record], int]:
    """The texts, each with its lines and the number of the first; and lines left out."""
    found: list[Record] = []
    first = 1
    for source in texts:
        count = max(0, min(source.line_count, _MOST_LINES + 1 - first))
        lines = [_shortened(visible(source.line_text(i + 1))) for i in range(count)]
        path = None if source.path is None else visible(source.path)
        found.append({"path": path, "first": first, "lines": lines})
        first += source.line_count
    return found, max(0, first - 1 - _MOST_LINES)


def _shortened(line: str) -> str:
    return line if len(line) <= _MOST_LINE_TEXT else line[:_MOST_LINE_TEXT] + "…"


class Moves:
    """Motion statements in order of text, and the times at which they begin in the played motion.

    until: seconds up to which it is played. keys: procedure and number of each. begins: seconds,
    place in the list and line of the text (0 for none), in order of time, of at most
    `_MOST_PLAYED`.
    until: seconds up to which these are complete.
    """

    def __init__(
        self, solution: SolvedProgram, simulation: Simulation, places: Places, until: float
    ) -> None:
        self.solution, self.labels, self.texts = solution, simulation.labels, places
        self.keys = list(simulation.labels)
        self.places = {key: i for i, key in enumerate(self.keys)}
        self._in_run = set[MoveKey]()  # statements that are a line each of a run with one span
        self._run: tuple[Span, Sequence[str]] | None = None
        self._lines = dict(self._numbered())
        self.begins: list[tuple[float, int, int]] = []
        self.until = until
        known: dict[int, list[tuple[float, int, int]]] = {}
        for start, passed in motion_stages(simulation, until):
            if len(self.begins) >= _MOST_PLAYED:
                self.until = start
                break
            if id(passed) not in known:
                known[id(passed)] = list(self._passings(passed))
            self.begins += [
                (start + time, at, line)
                for time, at, line in known[id(passed)]
                if start + time <= until
            ]
        self.spans: dict[int, int] = {}  # of statements that share one the first
        for name, legs in solution.legs.items():
            for number, leg in enumerate(legs, start=1):
                if leg.statement.span is not None and (name, number) in self.places:
                    self.spans.setdefault(leg.statement.span.start, self.places[name, number])

    def __len__(self) -> int:
        return len(self.keys)

    def records(self) -> list[Record]:
        """Those of the list; `time` is when each begins first, None if it is not played."""
        first: dict[int, float] = {}
        for time, place, _ in self.begins:
            first.setdefault(place, time)
        return [self._record(key, first.get(i)) for i, key in enumerate(self.keys[:MOST_MOVES])]

    def played(self) -> Record:
        times, places, lines = zip(*self.begins, strict=True) if self.begins else ((), (), ())
        return {
            "times": column_text(np.array(times, dtype=np.float64)),
            "moves": column_text(np.array(places, dtype=np.int64)),
            "lines": column_text(np.array(lines, dtype=np.int64)),
            "until": self.until,
        }

    def lines(self) -> tuple[list[Record], int]:
        """The texts, see `text_records`."""
        return text_records(self.texts.texts)

    def of_finding(self, finding: Diagnostic) -> int | None:
        """The place in the list of the statement that a finding is at."""
        return None if finding.span is None else self.spans.get(finding.span.start)

    def line_of(self, key: MoveKey, row: int = 0) -> int:
        """Return the line of a move, counted through all texts from 1; 0 without a line."""
        rows = self._lines.get(key, ())
        return rows[row] if row < len(rows) else rows[0] if rows else 0

    def _passings(self, passed: MovesWithoutStop) -> Iterator[tuple[float, int, int]]:
        """Yield moves of a stretch that have a separate line, and statements, with the seconds in
        it after which they begin.
        """
        stretches = stretches_of(passed.plan)
        before: tuple[Segment, int] | None = None
        rows, first = np.unique(stretches.row, return_index=True)
        for row, at in zip(rows.tolist(), first.tolist(), strict=True):
            piece, inner = passed.piece_of(row)
            key = piece.procedure, piece.number
            line = self.line_of(key, inner)
            if before is None or before[0] is not piece or before[1] != line:
                yield float(stretches.times[at]), self.places[key], line
            before = piece, line

    def _leg(self, key: MoveKey) -> Leg | None:
        procedure, number = key
        legs = self.solution.legs.get(procedure, ())
        return legs[number - 1] if number <= len(legs) else None

    def _numbered(self) -> Iterator[tuple[MoveKey, Sequence[int]]]:
        """Each statement with its line, or with those of its moves.

        A run of like lines has one span: if it has as many lines as moves, each is one of them.
        """
        for name, legs in self.solution.legs.items():
            numbered = enumerate(legs, start=1)
            for span, same in groupby(numbered, key=lambda one: one[1].statement.span):
                run = list(same)
                first, last = (0, 0) if span is None else self.texts.lines(span)
                if first == 0:
                    continue
                moves = [_last_on_line(leg) for _, leg in run]
                told = sum(map(len, moves)) and sum(sum(ends) for ends in moves) == last - first + 1
                line = first
                for (number, _), ends in zip(run, moves, strict=True):
                    lines = []
                    for end in ends or (True,):
                        lines.append(line)
                        line += int(told and end)
                    yield (name, number), tuple(lines) if told else (first,)
                    if told and len(run) > 1:
                        self._in_run.add((name, number))

    def _lines_of_run(self, span: Span, text: str) -> Sequence[str]:
        """Return the lines of a run; the last run is cached, as its moves come one after the
        other.
        """
        if self._run is None or self._run[0] != span:
            self._run = span, lines_of(text)
        return self._run[1]

    def _record(self, key: MoveKey, time: float | None) -> Record:
        procedure, number = key
        leg = self._leg(key)
        span = None if leg is None else leg.statement.span
        place = None if span is None else self.texts.of(span)
        path = None if place is None or place.path is None else visible(place.path)
        line = self.line_of(key)
        if place is not None and span is not None:
            if key in self._in_run:
                own = line - self.texts.lines(span)[0]
                text = self._lines_of_run(span, place.text)[own].strip()
                place = replace(place, line=place.line + own, text=text)
        return {
            "procedure": visible(procedure),
            "number": number,
            "label": visible(self.labels[key].strip("`")),
            "time": time,
            "line": None if place is None else place.line,
            "global": line,
            "path": path,
            "text": "" if place is None else _one_line(place.text),
        }


def _one_line(text: str) -> str:
    """The beginning of a statement's text on one line."""
    return visible(" ".join(text.split())[:_MOST_TEXT])


def _last_on_line(leg: Leg) -> list[bool]:
    """Return a flag for each move of a statement: True if it ends a line of the text; an arc has
    two.
    """
    if leg.solved_run is None:
        return [True] if len(leg.joints) <= 1 else [False] * (len(leg.joints) - 1) + [True]
    return [bool(end) for end in leg.solved_run.run.kinds[leg.rows] != Kind.VIA]


_MOST_PLACES: Final = 100_000
"""Most points of the path of a program that is only drawn."""
_NO_NUMBERS: Final = column_text(np.zeros(0))


@dataclass(frozen=True, slots=True)
class StillMotion:
    """Motion record of a page without a motion."""

    until: float = 0.0

    def record(self) -> Record:
        names = ("times", "joints", "places", "speeds", "room", "nearest")
        rest = {"axes": 0, "names": [], "halves": [], "units": [], "held": True, "whole": 0.0}
        return dict.fromkeys(names, _NO_NUMBERS) | rest

    def passing(self, place: Floats) -> None:
        """No time at all."""


@dataclass(slots=True)
class StillMoves:
    """The motion statements of a program in order of text."""

    program: Program
    texts: Places
    _spans: dict[int, int] = field(default_factory=dict)
    _records: list[Record] = field(default_factory=list)

    def __post_init__(self) -> None:
        for procedure in self.program.procedures:
            moving = (one for one in walk(procedure.body) if isinstance(one, Moving))
            for number, statement in enumerate(moving, start=1):
                self._add((procedure.name, number), statement)

    def __len__(self) -> int:
        return len(self._records)

    def records(self) -> list[Record]:
        return self._records[:MOST_MOVES]

    def played(self) -> Record:
        return {"times": _NO_NUMBERS, "moves": _NO_NUMBERS, "lines": _NO_NUMBERS, "until": 0.0}

    def lines(self) -> tuple[list[Record], int]:
        """The texts, see `text_records`."""
        return text_records(self.texts.texts)

    def of_finding(self, finding: Diagnostic) -> int | None:
        """The place in the list of the statement that a finding is at."""
        return None if finding.span is None else self._spans.get(finding.span.start)

    def _add(self, key: MoveKey, statement: Moving) -> None:
        procedure, number = key
        span = statement.span
        place = None if span is None else self.texts.of(span)
        if span is not None:
            self._spans.setdefault(span.start, len(self._records))
        self._records.append(
            {
                "procedure": visible(procedure),
                "number": number,
                "label": visible(label_of(statement).strip("`")),
                "time": None,
                "line": None if place is None else place.line,
                "global": 0 if span is None else self.texts.lines(span)[0],
                "path": None if place is None or place.path is None else visible(place.path),
                "text": "" if place is None else _one_line(place.text),
            }
        )


def path_record(program: Program, base: Pose) -> Record:
    """The way of the tool as straight pieces between its targets; `joint` where a joint move leads
    to one, whose way nobody tells.
    """
    way = track(program)
    places: Floats = base.moved(way.positions[:_MOST_PLACES])
    joint = (way.kinds[:_MOST_PLACES] == Kind.JOINT).astype(np.int64)
    left = max(0, len(way) - _MOST_PLACES)
    return {"places": column_text(places), "joint": column_text(joint), "left": left}
