"""What the names of one file mean: variables, targets, signals, functions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.lift.structure.scopes import Scope, letter_type
from assistant.languages.melfa_basic.lift.values.constants import Constants
from assistant.languages.melfa_basic.tables.poses import plain_pose
from assistant.languages.melfa_basic.tables.variables import TAUGHT_STATUS
from assistant.languages.melfa_basic.tables.vocabulary import status
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import Positions, joints_of, target_of
from assistant.languages.vendor_statements import CONTROLLER_STATE
from assistant.program import expressions as e
from assistant.program.analysis.io_use import AddressedSignals
from assistant.program.geometry import BASE, FLANGE, Target
from assistant.program.program import Parameter, Signal, ValueType, Variable, identifier
from assistant.program.statements import Reason

if TYPE_CHECKING:
    from assistant.robots import Robot

SIGNAL_VARIABLES: Final[dict[str, tuple[str, str, int]]] = {
    "M_IN": ("digital", "input", 1), "M_OUT": ("digital", "output", 1),
    "M_INB": ("group", "input", 8), "M_IN8": ("group", "input", 8),
    "M_OUTB": ("group", "output", 8), "M_OUT8": ("group", "output", 8),
    "M_INW": ("group", "input", 16), "M_IN16": ("group", "input", 16),
    "M_OUTW": ("group", "output", 16), "M_OUT16": ("group", "output", 16),
    "M_IN32": ("group", "input", 32), "M_OUT32": ("group", "output", 32),
    "M_DIN": ("analog", "input", 1), "M_DOUT": ("analog", "output", 1),
}  # fmt: skip
"""Status variable → kind, direction and bits of the signal that it addresses.

Analog ones stand in registers of the network.
"""

IO_BITS: Final = {"BIT": 1, "BYTE": 8, "WORD": 16, "INTEGER": 16, "DWORD": 32}
"""Bits of a name that `Def Io` gives to inputs and outputs."""


VENDOR_ONLY_NAME: Final = "told {}"
"""Name of a function that stands for a status variable until other languages are told of it."""
VENDOR_ONLY_END: Final = VENDOR_ONLY_NAME.format("END")
"""Name of a call that stands for `End` in a subroutine until then, see `told.endings`."""
CONTROLLER_STATES: Final = ("M_SVO", "M_OPOVRD", "M_OVRD")
"""States of the controller that other languages are told."""


class Unliftable(Exception):
    """The pseudo-program has no words for it. reason: why, None if the statement itself tells."""

    def __init__(self, reason: Reason | None = None) -> None:
        self.reason = reason
        super().__init__(reason.why if reason else "")


@dataclass(slots=True)
class Routine:
    """A function of the user's own.

    name: in the pseudo-program. result: None for none. parameters: None if the pseudo-program
    cannot say them, so that it stays as its text.
    """

    name: str
    result: ValueType | None = None
    parameters: tuple[Parameter, ...] | None = ()


@dataclass(frozen=True, slots=True)
class ComputedPallet:
    """A pallet that the program defines as it runs.

    names: of the variables, by CORNERS and COUNTS of `pallets`. arc: its places are on an arc.
    opposite: a definition has a fourth corner. turned: its places may have other angles than
    its start. direction: in all definitions, None if it is worked out.
    """

    names: Mapping[str, str]
    arc: bool
    opposite: bool
    turned: bool
    direction: int | None


@dataclass
class Symbols:
    """variables, signals: of the whole program. targets: positions that expressions name.

    scope: of the file. routines: the user's functions by upper-case name. inside: the function
    that is read, with its own variables by upper-case name.
    """

    header: Header
    positions: Positions
    constants: Constants
    scope: Scope
    robot: Robot | None
    dialect: str
    own: bool
    signals: dict[str, Signal]
    variables: dict[str, Variable]
    taken: set[str] = field(default_factory=set)
    targets: set[str] = field(default_factory=set)
    routines: dict[str, Routine] = field(default_factory=dict)
    inside: Inside | None = None

    def __post_init__(self) -> None:
        self.addressed = AddressedSignals(self.signals, self.free)
        self.pallets: dict[int, tuple[str, tuple[Target, ...]]] = {}
        """Arrays of the pallets whose points are known, by number."""
        self.worked_out: dict[int, ComputedPallet] = {}
        """Pallets that are worked out as the program runs, by number."""
        self.mo_triggers: dict[int, tuple[str, s.Expression]] = {}
        """Conditions of Mo triggers, and the variables that say whether they are watched."""
        self.grids = True
        """True if pallets are such arrays in every language."""
        self.timers: dict[int, str] = {}
        """Names of the timers that are read as such, by number."""
        self.spelling: dict[str, str] = {}
        self.io: dict[str, tuple[int, int]] = {}
        self.renamed: dict[str, str] = {}
        self.placing: tuple[Any, Any] = (FLANGE, BASE)
        """Tool and frame that hold at the line that is read."""
        self.placing_told: tuple[Any, Any] = (FLANGE, BASE)
        """The same, lowered for other languages."""
        self.speed: Any = None
        """Speed of `Spd` at the line that is read: mm/s, or the variable that holds it."""
        self.goes_on = False
        """True if some `Print #` leaves its line unfinished."""
        self.opened: tuple[int, ...] | None = None
        """The channels that a `Close` of all closes, None if they are not known."""
        self.variants: dict[str, str] = {}
        """Names of the forms of functions that are called from the line that is read."""
        self.in_texts: set[str] = set()
        """What texts that stay may call by its name: functions, labels, in upper case."""
        self.telling = False
        """Whether it is read what other languages are told, see `exported`."""

    # ------------------------------------------------------------------------------- names

    def free(self, given: str) -> str:
        """A name close to the given one that nothing has yet; from now on it is taken."""
        free = identifier(given, self.taken)
        self.taken.add(free.lower())
        return free

    def static(self, routine: str, key: str, written: str) -> str:
        """The name of a variable that outlives its function, the same in all forms of it."""
        return self._renamed(f"{routine}.{key}", f"{routine}_{written}")

    def _renamed(self, key: str, wanted: str) -> str:
        if key not in self.renamed:
            self.renamed[key] = self.free(wanted)
        return self.renamed[key]

    def name(self, node: s.Variable) -> e.Expression:
        """A whole variable by its original name; inline positions by their value."""
        key, names = node.key, self.header.names
        if self.inside is not None and key in self.inside.names:
            return e.Name(self.inside.names[key])
        if key in self.header.inline:
            constant = self.positions.constant(key)
            if constant is None:
                raise Unliftable
            return self.value_of(constant, "joints" if key[0] == "J" else "position")
        for kind in ("target", "joints", "loop"):
            if key in names[kind]:
                return e.Name(names[kind][key])
        if key in self.header.variables:
            return e.Name(self.header.variables[key].name)
        if (mounted := self.mounted(key)) is not None:
            return mounted
        taught = key in TAUGHT_STATUS and self.positions.constant(key) is not None
        if status(key) is not None and not taught:
            return self.state(key)
        if key not in self.constants.assigned and self.positions.constant(key) is not None:
            self.targets.add(key)
            return e.Name(self.target_name(node.name))
        return e.Name(self.declared(node))

    def state(self, key: str) -> e.Expression:
        """A state of the controller; what others are told of it is worked out later."""
        if not self.telling or key not in CONTROLLER_STATES:
            raise Unliftable(CONTROLLER_STATE)
        return e.Apply(VENDOR_ONLY_NAME.format(key))

    def mounted(self, key: str) -> e.Expression | None:
        """The pose of a tool or frame of a heading that a variable is, None for any other.

        What `Base` is given is the inverse of a frame.
        """
        names = self.header.names
        if self.own and key in names["tool"]:
            return e.Name(names["tool"][key])
        if self.own and key in names["frame"] and not self.header.products:
            return e.Apply("inverse", (e.Name(names["frame"][key]),))
        return None

    def target_name(self, written: str) -> str:
        """The name of a position constant, another one if a program before has it already."""
        return written if self.own else self._renamed(written.upper(), written)

    def declared(self, node: s.Variable) -> str:
        """The name of a variable of the file, declared where it is first met."""
        key = node.key
        if key in self.spelling:
            return self.spelling[key]
        shared = key[1:2] == "_"
        if shared:  # one variable of all programs
            known = next((n for n in self.variables if n.upper() == key), None)
            if known is not None:
                self.spelling[key] = known
                return known
        name = self.spelling[key] = self.free(node.name)
        kind = self.type_of_key(key)
        constant = None if self.own else self.positions.constant(node.name)
        initial: e.Expression | None = None
        if constant is not None and kind in ("joints", "position"):
            initial = self.value_of(constant, kind)
        elif not self.own and key in self.positions.plain:
            initial = self.positions.plain[key][1].get(())
        kept = shared or initial is not None  # stands in the file or the controller
        self.variables[name] = Variable(
            kind, initial, self.scope.sizes.get(key, ()), "persistent" if kept else "variable"
        )
        return name

    def value_of(self, constant: s.Constant, kind: ValueType) -> e.Expression:
        """What a constant means to a variable of a type."""
        if kind == "joints":
            return e.JointValue(joints_of(constant, self.robot))
        if kind == "pose":
            return e.PoseValue(plain_pose(constant.values))
        return e.TargetValue(target_of(constant, self.robot))

    def type_of_key(self, key: str) -> ValueType:
        """The type of a variable or function of the user's own, or a status variable."""
        if self.inside is not None and key in self.inside.names:
            return self.inside.types.get(key, letter_type(key))
        if key in self.header.variables:
            return self.header.variables[key].type
        routine = self.routines.get(key)
        if routine is not None and routine.result is not None:
            return routine.result
        if self.mounted(key) is not None:
            return "pose"
        return self.scope.types.get(key, letter_type(key))

    def size_of(self, key: str) -> tuple[int, ...]:
        if self.inside is not None and key in self.inside.names:
            return self.inside.sizes.get(key, ())
        if key in self.header.variables:
            return self.header.variables[key].size
        return self.scope.sizes.get(key, ())

    def is_shadowed(self, key: str) -> bool:
        return self.inside is not None and key in self.inside.names

    def value(self, node: s.Expression | None) -> float | str | None:
        """What an expression is known to come to."""
        if isinstance(node, s.Variable) and self.is_shadowed(node.key):
            return None
        known = self.constants.value(node)
        return self._listed(node) if known is None else known

    def _listed(self, node: s.Expression | None) -> float | None:
        """The number that the file's list of values holds for a variable that no line changes.

        Other programs change shared ones.
        """
        if not isinstance(node, s.Variable) or node.arguments is not None or node.component:
            return None
        if node.key[1:2] == "_" or node.key in self.constants.assigned:
            return None
        match self.positions.plain.get(node.key, ("", {}))[1].get(()):
            case e.Number(value=value):
                return float(value)
        return None

    # ----------------------------------------------------------------------------- signals

    def signal(self, key: str, number: int) -> str:
        """The name of a signal by its address. key: of SIGNALS."""
        kind, direction, bits = SIGNAL_VARIABLES[key]
        return self.signal_at(kind, direction, bits, number)

    def signal_at(self, kind: Any, direction: Any, bits: int, number: int, wanted: str = "") -> str:
        return self.addressed.name(Signal(kind, direction, number, bits), wanted)

    def io_signal(self, node: s.Variable, direction: str) -> str:
        """The input or output behind a name that `Def Io` gave."""
        bits, number = self.io[node.key]
        kind = "digital" if bits == 1 else "group"
        return self.signal_at(kind, direction, bits, number, node.name)


@dataclass(slots=True)
class Inside:
    """A function while it is read.

    names, types, sizes: its parameters and own variables by upper-case name. result: the variable
    that holds its result so far, None if each result is given back at once.
    """

    key: str
    names: dict[str, str]
    types: dict[str, ValueType]
    sizes: dict[str, tuple[int, ...]]
    result: str | None = None
