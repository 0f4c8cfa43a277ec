"""Results of a simulation: times of procedures and moves, and the motion over time in columns.

The ledger records each move as it took the longest, the outputs that moves set while they run, and
everything that is unknown.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, error
from assistant.lazy import pictured
from assistant.program.expressions import Expression, Number
from assistant.program.pseudo.expressions import expression_text
from assistant.program.statements import Trigger
from assistant.robots.robot import Robot
from assistant.robots.timing.plan import BINDING_WORDS, FIRST_AXIS, Moment, Plan
from assistant.robots.timing.segments import Duration, History, Segment
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop

_Columns = dict[str, Floats]
"""The columns of `Moment` by name."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Samples:
    """k samples.

    t: (k,) seconds. position: (k, 3) mm and quaternion: (k, 4) of the tool that moves, in the
    base (of a work piece that the arm carries: of the tool in it). joints: (k, a).
    tcp_speed: (k,) mm/s. joint_velocity, joint_acceleration: (k, a).
    """

    t: Floats
    position: Floats
    quaternion: Floats
    joints: Floats
    tcp_speed: Floats
    joint_velocity: Floats
    joint_acceleration: Floats

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        end = float(self.t[-1]) if len(self.t) else 0.0
        return f"<Samples: {len(self)} row{'s' * (len(self) != 1)}, to {end:.2f} s>"

    def _repr_html_(self) -> str:
        return pictured(self)


def samples_of(
    history: History | None, seconds: float, period: float, robot: Robot, start: Floats
) -> Samples:
    """Samples of a history from 0 to its end, the last one before the end or at it."""
    t = np.arange(int(seconds / period + 1e-9) + 1, dtype=np.float64) * period
    columns = _rest_at(robot, start, len(t))
    if history is not None:
        _fill(columns, history, np.arange(len(t)), t, None)
    velocity = columns["velocities"]
    acceleration = np.gradient(velocity, period, axis=0) if len(t) > 1 else velocity * 0.0
    return Samples(
        t,
        columns["positions"],
        rotations.unflipped(columns["quaternions"]),
        columns["joints"],
        columns["speeds"],
        velocity,
        acceleration,
    )


def _rest_at(robot: Robot, start: Floats, count: int) -> _Columns:
    """The columns of `Moment` for an arm that stands still."""
    p, q = robot.flange_poses(start[None])
    rest = Moment(p, q, start[None], np.zeros(1), np.zeros((1, len(start))))
    return {name: np.repeat(getattr(rest, name), count, axis=0) for name in Moment.__slots__}


def _fill(columns: _Columns, history: History, rows: Rows, t: Floats, last: Plan | None) -> None:
    """Fills rows (m,) with a history at times (m,) from its start; last: the plan before it.

    The rounds of a loop are filled together, so that it does not matter how many there are.
    """
    chain = history.chain()
    index = np.searchsorted([node.start for node in chain], t, side="left") - 1
    index = np.clip(index, 0, None)
    order = np.argsort(index, kind="stable")
    bounds = np.searchsorted(index[order], np.arange(len(chain) + 1))
    for at in np.unique(index):
        node, some = chain[at], order[bounds[at] : bounds[at + 1]]
        before = (node.before.last if node.before is not None else None) or last
        inside = t[some] - node.start
        if isinstance(node.done, Plan):
            _put(columns, rows[some], node.done.at(inside))
        elif not isinstance(node.done, tuple):
            if before is not None:
                _put(columns, rows[some], before.at(np.full(len(some), before.seconds)))
        else:
            inner, count = node.done
            gone = np.ceil(inside / inner.seconds) - 1.0 if inner.seconds > 0.0 else 0.0 * inside
            gone = np.clip(gone, 0.0, count - 1.0)
            inside = inside - gone * inner.seconds
            for first, came in ((True, before), (False, inner.last or before)):
                mine = (gone == 0.0) == first
                if mine.any():
                    _fill(columns, inner, rows[some[mine]], inside[mine], came)


def _put(columns: _Columns, rows: Rows, moment: Moment) -> None:
    for name, column in columns.items():
        column[rows] = getattr(moment, name)


_TIME_PARTS: Final = 400
"""Parts of the time of a move between which its way is measured."""


@dataclass(frozen=True, slots=True)
class OutputTime:
    """An output that a move sets on its way.

    number: of the motion statement in its procedure, from 1. value: as text. seconds: after the
    move begins.
    """

    procedure: str
    number: int
    signal: str
    value: str
    seconds: float


def _output_times(
    plan: Plan, rows: slice, triggers: tuple[Trigger, ...], procedure: str, number: int
) -> Iterator[OutputTime]:
    """Yield the output times of the move that spans some rows of a plan; computed positions are
    left out.
    """
    times = np.concatenate([[0.0], np.cumsum(plan.profile.seconds)])
    begin, end = float(times[rows.start]), float(times[rows.stop])
    at = np.linspace(begin, end, _TIME_PARTS + 1)
    steps = norms(np.diff(plan.at(at).positions, axis=0))
    done: Floats = np.concatenate([[0.0], np.cumsum(steps)])
    for one in triggers:
        amount, ahead = (
            _number_value(one.amount),
            0.0 if one.ahead is None else _number_value(one.ahead),
        )
        if amount is None or ahead is None:
            continue
        if one.measure == "time":
            seconds = end - amount
        else:
            whole = float(done[-1])
            way = {"start": amount, "end": whole - amount, "share": whole * amount / 100.0}
            seconds = float(np.interp(way[one.measure], done, at))
        after = min(max(seconds - ahead - begin, 0.0), end - begin)
        yield OutputTime(procedure, number, one.signal, expression_text(one.value), after)


def _number_value(value: Expression) -> float | None:
    return float(value.value) if isinstance(value, Number) else None


_MOST_SAMPLES: Final = 1_000_000
"""Rows of samples that are computed; about 250 bytes each."""
SAMPLE_PERIOD: Final = 0.01
"""seconds between samples, unless that would be too many."""

_TOO_MANY_SAMPLES = error(
    "RB301",
    "{seconds:.0f} s at {period:g} s make {count} samples, more than {most}",
    "take a period of {least:g} s or longer, or none for one that fits",
)
NO_PERIOD = error("RB302", "{value:g} is no {what}", "give a number above 0")


@dataclass(frozen=True, slots=True, eq=False)
class MoveTimes:
    """Columns of m moves in order of text; each as it took the longest.

    procedure: (m,) rows of the table procedures. number: (m,) of the motion statement in its
    procedure, from 1. row: (m,) of its path, from 0. kind: (m,) `Kind`. length: (m,) mm.
    turn: (m,) deg. seconds: (m,). binds: (m,) see `bound_by`.
    """

    procedures: tuple[str, ...]
    procedure: NDArray[np.int32]
    number: NDArray[np.int32]
    row: NDArray[np.int32]
    kind: NDArray[np.uint8]
    length: Floats
    turn: Floats
    seconds: Floats
    binds: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.seconds)


@dataclass(frozen=True, slots=True)
class Unknown:
    """Effect that the times leave out, or include only as assumed.

    procedure: its procedure. what: a clause. times: number of occurrences.
    """

    procedure: str
    what: str
    times: int = 1

    def __str__(self) -> str:
        often = f" ({self.times} times)" if self.times > 1 else ""
        return f"{self.procedure}: {self.what}{often}"


@dataclass(frozen=True, eq=False)
class Simulation:
    """Duration of a program on a robot.

    duration: of the entry. procedures: name → duration of a call, over all calls. outputs: outputs
    that moves set during motion, in order of text. labels: procedure and number of each of its
    motion statements → its target. history: of the branch through the entry that takes the longest.
    start: (a,) joints where it begins. passed: every stretch of moves that was timed, also outside
    that branch. wanted_period: see `period`.
    """

    robot: Robot
    duration: Duration
    procedures: Mapping[str, Duration]
    moves: MoveTimes
    outputs: tuple[OutputTime, ...]
    unknown: tuple[Unknown, ...]
    labels: Mapping[tuple[str, int], str]
    history: History | None
    start: Floats
    passed: tuple[MovesWithoutStop, ...]
    wanted_period: float | None

    @property
    def seconds(self) -> float:
        """Seconds of the entry, in the branch that takes the longest."""
        return self.duration.most

    @property
    def period(self) -> float:
        """Seconds between samples: as wanted, else `SAMPLE_PERIOD` or the least 1, 2 or 5 that
        fits.
        """
        if self.wanted_period is not None:
            return self.wanted_period
        period = SAMPLE_PERIOD
        while self.seconds / period >= _MOST_SAMPLES:
            period *= 2.5 if f"{period:e}".startswith("2") else 2.0
        return period

    @cached_property
    def samples(self) -> Samples:
        """The motion over time; raises Refused if a wanted period gives too many samples."""
        count = int(self.seconds / self.period) + 1
        if count > _MOST_SAMPLES:
            raise Refused(
                _TOO_MANY_SAMPLES(
                    seconds=self.seconds,
                    period=self.period,
                    count=count,
                    most=_MOST_SAMPLES,
                    least=self.seconds / (_MOST_SAMPLES - 1),
                ),
                exit_status=2,
            )
        return samples_of(self.history, self.seconds, self.period, self.robot, self.start)

    def bound_by(self, binds: int) -> str:
        """Describe a value of `MoveTimes.binds` in words."""
        return self.robot.axes[binds - FIRST_AXIS] if binds >= FIRST_AXIS else BINDING_WORDS[binds]


@dataclass(frozen=True, slots=True, eq=False)
class _LedgerEntry:
    """Columns of the rows of one motion statement."""

    kind: NDArray[np.uint8]
    row: NDArray[np.int32]
    length: Floats
    turn: Floats
    seconds: Floats
    binds: NDArray[np.uint8]
    total: float


class Ledger:
    """Takes down the moves as they are timed, each as it took the longest, and notes.

    entries, outputs: by procedure and number of the motion statement. notes: procedure and what is
    not known there → how often it was met.
    """

    def __init__(self) -> None:
        self.entries: dict[tuple[str, int], _LedgerEntry] = {}
        self.outputs: dict[tuple[str, int], tuple[OutputTime, ...]] = {}
        self.notes: dict[tuple[str, str], int] = {}

    def note(self, procedure: str, what: str) -> None:
        self.notes[procedure, what] = self.notes.get((procedure, what), 0) + 1

    def moved(self, pieces: Sequence[Segment], skipped: int, plan: Plan) -> None:
        """Enters the moves of pieces, but for the first `skipped`, as a plan has them."""
        profile, at = plan.profile, -skipped
        for piece in pieces:
            first, last = max(at, 0), at + len(piece.moves)
            at = last
            if last <= 0:
                continue
            rows, seconds = slice(first, last), profile.seconds[first:last]
            total = float(seconds.sum())
            before = self.entries.get((piece.procedure, piece.number))
            if before is not None and before.total >= total:
                continue
            times = _output_times(plan, rows, piece.triggers, piece.procedure, piece.number)
            self.outputs[piece.procedure, piece.number] = tuple(times) if piece.triggers else ()
            left = len(piece.moves) - (last - first)
            self.entries[piece.procedure, piece.number] = _LedgerEntry(
                piece.moves.kinds[left:],
                np.arange(left, len(piece.moves), dtype=np.int32),
                profile.lengths[rows],
                profile.turns[rows],
                seconds,
                profile.binds[rows],
                total,
            )

    def move_times(self, procedures: Sequence[str]) -> MoveTimes:
        """All that was entered, in order of text; procedures: their names in that order."""
        place = {name: index for index, name in enumerate(procedures)}
        keys = sorted(self.entries, key=lambda key: (place[key[0]], key[1]))
        entries = [self.entries[key] for key in keys]
        counts = [len(entry.row) for entry in entries]

        def column(name: str, dtype: type) -> NDArray[np.generic]:
            parts = [getattr(entry, name) for entry in entries]
            return np.concatenate([np.empty(0, dtype), *parts]).astype(dtype)

        return MoveTimes(
            procedures=tuple(procedures),
            procedure=np.repeat([place[name] for name, _ in keys], counts).astype(np.int32),
            number=np.repeat([number for _, number in keys], counts).astype(np.int32),
            row=column("row", np.int32),  # type: ignore[arg-type]
            kind=column("kind", np.uint8),  # type: ignore[arg-type]
            length=column("length", np.float64),  # type: ignore[arg-type]
            turn=column("turn", np.float64),  # type: ignore[arg-type]
            seconds=column("seconds", np.float64),  # type: ignore[arg-type]
            binds=column("binds", np.uint8),  # type: ignore[arg-type]
        )

    def output_times(self, procedures: Sequence[str]) -> tuple[OutputTime, ...]:
        """All that moves set on their way, in order of text."""
        place = {name: index for index, name in enumerate(procedures)}
        keys = sorted(self.outputs, key=lambda key: (place[key[0]], key[1]))
        return tuple(one for key in keys for one in self.outputs[key])

    def unknown(self) -> tuple[Unknown, ...]:
        return tuple(Unknown(where, what, times) for (where, what), times in self.notes.items())
