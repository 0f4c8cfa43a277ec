"""Symbols of a file: variables, targets, signals and functions, their scopes and constant values.

`Symbols` gives the meaning of each name, `Scope` the types and sizes of the variables of a file or
function, and `Constants` the variables that keep one known value or are never assigned. Names are
in upper case.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.tables.poses import plain_pose
from assistant.languages.melfa_basic.tables.variables import (
    MARK_VALUE_TYPES,
    TAUGHT_STATUS,
    VALUE_TYPES,
)
from assistant.languages.melfa_basic.tables.vocabulary import commands, function, status
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import block_word
from assistant.languages.melfa_basic.tree.line_tables import Positions, joints_of, target_of
from assistant.languages.melfa_basic.tree.walk import declarations, nodes
from assistant.languages.vendor_statements import CONTROLLER_STATE
from assistant.program import expressions as e
from assistant.program.analysis.io_use import AddressedSignals
from assistant.program.geometry import BASE, FLANGE, Target
from assistant.program.program import Parameter, Signal, ValueType, Variable, identifier
from assistant.program.statements import Reason

if TYPE_CHECKING:
    from assistant.robots import Robot


LETTER_TYPES: Final[dict[str, ValueType]] = {
    "P": "position",
    "J": "joints",
    "C": "text",
    "M": "number",
}
"""Types by the first letter of a name; any other letter is a number's."""


@dataclass(slots=True)
class Scope:
    """types: as declared, or marked by a suffix. sizes: of arrays. names: every variable that is
    met, upper case → as first written. static: those that outlive their function.
    """

    types: dict[str, ValueType] = field(default_factory=dict)
    sizes: dict[str, tuple[int, ...]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    static: set[str] = field(default_factory=set)

    def copy(self) -> Scope:
        return Scope(dict(self.types), dict(self.sizes), dict(self.names), set(self.static))


def scope_of(items: Iterable[s.Entry], functions: Iterable[str]) -> Scope:
    """The variables that some lines hold. functions: upper-case names of the user's own."""
    scope = Scope()
    own = frozenset(functions)
    marked: dict[str, ValueType] = {}
    for item in items:
        if item.statement is None:
            continue
        _declare_variables(scope, item.statement)
        for node in nodes(item.statement):
            if isinstance(node, s.Variable) and node.key not in own and _is_variable(node):
                scope.names.setdefault(node.key, node.name)
                if node.suffix:
                    marked.setdefault(node.key, MARK_VALUE_TYPES[node.suffix])
    scope.types = {**marked, **scope.types}
    return scope


def _declare_variables(scope: Scope, statement: s.Statement) -> None:
    for variable, word in declarations(statement):
        if word in VALUE_TYPES:
            scope.types[variable.key] = VALUE_TYPES[word]
        if word in VALUE_TYPES or not word:
            _set_size(scope, variable)
        if isinstance(statement, s.Static):
            scope.static.add(variable.key)


def _set_size(scope: Scope, variable: s.Variable) -> None:
    size = tuple(int(a.value) for a in variable.arguments or () if isinstance(a, s.Number))
    if size and len(size) == len(variable.arguments or ()):
        scope.sizes[variable.key] = size


def _is_variable(node: s.Variable) -> bool:
    """True if a name belongs to the program, not to a status variable or function of the
    language.
    """
    if node.arguments is not None and function(node.key) is not None:
        return False
    return status(node.key) is None


def letter_type(key: str) -> ValueType:
    """The type of a variable that is declared nowhere; texts have a `$`, but for external ones."""
    if key[:1] == "C" and key[1:2] != "_":
        return "number"
    return LETTER_TYPES.get(key[:1], "number")


def variable_keys(items: Sequence[s.Entry]) -> Iterator[str]:
    """Upper-case names of all variables in some lines."""
    for item in items:
        statement: Any = item.statement if isinstance(item, s.Line) else None
        for node in nodes(statement):
            if isinstance(node, s.Variable):
                yield node.key


Value = float | str


INITIAL_STATUS: Final = {"M_NOVRD": 100.0, "M_NJOVRD": 100.0}
"""Status variables that never change: the percentages that hold when a program starts."""


class Constants:
    """assigned: upper-case names that a statement may change, elements and components too.

    values: those that are set once, before anything else can have happened, or by `Const`.
    kept: which arguments the functions and arrays of the file leave alone.
    """

    def __init__(self, code: Sequence[s.Entry]) -> None:
        count: Counter[str] = Counter()
        self.kept = kept = _kept_arguments(code)
        for item in code:
            if item.statement is not None:
                count.update(changed_variables(item.statement, kept))
        self.assigned = frozenset(count)
        self.values: dict[str, Value] = {}
        self.placed: dict[str, s.Constant] = {}
        """Positions that are given one constant, before anything else reads them."""
        at_start, read = True, set[str]()
        for item in code:
            statement = item.statement
            if isinstance(statement, s.Const):
                self._take(statement.variable, statement.value, count, at_start)
            # From a label on, lines may run again, after others have set the variable.
            at_start = at_start and item.label is None and not _leads_away(statement)
            if at_start and isinstance(statement, s.Assign):
                self._take(statement.target, statement.value, count, True)
                if statement.target.key not in read:
                    self._place(statement, count)
            if at_start and not isinstance(statement, s.DefNames):
                read.update(x.key for x in nodes(statement) if isinstance(x, s.Variable))

    def _take(
        self, variable: s.Variable, node: s.Expression, count: Counter[str], plain: bool
    ) -> None:
        key = variable.key
        if not plain or count[key] != 1 or variable.arguments is not None or variable.component:
            return
        if key[1:2] == "_" or status(key) is not None:  # others may change those
            return
        value = self.value(node)
        if value is not None:
            whole = variable.suffix in ("%", "&") and isinstance(value, float)
            self.values[key] = float(round(value)) if whole else value  # type: ignore[arg-type]

    def _place(self, node: s.Assign, count: Counter[str]) -> None:
        key, value = node.target.key, node.value
        if count[key] == 1 and node.target.arguments is None and not node.target.component:
            if isinstance(value, s.Constant) and key[1:2] != "_" and status(key) is None:
                self.placed[key] = value

    def value(self, node: s.Expression | None) -> Value | None:
        """Return the value of an expression if it is known: literals, constants, their sums."""
        match node:
            case s.Number(value=number):
                return float(number)
            case s.String(value=text):
                return text
            case s.Variable(arguments=None, component=""):
                return INITIAL_STATUS.get(node.key) or self.values.get(node.key)
            case s.Unary(operator=("-" | "+") as sign, operand=operand):
                inner = self.value(operand)
                if not isinstance(inner, float):
                    return None
                return -inner if sign == "-" else inner
            case s.Binary(operator=("+" | "-" | "*") as sign, left=left, right=right):
                one, two = self.value(left), self.value(right)
                if not isinstance(one, float) or not isinstance(two, float):
                    return None
                return one + two if sign == "+" else one - two if sign == "-" else one * two
        return None


def _leads_away(statement: s.Statement | None) -> bool:
    """True if the lines after a statement may run more than once, later, or not at all."""
    if isinstance(statement, s.Jump | s.If | s.OnJump | s.CallP | s.Call | s.Function | s.DefAct):
        return True
    return bool(block_word(statement).opens) or isinstance(statement, s.Next | s.OnCom)


KeptArguments = Mapping[str, Sequence[bool]]
"""By upper-case name of a function or array, which arguments it leaves alone."""


def _kept_arguments(code: Sequence[s.Entry]) -> dict[str, Sequence[bool]]:
    """Return, for the functions and arrays of a file, which arguments they leave unchanged."""
    found: dict[str, Sequence[bool]] = {}
    for item in code:
        match item.statement.definition if isinstance(item.statement, s.Static) else item.statement:
            case s.Function(name=name, parameters=parameters):
                found[name.upper()] = [q.mode == "ByVal" for q in parameters or ()]
            case s.Dim(variables=variables) | s.DefNames(variables=variables):
                found.update({v.key: [True] * len(v.arguments or ()) for v in variables})
            case s.DefFunction(name=name, parameters=variables):
                found[name.upper()] = [True] * len(variables)
    return found


def changed_variables(statement: s.Statement, kept: KeptArguments) -> Iterator[str]:
    """Upper-case names of the variables that a statement may give a new value."""
    for part in nodes(statement):
        match part:
            case s.Assign(target=variable) | s.Const(variable=variable):
                yield variable.key
            case s.For(variable=variable) | s.DefIo(variable=variable):
                yield variable.key
            case s.Input(variables=variables) | s.FPrm(variables=variables):
                yield from (v.key for v in variables)
            case s.Command(keyword, arguments) if keyword not in commands("reads"):
                yield from _changed_arguments(arguments)
            case s.Variable(arguments=tuple(given)) if status(part.key) is None:
                yield from _changed_arguments(
                    given, _unchanged_arguments(part.key, kept)
                )  # a function may change it


def _unchanged_arguments(key: str, kept: KeptArguments) -> Sequence[bool]:
    known = function(key)
    if known is not None and key not in kept:
        last = [not argument.assigned for argument in known.arguments]
        return [*last, *last[-1:] * 16]
    return kept.get(key, ())


def _changed_arguments(arguments: Sequence[Any], kept: Sequence[bool] = ()) -> Iterator[str]:
    """Variables among arguments, but for those that are left alone."""
    for at, argument in enumerate(arguments):
        if isinstance(argument, s.Variable) and not (at < len(kept) and kept[at]):
            yield argument.key


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

Analog signals are in registers of the network.
"""

IO_BITS: Final = {"BIT": 1, "BYTE": 8, "WORD": 16, "INTEGER": 16, "DWORD": 32}
"""Bits of a name that `Def Io` gives to inputs and outputs."""


VENDOR_ONLY_NAME: Final = "told {}"
"""Name of a function that replaces a status variable until it is lowered for other languages."""
VENDOR_ONLY_END: Final = VENDOR_ONLY_NAME.format("END")
"""Name of a call that stands for `End` in a subroutine until then, see `vendor_only`."""
CONTROLLER_STATES: Final = ("M_SVO", "M_OPOVRD", "M_OVRD")
"""States of the controller that are lowered for other languages."""


class Unliftable(Exception):
    """The pseudo-program has no words for it. reason: why, None if the statement itself tells."""

    def __init__(self, reason: Reason | None = None) -> None:
        self.reason = reason
        super().__init__(reason.why if reason else "")


@dataclass(slots=True)
class Routine:
    """A function of the user.

    name: in the pseudo-program. result: None for no result. parameters: None if the pseudo-program
    cannot express them, so that the function is passed through as vendor text.
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
        """Names of the timers that are lifted as timers, by number."""
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
        """Names that vendor text may refer to: functions, labels, in upper case."""
        self.telling = False
        """True while code is lifted for other languages, see `exported`."""

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
        """Lift a state of the controller; a later step lowers it for other languages."""
        if not self.telling or key not in CONTROLLER_STATES:
            raise Unliftable(CONTROLLER_STATE)
        return e.Apply(VENDOR_ONLY_NAME.format(key))

    def mounted(self, key: str) -> e.Expression | None:
        """Return the pose of the heading's tool or frame that a variable holds; None for any other
        variable.

        `Base` takes the inverse of a frame.
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
        # A position that the file lists is what the variable holds before the first line runs.
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
        """Lift a constant as the value of a variable of a type."""
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
        """Return the known value of an expression."""
        # A variable of a function hides the constant of that name.
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


SignalNames = Mapping[tuple[str, str, float], str]
"""Names of signals by kind, direction and number."""


def signal_names(signals: Mapping[str, Signal]) -> SignalNames:
    """The names that say more than a number, in ASCII, which all controllers show.

    Without those of signals that begin at one number: the code does not say which it means.
    """
    named: dict[tuple[str, str, float], list[str]] = {}
    for name, one in signals.items():
        if one.number is not None:
            named.setdefault((one.kind, one.direction, one.number), []).append(name)
    return {
        at: names[0]
        for at, names in named.items()
        if len(names) == 1
        and names[0].isascii()
        and str(at[2]) not in re.findall("[0-9]+", names[0])
    }


def signal_comment(statement: s.Statement | None, names: SignalNames) -> str:
    """The names of the signals that a statement addresses by number, separated by commas."""
    if not names:
        return ""
    addressed = (
        (*SIGNAL_VARIABLES[node.key][:2], node.arguments[0].value)
        for node in nodes(statement)
        if isinstance(node, s.Variable)
        and node.key in SIGNAL_VARIABLES
        and node.arguments
        and isinstance(node.arguments[0], s.Number)
    )
    return ", ".join(dict.fromkeys(names[at] for at in addressed if at in names))
