"""Values of MELFA-BASIC, the variables that hold them, and the errors that end a run.

Values are numbers, texts, positions and joints; a type changes what is stored. A memory holds cells
by name, arrays, and references to either.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.virtual.events import Moved
from assistant.virtual.melfa.options import Options


class Failed(Exception):
    """The controller stops with an error.

    number: as it shows it (lists of errors, BFP-A8871), None where the manuals give none.
    """

    def __init__(self, number: int | None, what: str) -> None:
        super().__init__(f"error {number}: {what}" if number else f"error: {what}")
        self.number = number


class Unknown(Exception):
    """Behaviour that no source at hand defines, or that is not simulated: the run ends instead of
    guessing.
    """


class Ended(Exception):
    """`End` of the program that runs."""


class Redirected(Exception):
    """An interrupt has the program go on elsewhere. nest: the run of rows. at: the row."""

    def __init__(self, nest: int, at: int) -> None:
        super().__init__(nest, at)
        self.nest, self.at = nest, at


def _number_wanted(what: str) -> Failed:
    return Failed(4390, f"{what} is no number")


def out_of_range(what: str) -> Failed:
    return Failed(3110, f"{what} is out of range")


def open_point(what: str, option: str) -> Unknown:
    """Return an Unknown for a point that the manuals leave open, and an option of the run decides
    (see `Options`).
    """
    return Unknown(f"{what}: the option `{option}` tells")


Kind = Literal["number", "integer", "long", "text", "position", "joints"]
"""Types of variables. Single and double precision are both kept as double here."""

Elements = tuple[float | None, ...]

COMPONENTS: Final = ("X", "Y", "Z", "A", "B", "C", "L1", "L2")
"""Components of a position: mm and degrees in constants; None for undefined ones."""
FLAGS: Final = ("FL1", "FL2")
JOINTS: Final = tuple(f"J{axis}" for axis in range(1, 9))

_DEFAULT_FLAGS: Final = (7, 0)
"""Flags of a constant that states none (CR1D 4.3.12)."""


@dataclass(frozen=True, slots=True)
class Position:
    """values: eight of COMPONENTS, mm and degrees. flags: FL1 and FL2; None where not known.

    corner: the motion in whose corner it was read from the arm, None for any other: where motions
    take no time it has the target of that motion, but on a controller any position near it.
    """

    values: Elements
    flags: tuple[int | None, int | None] = _DEFAULT_FLAGS
    corner: Moved | None = field(default=None, compare=False, repr=False)


ORIGIN: Final = Position((0.0,) * 6 + (None,) * 2, (0, 0))
"""No tool, no base."""


@dataclass(frozen=True, slots=True)
class Joints:
    """Eight values, degrees, mm of an axis that slides; None for what is not defined."""

    values: Elements


@dataclass(frozen=True, slots=True)
class Bare:
    """A constant without flags: a position or joints, as that which it meets."""

    values: Elements

    def position(self) -> Position:
        return Position(self.values)

    def joints(self) -> Joints:
        return Joints(self.values)


Value = int | float | bool | str | Position | Joints | Bare
"""A truth is what a comparison gives: 1 or 0 where a number is wanted."""

_INTEGER_RANGES: Final = {"integer": 1 << 15, "long": 1 << 31}
"""Bound of whole types: 16 and 32 bits with a sign."""


def eight(values: tuple[float | None, ...]) -> Elements:
    """Eight elements; those that are left out at the end are not defined."""
    if len(values) > 8:
        raise Failed(4220, "a constant of more than eight elements")
    return (*values, *(None,) * (8 - len(values)))


def number(value: Value, what: str = "the value") -> int | float:
    """A value as a number; raises Failed for another type."""
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, int | float):
        return value
    raise _number_wanted(what)


def whole(value: Value, what: str = "the value") -> int:
    r"""A number rounded to a whole one, halves away from zero as CInt does (COSIROP: CINT).

    That is what subscripts, the operands of `\` and `Mod`, and whole types do with real numbers.
    """
    given = number(value, what)
    if isinstance(given, int):
        return given
    if not math.isfinite(given):
        raise Unknown(f"{what} is not finite")
    # `round` would take halves to the even number.
    return math.floor(given + 0.5) if given >= 0 else math.ceil(given - 0.5)


def text(value: Value, what: str = "the value") -> str:
    if isinstance(value, str):
        return value
    raise Failed(4390, f"{what} is no text")


def position(value: Value, what: str = "the value") -> Position:
    if isinstance(value, Bare):
        return value.position()
    if isinstance(value, Position):
        return value
    raise Failed(4390, f"{what} is no position")


def joints(value: Value, what: str = "the value") -> Joints:
    if isinstance(value, Bare):
        return value.joints()
    if isinstance(value, Joints):
        return value
    raise Failed(4390, f"{what} is no joint position")


def kind_of(value: Value) -> Kind:
    """The type of a value: `number` for all numbers; of a bare constant, a position's."""
    if isinstance(value, str):
        return "text"
    if isinstance(value, Joints):
        return "joints"
    return "position" if isinstance(value, Position | Bare) else "number"


def holds(value: Value) -> bool:
    """True if a condition is met: every number but 0 is true (COSIROP: WHILE)."""
    return number(value, "the condition") != 0


def fitted(value: Value, kind: Kind, what: str, options: Options) -> Value:
    """A value that is to go into a variable: a whole one takes no more than its bits."""
    if isinstance(value, str) and len(value) > options.longest_text:
        raise open_point(f"a text of {len(value)} characters", "longest_text")
    if kind not in _INTEGER_RANGES or isinstance(value, str) or options.overflow is None:
        return value
    bound, rounded = _INTEGER_RANGES[kind], whole(value, what)
    if -bound <= rounded < bound:
        return rounded
    if options.overflow == "error":
        raise Failed(None, f"{rounded} does not fit into {what}")
    # The bits that fit, as a number with a sign.
    return (rounded + bound) % (2 * bound) - bound


def converted(value: Value, kind: Kind, what: str) -> Value:
    """A value as a variable of a type keeps it."""
    match kind:
        case "number":
            return number(value, what)
        case "integer" | "long":
            rounded = whole(value, what)
            if not -_INTEGER_RANGES[kind] <= rounded < _INTEGER_RANGES[kind]:
                raise open_point(f"{rounded} does not fit into {what}", "overflow")
            return rounded
        case "text":
            return text(value, what)
        case "position":
            return position(value, what)
        case "joints":
            return joints(value, what)


# ---------------------------------------------------------------------------- components

_ANGLE_PLACES: Final = 9
"""Decimals of degrees that are kept of an angle set in radian: 60 degrees are 60 again."""


def _degrees(radian: float) -> float:
    return round(math.degrees(radian), _ANGLE_PLACES)


def component(value: Value, name: str, options: Options) -> int | float:
    """A component: angles in radian (PRGMDEG 0), lengths in mm, flags whole."""
    if isinstance(value, Joints):
        if name not in JOINTS:
            raise Failed(4220, f"joints have no component {name}")
        element = _defined_element(value.values[JOINTS.index(name)], name)
        return math.radians(element) if _in_radian(name, options) else element
    given = position(value, f"what has a component {name}")
    if name in FLAGS:
        flag = given.flags[FLAGS.index(name)]
        if flag is None:
            raise Unknown(f"the component {name} of a position without flags")
        return flag
    if name not in COMPONENTS:
        raise Failed(4220, f"positions have no component {name}")
    element = _defined_element(given.values[COMPONENTS.index(name)], name)
    return math.radians(element) if _in_radian(name, options) else element


def with_component(value: Value, name: str, new: Value, options: Options) -> Position | Joints:
    """The value with one component set, which is given as `component` gives it."""
    if isinstance(value, Joints):
        if name not in JOINTS:
            raise Failed(4220, f"joints have no component {name}")
        given_joint = float(number(new, name))
        element = _degrees(given_joint) if _in_radian(name, options) else given_joint
        return Joints(_with_element(value.values, JOINTS.index(name), element))
    given = position(value, f"what has a component {name}")
    if name in FLAGS:
        one, two = given.flags
        flag = whole(new, name)
        return replace(given, flags=(flag, two) if name == "FL1" else (one, flag))
    if name not in COMPONENTS:
        raise Failed(4220, f"positions have no component {name}")
    element = float(number(new, name))
    element = _degrees(element) if _in_radian(name, options) else element
    return replace(given, values=_with_element(given.values, COMPONENTS.index(name), element))


def _in_radian(name: str, options: Options) -> bool:
    if name in _ADDITIONAL:
        if options.slides is None:
            raise open_point("whether an additional axis turns or slides", "slides")
        return not options.slides and not options.degrees
    return name not in ("X", "Y", "Z") and not options.degrees


_ADDITIONAL: Final = ("L1", "L2", "J7", "J8")


def _with_element(values: Elements, at: int, value: float) -> Elements:
    return (*values[:at], value, *values[at + 1 :])


def _defined_element(value: float | None, name: str) -> float:
    if value is None:
        raise Failed(3700, f"the component {name} is not defined")
    return value


Index = tuple[int, ...]

LETTERS: Final[Mapping[str, Kind]] = {"P": "position", "J": "joints"}
SUFFIXES: Final[Mapping[str, Kind]] = {
    "%": "integer", "&": "long", "!": "number", "#": "number", "$": "text",
}  # fmt: skip
DEFINED: Final[Mapping[str, Kind]] = {
    "Inte": "integer", "Long": "long", "Float": "number", "Double": "number", "Char": "text",
    "Pos": "position", "Jnt": "joints",
}  # fmt: skip
"""Type of `Def …`."""


OWN_ARRAY: Final = re.compile(r"[PJMC]_10[0-4]")
OWN_ELEMENTS: Final = 10
"""Arrays that all programs share on every controller, and how many elements each has."""


def kind_by_name(name: str) -> Kind:
    """The type of a name that nothing declares; an external one that begins with C is a text."""
    if name[:2] == "C_":
        return "text"
    return LETTERS.get(name[:1], "number")


def is_external(name: str) -> bool:
    """True if all programs share the variable (CR1D 4.3.7)."""
    return name[1:2] == "_"


@dataclass(slots=True)
class Cell:
    """A variable. size: extents of an array, empty for a single value."""

    name: str
    kind: Kind
    size: Index = ()
    values: dict[Index, Value] = field(default_factory=dict)

    def get(self, index: Index = ()) -> Value:
        self._check(index)
        if index not in self.values:
            raise Failed(3700, f"the variable {self._said(index)} has no value")
        return self.values[index]

    def set(self, value: Value, index: Index = ()) -> None:
        self._check(index)
        self.values[index] = converted(value, self.kind, self._said(index))

    def is_set(self, index: Index = ()) -> bool:
        self._check(index)
        return index in self.values

    def copy(self, name: str) -> Cell:
        """For an array that is given by value."""
        return Cell(name, self.kind, self.size, dict(self.values))

    def _check(self, index: Index) -> None:
        if len(index) != len(self.size):
            if not index:
                raise Unknown(f"the array {self.name} without a subscript")
            raise Failed(4370, f"{self._said(index)} is no element of an array")
        if any(not 1 <= i <= n for i, n in zip(index, self.size, strict=True)):
            raise Failed(4370, f"there is no element {self._said(index)}")

    def _said(self, index: Index) -> str:
        return f"{self.name}({','.join(map(str, index))})" if index else self.name


@dataclass(slots=True)
class Element:
    """One element of an array under a separate name: a reference that a Function takes."""

    cell: Cell
    at: Index

    @property
    def kind(self) -> Kind:
        return self.cell.kind

    def get(self, index: Index = ()) -> Value:
        self._check(index)
        return self.cell.get(self.at)

    def set(self, value: Value, index: Index = ()) -> None:
        self._check(index)
        self.cell.set(value, self.at)

    def is_set(self, index: Index = ()) -> bool:
        self._check(index)
        return self.cell.is_set(self.at)

    def _check(self, index: Index) -> None:
        if index:
            raise Failed(4370, f"{self.cell.name} is no array here")


Storage = Cell | Element


@dataclass(slots=True)
class Scope:
    """Types and extents as the text of a program or of a function declares them."""

    kinds: dict[str, Kind] = field(default_factory=dict)
    sizes: dict[str, Index] = field(default_factory=dict)
    declared: set[str] = field(default_factory=set)
    static: set[str] = field(default_factory=set)

    def cell(self, name: str) -> Cell:
        return Cell(name, self.kinds.get(name, kind_by_name(name)), self.sizes.get(name, ()))


@dataclass(slots=True)
class Memory:
    """Variables by upper-case name, made when they are first met."""

    scope: Scope
    places: dict[str, Storage] = field(default_factory=dict)

    def place(self, name: str) -> Storage:
        found = self.places.get(name)
        if found is None:
            found = self.places[name] = self.scope.cell(name)
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self.places)
