"""A running program: its line, subroutines, variables, arguments, and a debugger's view of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.events import Place
from assistant.virtual.kernel.task import Level, Shown
from assistant.virtual.melfa import expressions
from assistant.virtual.melfa.arm_state import FULL, OPTIMUM
from assistant.virtual.melfa.code import Block, Code
from assistant.virtual.melfa.positions import Grid
from assistant.virtual.melfa.values import (
    COMPONENTS,
    FLAGS,
    JOINTS,
    LETTERS,
    OWN_ARRAY,
    OWN_ELEMENTS,
    SUFFIXES,
    Bare,
    Cell,
    Element,
    Elements,
    Ended,
    Failed,
    Joints,
    Kind,
    Memory,
    Position,
    Redirected,
    Scope,
    Storage,
    Unknown,
    Value,
    converted,
    fitted,
    is_external,
    kind_by_name,
)
from assistant.virtual.melfa.world import World

if TYPE_CHECKING:
    from assistant.virtual.melfa.interrupts import Interrupts


_MOST_SUBROUTINES: Final = 800
_MOST_FUNCTIONS: Final = 16
_MOST_PROGRAMS: Final = {4: 7, 5: 8, 6: 8}
"""Largest depth of calls (CR1D 4-151, COSIROP: FPRM); that of GoSub is about 800."""


@dataclass(slots=True)
class Loop:
    """A `For` that runs: the value that ends it, and its step, as they were at its beginning."""

    last: float
    step: float


@dataclass(slots=True)
class Frame:
    """A Function that runs, or the program itself. back: rows that `Return` goes to.

    called_from: the row that calls. interrupts: whether it is of an interrupt. choice: what that
    returns with.
    """

    function: str
    memory: Memory
    back: list[int] = field(default_factory=list)
    loops: dict[int, Loop] = field(default_factory=dict)
    result: Value | None = None
    left: bool = False
    called_from: int = 0
    interrupts: bool = False
    choice: int | None = None


@dataclass
class Machine:
    """One program that runs. programs: what it may call, by upper-case name.

    here: the row that runs. at: the one that comes next. began: whether that at hand has begun.
    nest: runs of rows inside of each other. interrupts: None before it speaks of any.
    """

    code: Code
    world: World
    programs: Mapping[str, Machine]
    depth: int = 0
    here: int = 0
    at: int = 0
    began: bool = False
    nest: int = 0
    interrupts: Interrupts | None = None
    first: int = 0

    def __post_init__(self) -> None:
        self.main = Memory(self.code.main)
        self.static: dict[str, Memory] = {}
        self.frames = [Frame("", self.main)]
        self.pallets: dict[int, Grid] = {}
        self.arguments: tuple[Value, ...] = ()
        for name, index, value in self.code.data:
            self.memory_of(name).place(name).set(value, index)

    @property
    def frame(self) -> Frame:
        return self.frames[-1]

    # ------------------------------------------------------------------------------ running

    def run(self) -> None:
        """From the top, or once from the row `first`, to the end of the program."""
        self.at, self.first = self.first, 0
        self.frames, self.nest = [Frame("", self.main)], 0
        self.interrupts = None
        if self.depth == 0:
            self.world.task.looks = self.world.task.sampling = None
        self.world.running.append(self)
        with suppress(Ended):
            self.go_on(self.frame)
        self.world.running.pop()
        if self.depth == 0:
            self.world.end()

    def go_on(self, until: Frame) -> None:
        """Runs until a frame is left; the last row of a program is its end."""
        # Statements and machine need each other, so this import waits until it is used.
        from assistant.virtual.melfa.statements import execute

        self.nest += 1
        while not until.left:
            if self.at >= len(self.code.rows):
                raise Ended
            self.here, self.began = self.at, False
            # The next row unless the statement jumps.
            self.at += 1
            statement = self.code.rows[self.here].statement
            if statement is None:
                continue
            try:
                self.world.task.step()
                self.began = True
                execute(self, statement)
            except Redirected as elsewhere:
                self._redirect(elsewhere)
        self.nest -= 1

    def _redirect(self, elsewhere: Redirected) -> None:
        """Goes on where an interrupt says, in the run of rows that it is of."""
        # Runs of rows are nested calls: leave those inside the one that is meant.
        if elsewhere.nest != self.nest:
            self.nest -= 1
            raise elsewhere
        self.at = elsewhere.at

    def interrupting(self, where: Frame) -> Frame:
        """The frame of an interrupt's subroutine: it has the variables of its definition."""
        # It shares variables and loops, so that the interrupted lines find them changed.
        frame = Frame(where.function, where.memory, loops=where.loops, called_from=self.here)
        frame.interrupts = True
        self.frames.append(frame)
        return frame

    def took(self, way: int) -> None:
        """Tells who listens which way the statement at hand goes on, counted from 0."""
        listener = self.world.task.kernel.branch
        if listener is not None:
            listener(self.code.path, self.here, way)

    def jump(self, target: s.Target) -> None:
        self.at = self.code.target(target, self.frame.function)

    def gosub(self, target: s.Target) -> None:
        if len(self.frame.back) >= _MOST_SUBROUTINES:
            raise Failed(3220, "subroutines call too deep")
        self.frame.back.append(self.at)
        self.jump(target)

    # ------------------------------------------------------------------------------- memory

    def memory_of(self, name: str) -> Memory:
        """Return the memory of a variable: shared by all programs, of the function, or of the
        program.
        """
        if is_external(name):
            self._share(name)
            return self.world.shared
        frame = self.frame
        if not frame.function:
            return self.main
        # Parameters and own variables first, then static ones, then those of the program.
        if name in frame.memory.places:
            return frame.memory
        scope = self.code.scopes[frame.function]
        if name in scope.static:
            return self.static.setdefault(frame.function, Memory(scope))
        if name in self.code.main.declared and name not in scope.declared:
            return self.main
        return frame.memory

    def _share(self, name: str) -> None:
        """Makes a variable of all programs as the first one declares it that meets it.

        Behind a slot the controller knows them.
        """
        places = self.world.shared.places
        if name not in places and self.world.slot is None:
            cell = self.code.main.cell(name)
            if not cell.size and OWN_ARRAY.fullmatch(name):
                cell.size = (OWN_ELEMENTS,)
            places[name] = cell

    def is_own(self, name: str) -> bool:
        """True if the running function itself has a variable of that name."""
        return bool(self.frame.function) and (
            name in self.frame.memory.places
            or name in self.code.scopes[self.frame.function].declared
        )

    def is_result(self, node: s.Variable) -> bool:
        """True if a name means the result of the running function."""
        return node.arguments is None and node.key == self.frame.function != ""

    def result(self) -> Value:
        return self._given(self.frame, f"the result of {self.frame.function} is not set")

    def _given(self, frame: Frame, otherwise: str) -> Value:
        """Return the result of a function so far. otherwise: error message if it has no result."""
        if frame.result is not None:
            return frame.result
        kind = self._result_kind(frame.function)
        if self.world.options.unset == "zero" and kind not in (None, "text", *LETTERS.values()):
            return 0
        raise Failed(3700, otherwise)

    def set_result(self, value: Value) -> None:
        """The result of the function that runs, as its head says its type."""
        function = self.code.function_of(self.code.functions[self.frame.function])
        kind = self._result_kind(self.frame.function)
        if kind is None:
            raise Failed(4220, f"{function.name} gives nothing back")
        value = fitted(value, kind, function.name, self.world.options)
        self.frame.result = converted(value, kind, function.name)

    def _result_kind(self, key: str) -> Kind | None:
        """Return the kind of a function's result; None if it returns nothing."""
        function = self.code.function_of(self.code.functions[key])
        name = function.result.upper()
        if name in ("", "V"):
            return None
        mark = name[-1] if name[-1] in SUFFIXES else function.suffix
        return SUFFIXES.get(mark, "text" if name[0] == "C" else kind_by_name(name[0]))

    # ------------------------------------------------------------------------------ calling

    def called(self, node: s.Variable) -> Value:
        """Call a Function and return its result."""
        return self._given(self.call(node), f"{node.name} gives nothing back")

    def call(self, node: s.Variable) -> Frame:
        """Runs a Function of MELFA-BASIC VI."""
        block = self.code.functions.get(node.key)
        if block is None:
            raise Failed(3600, f"there is no function {node.name}")
        if len(self.frames) > _MOST_FUNCTIONS:
            raise Failed(3220, "functions call too deep")
        function = self.code.function_of(block)
        parameters, given = function.parameters or (), node.arguments or ()
        if len(parameters) != len(given):
            raise Failed(3120, f"{len(given)} arguments for the {len(parameters)} of {node.name}")
        memory = Memory(self.code.scopes[node.key])
        for parameter, argument in zip(parameters, given, strict=True):
            name = parameter.name.upper()
            memory.places[name] = self._argument(parameter, argument, memory.scope)
        frame = Frame(node.key, memory, called_from=self.here)
        # The function runs in the same machine, whose place is put back afterwards.
        back = self.here, self.at
        self.frames.append(frame)
        self.at = block.start + 1
        self.go_on(frame)
        self.frames.pop()
        self.here, self.at = back
        return frame

    def _argument(
        self, parameter: s.FunctionParameter, node: s.Expression | None, scope: Scope
    ) -> Storage:
        name = parameter.name.upper()
        mode = parameter.mode or self.world.options.parameters
        whole = isinstance(node, s.Variable) and not node.arguments and not node.component
        if parameter.array:
            if not isinstance(node, s.Variable) or not whole:
                raise Failed(3810, f"{parameter.name} takes an array")
            place = self.memory_of(node.key).place(node.key)
            if not isinstance(place, Cell):
                raise Failed(3810, f"{parameter.name} takes an array")
            return place if mode == "ByRef" else place.copy(name)
        kind = scope.kinds.get(name, kind_by_name(name))
        if mode == "ByRef" and isinstance(node, s.Variable):
            if node.component or self.is_result(node):
                raise Unknown("a component or a result that is given by reference")
            place, index = expressions.reference(self, node)
            if place.kind != kind:
                raise Unknown(f"a variable of another type by reference as {parameter.name}")
            return Element(place, index) if index and isinstance(place, Cell) else place
        made = Cell(name, kind)
        made.set(expressions.value(self, node))
        return made

    def leave(self) -> None:
        """The end of a Function; that of the first one is the end of the program."""
        if self.frame.function == MAIN and len(self.frames) == 2:
            raise Ended
        self.frame.left = True

    def defined(self, node: s.Variable) -> Value:
        """Return the value of a function that `Def FN` defines."""
        definition = self.code.definitions[node.key]
        given = node.arguments or ()
        if len(given) != len(definition.parameters):
            raise Failed(3120, f"{len(given)} arguments of {node.name}")
        memory = Memory(Scope(dict(self.frame.memory.scope.kinds)))
        for parameter, argument in zip(definition.parameters, given, strict=True):
            cell = memory.place(parameter.key)
            cell.set(expressions.value(self, argument))
        frame = self.frame
        # The parameters hide variables of the same names while the expression is evaluated.
        names = {name: frame.memory.places.get(name) for name in memory.places}
        frame.memory.places.update(memory.places)
        try:
            found = expressions.value(self, definition.value)
        finally:
            # Put the hidden variables back, also after an error.
            for name, before in names.items():
                if before is None:
                    del frame.memory.places[name]
                else:
                    frame.memory.places[name] = before
        kind: Kind = SUFFIXES.get(definition.suffix, kind_by_name(node.key[2:3]))
        return converted(found, kind, node.name)

    def call_program(self, name: str, arguments: tuple[Value, ...]) -> None:
        """`CallP`: another program, to its end; arguments go by value."""
        called = self.programs.get(name.upper())
        if called is None:
            raise Unknown(f"the program {name}, which is not at hand")
        if self.depth + 1 > _MOST_PROGRAMS[self.code.level]:
            raise Failed(3710, "programs call too deep")
        if called.depth or called is self:
            raise Failed(3710, f"the program {name} calls itself")
        if arguments and not called.code.takes:
            raise Failed(3120, f"{len(arguments)} arguments of {name}, which takes none")
        called.depth, called.arguments = self.depth + 1, arguments
        settings = self.world.settings
        before = settings.speed, settings.acceleration
        own = self.world.options.calls == "own speeds"
        if own:
            settings.speed, settings.acceleration = OPTIMUM, (FULL, FULL)
        called.run()
        if own:
            settings.speed, settings.acceleration = before
        called.depth = 0

    def enter_main(self, block: Block) -> None:
        """The Function that a program of MELFA-BASIC VI begins with."""
        if self.frame.function or self.frame.back:
            raise Failed(3220, "a Function is run into")
        self.frames.append(Frame(MAIN, Memory(self.code.scopes[MAIN])))
        self.at = block.start + 1


MAIN: Final = "MAIN"


def statement_place(world: World) -> Place | None:
    """Return the source location of the current statement."""
    if not world.running:
        return None
    machine = world.running[-1]
    return machine.code.place(machine.here)


def call_levels(world: World) -> list[Level]:
    """The functions and subroutines that run, of all programs, the innermost first."""
    return [level for machine in reversed(world.running) for level in _program_levels(machine)]


def _program_levels(machine: Machine) -> list[Level]:
    at, found = machine.here, []
    for frame in reversed(machine.frames):
        groups = _data_groups(machine, frame)
        for back in reversed(frame.back):
            found.append(Level("GoSub", machine.code.place(at), groups))
            # The call is in the row before the one that it returns to.
            at = back - 1
        found.append(Level(frame.function or "Main", machine.code.place(at), groups))
        at = frame.called_from
    return found


def _data_groups(machine: Machine, frame: Frame) -> Mapping[str, Callable[[], Sequence[Shown]]]:
    groups = {"Program": lambda: list(_shown_data(machine.main))}
    if frame.function:
        groups = {"Function": lambda: list(_shown_data(frame.memory)), **groups}
    return {**groups, "All programs": lambda: list(_shown_data(machine.world.shared))}


def _shown_data(memory: Memory) -> Iterator[Shown]:
    for name, place in memory.places.items():
        if not isinstance(place, Cell):
            yield _shown_value(name, place.cell.values.get(place.at), place.kind)
        elif place.size:
            size = ",".join(map(str, place.size))
            items = [
                _shown_value(f"({','.join(map(str, index))})", value, place.kind)
                for index, value in sorted(place.values.items())
            ]
            yield Shown(name, f"({size})", place.kind, lambda items=items: items)  # type: ignore[misc]
        else:
            yield _shown_value(name, place.values.get(()), place.kind)


def _shown_value(name: str, value: Value | None, kind: str) -> Shown:
    match value:
        case None:
            return Shown(name, "", kind)
        case Position(values, flags):
            parts = [*_shown_elements(COMPONENTS, values), *_shown_elements(FLAGS, flags)]
        case Joints(values) | Bare(values):
            parts = list(_shown_elements(JOINTS, values))
        case str():
            return Shown(name, f'"{value}"', kind)
        case _:
            return Shown(name, f"{float(value):.10g}", kind)
    text = "(" + ",".join(part.value for part in parts) + ")"
    return Shown(name, text, kind, lambda: parts)


def _shown_elements(
    names: Sequence[str], values: Elements | Sequence[int | None]
) -> Iterator[Shown]:
    for name, value in zip(names, values, strict=True):
        yield Shown(name, "" if value is None else f"{value:.10g}")
