"""A program with records as one with plain data, before it is lifted.

`VAR part p` with the components `num height` and `pos place` becomes `VAR num p_height` and so on;
arrays of records become arrays of their parts, and routines take and return the parts. What nothing
reads is left out. Trap routines become procedures, which the interrupts of other languages call.
RAPID itself keeps its records: only other languages get the flat program.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from itertools import takewhile
from typing import TypeGuard

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span
from assistant.languages.rapid.lift.flatten.arrays import with_counts, with_shared_arrays
from assistant.languages.rapid.lift.flatten.cell_facts import (
    with_cell_states,
    with_own_task,
    with_still_axes,
)
from assistant.languages.rapid.lift.flatten.channel_data import (
    with_emptied_files,
    with_line_reads,
    with_raw_bytes,
)
from assistant.languages.rapid.lift.flatten.chosen_signals import with_chosen_signals
from assistant.languages.rapid.lift.flatten.clocks import with_plain_clocks
from assistant.languages.rapid.lift.flatten.constants import (
    with_constant_speeds,
    with_constant_values,
    with_module_settings,
    with_process_data,
)
from assistant.languages.rapid.lift.flatten.data_names import FreshNames, ProgramData
from assistant.languages.rapid.lift.flatten.displacements import (
    with_arm_kinematics,
    with_displacements,
    with_fixed_units,
)
from assistant.languages.rapid.lift.flatten.late_binding import with_bound_calls, with_named_data
from assistant.languages.rapid.lift.flatten.library import (
    with_library,
    with_long_numbers,
    without_uncalled,
)
from assistant.languages.rapid.lift.flatten.parameters import (
    with_passed_errors,
    with_required,
    without_unused_parameters,
)
from assistant.languages.rapid.lift.flatten.record_layout import (
    SPEED_AND_ZONE,
    NotExpressible,
    RecordLayouts,
    RecordValue,
    with_frame_updates,
)
from assistant.languages.rapid.lift.flatten.record_statements import (
    RoutineBody,
    changes_speeds_or_zones,
    flat_declarations,
)
from assistant.languages.rapid.lift.flatten.record_values import Values
from assistant.languages.rapid.lift.flatten.routine_copies import with_copies
from assistant.languages.rapid.lift.flatten.unread_data import UnreadVariable, without_unread_data
from assistant.languages.rapid.lift.name_clashes import (
    with_unique_data_names,
    with_unique_routine_names,
)
from assistant.languages.rapid.tree import syntax as s
from assistant.program.program import Signal


def _with_traps(modules: Sequence[s.Module]) -> list[s.Module]:
    """The modules with a procedure for each trap routine."""
    return list(map(_with_trap_procedures, modules))


def _with_trap_procedures(module: s.Module) -> s.Module:
    if not any(_is_trap(item) for item in module.items):
        return module
    items = (replace(item, kind="PROC") if _is_trap(item) else item for item in module.items)
    return replace(module, items=tuple(items))


def _is_trap(item: s.Item) -> TypeGuard[s.Routine]:
    return isinstance(item, s.Routine) and item.kind == "TRAP"


OmittedAxes = tuple[tuple[Span | None, str], ...]
"""Places, each with the component of an external axis that is left out there."""


@dataclass(frozen=True, slots=True)
class FlatProgram:
    """A program with plain data. files: its files. kept: statements in them that stay as written,
    by `id`, with the reason. unread: the omitted variables of each file. outside: positions where
    components of missing external axes are omitted, and which components. remarks: other findings
    of each file, at positions in it. signals: signals that statements use without their names.
    gone: names of signals that nothing uses any more.
    """

    files: tuple[s.File, ...]
    kept: Mapping[int, str] = field(default_factory=dict)
    unread: tuple[tuple[UnreadVariable, ...], ...] = ()
    outside: tuple[OmittedAxes, ...] = ()
    remarks: tuple[tuple[Diagnostic, ...], ...] = ()
    signals: Mapping[str, Signal] = field(default_factory=dict)
    gone: frozenset[str] = frozenset()


def flatten(files: Sequence[s.File]) -> FlatProgram | None:
    """The files of a program with plain data, None if they have no other.

    Speeds and zones in records stay whole first: most are constants then.
    """
    # Only the flat program shows if speeds or zones change, so it is made first.
    made = _flattened(files, frozenset())
    return (
        _flattened(files, SPEED_AND_ZONE)
        if made is not None and changes_speeds_or_zones(made.files)
        else made
    )


def _flattened(files: Sequence[s.File], apart: frozenset[str]) -> FlatProgram | None:
    """apart: see `RecordLayouts`."""
    # Every later pass looks data up by its name alone.
    there = with_unique_data_names([module for file in files for module in file.modules])
    sized, of_sizes = with_counts(with_passed_errors(there))
    written, of_task = with_own_task(with_module_settings(with_constant_values(sized)))
    counted, of_clocks = with_plain_clocks(with_line_reads(written), files)
    emptied, of_files = with_emptied_files(counted, files)
    short, of_numbers = with_long_numbers(emptied, files)
    named, of_calls = with_bound_calls(*with_unique_routine_names(short))
    still, of_axes = with_still_axes(without_unused_parameters(with_process_data(named)))
    standing, of_units = with_fixed_units(still)
    chosen = with_chosen_signals(standing)
    read, of_names = with_named_data(with_cell_states(_with_traps(chosen.modules)))
    # The library is added after the passes that call it, and cut down to what is called at the end.
    whole = with_library(with_raw_bytes(read))
    layouts = RecordLayouts(whole, apart)
    uncalled: list[tuple[int, Diagnostic]] = []
    # Copies come before `with_required`: they decide which optional tools and frames are there.
    copied = with_copies(with_shared_arrays(whole, layouts), layouts, uncalled)
    copied = with_constant_speeds(copied, layouts, ())
    name = FreshNames(copied)
    required = with_required(copied, layouts, name)
    still, displaced = with_displacements(required, name)
    modules = with_arm_kinematics(still, displaced)
    program = ProgramData(modules, layouts, name, displaced)
    kept: dict[int, str] = {}
    made: list[s.Module] = []
    outside: list[OmittedAxes] = []
    remarks: list[tuple[Diagnostic, ...]] = []
    early = (
        of_sizes,
        of_task,
        of_clocks,
        of_files,
        of_numbers,
        of_calls,
        chosen.remarks,
        of_axes,
        of_units,
        of_names,
    )
    # The lists of `program` collect findings while a module is made, and are emptied for the next
    # one.
    for at, module in enumerate(modules):
        made.append(_flat_module(program, module, kept))
        outside.append(tuple(program.outside))
        program.outside.clear()
        remarks.append((*program.remarks, *(one for told in early for one in told[at])))
        program.remarks.clear()
    for at, finding in uncalled:
        remarks[at] += (finding,)
    made = with_frame_updates(made, program.moving.values())
    if whole is not read:
        made = without_uncalled(made, read)
    made = with_constant_speeds(made, layouts, kept)
    # Passes return the same object where they change nothing.
    if all(one is before for one, before in zip(made, there, strict=True)):
        return None
    left, unread = without_unread_data(made, program)
    listed, found, axes, others_of = iter(left), iter(unread), iter(outside), iter(remarks)
    filed, told, without, remarked = [], [], [], []
    for file in files:
        own = [next(listed) for _ in file.modules]
        told.append(tuple(one for _ in file.modules for one in next(found)))
        without.append(tuple(one for _ in file.modules for one in next(axes)))
        remarked.append(tuple(one for _ in file.modules for one in next(others_of)))
        others = iter(own)
        parts = (next(others) if isinstance(one, s.Module) else one for one in file.parts)
        filed.append(replace(file, parts=tuple(parts)))
    return FlatProgram(
        tuple(filed),
        kept,
        tuple(told),
        tuple(without),
        tuple(remarked),
        chosen.signals,
        chosen.gone,
    )


def _flat_module(program: ProgramData, module: s.Module, kept: dict[int, str]) -> s.Module:
    items: list[s.Item] = []
    for item in module.items:
        made = _flat_item(program, item, kept)
        # The data of the result must not come between a routine and the comments above it.
        if len(made) > 1 and isinstance(item, s.Routine):  # data of its result, and itself
            above = _start_of_notes(items)
            items[above:above] = made[:-1]
            made = made[-1:]
        items += made
    same = len(items) == len(module.items)
    same = same and all(a is b for a, b in zip(items, module.items, strict=True))
    return module if same else replace(module, items=tuple(items))


def _start_of_notes(items: Sequence[s.Item]) -> int:
    """Return the index of the comments directly above the next item; at the top of a module the
    index after them, as they may be a heading.
    """
    notes = takewhile(lambda one: isinstance(one, s.CommentLine) and not one.trailing, items[::-1])
    # 0 means that comments are all there is above: they are a heading.
    return len(items) - sum(1 for _ in notes) or len(items)


def _flat_item(program: ProgramData, item: s.Item, kept: dict[int, str]) -> Sequence[s.Item]:
    match item:
        case s.Record() | s.Alias():
            return ()
        case s.Data():
            datum = program.data.get(item.name.lower())
            if datum is None:
                return (item,)
            try:
                made = tuple(flat_declarations(item, datum, Values(program, {}, _no_record_result)))
            except NotExpressible:
                return (item,)
            return (item,) if made == (item,) else made
        case s.Routine():
            whole = RoutineBody(program, item, kept).whole()
            result = program.result(item)
            if result:
                # A function cannot return several values: its caller reads them from data of the
                # module.
                parts = program.layouts.parts(item.type) or ()
                data = (s.Data("", "VAR", one.type, result[one.path]) for one in parts)
                return (*data, replace(whole, kind="PROC", type=""))
            if item.kind == "FUNC":
                whole = replace(whole, type=program.plain_type(item.type))
            return (item,) if whole == item else (whole,)
    return (item,)


def _no_record_result(call: s.FunctionCall) -> RecordValue:
    raise NotExpressible(f"`{call.name}` gives back a record")
