"""Poses and motions of the rows of a table, and the program of them.

Motions are index columns into small tables of speeds, blends, tools and frames, as in a `Path`.
Poses from outside are checked: finite, of believable size, with unit quaternions or rigid
matrices.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, info, warning
from assistant.base.near_names import near_name
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, FLANGE, JointTarget, Pose, Target
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import (
    MANGLED,
    Procedure,
    Program,
    Signal,
    TakenNames,
    identifier,
    renamed,
)
from assistant.program.statements import (
    Follow,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    SetSignal,
    Statement,
)
from assistant.sources.contours.path_tolerance import (
    ROUNDING_RADII,
    THINNING_PART,
    needed_points,
    rounding_radii,
    shortest_piece,
)
from assistant.sources.process import Process
from assistant.sources.tables.headers import shown

ERROR: Final = Severity.ERROR
UNKNOWN_TOOL = error("TB301", "there is no tool {name}{more}", "{cure}")
UNKNOWN_FRAME = error("TB302", "there is no frame {name}{more}", "{cure}")
UNKNOWN_SIGNAL = error("TB303", "there is no output {name}", "{cure}")
UNKNOWN_KIND = error(
    "TB304",
    "there is no motion {name}{more}",
    "write `joint`, `linear`, or `via` and in the row after it `end`",
)
TOO_SLOW = error(
    "TB305", "{what} is {value:g}, it must be more than 0{more}", "write a positive number"
)
NEGATIVE = error("TB306", "{what} is {value:g}, it must not be negative{more}", "write 0 or more")
TOO_MANY_SPEEDS = error(
    "TB307",
    "the rows have {count} different values of {what}, more than {most}",
    "round them, for example to whole millimetres",
)
BROKEN_ARC = error(
    "TB308",
    "{what}",
    "an arc is a `via` row and the `end` row after it, with a row before it to start from",
)
_TWICE_NAMED = error(
    "TB309",
    "the name {name} stands here and in {first}",
    "give every target a name of its own; case does not tell names apart",
)
VIA_ACTION = error(
    "TB311", "{what} at a `via` target, which is passed in motion", "move it to the `end` target"
)
NOT_ITS_VALUE = error(
    "TB312", "the {kind} output {name} cannot be {value:g}", "write a whole number, 0 to {most}"
)
_TRAVELS = error(
    "TB313",
    "a table has rows one after the other, and no ways that are planned: `travel` is no kind here",
    'write kind = "joint" or "linear" under [motion]',
)
REPEATED = info(
    "TB314",
    "{count} rows are where the row before them is and are left out; the first is {first}",
    "delete them, or give the rows names to move to each",
)
THINNED_ROWS = info(
    "TB315",
    "{count} rows less than {short:g} mm apart are left out, as the way without them is at most"
    " {deviation:.4f} mm off; the first is {first}",
    "give a smaller `tolerance` to keep them, or a `blend`",
)
SET_IN_CORNER = warning(
    "TB316",
    "outputs are set behind the corner at {names}, and may be set before the arm is there",
    'write "fine" as the blend where the place matters',
)
LEFT_BY_JOINTS = warning(
    "TB317",
    "a joint move leads out of {names}, where a line leads in from the same place: the tool may"
    " touch what is beside it",
    'write "linear" as the kind of the move that follows',
)
_NO_NAME = error("TB310", "the target has no name", "name it, or name none of the rows")

MOST_DIFFERENT: Final = 1000
"""Different speeds or blends in one file: each becomes a declaration on the controller."""
KIND_WORDS: Final = {
    "joint": Kind.JOINT, "linear": Kind.LINEAR, "via": Kind.VIA, "end": Kind.END
}  # fmt: skip

_SAME_ROW: Final = 1e-3
"""mm, and degrees, between two rows that are one: a move between them would only be a stop."""
_SAME_ROW_TURN: Final = 1.0 - (np.radians(_SAME_ROW) / 2.0) ** 2 / 2.0
"""The product of their quaternions."""

V = TypeVar("V")


def _changed_row(
    index: NDArray[np.int32], table: tuple[V, ...], row: int, value: V
) -> tuple[NDArray[np.int32], tuple[V, ...]]:
    """An index column and its table with another value in a row."""
    table = table if value in table else (*table, value)
    index = index.copy()
    index[row] = table.index(value)
    return index, table


RowPlace = Callable[[int], Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class RowMotions:
    """Index columns (n,) into tables of speeds, blends, tools and frames, as in a `Path`.

    A blend of None is not stated.
    """

    speed: NDArray[np.int32]
    blend: NDArray[np.int32]
    tool: NDArray[np.int32]
    frame: NDArray[np.int32]
    speeds: tuple[Speed | Name, ...]
    blends: tuple[Blend | Name | None, ...]
    tools: tuple[str, ...]
    frames: tuple[str, ...]

    def of(self, row: int) -> Motion:
        """The motion of one row, for named rows."""
        return Motion(
            self.speeds[self.speed[row]],
            self.blends[self.blend[row]] or FINE,
            self.tools[self.tool[row]],
            self.frames[self.frame[row]],
        )

    def those(self, kept: Truths | slice) -> RowMotions:
        """The motions of some rows."""
        columns = {n: getattr(self, n)[kept] for n in ("speed", "blend", "tool", "frame")}
        return replace(self, **columns)

    def approached(self, travel: Speed | None = None) -> RowMotions:
        """The motions with a stop at the first row: the arm comes there from wherever it is, and no
        corner can be rounded on a way that nobody knows.

        travel: speed of that way in place of the first row's, which is that of the work.
        """
        blend, blends = _changed_row(self.blend, self.blends, 0, FINE)
        stopped = replace(self, blend=blend, blends=blends)
        if travel is None:
            return stopped
        stated = self.speeds[self.speed[0]]
        # A percentage counts only in joint moves, so one that is stated is of this move.
        if isinstance(stated, Speed):
            travel = replace(travel, joint=stated.joint)
        speed, speeds = _changed_row(self.speed, self.speeds, 0, travel)
        return replace(stopped, speed=speed, speeds=speeds)

    def stopped(self) -> RowMotions:
        """The motions with a stop at the last row."""
        blend, blends = _changed_row(self.blend, self.blends, -1, FINE)
        return replace(self, blend=blend, blends=blends)

    def rounded(
        self, positions: Floats, kinds: NDArray[np.uint8], tolerance: float
    ) -> dict[str, Any]:
        """The arguments of `Path.of` for a way, with a blend where none is stated."""
        columns = {name: getattr(self, name) for name in self.__slots__}
        if None not in self.blends:
            return columns
        whole = (np.diff(self.tool) == 0) & (np.diff(self.frame) == 0)
        stated = np.array([blend is not None for blend in self.blends])[self.blend]
        sizes = np.where(stated, 0.0, rounding_radii(positions, kinds, whole, tolerance))
        every = np.append(0.0, ROUNDING_RADII)
        # Row 0 is a stop, then the sizes in ascending order: `searchsorted` finds them exactly.
        rows = np.searchsorted(every, sizes)
        used = np.bincount(rows, minlength=len(every)) > 0
        table, rows = every[used], (np.cumsum(used) - 1)[rows]
        blends = [blend or FINE for blend in self.blends]
        index = np.where(stated, self.blend, rows + len(blends)).astype(np.int32)
        blends += [Blend(size) if size > 0 else FINE for size in table.tolist()]
        return columns | {"blend": index, "blends": tuple(blends)}


def moving_rows(
    positions: Floats,
    quaternions: Floats,
    kinds: NDArray[np.uint8],
    *others: NDArray[Any] | None,
) -> Truths:
    """Which rows (n,) go anywhere: lines to where the arm is already are left out.

    others: columns (n, ...) that have to agree too. The rows of an arc are never left out.
    """
    n = len(positions)
    kept = np.ones(n, dtype=np.bool_)
    if n < 2:
        return kept
    straight = (kinds == Kind.LINEAR) | (kinds == Kind.JOINT)
    straight[1:] &= kinds[:-1] != Kind.VIA

    def same(one: Rows | slice, two: Rows | slice) -> Truths:
        found = np.linalg.norm(positions[one] - positions[two], axis=1) <= _SAME_ROW
        turn = np.abs((quaternions[one] * quaternions[two]).sum(axis=1))
        found &= turn >= _SAME_ROW_TURN * np.linalg.norm(quaternions[two], axis=1)
        for column in others:
            if column is not None:
                a, b = column[one], column[two]
                equal = (a == b) | ((a != a) & (b != b))  # NaN: there is no such axis
                found &= equal.reshape(len(equal), -1).all(axis=1)
        return np.asarray(found)

    # In columns first: only rows near their neighbour are compared one by one.
    near = np.append(False, same(slice(n - 1), slice(1, n))) & straight
    # Against the last row that stays: a slow drift over many rows is a motion.
    here = 0
    for row in np.flatnonzero(near).tolist():
        if kept[row - 1]:
            here = row - 1
        kept[row] = not same(np.array([here]), np.array([row]))[0]
    return kept


def needed_rows(
    positions: Floats,
    quaternions: Floats,
    kinds: NDArray[np.uint8],
    motions: RowMotions,
    tolerance: float,
    *others: NDArray[Any] | None,
) -> tuple[Truths, float]:
    """Which rows (n,) of a way stay, and how far off, in mm, those are that are left out.

    Rows nearer to each other than a move can round its corner would be stops. Left out are lines
    between such, with all columns as their neighbours have them and no blend stated, that the
    tolerance does not need. others: columns (n, ...) that have to agree.
    """
    n = len(positions)
    kept, most = np.ones(n, dtype=np.bool_), 0.0
    if n < 3 or None not in motions.blends:
        return kept, most
    sides, short = np.linalg.norm(np.diff(positions, axis=0), axis=1), shortest_piece(tolerance)
    # Nothing is too short to be rounded.
    if not (sides < short).any():
        return kept, most
    columns = (motions.speed, motions.blend, motions.tool, motions.frame, *others)
    like = np.abs((quaternions[1:] * quaternions[:-1]).sum(axis=1)) >= _SAME_ROW_TURN
    like &= (kinds[1:] == Kind.LINEAR) & (sides > 0.0)
    like &= np.array([blend is None for blend in motions.blends])[motions.blend[1:]]
    for column in columns:
        if column is not None:
            a, b = column[1:], column[:-1]
            like &= ((a == b) | ((a != a) & (b != b))).reshape(n - 1, -1).all(axis=1)
    # Stretches of rows that are all alike, each with the row that it begins at.
    bounds = np.flatnonzero(np.diff(like, prepend=False, append=False)).reshape(-1, 2)
    for first, last in bounds.tolist():
        if last - first < 2 or not (sides[first:last] < short).any():
            # Two rows have nothing between them.
            continue
        part, off = needed_points(positions[first : last + 1], THINNING_PART * tolerance, short)
        kept[first : last + 1] = part
        most = max(most, off)
    return kept, most


def default_motions(n: int, process: Process) -> RowMotions:
    """Every row as the process file's defaults say."""
    rows = np.broadcast_to(np.int32(0), (n,))
    d = process.defaults
    return RowMotions(rows, rows, rows, rows, (d.speed,), (d.blend,), (d.tool,), (d.frame,))


def beginning_kinds(kinds: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Kinds of rows that begin a program, of which the first does not say how it is reached: no
    line leads there from wherever the arm is.
    """
    if not len(kinds) or kinds[0] != Kind.LINEAR:
        return kinds
    return np.concatenate([[np.uint8(Kind.JOINT)], kinds[1:]])


def begins_with_approach(kinds: NDArray[np.uint8]) -> bool:
    """True if a joint move leads to the first row, and the work begins there."""
    return len(kinds) > 1 and bool(kinds[0] == Kind.JOINT != kinds[1])


def default_kind(process: Process) -> Kind:
    """Raises Refused for what only drawings have."""
    if process.defaults.travels:
        raise Refused(_TRAVELS())
    return KIND_WORDS[process.defaults.kind]


def _distinct_rows(columns: Sequence[Floats]) -> tuple[NDArray[np.int32], Rows]:
    """Rows that agree in all columns (n,), NaN being equal to NaN, get one number.

    Gives the number of each row, and for each number a row that has it.
    """
    code = np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:
        _, inverse = np.unique(column, return_inverse=True)
        # Codes stay below the number of rows, so the product does not overflow.
        _, code = np.unique(code * (int(inverse.max(initial=0)) + 1) + inverse, return_inverse=True)
    _, first, code = np.unique(code, return_index=True, return_inverse=True)
    return code.astype(np.int32), first


def speeds_of(
    tcp: Floats,
    rotation: Floats,
    joint: Floats,
    process: Process,
) -> tuple[NDArray[np.int32], tuple[Speed | Name, ...]]:
    """Speed index (n,) and table of columns in mm/s, deg/s and percent, NaN for the default."""
    index, rows = _distinct_rows([tcp, rotation, joint])
    table = [_speed_of(float(tcp[r]), float(rotation[r]), float(joint[r]), process) for r in rows]
    return index, tuple(table)


def _speed_of(tcp: float, rotation: float, joint: float, process: Process) -> Speed | Name:
    default = process.defaults.speed
    if tcp != tcp and rotation != rotation and joint != joint:
        return default
    known = default if isinstance(default, Speed) else Speed(tcp)
    changed = {"tcp": tcp, "rotation": rotation, "joint": joint}
    return replace(known, **{name: value for name, value in changed.items() if value == value})


def blends_of(
    radius: Floats, process: Process
) -> tuple[NDArray[np.int32], tuple[Blend | Name | None, ...]]:
    """Blend index (n,) and table of radii in mm, 0 to stop, NaN for the default."""
    index, rows = _distinct_rows([radius])
    values = [float(radius[r]) for r in rows]
    default = process.defaults.blend
    return index, tuple(default if v != v else Blend(v) if v > 0 else FINE for v in values)


def arc_findings(kinds: NDArray[np.uint8], locate: RowPlace) -> list[Diagnostic]:
    """A `via` row without its `end` row, an `end` row without its `via` row."""
    return [BROKEN_ARC(**locate(row), what=what) for row, what in broken_arcs(kinds)]


def broken_arcs(kinds: NDArray[np.uint8]) -> list[tuple[int, str]]:
    """The first row that breaks each rule of arcs, and how."""
    via, end = kinds == Kind.VIA, kinds == Kind.END
    after_via = np.concatenate([[False], via[:-1]])
    before_end = np.concatenate([end[1:], [False]])
    first = np.arange(len(kinds)) == 0
    broken = (
        ("`via` has no `end` after it", via & ~before_end),
        ("`end` has no `via` before it", end & ~after_via),
        ("`via` has nothing before it that the arc could start from", via & first),
    )
    return [(int(np.argmax(rows)), what) for what, rows in broken if rows.any()]


def _known_entry(name: str, table: Mapping[str, Any], builtin: str) -> str | None:
    """Return the entry of that name, compared without case; None if the table does not contain
    it.
    """
    if name.lower() == builtin.lower():
        return builtin
    return next((entry for entry in table if entry.lower() == name.lower()), None)


def most_value(signal: Signal) -> float:
    """The largest value of a signal that counts in whole numbers from 0; infinite if none."""
    return np.inf if signal.kind == "analog" else 2**signal.bits - 1


def known_tool(name: str, process: Process) -> str | None:
    return _known_entry(name, process.tools, FLANGE)


def known_frame(name: str, process: Process) -> str | None:
    return _known_entry(name, process.frames, BASE)


def cure_for(kind: str, name: str, table: Mapping[str, Any]) -> str:
    """What to do about a tool, frame or signal that nobody declared."""
    if near := near_name(name, table):
        return f"did you mean `{near}`?"
    return f"declare it in the process file: `[{kind}s.{identifier(name)}]`"


def default_findings(process: Process, path: str | None) -> list[Diagnostic]:
    """Default tool or frame that is declared nowhere."""
    d, findings = process.defaults, []
    if known_tool(d.tool, process) is None:
        cure = cure_for("tool", d.tool, process.tools)
        findings.append(UNKNOWN_TOOL(path=path, name=shown(d.tool), more="", cure=cure))
    if known_frame(d.frame, process) is None:
        cure = cure_for("frame", d.frame, process.frames)
        findings.append(UNKNOWN_FRAME(path=path, name=shown(d.frame), more="", cure=cure))
    return findings


class RowNames:
    """Identifiers for the names of a file, each once; `findings` tell what became of them."""

    def __init__(self) -> None:
        self.findings: list[Diagnostic] = []
        self._first: dict[str, str] = {}
        self._taken = TakenNames()

    def of(self, given: str, where: Mapping[str, Any], label: str) -> str:
        """The identifier of a name; label: how a repetition refers to this place."""
        if not given.strip():
            self.findings.append(_NO_NAME(**where))
        first = self._first.setdefault(given.strip().lower(), label)
        if given.strip() and first != label:
            self.findings.append(_TWICE_NAMED(**where, name=shown(given), first=first))
            return given
        name = identifier(given)
        if name.lower() in self._taken:
            name = identifier(given, self._taken)
        self._taken.add(name.lower())
        if name != given and given.strip():
            self.findings.append(renamed(given, name, **where))
        return name


def program_name(stem: str, path: str) -> tuple[str, list[Diagnostic]]:
    """Program name of a file name, with a note if it had to be changed."""
    name = identifier(stem)
    changed = name != stem
    return name, [
        MANGLED(path=path, given=stem[:80], name=name, severity=Severity.INFO)
    ] if changed else []


def paths_program(
    name: str, paths: Sequence[Path], process: Process, comments: tuple[str, ...] = ()
) -> Program:
    """A program that follows paths one after the other; a path of one row is a move."""
    body: list[Statement] = []
    targets: dict[str, Target] = {}
    for path in paths:
        if len(path) == 1 and path.kinds[0] in (Kind.JOINT, Kind.LINEAR):
            target = f"{path.name}_1"
            targets[target] = path.target(0)
            kind = "joint" if path.kinds[0] == Kind.JOINT else "linear"
            motion = Motion(
                path.speeds[path.speed[0]],
                path.blends[path.blend[0]],
                path.tools[path.tool[0]],
                path.frames[path.frame[0]],
            )
            body.append(Move(kind, Name(target), motion))  # type: ignore[arg-type]
        else:
            body += _between_places_above(path, process, targets)
    return program_of(name, body, process, targets, comments=comments)


def _between_places_above(
    path: Path, process: Process, targets: dict[str, Target]
) -> Iterator[Statement]:
    """A path with the lines to its start and away from its end that `approach` and `retract` ask
    for, along the axis of the tool; the targets above are added.

    A start that states itself how it is reached has no line to it.
    """
    travel = process.defaults.travel

    def above(row: int, length: float, name: str, kind: Literal["joint", "linear"]) -> Move:
        target = path.target(row)
        back = Pose((0.0, 0.0, -length))
        targets[f"{path.name}_{name}"] = replace(target, pose=target.pose @ back)
        tool, frame = path.tools[path.tool[row]], path.frames[path.frame[row]]
        return Move(kind, Name(f"{path.name}_{name}"), Motion(travel, FINE, tool, frame))

    if process.defaults.approach and begins_with_approach(path.kinds):
        yield above(0, process.defaults.approach, "approach", "joint")
        kinds, speed = path.kinds.copy(), path.speed.copy()
        kinds[0], speed[0] = Kind.LINEAR, speed[1]
        path = replace(path, kinds=kinds, speed=speed)
    yield Follow(path)
    if process.defaults.retract:
        yield above(-1, process.defaults.retract, "retract", "linear")


def program_of(
    name: str,
    body: Sequence[Statement],
    process: Process,
    targets: Mapping[str, Target] | None = None,
    joint_targets: Mapping[str, JointTarget] | None = None,
    comments: tuple[str, ...] = (),
) -> Program:
    """A program with one procedure `main` and the process file's robot, tools, frames, signals."""
    return Program(
        name,
        (Procedure("main", _stopping(body, process.defaults.blend)),),
        robot=process.robot,
        comments=comments,
        tools=dict(process.tools),
        frames=dict(process.frames),
        signals=dict(process.signals),
        targets=dict(targets or {}),
        joint_targets=dict(joint_targets or {}),
    )


def _stopping(body: Sequence[Statement], default: Blend | Name | None) -> tuple[Statement, ...]:
    """Make the first and the last move stops if they have the default blend: no corner is there
    that it rounds, as nobody knows from where the arm comes and where it goes.
    """
    moves = [i for i, statement in enumerate(body) if isinstance(statement, _MOVES)]
    if not moves or default in (None, FINE):
        return tuple(body)
    stopped = list(body)
    for at, row in ((moves[0], 0), (moves[-1], -1)):
        move = stopped[at]
        if isinstance(move, Follow):
            path = move.path
            if path.blends[path.blend[row]] == default:
                blend, blends = _changed_row(path.blend, path.blends, row, FINE)
                stopped[at] = Follow(replace(path, blend=blend, blends=blends))
        elif isinstance(move, _SINGLE_MOVES) and move.motion.blend == default:
            stopped[at] = replace(move, motion=replace(move.motion, blend=FINE))
    return tuple(stopped)


def set_in_corners(program: Program) -> tuple[str, ...]:
    """The targets behind whose corners outputs are set: a controller runs ahead of the arm there.

    Each is listed once, in the order of the moves.
    """
    (main,) = program.procedures
    found = [
        reached.name
        for move, after in pairwise(main.body)
        if isinstance(move, _SINGLE_MOVES) and isinstance(after, SetSignal)
        if move.motion.blend != FINE and isinstance(reached := move.target, Name)
    ]
    return tuple(dict.fromkeys(found))


def left_by_joints(program: Program) -> dict[str, str]:
    """The targets to which a line leads from a place, and a joint move leads back there, each with
    the target of that move.
    """
    (main,) = program.procedures
    moves = [one for one in main.body if isinstance(one, _SINGLE_MOVES)]

    def place(move: Statement) -> Target | JointTarget | None:
        target = getattr(move, "target", None)
        if not isinstance(target, Name):
            return None
        return program.targets.get(target.name) or program.joint_targets.get(target.name)

    return {
        into.target.name: back.target.name
        for before, into, back in zip(moves, moves[1:], moves[2:], strict=False)
        if isinstance(into, Move) and into.kind == "linear" and isinstance(into.target, Name)
        if isinstance(back, MoveJoints) or (isinstance(back, Move) and back.kind == "joint")
        if isinstance(back.target, Name) and place(back) == place(before) is not None
    }


_SINGLE_MOVES: Final = (Move, MoveCircular, MoveJoints)
_MOVES: Final = (*_SINGLE_MOVES, Follow)


def more_rows(rows: Truths | Rows, locate: RowPlace) -> str:
    """Return how many rows have a fault that is reported at the first one, and which they are.

    rows: which of all (n,), or their numbers.
    """
    at = np.flatnonzero(rows) if rows.dtype == np.bool_ else rows
    if len(at) < 2:
        return ""
    places = [locate(int(row)) for row in at[:_MOST_NAMED_ROWS]]
    lines = "line" in places[0]
    named = ", ".join(str(place["line" if lines else "place"]) for place in places)
    rest = len(at) - len(places)
    return (
        f" ({len(at)} such rows: {'lines ' if lines else ''}{named}"
        f"{f' and {rest} more' if rest else ''})"
    )


_MOST_NAMED_ROWS: Final = 20
"""Rows with the same fault that are named."""


NOT_FINITE = error("TB201", "{what} {value} is not finite{more}", "mend or remove the row")
_TOO_LARGE = error(
    "TB202",
    "{what} {value:g} is larger than {most:g}{more}",
    "check the unit and the decimal point",
)
_NOT_UNIT = error(
    "TB203",
    "the quaternion is {length:.6g} long, not 1{more}",
    "check the order of its parts (w x y z) and give at least four decimals",
)
_NORMALISED = warning(
    "TB204",
    "not quite 1 long and made so: {count} quaternions, the worst {length:.6g}",
    "give more decimals",
)
_NOT_RIGID = error(
    "TB205",
    "the matrix is no rotation: it is off by {miss:.3g}{more}",
    "check that it is no reflection, has no scale, and that columns are the axes",
)
_ORTHONORMALISED = warning(
    "TB206",
    "not quite orthonormal and made so: {count} matrices, the worst by {miss:.3g}",
    "give more decimals",
)
_LAST_ROW = error(
    "TB207",
    "the last row of the matrix is {row}, not 0 0 0 1{more}",
    "give homogeneous matrices with the position in the last column",
)
METRES_CURE: Final = (
    'give millimetres, or say `unit = "m"` in the call, the file or its process file; columns of '
    "metres are called `x_m`, `y_m` and `z_m`"
)
_LIKELY_METRES = warning(
    "TB208",
    "all {count} positions lie within {most:g} mm of the frame; are they metres?",
    METRES_CURE,
)

LARGEST_POSITION: Final = 1e6
"""mm; no robot, track or gantry is a kilometre long."""
LARGEST_ANGLE: Final = 1e5
"""degrees."""
_SILENT_DEVIATION: Final = 1e-6
"""Deviation from unit length that counts as rounding in the last decimal."""
_REPAIRABLE_DEVIATION: Final = 1e-3
"""Deviation from unit length up to which it is repaired with a warning."""
LIKE_METRES: Final = 3.0
"""mm; a path that stays this near to the origin of its frame is likely in metres."""

LocateRow = Callable[[int], Mapping[str, Any]]
"""Row → where it is, as arguments of a rule (path, line, place …)."""


def position_findings(
    values: Floats,
    locate: LocateRow,
    what: str = "the coordinate",
    *,
    most: float = LARGEST_POSITION,
) -> list[Diagnostic]:
    """Return findings for the numbers (n, k) of n rows that are not finite, or beyond `most`."""
    if values.size:
        low, high = values.min(), values.max()  # no number if one of them is none
        # NaN and infinity in the columns reach the sums, too: one look at both is enough.
        if np.isfinite(low) and np.isfinite(high) and -most <= low and high <= most:
            return []
    findings = []
    finite = np.isfinite(values)
    if not finite.all():
        rows = np.flatnonzero(~finite.all(axis=1))
        value = values[rows[0]][~finite[rows[0]]][0]
        findings.append(
            NOT_FINITE(
                **locate(int(rows[0])), what=what, value=float(value), more=more_rows(rows, locate)
            )
        )
    large = np.abs(np.where(finite, values, 0.0)) > most
    if large.any():
        rows = np.flatnonzero(large.any(axis=1))
        value = values[rows[0]][large[rows[0]]][0]
        findings.append(
            _TOO_LARGE(
                **locate(int(rows[0])),
                what=what,
                value=float(value),
                most=most,
                more=more_rows(rows, locate),
            )
        )
    return findings


def unit_quaternions(quaternions: Floats, locate: LocateRow) -> tuple[Floats, list[Diagnostic]]:
    """Canonical quaternions (n, 4), and what was wrong with the given ones.

    Up to `REPAIRED` off unit length they are repaired, beyond refused; not finite ones too.
    """
    findings = position_findings(quaternions, locate, "the quaternion part", most=np.inf)
    if findings:
        return quaternions, findings
    with np.errstate(over="ignore"):
        lengths = norms(quaternions)
    miss = np.abs(lengths - 1.0)
    # The negation catches NaN as well.
    bad = np.flatnonzero(~(miss <= _REPAIRABLE_DEVIATION))
    if len(bad):
        row = int(bad[0])
        return quaternions, [
            _NOT_UNIT(**locate(row), length=lengths[row], more=more_rows(bad, locate))
        ]
    if len(off := np.flatnonzero(miss > _SILENT_DEVIATION)):
        worst = int(np.argmax(miss))
        findings.append(_NORMALISED(**locate(worst), count=len(off), length=lengths[worst]))
    return rotations.canonical(quaternions), findings


def poses_of_matrices(
    matrices: Floats, locate: LocateRow
) -> tuple[Floats, Floats, list[Diagnostic]]:
    """Positions (n, 3) and canonical quaternions (n, 4) of homogeneous matrices (n, 4, 4)."""
    positions = np.ascontiguousarray(matrices[:, :3, 3])
    findings = position_findings(
        matrices.reshape(len(matrices), 16), locate, "the matrix element", most=np.inf
    )
    if findings:
        return positions, np.empty((0, 4)), findings
    last = np.flatnonzero((np.abs(matrices[:, 3] - [0, 0, 0, 1]) > 1e-9).any(axis=1))
    if len(last):
        row = " ".join(f"{v:g}" for v in matrices[last[0], 3])
        findings.append(_LAST_ROW(**locate(int(last[0])), row=row, more=more_rows(last, locate)))
    turn = matrices[:, :3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        # A rotation's transpose is its inverse.
        product = np.einsum("nij,nik->njk", turn, turn)
        miss = np.abs(product - np.eye(3)).max(axis=(1, 2))
        # A reflection passes the test above.
        miss = np.where(np.linalg.det(turn) < 0, np.maximum(miss, 2.0), miss)
    bad = np.flatnonzero(~(miss <= _REPAIRABLE_DEVIATION))
    if len(bad):
        first = int(bad[0])
        findings.append(_NOT_RIGID(**locate(first), miss=miss[first], more=more_rows(bad, locate)))
    if findings:
        return positions, np.empty((0, 4)), findings
    if len(off := np.flatnonzero(miss > _SILENT_DEVIATION)):
        worst = int(np.argmax(miss))
        findings.append(_ORTHONORMALISED(**locate(worst), count=len(off), miss=miss[worst]))
    return positions, rotations.from_matrix(turn), findings


def metres_finding(positions: Floats, place: Mapping[str, Any]) -> list[Diagnostic]:
    """A warning if positions look like metres."""
    # Points in one place are no path whose size could tell.
    apart = len(positions) > 1 and np.ptp(positions, axis=0).max() > 0.0
    if apart and 0 < np.abs(positions).max() <= LIKE_METRES:
        return [_LIKELY_METRES(**place, count=len(positions), most=LIKE_METRES)]
    return []
