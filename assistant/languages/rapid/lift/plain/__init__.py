"""A program whose data are records as one with plain data, before it is lifted.

`VAR part p` with the components `num height` and `pos place` becomes `VAR num p_height`, and so on;
arrays of records become arrays of their parts, and routines take and give back the parts. What
nothing reads is left out. RAPID itself keeps its records: other languages are told this.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile

from assistant.base.diagnostics import Diagnostic, Span
from assistant.languages.rapid.lift.local_names import with_unique_data_names
from assistant.languages.rapid.lift.plain.arm_calls import with_arm_kinematics
from assistant.languages.rapid.lift.plain.arrays import with_shared_arrays
from assistant.languages.rapid.lift.plain.bodies import RoutineBody
from assistant.languages.rapid.lift.plain.by_name import with_named_data
from assistant.languages.rapid.lift.plain.chosen_signals import with_chosen_signals
from assistant.languages.rapid.lift.plain.clocks import with_plain_clocks
from assistant.languages.rapid.lift.plain.copies import with_copies
from assistant.languages.rapid.lift.plain.counted_arrays import with_counts
from assistant.languages.rapid.lift.plain.declaring import flat_declarations
from assistant.languages.rapid.lift.plain.displaced import with_displacements
from assistant.languages.rapid.lift.plain.late_names import with_bound_calls
from assistant.languages.rapid.lift.plain.layouts import SPEED_AND_ZONE, RecordLayouts
from assistant.languages.rapid.lift.plain.library import with_library, without_uncalled
from assistant.languages.rapid.lift.plain.long_numbers import with_long_numbers
from assistant.languages.rapid.lift.plain.mounted import with_frame_updates
from assistant.languages.rapid.lift.plain.optional import with_required
from assistant.languages.rapid.lift.plain.own_routines import with_unique_routine_names
from assistant.languages.rapid.lift.plain.own_settings import with_module_settings
from assistant.languages.rapid.lift.plain.own_task import with_own_task
from assistant.languages.rapid.lift.plain.paces import changes_speeds_or_zones
from assistant.languages.rapid.lift.plain.passed_errors import with_passed_errors
from assistant.languages.rapid.lift.plain.process_data import with_process_data
from assistant.languages.rapid.lift.plain.raw_bytes import with_raw_bytes
from assistant.languages.rapid.lift.plain.removed_files import with_emptied_files
from assistant.languages.rapid.lift.plain.scopes import FreshNames, ProgramData
from assistant.languages.rapid.lift.plain.settled import with_constant_speeds
from assistant.languages.rapid.lift.plain.spreads import NotExpressible, RecordValue
from assistant.languages.rapid.lift.plain.standing_units import with_fixed_units
from assistant.languages.rapid.lift.plain.states import with_cell_states
from assistant.languages.rapid.lift.plain.still_axes import with_still_axes
from assistant.languages.rapid.lift.plain.traps import with_traps
from assistant.languages.rapid.lift.plain.unread import UnreadVariable, without_unread_data
from assistant.languages.rapid.lift.plain.unused_parameters import without_unused_parameters
from assistant.languages.rapid.lift.plain.values import Values
from assistant.languages.rapid.lift.plain.whole_texts import with_line_reads
from assistant.languages.rapid.lift.plain.written_out import with_constant_values
from assistant.languages.rapid.tree import syntax as s
from assistant.program.program import Signal

OmittedAxes = tuple[tuple[Span | None, str], ...]
"""Places, each with the component of an external axis that is left out there."""


@dataclass(frozen=True, slots=True)
class FlatProgram:
    """files: with plain data. kept: statements in them that stay as they are written, by `id`,
    with why. unread: what is left out, of each file. outside: where external axes are left out that
    there are none of, and which. remarks: other findings of each, at places in it.
    signals: that are not named where they are used. gone: names of signals that nothing has any
    more.
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
    made = _flattened(files, frozenset())
    return (
        _flattened(files, SPEED_AND_ZONE)
        if made is not None and changes_speeds_or_zones(made.files)
        else made
    )


def _flattened(files: Sequence[s.File], apart: frozenset[str]) -> FlatProgram | None:
    """apart: see `Layouts`."""
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
    read, of_names = with_named_data(with_cell_states(with_traps(chosen.modules)))
    whole = with_library(with_raw_bytes(read))
    layouts = RecordLayouts(whole, apart)
    uncalled: list[tuple[int, Diagnostic]] = []
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
        if len(made) > 1 and isinstance(item, s.Routine):  # data of its result, and itself
            above = _start_of_notes(items)
            items[above:above] = made[:-1]
            made = made[-1:]
        items += made
    same = len(items) == len(module.items)
    same = same and all(a is b for a, b in zip(items, module.items, strict=True))
    return module if same else replace(module, items=tuple(items))


def _start_of_notes(items: Sequence[s.Item]) -> int:
    """Where the comments begin that stand above what comes next; at the top of a module behind
    them, as a heading may stand there.
    """
    notes = takewhile(lambda one: isinstance(one, s.CommentLine) and not one.trailing, items[::-1])
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
                parts = program.layouts.parts(item.type) or ()
                data = (s.Data("", "VAR", one.type, result[one.path]) for one in parts)
                return (*data, replace(whole, kind="PROC", type=""))
            if item.kind == "FUNC":
                whole = replace(whole, type=program.plain_type(item.type))
            return (item,) if whole == item else (whole,)
    return (item,)


def _no_record_result(call: s.FunctionCall) -> RecordValue:
    raise NotExpressible(f"`{call.name}` gives back a record")
