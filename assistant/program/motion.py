"""Speeds and blends of moves, in physical units, and paths: targets and moves in numpy columns.

A path has no Python object per point.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, Final, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, require_same_length, rows_of
from assistant.base.data_classes import dataclass
from assistant.lazy import pictured
from assistant.program.expressions import Expression, Name, Number
from assistant.program.geometry import BASE, FLANGE, Configuration, Pose, Target

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Speed:
    """Speed of a move.

    tcp: mm/s along the path; infinite for the robot's own maximum.
    rotation: deg/s of reorientation. external_linear, external_rotary: mm/s and deg/s of
    external axes. joint: percent of the joints' maximum in a joint move, None if not stated.
    The defaults are those of every predefined RAPID speed.
    """

    tcp: float
    rotation: float = 500.0
    external_linear: float = 5000.0
    external_rotary: float = 1000.0
    joint: float | None = None


MAXIMUM_SPEED: Final = Speed(math.inf)


@dataclass(frozen=True, slots=True)
class Blend:
    """Corner rounding at a target.

    radius: mm before the target at which the path may leave it; None stops there exactly,
    infinite leaves the corner to the controller. exit: mm after the target at which the
    path is back, None for the same as radius. details: further zone sizes as RAPID's
    zonedata gives them (reorientation mm, external mm, reorientation deg, external linear
    mm, external rotary deg), None for the usual ones of the radius.
    """

    radius: float | None = None
    exit: float | None = None
    details: tuple[float, float, float, float, float] | None = None

    @property
    def fine(self) -> bool:
        return self.radius is None


FINE: Final = Blend()
FULL_BLEND: Final = Blend(math.inf)

USUAL_ROTATION: Final = Number(500)
USUAL_LINEAR: Final = Number(5000)
USUAL_ROTARY: Final = Number(1000)
"""Usual values of a speed beyond that of the tool's tip; see `Speed`."""


@dataclass(frozen=True, slots=True)
class ComputedSpeed:
    """A speed that is worked out where its move begins; the parts are those of `Speed`.

    tcp: None for the robot's own maximum.
    """

    tcp: Expression | None
    rotation: Expression = USUAL_ROTATION
    external_linear: Expression = USUAL_LINEAR
    external_rotary: Expression = USUAL_ROTARY
    joint: Expression | None = None


@dataclass(frozen=True, slots=True)
class ComputedBlend:
    """A blend that is worked out where its move begins.

    radius: mm, see `Blend`. stops: whether the move ends exactly at its target instead, None for
    never. details: see `Blend`, None for the usual ones of the radius.
    """

    radius: Expression
    stops: Expression | None = None
    details: tuple[Expression, ...] | None = None


COMPUTED: Final = Name("")
"""Stands for a speed or blend of which only the running program knows the value."""


class Kind(enum.IntEnum):
    """Motion type that reaches a row of a path. A VIA row and the END row after it are one arc."""

    JOINT = 0
    LINEAR = 1
    VIA = 2
    END = 3


UNSTATED: Final = -128
"""In the first configuration column: the target states no arm branch."""

CONFIGURATION_COLUMNS: Final = ("back", "down", "flip", "quadrant1", "quadrant4", "quadrant6")


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """n targets with the moves that reach them.

    name: identifier; row i is known as `<name>_<i+1>`.
    kinds: (n,) uint8, a `Kind` each.
    positions: (n, 3) mm. quaternions: (n, 4) unit, scalar first.
    configurations: (n, 6) int8, `CONFIGURATION_COLUMNS`; UNSTATED in the first if unknown.
    external: (n, 6) deg or mm, NaN for an unused axis.
    speed, blend, tool, frame: (n,) int32 rows of the tables speeds, blends, tools, frames.
    places: (n, 2) start and end of the move to each row in the source text, counted from the
    start of the statement that follows the path; None if the rows have no separate lines.
    original: stem and number of the first row in the source text, if rows have other names
    there: `P` and 5 of P5, P6 … `places` and `original` are not part of the path's meaning.
    """

    name: str
    kinds: NDArray[np.uint8]
    positions: Floats
    quaternions: Floats
    configurations: NDArray[np.int8]
    external: Floats
    speed: NDArray[np.int32]
    blend: NDArray[np.int32]
    tool: NDArray[np.int32]
    frame: NDArray[np.int32]
    speeds: tuple[Speed | Name, ...]
    blends: tuple[Blend | Name, ...]
    tools: tuple[str, ...]
    frames: tuple[str, ...]
    places: Rows | None = None
    original: tuple[str, int] | None = None

    @staticmethod
    def of(
        name: str,
        positions: ArrayLike,
        quaternions: ArrayLike,
        *,
        kinds: ArrayLike | Kind = Kind.LINEAR,
        configurations: ArrayLike | None = None,
        external: ArrayLike | None = None,
        speeds: Sequence[Speed | Name],
        blends: Sequence[Blend | Name] = (FINE,),
        tools: Sequence[str] = (FLANGE,),
        frames: Sequence[str] = (BASE,),
        speed: ArrayLike = 0,
        blend: ArrayLike = 0,
        tool: ArrayLike = 0,
        frame: ArrayLike = 0,
        places: Rows | None = None,
    ) -> Path:
        """A path from arrays; scalars and missing columns hold for every row.

        Raises ValueError if shapes do not fit or an index has no row in its table.
        """
        position = np.ascontiguousarray(rows_of(positions, 3, "positions"))
        n = len(position)
        quaternion = np.ascontiguousarray(rows_of(quaternions, 4, "quaternions"))
        require_same_length(position, quaternion, "positions", "quaternions")
        unstated = np.array([UNSTATED, 0, 0, 0, 0, 0], dtype=np.int8)
        column = {
            "speed": (speed, speeds),
            "blend": (blend, blends),
            "tool": (tool, tools),
            "frame": (frame, frames),
        }
        indices: dict[str, Any] = {}
        for label, (index, table) in column.items():
            # Broadcast views cost no memory for columns that are the same in all rows.
            rows = np.broadcast_to(np.asarray(index, dtype=np.int32), (n,))
            if n and not (rows.min() >= 0 and rows.max() < len(table)):
                raise ValueError(f"a {label} index has no row in its table of {len(table)}")
            indices[label] = rows
        return Path(
            name=name,
            kinds=np.broadcast_to(np.asarray(kinds, dtype=np.uint8), (n,)),
            positions=position,
            quaternions=quaternion,
            configurations=np.broadcast_to(
                np.asarray(unstated if configurations is None else configurations, np.int8), (n, 6)
            ),
            external=np.broadcast_to(
                np.asarray(np.nan if external is None else external, dtype=np.float64), (n, 6)
            ),
            speeds=tuple(speeds),
            blends=tuple(blends),
            tools=tuple(tools),
            frames=tuple(frames),
            places=places,
            **indices,
        )

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"<Path {self.name}: {len(self)} row{'s' * (len(self) != 1)}>"

    def _repr_html_(self) -> str:
        return pictured(self)

    def __eq__(self, other: object) -> bool:
        """Same rows in effect: tables may be ordered differently."""
        if not isinstance(other, Path):
            return NotImplemented
        if self.name != other.name or len(self) != len(other):
            return False
        numbers = ("kinds", "positions", "quaternions", "configurations")
        return (
            all(np.array_equal(getattr(self, f), getattr(other, f)) for f in numbers)
            and np.array_equal(self.external, other.external, equal_nan=True)
            and all(
                self.differing_rows(other, column).size == 0
                for column in ("speed", "blend", "tool", "frame")
            )
        )

    def __hash__(self) -> int:
        return hash((self.name, len(self)))

    def differing_rows(self, other: Path, column: str) -> Rows:
        """Rows in which the table entries that `column` points to are not equal."""
        mine, theirs = getattr(self, column + "s"), getattr(other, column + "s")
        # Few table entries are compared, then rows by their indices.
        equal = np.array([[a == b for b in theirs] for a in mine], dtype=bool)
        equal = equal.reshape(len(mine), len(theirs))
        if not len(self):
            return np.empty(0, dtype=np.intp)
        return np.flatnonzero(~equal[getattr(self, column), getattr(other, column)])

    def rows(self, start: int, stop: int, name: str | None = None) -> Path:
        """Return the rows from start up to stop as a separate path."""
        cut: dict[str, Any] = {
            f.name: getattr(self, f.name)[start:stop]
            for f in fields(self)
            if isinstance(getattr(self, f.name), np.ndarray)
        }
        if self.original is not None:
            cut["original"] = self.original[0], self.original[1] + start
        return replace(self, name=name or self.name, **cut)

    def row_name(self, row: int) -> str:
        """Name of a row, counted from 0, in the source text."""
        stem, first = (f"{self.name}_", 1) if self.original is None else self.original
        return f"{stem}{first + row}"

    def pose(self, row: int) -> Pose:
        return Pose.of(self.positions[row], self.quaternions[row])

    def target(self, row: int) -> Target:
        """One row as a target object; for the few, never for all."""
        external = tuple(float(v) for v in self.external[row])
        return Target(self.pose(row), configuration_of(self.configurations[row]), external)

    def with_unit_quaternions(self) -> Path:
        return replace(self, quaternions=rotations.canonical(self.quaternions))


def configuration_of(row: NDArray[np.int8]) -> Configuration | None:
    """One row of a configuration column."""
    back, down, flip, one, four, six = (int(v) for v in row)
    if back == UNSTATED:
        return None
    return Configuration(bool(back), bool(down), bool(flip), (one, four, six))


def configuration_row(configuration: Configuration | None) -> tuple[int, ...]:
    """A configuration as a row of a configuration column."""
    if configuration is None:
        return (UNSTATED, 0, 0, 0, 0, 0)
    c = configuration
    return (int(c.back), int(c.down), int(c.flip), *c.quadrants)


@dataclass(frozen=True, slots=True)
class ValueNames(Generic[T]):
    """Names of speeds, or blends, that a language declares.

    kind: speeds or blends. predefined: by name. name: of a value, predefined or to be declared.
    """

    kind: str
    predefined: Mapping[str, T]
    name: Callable[[T], str]

    def meant(self, name: str, declared: Mapping[str, T]) -> T | None:
        """Return the value with this name if the name is its standard name; None for another
        declared name.

        declared: by lower-case name.
        """
        value = declared.get(name.lower())
        if value is None:
            return self.predefined.get(name.lower())
        # A declared value of another meaning hides the predefined name.
        return value if self.name(value) == name.lower() else None

    def named(self, declared: Mapping[str, T]) -> dict[str, T]:
        """Return the values whose names differ from their standard names."""
        return {n: v for n, v in declared.items() if n.lower() != self.name(v)}
