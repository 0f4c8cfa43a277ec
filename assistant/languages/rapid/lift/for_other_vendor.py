"""A program of RAPID for the language of another vendor.

The flattened program comes first, if the program is still as it was lifted except for its cell and
for statements put before the procedures' own. Then vendor statements are replaced by neutral ones;
instructions that state what holds anyway, or change no motion, are left out, with a finding where
an effect is lost. Waits for standstill become stop points, rows of tables of tools and work objects
tools and frames, `Dim` of a declared array a number, and predefined variables variables of the
program. RAPID itself keeps all of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import replace
from functools import cache
from itertools import chain
from typing import TYPE_CHECKING, Any, Final, TypeGuard

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Findings, Span
from assistant.base.source_text import starts_of
from assistant.languages.language_types import Adapted
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.channels import with_channels
from assistant.languages.rapid.lift.clocks import with_stopwatches
from assistant.languages.rapid.lift.expressions import with_neutral_dates, with_neutral_radian
from assistant.languages.rapid.lift.flatten.library import QUATERNION_PART, TEST_AND_SET
from assistant.languages.rapid.lift.flatten.program import FlatProgram, flatten
from assistant.languages.rapid.lift.flatten.unread_data import OMISSION_MARK
from assistant.languages.rapid.lift.operator_dialogs import with_operator_dialogs
from assistant.languages.rapid.lift.program import as_one_unit, lift
from assistant.languages.rapid.lift.statements import (
    TRIGGER_REASONS,
    NameResolver,
    TriggerReader,
    lift_of,
    opaque,
)
from assistant.languages.rapid.lift.vendor_effects import (
    option_names,
    vendor_steps,
    with_active_tool_frame,
)
from assistant.languages.rapid.lift.vendor_only.errors import with_errors
from assistant.languages.rapid.lift.vendor_only.instructions import (
    TEST_AND_SET_LOSS,
    VendorLowering,
    lowered_instruction,
)
from assistant.languages.rapid.lift.vendor_only.interrupts import (
    BROKEN_OFF,
    with_interrupt_wait_timers,
    with_interrupts,
    with_moves_ended_by_interrupts,
)
from assistant.languages.rapid.lift.vendor_only.omissions import (
    NO_EXTERNAL_AXES,
    OMITTED_INSTRUCTIONS,
    Loss,
    has_external_axes,
    with_needed_declarations,
)
from assistant.languages.rapid.lift.vendor_only.process_moves import (
    bead_numbers,
    spot_programs,
    weld_speeds,
)
from assistant.languages.rapid.lift.vendor_only.signal_statements import (
    delays_into_moves,
    switched_outputs,
    with_aliases,
)
from assistant.languages.rapid.lift.vendor_only.speeds import (
    with_limited_speeds,
    with_speed_limit,
    with_timed_moves,
)
from assistant.languages.rapid.lift.vendor_only.stopped_moves import with_held_moves
from assistant.languages.rapid.lift.vendor_only.waits import SYNC_DUE, sync_counter, task_lists
from assistant.languages.rapid.lift.vendor_statements import (
    instruction_of,
    is_vendor_text,
    lifted_call,
)
from assistant.languages.rapid.tables.constants import PORTABLE_CONSTANTS, VALUE_OF_TYPE
from assistant.languages.rapid.tables.constants import STATE_BY_NAME as STATE_OF
from assistant.languages.rapid.tables.predefined import FUNCTIONS, error_numbers
from assistant.languages.rapid.tables.predefined import data as predefined
from assistant.languages.rapid.tables.signals import PROCESS_DATA_TYPES, SIGNAL_TYPES, hand_signal
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number, literal_values
from assistant.languages.records import frame_of, tool_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import hands_used, used_signal_names, with_used_signals
from assistant.program.analysis.uses import locals_of, names_in
from assistant.program.geometry import Frame, Tool
from assistant.program.passes.implicit_motion_state import stopped, with_open_lines, with_stops
from assistant.program.passes.positions import RowName, RowTable, with_read_angles, with_table_rows
from assistant.program.passes.trigger_data import with_triggers
from assistant.program.passes.variables import with_constants, with_predefined
from assistant.program.program import Declaration, Procedure, Program, Signal, Variable
from assistant.program.rewriting import (
    Body,
    map_bodies,
    records,
    rewrite,
    with_vendor_statements_replaced,
)
from assistant.program.statement_index import records_in_procedures, statements_with
from assistant.program.vendor_statements import effect_of

if TYPE_CHECKING:
    from assistant.robots import Robot


_CELL_TABLES: Final = (
    "frames", "tools", "speeds", "blends", "signals", "targets", "joint_targets", "variables",
)  # fmt: skip
"""Tables that a cell may have changed since the program was lifted."""


@dataclass(frozen=True, slots=True)
class _Flattened:
    """files: as they were read; they are kept, so that nothing else has their ids. gone: see
    `FlatProgram`.
    """

    files: tuple[s.File, ...]
    lifted: Program | None
    findings: tuple[Diagnostic, ...]
    gone: frozenset[str] = frozenset()


_NOT_FLATTENED: Final = _Flattened((), None, ())
_LAST_FLATTENED: Final[list[_Flattened]] = []
"""The last exported program: one translation requests it several times."""


def _flattened(files: tuple[s.File, ...]) -> _Flattened:
    """The program of some files with plain data, none if they have no other."""
    if _LAST_FLATTENED and len(_LAST_FLATTENED[0].files) == len(files):
        # The same files in the same order: `kept` and spans are bound to these very trees.
        if all(a is b for a, b in zip(_LAST_FLATTENED[0].files, files, strict=True)):
            return _LAST_FLATTENED[0]
    found = flatten(files)
    if found is None:
        told = _Flattened(files, None, ())
    else:
        lifted = _with_signals(lift(found.files, found.kept), found.signals)
        told = _Flattened(
            files,
            lifted,
            (*_unread_findings(files, found), *_idle_assignment_findings(lifted)),
            found.gone,
        )
    _LAST_FLATTENED[:] = [told]
    return told


def _with_signals(program: Program, signals: Mapping[str, Signal]) -> Program:
    there = {name.lower() for name in program.signals}
    new = {name: one for name, one in signals.items() if name.lower() not in there}
    return replace(program, signals={**program.signals, **new}) if new else program


def _idle_assignment_findings(program: Program) -> Iterator[Diagnostic]:
    """Report assignments that only set unread data, or that give a speed or zone its present
    value.
    """
    said = list(program.statements())
    # A statement that is left in part is not reported as left out.
    left = {node.span for node in said if not _is_omission_mark(node)}
    gone = {node.span: node.text for node in said if _is_omission_mark(node)}
    for span, text in gone.items():
        if span is not None and span not in left:
            name = text.removeprefix(OMISSION_MARK)
            yield rules.SETTLED(name=name, span=span) if name else rules.IDLE(span=span)


def _is_omission_mark(node: p.Statement) -> TypeGuard[p.Comment]:
    return isinstance(node, p.Comment) and node.text.startswith(OMISSION_MARK)


def _without_omission_marks(program: Program) -> Program:
    """The program without the comments that stand for statements which were left out."""

    def body(statements: Body) -> Body:
        return tuple(map_bodies(node, body) for node in statements if not _is_omission_mark(node))

    if not any(map(_is_omission_mark, program.statements())):
        return program
    procedures = tuple(replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures)


def _unread_findings(files: tuple[s.File, ...], found: FlatProgram) -> Iterator[Diagnostic]:
    """Report the omitted data, one finding for each declaration."""
    starts = starts_of(file.source for file in files)
    rows = zip(starts, found.unread, found.outside, found.remarks, strict=True)
    for start, unread, outside, remarks in rows:
        for remark in dict.fromkeys(remarks):
            if remark.span is not None:
                yield replace(remark, span=remark.span.moved(start))
        for span, axis in dict.fromkeys(outside):
            if span is not None:
                yield rules.NO_AXIS(axis=axis, span=span.moved(start))
        spans: dict[Span, list[str]] = {}
        for one in unread:
            if one.span is not None:
                spans.setdefault(one.span.moved(start), []).append(f"`{one.name}`")
        for span, names in spans.items():
            yield rules.UNREAD(names=", ".join(names), span=span)


def with_flat_data(program: Program) -> Adapted:
    """The program with plain data, if it is still as it was lifted but for its cell and heads.

    Heads are statements in front of those of a procedure, and comments behind those of the program.
    """
    origin = program.origin
    if origin is None or origin.language != verbatim.LANGUAGE:
        return Adapted(program)
    heads = _heads(program, origin.lifted)
    told = _NOT_FLATTENED if heads is None else _flattened(origin.trees)
    if heads is None or told.lifted is None or not _has_all(told.lifted, heads):
        return Adapted(program)
    changed: dict[str, Any] = {}
    for table in _CELL_TABLES:
        # Only what the cell changed is taken over: flattening replaced the rest of these tables.
        before, now = getattr(origin.lifted, table), getattr(program, table)
        said = {name: one for name, one in now.items() if before.get(name) != one}
        changed[table] = {**getattr(told.lifted, table), **said}
    changed["signals"] = {n: x for n, x in changed["signals"].items() if n.lower() not in told.gone}
    whole = replace(
        told.lifted,
        **changed,
        procedures=_with_heads(told.lifted.procedures, heads),
        comments=(*told.lifted.comments, *program.comments[len(origin.lifted.comments) :]),
        name=program.name,
        entry=program.entry,
        robot=program.robot,
        origin=origin,
    )
    return Adapted(whole, told.findings)


def _heads(program: Program, lifted: Program) -> dict[str, Body] | None:
    """Return the statements that were put in front of the procedures, by lower-case name; None for
    other changes.
    """
    if program.procedures is lifted.procedures:
        return {}
    if len(program.procedures) != len(lifted.procedures):
        return None
    heads = dict[str, Body]()
    for now, was in zip(program.procedures, lifted.procedures, strict=True):
        if now is was:
            continue
        # Heads only go in front, so the old statements are the end of the body, as the same
        # objects.
        new = len(now.body) - len(was.body)
        alike = new >= 0 and all(a is b for a, b in zip(now.body[new:], was.body, strict=True))
        if not alike or replace(now, body=was.body) != was:
            return None
        heads[now.name.lower()] = now.body[:new]
    return heads


def _has_all(program: Program, heads: Mapping[str, Body]) -> bool:
    return all(program.procedure(name) is not None for name in heads)


def _with_heads(
    procedures: tuple[Procedure, ...], heads: Mapping[str, Body]
) -> tuple[Procedure, ...]:
    if not heads:
        return procedures
    return tuple(
        replace(one, body=(*heads.get(one.name.lower(), ()), *one.body)) for one in procedures
    )


_ArraySizes = Mapping[str, tuple[int, ...]]
"""Extents of arrays by lower-case name, none where they are not known."""


def _with_known_extents(program: Program) -> Program:
    """The program with numbers for `Dim(array,1)`; of an array parameter it stays a call."""
    if not any(part.function.lower() == "dim" for part in records_in_procedures(program, e.Apply)):
        return program
    shared = {name.lower(): v.size for name, v in program.variables.items()}
    procedures = []
    for procedure in program.procedures:
        # A parameter hides data of the module, and its extent is not known.
        own: dict[str, tuple[int, ...]] = {q.name.lower(): () for q in procedure.parameters}
        own |= {name.lower(): v.size for name, v in procedure.variables.items()}
        sizes: _ArraySizes = {**shared, **own}
        body = rewrite(procedure.body, lambda x: _extent_number(x, sizes))  # noqa: B023
        procedures.append(replace(procedure, body=body))
    return replace(program, procedures=tuple(procedures))


def _extent_number(x: Any, sizes: _ArraySizes) -> Any:
    match x:
        case e.Apply(function, (array, e.Number(int(place)))) if function.lower() == "dim":
            name = next(names_in(array), "").lower()  # of a record that is taken apart any part
            size = sizes.get(name, ())
            return e.Number(size[place - 1]) if 0 < place <= len(size) else x
    return x


_INERT_INSTRUCTIONS: Final = {
    "confj", "confj on", "confl", "confl on", "singarea", "singarea off", "gripload load0",
    "cornerpathwarning true", "cornerpathwarning false",
}  # fmt: skip
"""Instructions that set what holds anyway, or concern the controller's own log alone.

With their options and arguments, in lower case (RAPID reference manual: ConfJ, ConfL, SingArea,
GripLoad)."""

_FIRST_BOOKED_ERROR: Final = 101
"""The first number of an error of the program's own: it may raise 1 to 90 itself (RAISE)."""
_IN_CORNER: Final = e.Reason(
    "the robot may be in a corner there, and would stop in it", "write `fine` for the moves before"
)

_DISPLACEMENT_ENDS: Final = {
    "pdispoff": re.compile(r"\bPDisp(?:On|Set|Add)\b", re.IGNORECASE),
    "eoffsoff": re.compile(r"\bEOffs(?:On|Set)\b", re.IGNORECASE),
}
"""Instructions that end displacements of targets and of external axes, with the words that begin
them.
"""
_IDLE_TYPES: Final = PROCESS_DATA_TYPES | {"tasks", "syncident", "errnum", "intnum", *SIGNAL_TYPES}
"""Types of data, in lower case, that are left out where nothing takes them any more."""
_NEAR_STOP_POINTS: Final = frozenset(("inpos20", "inpos50", "inpos100"))
"""Predefined stop points: the robot stops at its target, with more or less patience."""


def for_other_vendor(program: Program, arm: Robot | None) -> Adapted:
    """The program for another language. arm: that will run it, None if it is not known."""
    findings = Findings()
    plain = with_flat_data(program)
    findings += plain.findings
    # Flat data comes first, so that the passes below meet no records.
    program = as_one_unit(_without_omission_marks(plain.program))
    program = with_stopwatches(_with_known_extents(program), findings)
    if tables := _frame_tables(program):
        program = with_table_rows(program, tables, _with_named_rows)
    program = _with_move_triggers(program)
    # Without vendor statements there is nothing to lower here.
    if any(map(is_vendor_text, records_in_procedures(program, p.Opaque, e.Verbatim))):
        program, limit = with_speed_limit(program)
        program = with_held_moves(with_aliases(program), findings)
        program = with_interrupts(program, findings)
        program = _with_neutral_statements(program, findings)
        handled = with_errors(program, lift_of(program), findings)
        # Handlers end up at the statements that they are for, and may hold instructions that RAPID
        # alone has.
        program = program if handled is program else _with_neutral_statements(handled, findings)
        program = with_timed_moves(with_interrupt_wait_timers(program), arm, findings)
        program = with_channels(with_operator_dialogs(program, findings), findings)
        program = with_vendor_statements_replaced(
            program, lambda node: (_without_near_stop(node, findings),)
        )
        if arm is not None:
            program = with_open_lines(program, vendor_steps)
        stop = _reporting_stop(findings)
        after = _reporting_omitted_wait(findings)
        program = with_stops(program, vendor_steps, _without_standstill, _IN_CORNER, stop, after)
        nothing = _INERT_INSTRUCTIONS | {
            word for word, moves in _DISPLACEMENT_ENDS.items() if not _has_words(program, moves)
        }
        losses = dict(OMITTED_INSTRUCTIONS)
        if "eoffsoff" not in nothing and not has_external_axes(program):
            losses |= dict.fromkeys(("eoffsset", "eoffson", "eoffsoff"), NO_EXTERNAL_AXES)
        program = with_moves_ended_by_interrupts(program)
        booked = _booked_errors(program)
        program = with_vendor_statements_replaced(
            program, lambda node: _without_omitted(node, nothing, losses, findings, booked)
        )
        program = with_limited_speeds(program, limit)  # once all that moves is a move
        program, early = with_active_tool_frame(program)
        findings += [rules.BEFORE_MOVES(span=span) for span in dict.fromkeys(early)]
    program = _without_idle_declarations(with_needed_declarations(program, findings))
    types = {
        key: (known.name, VALUE_OF_TYPE[known.type])
        for key, known in predefined().items()
        if known.storage == "VAR" and known.type in VALUE_OF_TYPE
    }
    findings += _error_number_findings(program)
    program = with_constants(with_neutral_dates(program), {**PORTABLE_CONSTANTS, **error_numbers()})
    program = with_neutral_radian(program)
    program = with_read_angles(with_predefined(program, types))
    findings += _quaternion_findings(program)
    findings += _cell_state_findings(program)
    findings += _test_and_set_findings(program)
    return Adapted(_with_hands_or_outputs(program), tuple(findings))


def _with_hands_or_outputs(program: Program) -> Program:
    """Drop the outputs that only open and close hands, for which other languages have words.

    An output that is also read, or set in another way, stays one in all statements: the word for
    its hand may set another output.
    """
    hands = {hand_signal(hand) for hand in hands_used(program)}
    if not hands:
        return program
    outputs = hands & used_signal_names(program)
    hands -= outputs

    def output(node: Any) -> Any:
        if isinstance(node, p.Gripper) and (name := hand_signal(node.hand)) in outputs:
            return p.SetSignal(name, e.Number(int(node.action == "open")), span=node.span)
        return node

    kept = {name: one for name, one in program.signals.items() if name.lower() not in hands}
    signals = with_used_signals(kept, ((n, Signal("digital", "output")) for n in sorted(outputs)))
    return replace(rewrite(program, output) if outputs else program, signals=signals)


def _quaternion_findings(program: Program) -> Iterator[Diagnostic]:
    """Quaternions that are read where there are angles alone."""
    for statement, parts in statements_with(program, e.Apply):
        if statement.span is not None and any(part.function == QUATERNION_PART for part in parts):
            yield rules.SIGNS(span=statement.span)


def _test_and_set_findings(program: Program) -> Iterator[Diagnostic]:
    """Warn where a truth is tested and set in more than one step."""
    for statement, parts in statements_with(program, e.Apply):
        if statement.span is not None and any(part.function == TEST_AND_SET for part in parts):
            loss, cure = TEST_AND_SET_LOSS
            yield rules.LEFT_OUT(
                what="the one step of TestAndSet", loss=loss, cure=cure, span=statement.span
            )


def _error_number_findings(program: Program) -> Iterator[Diagnostic]:
    """Warn where the number of an error is used."""
    numbers = error_numbers()
    for statement, parts in statements_with(program, e.Name):
        named = [part.name for part in parts if part.name.lower() in numbers]
        if statement.span is not None:
            for name in dict.fromkeys(named):
                loss, cure = _ERROR_NUMBER_LOSS
                yield rules.LEFT_OUT(
                    what=f"the number of {name.upper()}", loss=loss, cure=cure, span=statement.span
                )


_ERROR_NUMBER_LOSS: Final = (
    "no manual states it, and another controller has no such error: it is counted here",
    "compare it with the names of errors alone",
)


def _cell_state_findings(program: Program) -> Iterator[Diagnostic]:
    """Report reads of controller states whose values the cell supplies."""
    if not any(name.lower() in STATE_OF for name in program.variables):
        return
    for statement, parts in statements_with(program, e.Name):
        read = (part.name.lower() for part in parts)
        for name in dict.fromkeys(one for one in read if one in STATE_OF):
            if statement.span is not None:
                yield rules.STATED(name=name, span=statement.span)


def _instruction_key(call: s.ProcedureCall) -> str:
    """Name, options and plain arguments, as the tables have them."""
    words = [str(call.name), *option_names(call.arguments)]
    for argument in call.arguments:
        match argument:
            case s.Positional(s.NameRef(name), None):
                words.append(name)
            case s.Positional(s.BoolLiteral(value), None):
                words.append(str(value))
    return " ".join(words).lower()


def _with_move_triggers(program: Program) -> Program:
    """The program with what moves set on their way that plain data and named rows have cleared."""
    if not any("trigg" in node.text.lower() for node in records_in_procedures(program, p.Opaque)):
        return program
    speeds = {name.lower(): speed for name, speed in program.speeds.items()}
    blends = {name.lower(): blend for name, blend in program.blends.items()}
    # A local name hides the constant of the module.
    inner = {name for procedure in program.procedures for name in locals_of(procedure)}
    numbers = {
        name.lower(): one.initial
        for name, one in program.variables.items()
        if one.storage == "constant" and isinstance(one.initial, e.Number)
    }
    numbers = {name: value for name, value in numbers.items() if name not in inner}
    meaning = NameResolver(speeds=speeds, blends=blends, numbers=numbers)
    own = {procedure.name.lower() for procedure in program.procedures}
    own = own.union(*(effect_of(one).writes for one in program.declarations))
    understood = TriggerReader(meaning, own.__contains__)
    program, used = with_triggers(
        program, understood.told, FUNCTIONS.__contains__, TRIGGER_REASONS, chosen=True
    )
    return replace(program, signals=with_used_signals(program.signals, [*used, *meaning.used]))


def _with_neutral_statements(program: Program, findings: Findings) -> Program:
    """The program with other statements for the instructions that RAPID alone has."""
    speeds = {name.lower(): speed for name, speed in program.speeds.items()}
    blends = {name.lower(): blend for name, blend in program.blends.items()}
    meaning = NameResolver(speeds=speeds, blends=blends)
    displaced = _has_words(program, _DISPLACEMENT_ENDS["eoffsoff"])
    telling = VendorLowering(
        program, findings, meaning, switched_outputs(program), displaced,
        weld_speeds(program), task_lists(program),
        cache(lambda: delays_into_moves(program)),
        cache(lambda: spot_programs(program)), cache(lambda: bead_numbers(program)),
    )  # fmt: skip
    program = with_vendor_statements_replaced(
        program, lambda node: lowered_instruction(telling, node)
    )
    counted = dict(map(sync_counter, telling.points))
    if counted:
        counted[SYNC_DUE] = Variable("number")
    return replace(
        program,
        signals=with_used_signals(program.signals, meaning.used),
        # Declared variables win over counters of the same name.
        variables={**counted, **program.variables},
    )


def _without_idle_declarations(program: Program) -> Program:
    """Return the program without RAPID-only data that no remaining statement takes."""
    idle = {id(one) for one in program.declarations if _is_idle_declaration(one)}
    if not idle:
        return program
    named: set[str] = set()
    kinds = p.Opaque, e.Verbatim, e.Name, p.SetSignal, p.Trigger, p.WaitSignal
    for record in chain(records_in_procedures(program, *kinds), records(program.variables)):
        match record:
            case p.Opaque() | e.Verbatim():
                named |= effect_of(record).names
            case e.Name(name) | p.SetSignal(name) | p.Trigger(name) | p.WaitSignal(name):
                named.add(name.lower())
    # A routine that stays as its text keeps the data that it names.
    for one in program.declarations:
        if _is_routine_declaration(one):
            named |= effect_of(one).names
    left = (d for d in program.declarations if id(d) not in idle or effect_of(d).writes & named)
    return replace(program, declarations=tuple(left))


def _is_idle_declaration(declaration: Declaration) -> bool:
    """True for data that is used only by instructions with translations that do not need it."""
    match verbatim.understood(verbatim.items, declaration.text):
        case (s.Data(type=type),):
            return type.lower() in _IDLE_TYPES
    return False


def _is_routine_declaration(declaration: Declaration) -> bool:
    match verbatim.understood(verbatim.items, declaration.text):
        case (s.Routine(),):
            return True
    return False


def _has_words(program: Program, words: re.Pattern[str]) -> bool:
    """True if a vendor statement or declaration of the program has one of the words."""
    texts = [one.text for one in program.statements() if isinstance(one, p.Opaque)]
    texts += [one.text for one in program.declarations]
    return any(map(words.search, texts))


def _booked_errors(program: Program) -> Mapping[str, int]:
    """Numbers of the program's own errors that expressions ask for, by lower-case name."""
    used = {one.name.lower() for one in records(program.procedures) if isinstance(one, e.Name)}
    names = (
        _booked_error(instruction_of(node)) for node in records_in_procedures(program, p.Opaque)
    )
    # Only errors whose number is asked for need one.
    found = [name for name in dict.fromkeys(names) if name and name in used]
    return {name: at for at, name in enumerate(found, _FIRST_BOOKED_ERROR)}


def _booked_error(call: s.ProcedureCall | None) -> str:
    """The variable in lower case that `BookErrNo` gives a number; empty for another call."""
    if call is not None and str(call.name).lower() == "bookerrno":
        match call.arguments:
            case (s.Positional(s.NameRef(name), None),):
                return name.lower()
    return ""


def _without_omitted(
    node: p.Opaque,
    nothing: Set[str],
    losses: Mapping[str, Loss],
    findings: Findings,
    booked: Mapping[str, int],
) -> Iterator[p.Statement]:
    """Lower a vendor statement for another language: assign the number of a booked error, omit the
    statement, or leave it unchanged.
    """
    call = instruction_of(node)
    key = "" if call is None else _instruction_key(call)
    if (own := _booked_error(call)) in booked:
        yield p.Assign(e.Name(own), e.Number(booked[own]), span=node.span)
        return
    loss = losses.get(key) or losses.get(key.split(" ")[0])
    if key in nothing:
        return
    # An omitted ClearPath would let the arm finish the move that the interrupt broke off.
    if loss is None or node.reason == BROKEN_OFF:
        yield node
    else:
        with findings.at(node.span):
            findings.append(rules.LEFT_OUT(what=node.text.rstrip(";"), loss=loss[0], cure=loss[1]))


def _reporting_omitted_wait(findings: Findings) -> Callable[[p.Opaque], None]:
    """Report a wait that is left out, as a move before it may be one that stays as its text."""

    def after(wait: p.Opaque) -> None:
        findings.append(rules.WAITS_FOR_KEPT(span=wait.span))

    return after


def _reporting_stop(findings: Findings) -> Callable[[p.MoveStatement], None]:
    """Return a function that reports a move that always stops, as a wait needs the stop on one
    branch.
    """

    def tell(move: p.MoveStatement) -> None:
        findings.append(rules.ALWAYS_STOPS(span=move.span))

    return tell


def _without_standstill(node: p.Opaque) -> Iterator[p.Statement]:
    """Yield the remainder of a wait for standstill: the waiting time."""
    call = instruction_of(node)
    if call is not None:
        plain = tuple(one for one in call.arguments if not isinstance(one, s.Option))
        yield from lifted_call(replace(call, arguments=plain), node, NameResolver())


def _without_near_stop(node: p.Opaque, findings: Findings) -> p.Statement:
    r"""A move that states `\Inpos` as one that stops; any other text as it is."""
    call = instruction_of(node)
    if call is None or not any(map(_is_stop_point, call.arguments)):
        return node
    rest = tuple(one for one in call.arguments if not _is_stop_point(one))
    for move in lifted_call(replace(call, arguments=rest), node, NameResolver()):
        if isinstance(move, p.MoveStatement):
            with findings.at(node.span):
                findings.append(rules.LEFT_OUT(
                    what=r"\Inpos", loss="how near to its target the robot counts as being there",
                    cure="none is needed where it stops",
                ))  # fmt: skip
            return stopped(move)
    return node


def _is_stop_point(argument: s.Argument) -> bool:
    match argument:
        case s.Option(option, s.NameRef(name)):
            return option.lower() == "inpos" and name.lower() in _NEAR_STOP_POINTS
    return False


# ------------------------------------------------------------------------------------ tables


def _with_named_rows(node: p.Opaque, named: RowName) -> p.Statement:
    """A move whose tools and work objects are rows of tables; any other text as it is."""

    def change(part: Any) -> Any:
        match part:
            case s.Element(s.NameRef(table), (index,)) if not isinstance(index, s.Whole):
                place = literal_number(index)
                name = named(table, place) if isinstance(place, int) else None
                return part if name is None else s.NameRef(name)
        return part

    call = instruction_of(node)
    changed = None if call is None else rewrite(call, change, ())
    if changed is None or changed is call:
        return node
    return next(
        lifted_call(changed, node, NameResolver()), replace(opaque(changed), span=node.span)
    )


_ROW_READERS: Final[Mapping[str, Callable[[Any], Tool | Frame | None]]] = {
    "tooldata": tool_of,
    "wobjdata": frame_of,
}


def _frame_tables(program: Program) -> Mapping[str, RowTable]:
    """Declared tables of tools and work objects, by lower-case name."""
    found = {}
    for declaration in program.declarations:
        match verbatim.understood(verbatim.items, declaration.text):
            case (
                s.Data(type=type, name=str(name), dimensions=(_,), value=s.AggregateNode(values)),
            ) if type.lower() in _ROW_READERS:
                rows = [_ROW_READERS[type.lower()](literal_values(value)) for value in values]
                # All rows or none: an index counts the rows of the whole table.
                known = [row for row in rows if row is not None]
                if known and len(known) == len(rows):
                    found[name.lower()] = declaration, known
    return found
