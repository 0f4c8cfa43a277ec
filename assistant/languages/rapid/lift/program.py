"""The typed trees of modules as one pseudo-program: its data, routines and comments.

Modules that a task holds beside its main one are units, and a call of what another module declares
is a call of that unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain
from types import MappingProxyType
from typing import Any, Final

from assistant.base.source_text import starts_of
from assistant.languages.rapid.lift.clocks import timer_clocks
from assistant.languages.rapid.lift.declared_data import DataLift, PathLift
from assistant.languages.rapid.lift.flatten.chosen_signals import chosen_signals
from assistant.languages.rapid.lift.name_clashes import with_unique_data_names
from assistant.languages.rapid.lift.statements import (
    TRIGGER_REASONS,
    NameResolver,
    StatementLift,
    TriggerReader,
    handler,
    opaque,
)
from assistant.languages.rapid.lift.vendor_effects import signals_in, with_places
from assistant.languages.rapid.tables.constants import PREDEFINED_VALUES, VALUE_OF_TYPE
from assistant.languages.rapid.tables.equivalents import BLENDS, SPEEDS
from assistant.languages.rapid.tables.predefined import FUNCTIONS
from assistant.languages.rapid.tables.signals import hand_of
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.text.header import Header, module_header
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inner_names
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import signal_uses, with_used_signals
from assistant.program.passes.loops import with_hiding_loops_renamed
from assistant.program.passes.operator_texts import with_values
from assistant.program.passes.paths import with_paths
from assistant.program.passes.trigger_data import with_triggers
from assistant.program.passes.variables import with_constants
from assistant.program.program import (
    Declaration,
    Parameter,
    Procedure,
    Program,
    Signal,
    TakenNames,
    Variable,
    identifier,
)
from assistant.program.rewriting import Body, map_bodies, with_names_replaced, with_spans_from


def _with_unit_calls(program: Program) -> Program:
    """Return the program with calls of procedures in another module as calls of that unit."""
    homes = {q.name.lower(): q.unit for q in program.procedures}

    def home(call: p.Call, own: str | None) -> str | None:
        there = homes.get(call.procedure.lower())
        return there if call.unit is None and there != own else call.unit

    return _with_units_changed(program, lambda unit: unit, home)


def as_one_unit(program: Program) -> Program:
    """A program of one unit, where its modules say that the task holds them all."""
    origin = program.origin
    modules = () if origin is None else (m for file in origin.trees for m in file.modules)
    if not any(module_header(module).resident for module in modules):
        return program
    return _with_units_changed(program, lambda _: None, lambda call, own: None)  # noqa: ARG005


def _with_units_changed(
    program: Program,
    of: Callable[[str | None], str | None],
    home: Callable[[p.Call, str | None], str | None],
) -> Program:
    def body(statements: Body, own: str | None) -> Body:
        return tuple(
            replace(node, unit=home(node, own))
            if isinstance(node, p.Call)
            else map_bodies(node, lambda inner: body(inner, own))
            for node in statements
        )

    procedures = (
        replace(q, unit=of(q.unit), body=body(q.body, q.unit)) for q in program.procedures
    )
    return replace(program, procedures=tuple(procedures))


_NOTHING_KEPT: Final = MappingProxyType[int, str]({})


def lift(files: Sequence[s.File], kept: Mapping[int, str] = _NOTHING_KEPT) -> Program:
    """The program that the modules of these files say together.

    kept: statements that stay as their text, by `id`, each with why.
    """
    modules: list[s.Module] = []
    starts: list[int] = []
    outside: list[tuple[str, ...]] = []
    for file, start in zip(files, starts_of(file.source for file in files), strict=True):
        modules += file.modules
        starts += [start] * len(file.modules)
        outside += _outer_comments(file)
    own = with_unique_data_names(modules)
    if not modules:
        return Program("empty", entry=None)
    return _Lift(own, starts, kept, chosen_signals(files), outside).program()


def routines(nodes: Iterable[s.Routine]) -> tuple[Procedure, ...]:
    """Lift routines of a module without other data, except those that stay vendor declarations."""
    return lift((s.File((s.Module("module", (), tuple(nodes)),)),)).procedures


class _Lift:
    """modules: one at least. starts: where the text of each begins, see `starts_of`. chosen:
    signals that texts alone may name. outside: the comments around each.
    """

    def __init__(
        self,
        modules: Sequence[s.Module],
        starts: Sequence[int],
        kept: Mapping[int, str],
        chosen: Mapping[str, Signal],
        outside: Sequence[tuple[str, ...]],
    ) -> None:
        self.chosen, self.outside = chosen, outside
        self.modules, self.starts = modules, starts
        self.headers = [module_header(m) for m in modules]
        self.main = self._main()
        self.names: dict[str, str] = {}
        for header in self.headers:
            self.names.update(header.names)
        routines = tuple(i for m in modules for i in m.items if isinstance(i, s.Routine))
        self.own = {r.name.lower() for r in routines}
        self.data = DataLift(modules, starts, self.original)
        self.paths = PathLift(modules, self.data, self.original)
        self.clocks = timer_clocks(modules)
        numbers = {
            n.lower(): v.initial
            for n, v in self.data.variables.items()
            if v.storage == "constant" and isinstance(v.initial, e.Number)
        }
        known = self.data.joint_targets.items()
        # An external axis without a position is NaN, which differs from itself.
        alone = {n.lower() for n, j in known if not any(v == v for v in j.external)}
        hidden = inner_names(routines) if numbers or alone else ()
        # A local name may hide the datum, so the name alone does not tell the value.
        inner = {self.original(name).lower() for name in hidden}
        self.meaning = NameResolver(
            self.original,
            self.data.speeds,
            self.data.blends,
            {name: number for name, number in numbers.items() if name not in inner},
            self.clocks,
            alone - inner,
        )
        self.statements = StatementLift(self.meaning, self.paths, self.own, kept)
        self.procedures: list[Procedure] = []
        self.declarations: list[Declaration] = []
        self.comments: list[str] = []

    def _main(self) -> int:
        """The module that names the program: that with its heading, else with its `main`."""
        # A module with a `unit of` heading belongs to another one.
        whole = [i for i, header in enumerate(self.headers) if not header.unit]
        headed = (i for i in whole if self.headers[i].program)
        entered = (i for i in whole if "main" in _routines_by_name(self.modules[i]))
        return next(chain(headed, entered, whole), 0)

    def original(self, name: str) -> str:
        return self.names.get(name.lower(), name)

    def program(self) -> Program:
        header = self.headers[self.main]
        self.comments += (*self.outside[self.main], *header.comments)
        for at, (module, own) in enumerate(zip(self.modules, self.headers, strict=True)):
            if at != self.main:
                self.comments += _declaration_comments(module, (*self.outside[at], *own.comments))
        each = zip(self.modules, self.starts, self.headers, strict=True)
        for at, (module, start, own) in enumerate(each):
            # Spans count from the start of all files together.
            self.data.start = start
            procedures, declarations = self.module(module, own)
            hidden = self._hidden(at)
            self.procedures += [
                with_names_replaced(with_spans_from(q, start), hidden) for q in procedures
            ]
            self.declarations += [
                replace(d, span=d.span and d.span.moved(start)) for d in declarations
            ]
        entry = header.entry or ("main" if "main" in self.own else "")
        found = (q.name for q in self.procedures if q.name.lower() == entry.lower())
        targets = self.paths.targets()  # first: those without orientation become variables
        program = Program(
            header.program or self.original(self.modules[self.main].name),
            procedures=tuple(self.procedures),
            entry=next(found, None),
            robot=header.robot,
            comments=tuple(self.comments),
            frames=self.data.frames,
            tools=self.data.tools,
            speeds=self.data.named(SPEEDS, self.data.speeds),
            blends=self.data.named(BLENDS, self.data.blends),
            targets=targets,
            joint_targets=self.data.joint_targets,
            variables=self.data.variables,
            declarations=tuple(self.declarations),
        )
        # Only then are modules units; otherwise all modules are one.
        if any(header.resident for header in self.headers):
            program = _with_unit_calls(program)
        triggers = TriggerReader(self.meaning, self.own.__contains__)
        program, set_on_way = with_triggers(
            program, triggers.told, FUNCTIONS.__contains__, TRIGGER_REASONS
        )
        declared = {
            name: signal
            for header in self.headers
            for name, signal in header.signals.items()
            if signal.number is not None or hand_of(name) is None
        }
        stated = signals_in(program.statements(), lambda name: name in self.declared)
        used = chain(
            set_on_way,
            self.meaning.used,
            signal_uses(program.statements()),
            stated,
            self.chosen.items(),
        )
        program = with_hiding_loops_renamed(
            replace(program, signals=with_used_signals(declared, used))
        )
        program = with_constants(program, PREDEFINED_VALUES)
        program = with_values(with_places(program, self.original))
        return with_paths(program, self.original)

    @cached_property
    def declared(self) -> frozenset[str]:
        """Lower-case names of data, which may stand for any signal."""
        items = [i for m in self.modules for i in m.items]
        data = (i.name for i in items if isinstance(i, s.Data))
        inner = inner_names(i for i in items if isinstance(i, s.Routine))
        return frozenset(name.lower() for name in chain(data, inner))

    def _hidden(self, at: int) -> dict[str, str]:
        """New names for routines of a module that have the name of one in another: for local ones,
        and for those of which an earlier module has one, as two programs in one folder have.
        """
        module, routines = self.modules[at], [_routines_by_name(one) for one in self.modules]
        own, before, behind = routines[at], routines[:at], routines[at + 1 :]
        elsewhere = set(chain(*before, *behind))
        earlier = {name for found in before for name, r in found.items() if not r.local}
        hidden = [r for key, r in own.items() if key in (elsewhere if r.local else earlier)]
        taken = TakenNames((*elsewhere, *own, *(name.lower() for name in self.data.variables)))
        return {r.name.lower(): identifier(f"{module.name}_{r.name}", taken) for r in hidden}

    def module(self, module: s.Module, header: Header) -> tuple[list[Procedure], list[Declaration]]:
        """The routines of a module, and what of its other items is no data."""
        procedures: list[Procedure] = []
        declarations: list[Declaration] = []
        unit = self.original(module.name) if header.unit else None
        pending: list[str] = []
        above: s.Item | None = None
        # The heading is read already.
        for item in module.items[header.lines :]:
            before, above = above, item
            match item:
                case s.CommentLine(text):
                    # The line of the declaration goes, so the comment gets its name.
                    if item.trailing and isinstance(before, s.Data):
                        self.comments.append(f"{before.name}: {text}")
                    else:
                        pending.append(text)
                    continue
                case s.Routine():
                    lifted = self.routine(item, unit, pending)
                    if isinstance(lifted, Procedure):
                        procedures.append(lifted)
                        pending = []
                    else:
                        declarations.append(lifted)
                case s.TargetRunNode():
                    pass
                case s.Data() if self.data.holds(item) or item.name.lower() in self.clocks:
                    pass
                case _:
                    declarations.append(_declaration(item))
            self.comments += _declaration_comments(item, pending)
            pending = []
        self.comments += pending
        return procedures, declarations

    def routine(
        self, node: s.Routine, unit: str | None, notes: Sequence[str]
    ) -> Procedure | Declaration:
        """Lift a routine to a procedure, or to a vendor declaration if the pseudo-program cannot
        express it.

        notes: the comments above it.
        """
        if self.stays(node):
            return _declaration(node)
        parameters = self.parameters(node)
        assert parameters is not None
        result = VALUE_OF_TYPE.get(node.type.lower()) if node.kind == "FUNC" else None
        variables: dict[str, Variable] = {}
        foreign: list[p.Opaque] = []
        for inner in node.body:
            if isinstance(inner, s.Data):
                variable = self.data.variable(inner)
                if variable is None:
                    foreign.append(opaque(inner))
                else:
                    variables[self.original(inner.name)] = replace(variable, local=False)
        statements = [inner for inner in node.body if not isinstance(inner, s.Data)]
        body = (
            *(p.Comment(n) for n in notes),
            *foreign,
            *self.statements.block(statements),
            *map(handler, node.handlers),
        )
        name = self.original(node.name)
        return Procedure(
            name, body, parameters, variables, result, unit, node.local, span=node.span
        )

    def stays(self, node: s.Routine) -> bool:
        """True if a routine remains a vendor declaration."""
        return (
            self.parameters(node) is None
            or node.kind == "TRAP"
            or (node.kind == "FUNC" and VALUE_OF_TYPE.get(node.type.lower()) is None)
            or any(isinstance(inner, s.TargetRunNode) for inner in node.body)
        )

    def parameters(self, node: s.Routine) -> tuple[Parameter, ...] | None:
        """Those of a routine, None if the pseudo-program has none of the kind of one."""
        found: list[Parameter] = []
        for group in node.parameters:
            for q in group.alternatives:
                if isinstance(q, s.Placeholder) or group.optional or q.dimensions < 0:
                    return None
                type = VALUE_OF_TYPE.get(q.type.lower())
                if type is None:
                    return None
                mode: Any = "inout" if q.mode else "in"
                found.append(Parameter(self.original(q.name), type, mode, q.dimensions))
        return tuple(found)


def _outer_comments(file: s.File) -> list[tuple[str, ...]]:
    """The comments above each module of a file, and below the last one."""
    found: list[list[str]] = []
    above: list[str] = []
    for part in file.parts:
        if isinstance(part, s.CommentLine):
            above.append(part.text)
        else:
            found.append(above)
            above = []
    if found:
        found[-1] += above
    return list(map(tuple, found))


def _routines_by_name(module: s.Module) -> dict[str, s.Routine]:
    """Those of a module by lower-case name."""
    return {item.name.lower(): item for item in module.items if isinstance(item, s.Routine)}


def _declaration_comments(item: s.Item | s.Module, notes: Sequence[str]) -> list[str]:
    """The comments above a declaration with its name, as they will stand far from it; of a module
    those that it begins with.
    """
    told = list(notes)
    # A line of dashes or stars alone is no text to put a name before.
    at = next((i for i, note in enumerate(told) if any(map(str.isalnum, note))), None)
    if at is not None and isinstance(item, s.Data | s.Routine | s.Module):
        if not re.search(rf"\b{item.name}\b", " ".join(told), re.IGNORECASE):
            told[at] = f"{item.name}: {told[at].strip()}"
    return told


def _declaration(item: s.Item) -> Declaration:
    text = verbatim.of_node(item, "items")
    effect = verbatim.effect_of_nodes((item,), text)
    return Declaration(verbatim.LANGUAGE, text, span=item.span, effect=effect)
