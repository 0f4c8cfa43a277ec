"""Results of a simulation: times for people and as plain data, the motion as tables."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.program.motion import Kind
from assistant.robots.timing import Duration, MoveTimes, OutputTime, Simulation

_SLOWEST: Final = 10
"""Motion statements that are shown to people."""
_KINDS: Final = {Kind.JOINT: "joint", Kind.LINEAR: "linear", Kind.VIA: "arc", Kind.END: "arc"}


@dataclass(frozen=True, slots=True)
class Statement:
    """A motion statement as a whole. rows: targets. bound: what the most time is spent at."""

    procedure: str
    number: int
    label: str
    kind: str
    rows: int
    length: float
    turn: float
    seconds: float
    bound: str


def statements(simulation: Simulation) -> list[Statement]:
    """The motion statements in order of text."""
    moves = simulation.moves
    if not len(moves):
        return []
    new = (np.diff(moves.procedure) != 0) | (np.diff(moves.number) != 0)
    starts = np.concatenate([[0], np.flatnonzero(new) + 1])
    ends = np.append(starts[1:], len(moves))
    return [_statement(simulation, moves, slice(a, b)) for a, b in zip(starts, ends, strict=True)]


def _statement(simulation: Simulation, moves: MoveTimes, rows: slice) -> Statement:
    first = int(rows.start)
    procedure, number = moves.procedures[moves.procedure[first]], int(moves.number[first])
    label = simulation.labels[procedure, number]
    count = int(rows.stop - first)
    spent = np.bincount(moves.binds[rows], moves.seconds[rows])
    return Statement(
        procedure,
        number,
        label,
        "path" if label.startswith("path ") else _KINDS[Kind(int(moves.kind[first]))],
        count,
        float(moves.length[rows].sum()),
        float(moves.turn[rows].sum()),
        float(moves.seconds[rows].sum()),
        simulation.bound_by(int(spent.argmax())),
    )


def lines(simulation: Simulation) -> Iterator[str]:
    """Times of the procedures, the slowest moves, and what is not known, for people."""
    times = [(name, seconds_of(one)) for name, one in simulation.procedures.items()]
    yield from _table([("procedure", "seconds"), *times], "<>")
    slowest = sorted(statements(simulation), key=lambda one: -one.seconds)[:_SLOWEST]
    if slowest:
        yield ""
        head = ("slowest moves", "to", "kind", "mm", "deg", "seconds", "bound by")
        yield from _table([head, *map(_row, slowest)], "<<<>>><")
    if simulation.outputs:
        yield ""
        outputs = [("outputs on the way", "set", "seconds"), *map(_set, simulation.outputs)]
        yield from _table(outputs, "<<>")
    if simulation.unknown:
        yield ""
        yield "not known, or only assumed:"
        for one in simulation.unknown:
            yield f"  {one}"


def _row(one: Statement) -> tuple[str, ...]:
    return (
        f"{one.procedure} move {one.number}",
        _short(one.label.strip("`")),
        f"{one.kind} of {one.rows}" if one.kind == "path" else one.kind,
        f"{one.length:.1f}",
        f"{one.turn:.1f}",
        f"{one.seconds:.2f}",
        one.bound,
    )


def _set(one: OutputTime) -> tuple[str, ...]:
    where = f"{one.procedure} move {one.number}"
    return where, _short(f"{one.signal} = {one.value}"), f"{one.seconds:.2f}"


def _short(text: str, most: int = 40) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"


def seconds_of(duration: Duration) -> str:
    """Seconds in words: the least and the most, where these differ."""
    if duration.most - duration.least < 0.005:
        return f"{duration.most:.2f}"
    return f"{duration.least:.2f} to {duration.most:.2f}"


def _table(rows: Sequence[tuple[str, ...]], sides: str) -> Iterator[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(sides))]
    for row in rows:
        cells = zip(row, sides, widths, strict=True)
        yield "  ".join(f"{cell:{side}{width}}" for cell, side, width in cells).rstrip()


def record(simulation: Simulation) -> dict[str, Any]:
    """The same as plain data, every motion statement included."""
    return {
        "robot": simulation.robot.name,
        "seconds": {"least": simulation.duration.least, "most": simulation.duration.most},
        "procedures": [
            {"name": name, "least": one.least, "most": one.most}
            for name, one in simulation.procedures.items()
        ],
        "moves": [
            {
                "procedure": one.procedure,
                "number": one.number,
                "to": one.label.strip("`"),
                "kind": one.kind,
                "targets": one.rows,
                "length_mm": one.length,
                "turn_deg": one.turn,
                "seconds": one.seconds,
                "bound_by": one.bound,
            }
            for one in statements(simulation)
        ],
        "outputs": [
            {
                "procedure": one.procedure,
                "number": one.number,
                "signal": one.signal,
                "value": one.value,
                "seconds": one.seconds,
            }
            for one in simulation.outputs
        ],
        "unknown": [
            {"procedure": one.procedure, "what": one.what, "times": one.times}
            for one in simulation.unknown
        ],
    }


def motion_csv(simulation: Simulation) -> bytes:
    """The samples: time, pose and speed of the tool, joints with velocities and accelerations."""
    samples = simulation.samples
    units = [("mm" if slides else "deg") for slides in simulation.robot.sliding]
    axes = [(axis.lower(), unit) for axis, unit in zip(simulation.robot.axes, units, strict=True)]
    names = ["t_s", "x_mm", "y_mm", "z_mm", "q_w", "q_x", "q_y", "q_z", "tcp_mm_s"]
    names += [f"{axis}_{unit}" for axis, unit in axes]
    names += [f"{axis}_{unit}_s" for axis, unit in axes]
    names += [f"{axis}_{unit}_s2" for axis, unit in axes]
    columns = np.column_stack(
        [
            samples.t,
            samples.position,
            samples.quaternion,
            samples.tcp_speed,
            samples.joints,
            samples.joint_velocity,
            samples.joint_acceleration,
        ]
    )
    a = len(axes)
    forms = ["%.6g"] + ["%.4f"] * 3 + ["%.9f"] * 4 + ["%.4f"] * (1 + 3 * a)
    text = io.StringIO(newline="")
    np.savetxt(text, columns + 0.0, fmt=forms, delimiter=",", header=",".join(names), comments="")
    return text.getvalue().encode()


def moves_csv(simulation: Simulation) -> bytes:
    """A line for each target of each motion statement."""
    moves = simulation.moves
    text = io.StringIO(newline="")
    text.write("procedure,move,row,kind,length_mm,turn_deg,seconds,bound_by\n")
    names = np.array(moves.procedures or ("",))[moves.procedure]
    kinds = [_KINDS[Kind(kind)] for kind in moves.kind.tolist()]
    bounds = [simulation.bound_by(binds) for binds in range(int(moves.binds.max(initial=0)) + 1)]
    columns = (
        names.tolist(),
        moves.number.tolist(),
        (moves.row + 1).tolist(),
        kinds,
        moves.length.tolist(),
        moves.turn.tolist(),
        moves.seconds.tolist(),
        moves.binds.tolist(),
    )
    for name, number, row, kind, length, turn, seconds, binds in zip(*columns, strict=True):
        text.write(
            f"{name},{number},{row},{kind},{length:.4f},{turn:.4f},{seconds:.6f},{bounds[binds]}\n"
        )
    return text.getvalue().encode()


def motion_npz(simulation: Simulation) -> bytes:
    """Samples and moves as columns of a NumPy archive, with the limits of the axes."""
    robot, samples, moves = simulation.robot, simulation.samples, simulation.moves
    words = [simulation.bound_by(binds) for binds in range(int(moves.binds.max(initial=0)) + 1)]
    data = io.BytesIO()
    np.savez_compressed(
        data,
        **{name: getattr(samples, name) for name in samples.__slots__},
        axes=np.array(robot.axes),
        limits=robot.limits,
        speeds=robot.speeds,
        procedures=np.array(moves.procedures),
        move_procedure=moves.procedure,
        move_number=moves.number,
        move_row=moves.row,
        move_kind=moves.kind,
        move_length=moves.length,
        move_turn=moves.turn,
        move_seconds=moves.seconds,
        move_binds=moves.binds,
        binds=np.array(words),
    )
    return data.getvalue()
