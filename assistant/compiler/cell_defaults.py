"""Declarations for names that a program uses and does not declare: from a cell file, or stand-ins.

Each missing name becomes a declaration in a separate file, next to those read: with the cell file's
value, or with a stand-in. So everything that reads the program, the motion proof included, finds it
at the same place as a declaration of the program.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors, info, warning
from assistant.base.source_text import SourceText
from assistant.base.toml_edits import toml_key
from assistant.compiler.cell_equipment import (
    STATED_TEXT_NAME,
    check_signals,
    controller_configuration,
    hand_outputs,
    names_in_words,
    with_cell_equipment,
    with_directions,
    with_lines,
    with_names_of_numbers_kept,
    with_signals,
    without_other_numbers,
    without_restated,
)
from assistant.compiler.loader import Loaded, language_of
from assistant.compiler.retarget import has_joint_angles, has_percent_joints
from assistant.compiler.source_map import Places
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import with_used_signals
from assistant.program.analysis.uses import called, texts_in
from assistant.program.motion import Kind, Speed
from assistant.program.program import Program, Signal
from assistant.program.rewriting import head, records
from assistant.program.statement_index import records_in_procedures
from assistant.program.undeclared_names import (
    JOINT_SPEED,
    LINE_NAME,
    NEUTRAL_LINE,
    ROUTINES,
    SAME_ARM,
    SLOW_SPEED,
    TAUGHT_ON,
    Supplied,
    SuppliedValue,
    Wanted,
    WantedKind,
    neutral_value,
)
from assistant.program.vendor_statements import effect_of
from assistant.sources.cell_values import (
    NO_CELL,
    TABLE_OF_KIND,
    Cell,
    data_text,
    kind_in_words,
    parse_cell,
    read_cell,
    wanted_in_words,
    with_entries,
)

if TYPE_CHECKING:
    from assistant.languages import Language, Tree
    from assistant.languages.language_types import ControllerConfiguration


UNFILLED: Final = warning(
    "CO071",
    "the cell file does not say what {what} is: something that only stands for it is written",
    "write its value in the cell file, then translate again",
)
_NO_FILE_OF: Final = error(
    "CO072",
    "`{name}` stands for itself in the cell file, and the file `{file}` cannot be used: {reason}",
    'name a file beside the cell file, or write "stop" or "empty"',
)
_OTHER_TYPE: Final = error(
    "CO073",
    "what the cell file says of `{name}` is no value of the type {type}",
    "write {wanted}, or another `type`",
)
_TWO_KINDS: Final = error(
    "CO078",
    "the cell file states `{name}` as data and as a signal",
    "keep the table of what it is, and delete the other one",
)
_ENTRY_UNUSED: Final = warning(
    "CO079",
    "`{entry}` of the cell file is not used: {reason}",
    "{cure}",
)
_DELETE_DECLARATION: Final = (
    "delete the entry, and write its value in the declaration if that is the one that is wrong"
)
_DEDICATED: Final = warning(
    "CO081",
    "`{name}` has the number {number}, and a controller as it leaves the factory {use} by this "
    "{direction}, as far as is known",
    "write another `number` in the cell file or process file, unless the controller's parameters "
    "give that use another signal",
)
_NOTHING_GIVEN: Final = warning(
    "CO082",
    "`{name}`, used in {uses}, is empty in the cell file: {what}",
    'write `routine = "stop"`, or the name of a file with a routine that gives the value',
)
_DELETE_TYPE: Final = (
    "delete the entry, and correct the declaration of the type if that is the one that is wrong"
)
UNPROVEN: Final = warning(
    "CO074",
    "what lacks values of its cell is not proven by motion",
    "write them in the cell file, then prove it",
)
_STATED_TWICE: Final = info(
    "CO083",
    "`{entry}` of the cell file counts instead of what the controller's files state: {other}",
    "delete the entry if the controller's files are right",
)
_MOST_USES: Final = 3
"""Uses of a name that a finding lists."""
_GROUP_BITS: Final = {"input": 15, "output": 16}
"""Bits of a group of signals without a stated width; an input of 16 may be read as negative."""
_GROUP_WIDTHS: Final = (8, 16, 32)
"""Widths of groups that controllers read at once: the rest of one stays free."""
_FIRST_ANALOG: Final = 6000
"""Number of the first analog signal: the first register that CR controllers have for such."""


def with_values_of_file(
    loaded: Loaded,
    path: str | FilePath,
    *,
    taught: str | None = None,
    to: Language[Any] | None = None,
) -> Loaded:
    """A program in the cell of a cell file, which need not be there yet.

    taught: the arm that its joint angles were taught on, if that is known without the cell file.
    to: the language that it is translated to, None for any. Raises Unreadable or Refused for a
    file that cannot be used.
    """
    return with_cell_values(loaded, read_cell(path), FilePath(path), taught=taught, to=to)


def with_cell_values(
    loaded: Loaded,
    cell: Cell,
    path: FilePath,
    *,
    taught: str | None = None,
    to: Language[Any] | None = None,
) -> Loaded:
    """The same for a cell that was read. What it does not say is in `wanting` of the answer."""
    origin = loaded.program.origin
    if origin is None:
        return loaded
    loaded, restated = _with_cell_first(loaded, cell, path)
    origin = loaded.program.origin
    assert origin is not None
    language = language_of(origin.language)
    wanted = language.wanted(origin.trees)
    files = _routine_files(language, cell, wanted, path)
    trees = [*origin.trees, *files]
    if files:
        wanted = language.wanted(trees)
    cell = _with_signals_used(cell, loaded.program, wanted)
    signals = loaded.program.signals | dict(loaded.signals) | dict(cell.process.signals)
    wanted = tuple(_of_stated_kind(one, cell, signals) for one in wanted)
    declared = [one for one in wanted if one.kind != "signal"]
    program = loaded.program
    values = [_value_of(one, cell) for one in declared]
    pairs = zip(declared, values, strict=True)
    given = [(_with_extents(_with_stated_type(one, cell), value), value) for one, value in pairs]
    if given:
        trees = language.with_supplied(trees, given, STATED_TEXT_NAME)
    if files or given:
        anew = with_signals(language.lift(trees, origin.robot), loaded.signals)
        program = _with_stated_tables(anew, program, origin.lifted)
        cell = _with_signals_used(cell, program)
    to_other = to is None or to.family != language.family
    hands = hand_outputs(program, to or _other_language(language)) if to_other else {}
    outputs = ((name, Signal("digital", "output")) for name in hands.values())
    program = replace(program, signals=with_used_signals(program.signals, outputs))
    check_signals(program, cell.process, str(path))
    program = _with_input_signals(program, wanted)
    told = _lowered_for_export(program, language)
    signals = told.signals | program.signals
    if to_other:
        own = set(hand_outputs(program, language).values())
        signals = {n: x for n, x in signals.items() if n.lower() not in own or n in told.signals}
    program = replace(program, signals=signals)
    program, findings = with_cell_equipment(program, cell.process, str(path), sharing=True)
    findings += tuple(_entries_unused(cell, wanted, origin.lifted, str(path)))
    findings += tuple(_values_not_given(cell, wanted, str(path)))
    missing = [
        one for one in declared if cell.value(one) is None and neutral_value(one) is not None
    ]
    dedicated = _dedicated_signals(to, language)
    findings += tuple(_numbers_of_controller(program, dedicated, cell, str(path)))
    program, unnumbered = _with_signal_numbers(program, wanted, dedicated)
    if to is not None:
        unnumbered = [_with_hint(one, to) for one in unnumbered]
    findings += tuple(_arms_unused(cell, taught, program.robot, str(path)))
    arm = Wanted(TAUGHT_ON, "arm")
    joints = (
        taught is None
        and program.robot is None
        and (has_joint_angles(program) or has_joint_angles(told))
    )
    stated = (cell.value(arm) or loaded.arm) if joints else SAME_ARM
    joint_speed, unused = _joint_speed(cell, loaded.joint_speed, str(path))
    findings += unused
    if to_other:
        open_ends = _lines_opened(told)  # without those whose other end the program states itself
        numbers = [number for number in _lines_opened(program) if number in open_ends]
        missing += [Wanted(LINE_NAME.format(number), "line") for number in numbers]
        program = with_lines(program, dict.fromkeys(numbers, NEUTRAL_LINE))
        if joint_speed is None and taught is None and has_percent_joints(told):
            missing.append(Wanted(JOINT_SPEED, "speed"))
            joint_speed = SLOW_SPEED.tcp
    if to_other and to is not None and to.tool_loads:
        asked = bool(missing or unnumbered)
        missing += [one for one in _loads_lacking(program) if asked or _is_entered(one, cell)]
    told_before = without_other_numbers(
        loaded.findings, program, loaded.signals, cell.process.signals
    )
    return replace(
        loaded,
        program=program,
        findings=(*told_before, *restated, *findings),
        joint_speed=joint_speed,
        joint_percent=cell.process.joint_percent or loaded.joint_percent,
        wanting=_with_uses(
            (*missing, *unnumbered, *([arm] if stated is None else [])), told, hands
        ),
        arm=str(neutral_value(arm) if stated is None else stated) if joints else loaded.arm,
    )


def _with_cell_first(
    loaded: Loaded, cell: Cell, path: FilePath
) -> tuple[Loaded, tuple[Diagnostic, ...]]:
    """A program without the values of its controller's files that a cell file states as well.

    Returns findings on those that differ, too.
    """
    origin, found = loaded.program.origin, list[Diagnostic]()
    assert origin is not None
    arm = Wanted(TAUGHT_ON, "arm")
    both = [(one, value) for one, value in loaded.held if cell.value(one) is not None]
    if loaded.arm is not None and cell.value(arm) is not None:
        both.append((arm, loaded.arm))
    if not both:
        return loaded, ()
    for one, value in both:
        if cell.value(one) == value:
            continue
        table = TABLE_OF_KIND[one.kind]
        plain = one.kind in ("data", "arm")
        other = f"`{data_text(value)}`" if plain else "another value"  # type: ignore[arg-type]
        entry = f"[{toml_key(table, one.name)}]"
        found.append(
            _STATED_TWICE(entry=entry, other=other, place=f"{table}.{one.name}", path=str(path))
        )
    left = [pair for pair in loaded.held if cell.value(pair[0]) is None]
    told = without_restated(
        loaded.findings, loaded.held, left, None if cell.value(arm) is None else loaded.arm
    )
    loaded = replace(loaded, findings=told)
    if len(left) == len(loaded.held):
        return loaded, tuple(found)
    language = language_of(origin.language)
    trees = list(loaded.bare)
    if left:
        trees = list(language.with_supplied(trees, left, STATED_TEXT_NAME))
    anew = with_signals(language.lift(trees, origin.robot), loaded.signals)
    program = _with_stated_tables(anew, loaded.program, origin.lifted)
    return replace(loaded, program=program, held=tuple(left)), tuple(found)


def _with_signals_used(cell: Cell, program: Program, wanted: Iterable[Wanted] = ()) -> Cell:
    """A cell file whose signals without a stated direction have that in which they are used."""
    read = {one.name: one.signal for one in wanted if one.signal is not None}
    return replace(cell, process=with_directions(cell.process, {**read, **program.signals}))


def _with_uses(
    missing: Iterable[Wanted], program: Program, hands: Mapping[int, str]
) -> tuple[Wanted, ...]:
    """Return missing values; those that no statement names get the statements that need them.

    program: lowered for a language of another family. hands: their outputs there.
    """
    missing = tuple(missing)
    if all(one.uses for one in missing):
        return missing
    places = Places(program)
    needs = [
        (place, needed)
        for statement in program.statements()
        if statement.span is not None and (place := places.of(statement.span)) is not None
        for needed in (_needs(head(statement), program, hands),)
    ]

    def uses(one: Wanted) -> tuple[str, ...]:
        found = (at for at, needed in needs if (one.kind, one.name.lower()) in needed)
        names = (f"{FilePath(at.path or '').name}:{at.line}".lstrip(":") for at in found)
        return tuple(dict.fromkeys(names))

    return tuple(one if one.uses else replace(one, uses=uses(one)) for one in missing)


def with_joint_speed_wanted(loaded: Loaded, compiled: Program, *, loads: bool) -> Loaded:
    """A program that lacks the speed of some joint moves, which becomes slow until it is filled in.

    compiled: the same, with the statements whose lines need it. loads: whether the other language
    asks for loads of tools too.
    """
    known = {(one.kind, one.name.lower()) for one in loaded.wanting}
    lacking = [Wanted(JOINT_SPEED, "speed"), *(_loads_lacking(loaded.program) if loads else ())]
    new = [one for one in lacking if (one.kind, one.name.lower()) not in known]
    asked = _with_uses(new, compiled, {})
    return replace(loaded, wanting=(*loaded.wanting, *asked), joint_speed=SLOW_SPEED.tcp)


def _needs(
    statement: p.Statement, program: Program, hands: Mapping[int, str]
) -> set[tuple[WantedKind, str]]:
    """Return what a statement needs of the cell, by kind and name in lower case."""
    texts = texts_in(statement)
    kinds: tuple[WantedKind, ...] = ("signal", "data", "tool")
    found: set[tuple[WantedKind, str]] = {(kind, text) for kind in kinds for text in texts}
    joints = {name.lower() for name in program.joint_targets}
    joints |= {name.lower() for name, one in program.variables.items() if one.type == "joints"}
    for record in records(statement):
        if isinstance(record, e.JointValue | p.MoveJoints) or not joints.isdisjoint(texts):
            found.add(("arm", TAUGHT_ON))
        if _moves_joints(record):
            found.add(("speed", JOINT_SPEED))
        if isinstance(record, p.Gripper) and record.hand in hands:
            found.add(("signal", hands[record.hand].lower()))
        if isinstance(record, p.Attach) and record.kind == "line":
            number = e.plain_number(record.place[0]) if record.place else None
            if number is not None:
                found.add(("line", LINE_NAME.format(int(number))))
    return found


def _moves_joints(record: Any) -> bool:
    """True if a record is a joint move, or a path with one."""
    match record:
        case p.Move(kind="joint") | p.MoveJoints():
            return True
        case p.Follow(path):
            return Kind.JOINT in path.kinds
    return False


def _of_stated_kind(one: Wanted, cell: Cell, signals: Mapping[str, Signal]) -> Wanted:
    """A name whose uses allow two kinds, as the one that a file states.

    signals: of the program, its controller and its cell. Raises Refused if the cell file states
    both.
    """
    if one.perhaps is None:
        return one
    low = one.name.lower()
    if (TABLE_OF_KIND["data"], low) in cell.given:
        if cell.signal(one.name) is not None:
            raise Refused(_TWO_KINDS(name=one.name, place=f"data.{one.name}"))
        if one.kind == "data":
            return replace(one, perhaps=None)
        type = cell.types.get(low, "")
        return Wanted(one.name, "data", type, uses=one.uses, nothing=0.0)
    signal = next((signals[name] for name in signals if name.lower() == low), None)
    if signal is None or (one.kind == "signal" and signal.number is None):
        return one
    return replace(one, kind="signal", signal=signal, perhaps=None)


def _entries_unused(
    cell: Cell, wanted: Sequence[Wanted], lifted: Program, path: str
) -> Iterator[Diagnostic]:
    """Yield a finding for each value of a cell file that a program has a name for, and not the use.

    Other names may be those of other programs of the cell. wanted: the names that the
    program does not declare. lifted: the program as it was read. path: of the cell file.
    """
    used = {(TABLE_OF_KIND[one.kind], one.name.lower()) for one in wanted}
    kinds = {one.name.lower(): one for one in wanted}
    tables = (lifted.speeds, lifted.blends, lifted.targets, lifted.joint_targets, lifted.variables)
    declared = {name.lower(): name for table in tables for name in table}
    declared |= {one.name.lower(): one.name for one in lifted.procedures}
    declared |= {name.lower(): name for name in (*lifted.tools, *lifted.frames)}
    types = {name for one in lifted.declarations for name in effect_of(one).names}
    for table, low in cell.given:
        if (table, low) in used:
            continue
        if table == TABLE_OF_KIND["record"]:
            # A type that declarations name, and that nobody is asked for, is there already.
            if low not in types:
                continue
            name, cure = low, _DELETE_TYPE
            reason = f"the type `{low}` is the program's or its controller's own"
        elif low in kinds:
            one = kinds[low]
            name, reason = one.name, f"the program uses `{one.name}` as {kind_in_words(one)}"
            cure = f"write `[{toml_key(TABLE_OF_KIND[one.kind], one.name)}]` with its value instead"
        elif low in declared:
            name = declared[low]
            reason, cure = f"the program declares `{name}` itself", _DELETE_DECLARATION
        else:
            continue
        yield _ENTRY_UNUSED(
            entry=f"[{toml_key(table, name)}]",
            reason=reason,
            cure=cure,
            place=f"{table}.{name}",
            path=path,
        )


def _arms_unused(
    cell: Cell, taught: str | None, own: str | None, path: str
) -> Iterator[Diagnostic]:
    """Yield a finding for each arm of a cell file that counts for nothing.

    taught: the arm that the caller names for the program. own: the arm that the program names.
    """
    table = TABLE_OF_KIND["arm"]
    named = taught or own
    for of, low in cell.given:
        if of != table:
            continue
        if low != TAUGHT_ON:
            reason = f"`{TAUGHT_ON}` is the only arm that a cell file states"
            cure = f"write `[{toml_key(table, TAUGHT_ON)}]`, or delete the entry"
        elif named is not None and cell.given[of, low] != named:
            by = "is named as the arm of" if taught else "is stated by"
            reason = f"`{named}` {by} the program"
            cure = "delete the entry, or name that arm"
        else:
            continue
        yield _ENTRY_UNUSED(
            entry=f"[{toml_key(table, low)}]",
            reason=reason,
            cure=cure,
            place=f"{table}.{low}",
            path=path,
        )


def _values_not_given(cell: Cell, wanted: Iterable[Wanted], path: str) -> Iterator[Diagnostic]:
    """Yield a finding for each routine that is to do nothing, and would give the program values."""
    for one in wanted:
        if one.kind != "routine" or cell.value(one) != "empty":
            continue
        kept = names_in_words(one.sets)
        what = [f"{kept} keep what they have" if len(one.sets) > 1 else f"{kept} keeps what it has"]
        if one.nothing is not None:
            result = f"what it gives is always {data_text(one.nothing)}"
            what = [result, *what] if one.sets else [result]
        elif not one.sets:
            continue
        yield _NOTHING_GIVEN(
            name=one.name,
            uses=", ".join(one.uses[:_MOST_USES]) or "the program",
            what=", and ".join(what),
            place=f"routines.{one.name}",
            path=path,
        )


def with_stated_values(loaded: Loaded, path: str | FilePath) -> Loaded:
    """A program with what a cell file states of it, and nothing in place of what it lacks.

    Raises Unreadable or Refused for a file that cannot be used.
    """
    origin = loaded.program.origin
    if origin is None:
        return loaded
    cell = read_cell(path)
    loaded, restated = _with_cell_first(loaded, cell, FilePath(path))
    origin = loaded.program.origin
    assert origin is not None
    language, program = language_of(origin.language), loaded.program
    wanted = language.wanted(origin.trees)
    cell = _with_signals_used(cell, program, wanted)
    signals = program.signals | dict(loaded.signals) | dict(cell.process.signals)
    given = values_stated(wanted, {}, cell, signals)
    if given:
        trees = language.with_supplied(origin.trees, given, STATED_TEXT_NAME)
        anew = with_signals(language.lift(trees, origin.robot), loaded.signals)
        program = _with_stated_tables(anew, program, origin.lifted)
    check_signals(program, cell.process, str(path))
    program, findings = with_cell_equipment(program, cell.process, str(path), sharing=True)
    wanted = tuple(_of_stated_kind(one, cell, signals) for one in wanted)
    findings += tuple(_entries_unused(cell, wanted, origin.lifted, str(path)))
    told = without_other_numbers(loaded.findings, program, loaded.signals, cell.process.signals)
    return replace(loaded, program=program, findings=(*told, *restated, *findings))


def with_values_beside(
    language: Language[Any], trees: Sequence[Tree], file: str, path: FilePath
) -> list[Tree]:
    """Return trees with the values that a cell file and files of their controller state.

    file: of one of the trees. path: of the cell file. Raises Unreadable or Refused for a cell file
    that cannot be used.
    """
    given, _ = controller_configuration(language, file)
    return with_tree_values(language, trees, given, read_cell(path))


def with_tree_values(
    language: Language[Any], trees: Sequence[Tree], given: ControllerConfiguration, cell: Cell
) -> list[Tree]:
    """Return trees with the values that a cell and the files of a controller state.

    given: contents of the files of the controller.
    """
    signals = {**given.signals, **cell.process.signals}
    values = values_stated(language.wanted(trees), given.values, cell, signals)
    return list(language.with_supplied(trees, values, STATED_TEXT_NAME)) if values else list(trees)


def values_stated(
    wanted: Iterable[Wanted],
    held: Mapping[tuple[WantedKind, str], SuppliedValue],
    cell: Cell,
    signals: Mapping[str, Signal],
) -> Supplied:
    """Return the undeclared names that a cell file, or else the controller, gives a value.

    held: values of the controller by kind and lower-case name. signals: of both.
    """
    found: list[tuple[Wanted, SuppliedValue | None]] = []
    for one in (_of_stated_kind(one, cell, signals) for one in wanted):
        if one.kind == "signal":
            continue
        value = held.get((one.kind, one.name.lower()))
        if cell.value(one) is not None:
            value = _value_of(one, cell)
        if value is not None:
            found.append((_with_extents(_with_stated_type(one, cell), value), value))
    return found


def _loads_lacking(program: Program) -> Iterator[Wanted]:
    """The tools that the program uses and that have no load, as their source keeps it elsewhere.

    A program that lacks nothing else is no draft for it: it is written with the least load.
    """
    used = texts_in(program.procedures)
    for name, tool in program.tools.items():
        if tool.load is None and name.lower() in used:
            yield Wanted(name, "tool", tip=tool.tip)


def _is_entered(wanted: Wanted, cell: Cell) -> bool:
    """True if a cell file has a place for a value that is still to be filled in."""
    entry = TABLE_OF_KIND[wanted.kind], wanted.name.lower()
    return entry in cell.known and cell.value(wanted) is None


def _joint_speed(
    cell: Cell, process: float | None, path: str
) -> tuple[float | None, tuple[Diagnostic, ...]]:
    """Return the mm/s of joint moves with a percentage: the lowest that is stated, as the safest.

    process: of the process file. path: of the cell file. Returns findings on higher ones, too.
    """
    table = cell.value(Wanted(JOINT_SPEED, "speed"))
    stated = {
        JOINT_SPEED: cell.process.joint_speed,
        f"{TABLE_OF_KIND['speed']}.{JOINT_SPEED}": table.tcp if isinstance(table, Speed) else None,
    }
    least = min((tcp for tcp in (process, *stated.values()) if tcp is not None), default=None)
    return least, tuple(
        _ENTRY_UNUSED(
            entry=place,
            reason=f"a lower joint speed, {least:g} mm/s, is stated as well",
            cure="delete the one that is wrong",
            place=place,
            path=path,
        )
        for place, tcp in stated.items()
        if tcp not in (None, least)
    )


def _lines_opened(program: Program) -> list[int]:
    """The communication lines that the program opens by their numbers alone."""
    return sorted({
        int(number)
        for one in records_in_procedures(program, p.Attach)
        for number in (e.plain_number(part) for part in one.place[:1])
        if one.kind == "line" and number is not None
    })  # fmt: skip


_STATED_TABLES: Final = ("frames", "tools", "speeds", "blends", "signals")
"""Tables of a program that a process file may have stated."""


def _with_stated_tables(program: Program, before: Program, lifted: Program) -> Program:
    """A program that was read once more, with what files had stated of it before.

    Those are a process file, and files of its controller, which name its entry and what is called.
    """
    program, changed = with_names_of_numbers_kept(program, before), dict[str, Any]()
    if before.entry != lifted.entry:
        changed["entry"] = before.entry
    if before.origin is not None and program.origin is not None:
        changed["origin"] = replace(program.origin, called=before.origin.called)
    for table in _STATED_TABLES:
        was, now = getattr(lifted, table), getattr(before, table)
        anew = {name: one for name, one in now.items() if was.get(name) != one}
        changed[table] = {**getattr(program, table), **anew}
    return replace(program, **changed)


def _lowered_for_export(program: Program, language: Language[Any]) -> Program:
    """Lower the program for a language of another family, which may ask for more signals."""
    return language.exported(program, _other_language(language), None).program


def _other_language(language: Language[Any]) -> Language[Any]:
    others = map(language_of, languages.names())
    return next(one for one in others if one.family != language.family)


def neutral_cell(loaded: Loaded) -> str:
    """A cell file for a program, with the values that say least: the flange, the base, 100 mm/s.

    Signals are numbered from 1. Routines that were not read are stops. Joint angles are those of
    the arm that runs the program, whichever it was written for.
    """
    loaded = replace(loaded, arm=None)
    wanting = with_cell_values(loaded, NO_CELL, FilePath("cell.toml")).wanting
    origin = loaded.program.origin
    percents = origin is not None and language_of(origin.language).joint_percent
    head = f"joint_speed = {SLOW_SPEED.tcp:g}\n" if percents else ""
    return with_entries(head, [(one, neutral_value(one)) for one in wanting])


def with_neutral_cell(loaded: Loaded) -> Loaded:
    """A program in a cell that says the least of everything, see `neutral_cell`; nothing lacks."""
    cell = parse_cell(SourceText(neutral_cell(loaded), STATED_TEXT_NAME))
    return with_cell_values(loaded, cell, FilePath("cell.toml"))


def cell_text(cell: Cell, wanting: Iterable[Wanted]) -> str:
    """The text of a cell file with a place for each value that it has no entry for."""
    new: dict[tuple[str, str], Wanted] = {}
    for one in wanting:
        entry = TABLE_OF_KIND[one.kind], one.name.lower()
        if entry not in cell.known:
            new.setdefault(entry, one)
    return (
        with_entries(cell.text, [(_without_number(one), None) for one in new.values()])
        if new
        else cell.text
    )


def marked_as_draft(program: Program, wanting: Sequence[Wanted]) -> Program:
    """Return a program that lacks values, with a heading that lists them and a stop before all
    else.

    A stand-in for an output or a frame must not start a motion.
    """
    if not wanting:
        return program
    names = (f"to be filled in: {wanted_in_words(one)}{_stand_in(one)}" for one in wanting)
    head = ("DRAFT: not for production. The cell file does not say these values:", *names)
    return stopped_at_start(replace(program, comments=(*program.comments, *head)))


def _stand_in(one: Wanted) -> str:
    """Say which value the program has meanwhile, so that nobody takes it for the real one."""
    if one.signal is not None and one.signal.number is not None:
        return f"; number {one.signal.number} is a stand-in"
    return _LEAST_LOAD if one.tip is not None else _STAND_INS.get(one.kind, "")


_LEAST_LOAD: Final = "; the least mass is a stand-in"
_STAND_INS: Final[Mapping[WantedKind, str]] = {
    "tool": "; its zeros are stand-ins",
    "frame": "; its zeros are stand-ins",
    "speed": f"; {SLOW_SPEED.tcp:g} mm/s is a stand-in",
}


def stopped_at_start(program: Program) -> Program:
    """Return a program that stops before all else, in each procedure that no other one calls."""
    calls = {one.name.lower(): set(called(one)) - {one.name.lower()} for one in program.procedures}
    inner = {name for names in calls.values() for name in names} - {(program.entry or "").lower()}
    return replace(
        program,
        procedures=tuple(
            one if one.name.lower() in inner else replace(one, body=(p.Stop(), *one.body))
            for one in program.procedures
        ),
    )


def _without_number(one: Wanted) -> Wanted:
    if one.signal is None:
        return one
    return replace(one, signal=replace(one.signal, number=None))


def _with_stated_type(one: Wanted, cell: Cell) -> Wanted:
    """With the type that the cell file states for data."""
    return (
        replace(one, type=cell.types.get(one.name.lower(), one.type)) if one.kind == "data" else one
    )


def _value_of(one: Wanted, cell: Cell) -> SuppliedValue | None:
    value, least = cell.value(one), neutral_value(one)
    if value is None:
        return least
    if (
        one.kind == "data"
        and _with_stated_type(one, cell).type == one.type
        and not _is_like(value, least)
    ):
        shown = data_text(one.nothing)
        at = f"data.{one.name}"
        raise Refused(
            _OTHER_TYPE(name=one.name, type=one.type, wanted=f"one like {shown}", place=at)
        )
    return value


def _with_extents(one: Wanted, value: SuppliedValue | None) -> Wanted:
    """An array with the extents that its value has."""
    extents: list[int] = []
    inner: Any = value
    for _ in one.size:
        if not isinstance(inner, tuple) or not inner:
            return one
        extents.append(len(inner))
        inner = inner[0]
    return replace(one, size=tuple(extents))


def _is_like(value: Any, other: Any) -> bool:
    """True if two values of data have the same form; arrays may have any number of elements."""
    if isinstance(value, tuple) and isinstance(other, tuple):
        alike = len({type(part) for part in other}) == 1 and len(other) > 0
        if len(value) != len(other) and not alike:
            return False
        return all(_is_like(a, b) for a, b in zip(value, other, strict=False))
    kinds = (bool, str, tuple, float | int)
    kind = next(k for k in kinds if isinstance(other, k)) if other is not None else object
    return isinstance(value, kind) and (kind is not kinds[-1] or not isinstance(value, bool))


def _routine_files(
    language: Language[Any], cell: Cell, wanted: Sequence[Wanted], path: FilePath
) -> list[Any]:
    """The trees of files that the cell file names for routines that were not read."""
    names: dict[str, str] = {}
    for one in wanted:
        value = cell.value(one) if one.kind == "routine" else None
        if isinstance(value, str) and value not in ROUTINES:
            names.setdefault(value, one.name)
    found = []
    for name, routine in names.items():
        try:
            tree = language.parse(language.read(path.parent / name))
        except Refused as refused:
            reason = refused.findings[0].message
            raise Refused(
                _NO_FILE_OF(name=routine, file=name, reason=reason, path=str(path))
            ) from None
        if has_errors(tree.findings):
            raise Refused(*tree.findings)
        found.append(tree)
    return found


def _with_input_signals(program: Program, wanted: Sequence[Wanted]) -> Program:
    """With the signals that expressions read and nothing sets."""
    known = {name.lower() for name in program.signals}
    found = {
        one.name: one.signal
        for one in wanted
        if one.signal is not None and one.name.lower() not in known
    }
    return replace(program, signals={**program.signals, **found}) if found else program


def _dedicated_signals(
    to: Language[Any] | None, source: Language[Any]
) -> Mapping[str, Mapping[int, str]]:
    """Return the numbers that a controller of the language uses itself.

    to: None for any language but that of the source, whose program states numbers by itself.
    """
    if to is not None:
        return {} if to.family == source.family else to.dedicated_signals
    found: dict[str, dict[int, str]] = {}
    for name in languages.names():
        for direction, uses in language_of(name).dedicated_signals.items():
            found.setdefault(direction, {}).update(uses)
    return found


def _numbers_of_controller(
    program: Program, dedicated: Mapping[str, Mapping[int, str]], cell: Cell, path: str
) -> Iterator[Diagnostic]:
    """Yield a finding for each signal whose number the controller uses itself.

    path: of the cell file; a number may be from a process file, or from files of the controller.
    """
    for name, signal in program.signals.items():
        if signal.number is None or signal.kind == "analog":
            continue
        uses = dedicated.get(signal.direction, {})
        numbers = range(signal.number, signal.number + signal.bits)
        for number in [one for one in numbers if one in uses][:1]:
            yield _DEDICATED(
                direction=signal.direction,
                name=name,
                number=number,
                use=uses[number],
                place=f"signals.{name}",
                path=None if cell.signal(name) is None else path,
            )


def _with_signal_numbers(
    program: Program, wanted: Sequence[Wanted], dedicated: Mapping[str, Mapping[int, str]]
) -> tuple[Program, list[Wanted]]:
    """With numbers for signals that have none, from 1 on, and those signals.

    dedicated: numbers that the controller uses itself, by direction.
    """
    uses = {one.name.lower(): one for one in wanted if one.kind == "signal"}
    signals = dict(program.signals)
    taken = {(direction, False): set(numbers) for direction, numbers in dedicated.items()}
    for signal in signals.values():
        if signal.number is not None:
            _numbers_taken(taken, signal).update(range(signal.number, signal.number + signal.bits))
    missing: list[Wanted] = []
    order = sorted(signals.items(), key=lambda pair: pair[1].kind == "group")
    for name, signal in order:
        if signal.number is not None:
            continue
        bits = (
            _GROUP_BITS[signal.direction]
            if signal.kind == "group" and signal.bits == 1
            else signal.bits
        )
        room = _numbers_taken(taken, signal)
        first = _FIRST_ANALOG if signal.kind == "analog" else 1
        wide = next(width for width in (1, *_GROUP_WIDTHS) if width >= bits)
        number = next(n for n in range(first, 100_000) if room.isdisjoint(range(n, n + wide)))
        room.update(range(number, number + wide))
        signals[name] = Signal(signal.kind, signal.direction, number, bits)
        known = uses.get(name.lower(), Wanted(name, "signal"))
        missing.append(replace(known, name=name, signal=signals[name]))
    return (replace(program, signals=signals) if missing else program), missing


def _with_hint(one: Wanted, to: Language[Any]) -> Wanted:
    """Return a signal with the numbers that controllers of a language have for it."""
    if one.signal is None:
        return one
    analog = one.signal.kind == "analog"
    return replace(one, numbers=to.register_numbers if analog else to.signal_numbers)


def _numbers_taken(taken: dict[tuple[str, bool], set[int]], signal: Signal) -> set[int]:
    """The numbers that signals of its kind have by now."""
    return taken.setdefault((signal.direction, signal.kind == "analog"), set())
