"""A controller that runs RAPID: its configuration, loaded modules, signals and persistent data.

All tasks share them. Long runs of declarations and moves, whose tree is columns, are read as plain
nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from datetime import datetime
from typing import Final, Literal, TypeGuard

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import MoveRun, TargetRun
from assistant.languages.rapid.tree.walk import nodes
from assistant.virtual.kernel.kernel import CLOCK_START
from assistant.virtual.kernel.task import Task
from assistant.virtual.rapid.control_flow import Fault
from assistant.virtual.rapid.disk import Disk
from assistant.virtual.rapid.scopes import Cell, Known, Meaning, Pending, Storage, Types, Unit
from assistant.virtual.rapid.values import Shape

_MOVE_NAMES: Final = ("MoveJ", "MoveL", "MoveC")
_CIRCULAR_MOVE: Final = 2
_TARGET_PARTS: Final = ((0, 3), (3, 7), (7, 11), (11, 17))


def target_data(node: s.TargetRunNode) -> Iterator[s.Data]:
    run: TargetRun = node.run
    for row in range(len(run)):
        name = run.names.name(row)
        yield s.Data(node.scope, "CONST", "robtarget", name, (), _target_data(run.values[row]))


def move_calls(run: MoveRun) -> Iterator[s.ProcedureCall]:
    for row in range(len(run)):
        kind, how = int(run.kinds[row]), run.motions[row]
        arguments: list[s.Argument] = []
        if kind == _CIRCULAR_MOVE:
            arguments.append(s.Positional(s.NameRef(run.vias.name(row))))
        to = s.NameRef(run.names.name(row)) if run.values is None else _target_data(run.values[row])
        arguments.append(s.Positional(to))
        arguments += [s.Positional(s.NameRef(n)) for n in (how.speed, how.zone, how.tool)]
        if how.frame:
            arguments.append(s.Option("WObj", s.NameRef(how.frame)))
        yield s.ProcedureCall(_MOVE_NAMES[kind], tuple(arguments))


def _target_data(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> s.AggregateNode:
    return s.AggregateNode(
        tuple(
            s.AggregateNode(tuple(_row_number(float(value)) for value in values[start:stop]))
            for start, stop in _TARGET_PARTS
        )
    )


def _row_number(value: float) -> s.Expression:
    literal = s.NumberLiteral(repr(abs(value)))
    # RAPID has no negative literals: the sign is an operator.
    return s.Prefix("-", literal) if value < 0 else literal


_STORAGE: Final[dict[str, Storage]] = {"VAR": "VAR", "PERS": "PERS", "CONST": "CONST"}
_SETTING_INSTRUCTIONS: Final = frozenset(
    (
        *("set", "reset", "setdo", "setgo", "setao", "invertdo", "pulsedo"),
        *("waitdo", "waitgo", "waitao", "doutput", "goutput", "aoutput", "goutputdnum"),
        *("isignaldo", "isignalgo", "isignalao"),
    )
)
"""Instructions and functions whose first argument is an output."""
_READING_FUNCTIONS: Final = frozenset(
    (
        *("waitdi", "waitgi", "waitai", "testdi", "dinput", "ginput", "ainput", "ginputdnum"),
        *("isignaldi", "isignalgi", "isignalai"),
    )
)
"""The same of an input."""
_SET_UP_TRIGGERS: Final = frozenset(("triggio", "triggequip"))
"""Instructions whose options name an output that motions set on their way."""
_CORNER_MOVES: Final = {
    f"move{letter}{kind}": place
    for letter, place in (("j", 4), ("l", 4), ("c", 5))
    for kind in ("do", "ao", "go")
}
"""Motions that set an output, and which argument it is."""
_ALIAS_INSTRUCTIONS: Final = "aliasio"
"""Gives data of a signal the one that its first argument is, or names in text."""


@dataclass(slots=True)
class Loaded:
    """named: what all modules know, by name in lower case. units: modules. cells: all data.

    files: the text of the modules.
    """

    named: dict[str, Meaning] = field(default_factory=dict)
    units: dict[str, Unit] = field(default_factory=dict)
    cells: list[Cell] = field(default_factory=list)
    files: Sequence[s.File] = ()


def load_modules(files: Sequence[s.File], types: Types, shared: dict[str, Cell]) -> Loaded:
    """The names and data of modules; raises Fault where two mean the same name.

    shared: persistents of all tasks by name in lower case, which is added to.
    """
    loaded = Loaded(files=files)
    named, cells = loaded.named, loaded.cells
    for file in files:
        for module in file.modules:
            unit = loaded.units[module.name.lower()] = Unit(file.source, name=module.name)
            for item in module.items:
                if isinstance(item, s.Record | s.Alias):
                    types.declare(item)
            for local, name, meaning in _module_names(module, unit):
                names, key = unit.names if local else named, name.lower()
                if isinstance(meaning, Cell) and _is_shared(meaning):
                    shared_cell = _shared_cell(meaning, key, shared)
                    # Modules may repeat the declaration of a shared persistent.
                    if names.get(key) is shared_cell:
                        continue
                    meaning = shared_cell
                if key in names:
                    raise Fault(f"two meanings of the name `{name}`")
                names[key] = meaning
                if isinstance(meaning, Cell):
                    cells.append(meaning)
    return loaded


def _is_shared(cell: Cell) -> bool:
    """A PERS that is neither LOCAL nor TASK is one and the same under its name everywhere."""
    return cell.pending is not None and cell.storage == "PERS" and not cell.pending.node.scope


def _shared_cell(cell: Cell, key: str, shared: dict[str, Cell]) -> Cell:
    """The one cell of a persistent: with the value of the first declaration that states one."""
    known = shared.setdefault(key, cell)
    if known.pending is not None and cell.pending is not None:
        first, second = known.pending.node, cell.pending.node
        if (first.type.lower(), len(first.dimensions)) != (
            second.type.lower(),
            len(second.dimensions),
        ):
            raise Fault(f"the persistent `{second.name}` is of another type elsewhere")
    # Only one of the declarations needs to state the value.
    if known.pending is not None and known.pending.node.value is None:
        known.pending = cell.pending
    return known


def _module_names(module: s.Module, unit: Unit) -> Iterator[tuple[bool, str, Meaning]]:
    for item in module.items:
        match item:
            case s.Routine(local=local, name=name):
                yield local, name, Known(item, unit)
            case s.Data():
                yield _declared_cell(item, unit)
            case s.TargetRunNode():
                yield from (_declared_cell(datum, unit) for datum in target_data(item))
            case s.Placeholder(text):
                raise Fault(f"the placeholder `{text}`")


def _declared_cell(node: s.Data, unit: Unit) -> tuple[bool, str, Meaning]:
    cell = Cell(Shape(""), _STORAGE[node.storage], pending=Pending(node, unit))
    return node.scope == "LOCAL", node.name, cell


def used_signals(files: Iterable[s.File]) -> tuple[frozenset[str], frozenset[str]]:
    """Return the names of outputs, and of all signals, that the modules use, in lower case."""
    outputs: set[str] = set()
    known: set[str] = set()
    for node in nodes(tuple(file.parts for file in files)):
        if not isinstance(node, s.ProcedureCall | s.FunctionCall) or not isinstance(node.name, str):
            continue
        name = node.name.lower()
        given = [a.value for a in node.arguments if isinstance(a, s.Positional)]
        if name in _SET_UP_TRIGGERS:
            # The output is the value of an option: `\DOp`, `\GOp` or `\AOp`.
            on_way = (a.value for a in node.arguments if isinstance(a, s.Option))
            named = {one.name.lower() for one in on_way if isinstance(one, s.NameRef)}
            outputs |= named
            known |= named
        # A name that is worked out at run time is not known here, see `works_signals_out`.
        if name == _ALIAS_INSTRUCTIONS and given and isinstance(given[0], s.StringLiteral):
            known.add(given[0].value.lower())
        place = _CORNER_MOVES.get(name, 0)
        if (
            name in _SETTING_INSTRUCTIONS | _READING_FUNCTIONS | _CORNER_MOVES.keys()
            and len(given) > place
        ):
            signal = given[place]
            if isinstance(signal, s.NameRef):
                known.add(signal.name.lower())
                if name not in _READING_FUNCTIONS:
                    outputs.add(signal.name.lower())
    return frozenset(outputs), frozenset(known)


def works_signals_out(files: Iterable[s.File]) -> bool:
    """True if signals may get names at run time that the modules do not contain."""
    calls = (n for n in nodes(tuple(file.parts for file in files)) if _is_alias(n))
    return any(
        isinstance(one, s.Positional) and not isinstance(one.value, s.StringLiteral)
        for call in calls
        for one in call.arguments[:1]
    )


def _is_alias(node: object) -> TypeGuard[s.ProcedureCall]:
    if not isinstance(node, s.ProcedureCall) or not isinstance(node.name, str):
        return False
    return node.name.lower() == _ALIAS_INSTRUCTIONS


Kind = Literal["normal", "static", "semistatic"]
"""Kind of a task: determines how it starts, and its state after power on (RAPID overview,
Multitasking).
"""
_RETRIES: Final = 4
"""The system parameter No Of Retry, as controllers are delivered (reference, 2.1)."""


@dataclass(frozen=True, slots=True)
class Options:
    """Differences between controllers, and points that their manuals leave open.

    retries: those of a statement, by RETRY. retries_raise: one more is the error ERR_EXCRTYMAX in
    that statement; else it stops the program. propagates: an error in a routine without a handler
    passes to that of its caller, as in the kernel manual; else it stops the program at once, as in
    the overview. began: date of the simulated clock at 0, for CDate and CTime. addresses: real
    hosts by the address that programs state; without an entry only this computer is reached.
    sockets: whether programs may reach anything outside the run at all.
    """

    retries: int = _RETRIES
    retries_raise: bool = False
    propagates: bool = True
    began: datetime = CLOCK_START
    addresses: Mapping[str, str] = field(default_factory=dict)
    sockets: bool = True


@dataclass(slots=True, eq=False)
class Controller:
    """disk: its files, none at first. persistents: what the tasks share, by name in lower case.

    booked: numbers of errors. tasks: in the order in which they were started. programs: what they
    run. outputs, known: names of signals in lower case that programs set, and of all that they
    use. come: how often a task came to a point of WaitSyncTask, both by name in lower case.
    held: the task that has stopped all motions by StopMove, None while none has.
    looks: are called before each statement of any task, to see whether shared data has changed.
    """

    options: Options = field(default_factory=Options)
    disk: Disk = field(default_factory=Disk)
    persistents: dict[str, Cell] = field(default_factory=dict)
    booked: set[int] = field(default_factory=set)
    outputs: set[str] = field(default_factory=set)
    known: set[str] = field(default_factory=set)
    tasks: list[Task] = field(default_factory=list)
    come: dict[tuple[str, str], int] = field(default_factory=dict)
    programs: list[tuple[Loaded, Types]] = field(default_factory=list)
    looks: list[Callable[[], None]] = field(default_factory=list)
    held: Task | None = None
