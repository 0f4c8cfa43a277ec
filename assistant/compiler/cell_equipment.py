"""Tools, frames, signals and lines that a cell gives a program which names them.

They come from a process file, if the program moves to another cell, or from the configuration
files of the program's controller: signals, the arm, values that the controller holds.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar

from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, info, warning
from assistant.base.source_text import decode, read_bytes
from assistant.languages.language_types import ControllerConfiguration
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import address_name, hands_used
from assistant.program.passes.names import with_signals_renamed
from assistant.program.passes.operator_texts import is_operators
from assistant.program.passes.positions import taken_names
from assistant.program.program import Program, Signal
from assistant.program.rewriting import records, rewrite
from assistant.program.statement_index import names_in_procedures
from assistant.program.undeclared_names import ChannelLine
from assistant.sources.process import NO_PROCESS, Process

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.program.undeclared_names import Supplied


_ENTRY_NOT_USED = warning(
    "CO006",
    "the program has no {kind} `{name}`, so what the process file says of it changes nothing",
    "write the name as the program does",
)

KEYS_WITHOUT_EFFECT = info(
    "CO009",
    "what the process file says of {keys} changes nothing in a program that states its own moves",
    "name arms with --robot and --from-robot; the rest is for drawings and tables",
)
_SIGNAL_MISMATCH = error(
    "CO010",
    "the program uses `{name}` as {used}, but the file states {stated}",
    'write kind = "{kind}" and direction = "{direction}", or see which signal the program means',
)
_NUMBER_AS_NAME = info("CO084", "`{name}` has its number as its name: {why}", "{cure}")
_PROGRAM_KEYS: Final = (
    *("tools", "frames", "signals", "lines", "joint_speed", "joint_percent", "interface"),
    *("undirected", "seen", "findings"),
)
"""Keys of a process file that a program takes from it."""
_KEY_WORDS: Final = {"defaults": "motion"}
"""Keys of a process file that have other names here."""

_DIRECTIONS: Final[tuple[Literal["input", "output"], ...]] = ("input", "output")

V = TypeVar("V")


def with_cell_equipment(
    program: Program, stated: Process, path: str, *, sharing: bool = False
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The program with the tools, frames and signals of the same name in a process file.

    Signals of other programs in the same cell may be in it as well, and where it is shared tools
    and frames. path: of the file.
    """
    findings = [*stated.findings]
    others = [
        f"`{_KEY_WORDS.get(f.name, f.name)}`"
        for f in fields(Process)
        if f.name not in _PROGRAM_KEYS and getattr(stated, f.name) != getattr(NO_PROCESS, f.name)
    ]
    if others:
        findings.append(KEYS_WITHOUT_EFFECT(keys=", ".join(others), path=path))
    program = with_signals(program, stated.signals)
    program, unnamed = _with_names_of_numbers(program, stated, path)
    findings += unnamed
    program = with_lines(program, stated.lines)
    for kind, given, there in _stated_tables(program, stated):
        known = {name.lower() for name in there}
        findings += [
            _ENTRY_NOT_USED(kind=kind, name=name, place=f"{kind}s.{name}", path=path)
            for name in given
            if name.lower() not in known and not sharing
        ]
    return replace(
        program,
        tools=_replaced_entries(program.tools, stated.tools),
        frames=_replaced_entries(program.frames, stated.frames),
        interface=stated.interface or program.interface,
    ), tuple(findings)


def with_directions(stated: Process, used: Mapping[str, Signal]) -> Process:
    """A process file whose signals without a stated direction have that of a program's signals."""
    given = {name.lower(): signal.direction for name, signal in used.items()}
    known = {name: given[name.lower()] for name in stated.undirected if name.lower() in given}
    if not known:
        return stated
    signals = {
        name: replace(signal, direction=known.get(name, signal.direction))
        for name, signal in stated.signals.items()
    }
    return replace(stated, signals=signals, undirected=stated.undirected - known.keys())


def without_other_numbers(
    findings: Iterable[Diagnostic],
    program: Program,
    held: Mapping[str, Signal],
    stated: Mapping[str, Signal],
) -> tuple[Diagnostic, ...]:
    """Findings in which those signals count no more that a file gives a number.

    held: the signals that the controller's files state. stated: those of the file.
    """
    numbers = {name.lower(): signal.number for name, signal in held.items()}
    given = {name.lower() for name, signal in stated.items() if signal.number is not None}
    left = sum(
        signal.number is not None
        and numbers.get(name.lower()) == signal.number
        and name.lower() not in given
        for name, signal in program.signals.items()
    )
    told = _SIGNALS_NUMBERED(count=left)
    return tuple(
        replace(one, message=told.message) if one.code == told.code else one
        for one in findings
        if left or one.code != told.code
    )


def check_signals(program: Program, stated: Process, path: str) -> None:
    """Raises Refused for signals that the program uses as something else than is stated.

    A wait for an input would become one for an output. program: as it was read, without signals of
    which only the name tells what they may be.
    """
    others = []
    given = {name.lower(): signal for name, signal in stated.signals.items()}
    for name, used in program.signals.items():
        one = given.get(name.lower(), used)
        if (one.kind, one.direction) != (used.kind, used.direction):
            others.append(
                _SIGNAL_MISMATCH(
                    name=name,
                    used=f"`{used.kind} {used.direction}`",
                    stated=f"`{one.kind} {one.direction}`",
                    kind=used.kind,
                    direction=used.direction,
                    place=f"signals.{name}",
                    path=path,
                )
            )
    if others:
        raise Refused(*others)


def with_signals(program: Program, stated: Mapping[str, Signal]) -> Program:
    """The program with the signals of the same names, those included that expressions read."""
    program = _with_signals_read(program, stated)
    return replace(program, signals=_replaced_entries(program.signals, stated))


def _with_names_of_numbers(
    program: Program, stated: Process, path: str
) -> tuple[Program, list[Diagnostic]]:
    """The program with the names of a file for signals that it addresses by their numbers.

    Returns a finding for each signal that has a name in the file which cannot be used.
    """
    undirected = {name.lower() for name in stated.undirected}
    by_address: dict[Signal, list[str]] = defaultdict(list)
    for name, signal in stated.signals.items():
        sides = _DIRECTIONS if name.lower() in undirected else (signal.direction,)
        for side in sides if signal.number is not None else ():
            by_address[replace(signal, direction=side)].append(name)
    taken = _names_taken(program)
    names, findings = dict[str, str](), list[Diagnostic]()
    for name, signal in program.signals.items():
        given = by_address.get(signal, [])
        if not given or name != address_name(signal) or name in given:
            continue
        wanted, place = given[0], f"signals.{given[0]}"
        address = f"{signal.direction} {signal.number}"
        if len(given) > 1:
            reason = f"the file gives {address} the names {names_in_words(given)}"
            cure = "delete the entries but one"
        elif wanted.lower() in undirected:
            reason = f"the file states no direction of `{wanted}`"
            cure = f'write `direction = "{signal.direction}"` in its entry if it is that one'
        elif wanted.lower() in taken:
            reason = f"the program has something else with the name `{wanted}`"
            cure = "give one of the two another name"
        else:
            names[name] = wanted
            continue
        findings.append(_NUMBER_AS_NAME(name=name, why=reason, cure=cure, place=place, path=path))
    return with_signals_renamed(program, names), findings


def with_names_of_numbers_kept(program: Program, before: Program) -> Program:
    """A program that was read once more, with the names that files gave its numbered signals."""
    named = {signal: name for name, signal in before.signals.items()}
    names = {
        name: named[signal]
        for name, signal in program.signals.items()
        if name == address_name(signal) and named.get(signal, name) not in program.signals
    }
    return with_signals_renamed(program, names)


def _names_taken(program: Program) -> set[str]:
    """The names in lower case that no further signal may have."""
    tables = (program.tools, program.frames, program.joint_targets)
    used = {name.lower() for table in tables for name in table}
    return taken_names(program) | used | {name.lower() for name in names_in_procedures(program)}


def with_lines(program: Program, lines: Mapping[int, ChannelLine]) -> Program:
    """A program with what the cell knows of communication lines in place of their numbers."""

    def stated(part: Any) -> Any:
        match part:
            case p.Attach(kind="line", place=(e.Number(number),)) if number in lines:
                line = lines[int(number)]
                port, address = e.Number(line.port), e.Text(line.address)
                places: dict[str, tuple[e.Expression, ...]] = {
                    "server": (port, address),
                    "client": (address, port),
                    "serial": (port,),
                }
                return replace(part, kind=line.role, place=places[line.role])
        return part

    return rewrite(program, stated) if lines else program


def hand_outputs(program: Program, to: Language[Any]) -> dict[int, str]:
    """Return the outputs of the hands that a program uses; none if the language has hands."""
    outputs = {hand: to.hand_output(hand) for hand in hands_used(program)}
    return {hand: name for hand, name in outputs.items() if name}


def _with_signals_read(program: Program, stated: Mapping[str, Signal]) -> Program:
    """With the signals that expressions read: only the cell knows that those are no data.

    So are names in what is kept as their text, which another language may read, what a person
    answers by, and the outputs of hands, for which some languages have words.
    """
    known = {name.lower() for name in (*program.signals, *program.variables)}
    given = {name.lower(): signal for name, signal in stated.items()}
    found: dict[str, Signal] = {}
    read = [part.name for part in records(program.procedures) if isinstance(part, e.Name)]
    texts = [one.text for one in program.declarations]
    texts += [one.text for one in program.statements() if isinstance(one, p.Opaque)]
    for text in texts:
        read += re.findall(r"\w+", text)
    read += filter(is_operators, stated)
    if hands_used(program):
        for language in map(languages.get, languages.names()):
            read += hand_outputs(program, language).values()
    for name in read:
        if name.lower() in given and name.lower() not in known:
            known.add(name.lower())
            found[name] = given[name.lower()]
    return replace(program, signals={**program.signals, **found})


def _stated_tables(
    program: Program, stated: Process
) -> tuple[tuple[str, Mapping[str, object], Mapping[str, object]], ...]:
    return (
        ("tool", stated.tools, program.tools),
        ("frame", stated.frames, program.frames),
    )


def _replaced_entries(there: dict[str, V], given: Mapping[str, V]) -> dict[str, V]:
    """Values by the program's own names."""
    stated = {name.lower(): value for name, value in given.items()}
    return {name: stated.get(name.lower(), value) for name, value in there.items()}


_SIGNALS_NUMBERED: Final = info(
    "CO043",
    "{count} signals of the program have the numbers that its controller's files state, each "
    "device behind the one before",
    "see that the other controller is wired so, or state other numbers in the process file or the "
    "cell file",
)
_CROSS_CONNECTED: Final = warning(
    "CO044",
    "the controller sets {names} from other signals, as its files state; this is not translated",
    "have the other controller or its wiring do that as well",
)
_CONFIGURATION_UNREAD: Final = warning(
    "CO045",
    "{what} of `{name}` is not used: {reason}",
    "correct it, or state what it says in the process file",
)
_CONFIGURATION_TAKEN: Final = info(
    "CO046",
    "the controller's files state {what}",
    "see that they are those of this program; a process file or a cell file counts instead",
)
_CALLED_BY_CONTROLLER: Final = warning(
    "CO048",
    "the controller calls `{name}` {when}, as its files state; that call is not translated",
    "have the other controller call it then, or call it where the program begins",
)
STATED_TEXT_NAME: Final = "cell values"
"""Name of the text of declarations made from a cell's values."""
_WHOLE_TEXT: Final = "the text"
_MOST_NAMED: Final = 5
_CONFIGURATION_ENCODINGS: Final = ("utf-8-sig", "utf-8", "cp1252", "latin-1")


def controller_configuration(
    language: Language[Any], file: str | FilePath
) -> tuple[ControllerConfiguration, tuple[Diagnostic, ...]]:
    """Return the configuration stated by the files beside a program; an unreadable file is a
    finding.
    """
    if language.surroundings is None:
        return ControllerConfiguration(), ()
    unread = list[Diagnostic]()

    def read(path: FilePath) -> str | None:
        try:
            return decode(read_bytes(path), str(path), _CONFIGURATION_ENCODINGS).text
        except Refused as refused:
            reason = refused.findings[0].message
            unread.append(
                _CONFIGURATION_UNREAD(
                    what=_WHOLE_TEXT, name=path.name, reason=reason, path=str(path)
                )
            )
            return None

    found = language.surroundings(FilePath(file), read)
    source = found.source
    if source is not None and not found.known:
        reason = "it does not look like a file of system parameters"
        unread.append(
            _CONFIGURATION_UNREAD(
                what=_WHOLE_TEXT, name=source.name, reason=reason, path=str(source)
            )
        )
    if source is not None and found.unread:
        reason = "it states no type of signal that there is"
        what = names_in_words(found.unread)
        unread.append(
            _CONFIGURATION_UNREAD(what=what, name=source.name, reason=reason, path=str(source))
        )
    return found, (*unread, *found.findings)


@dataclass(frozen=True, slots=True)
class ConfiguredProgram:
    """A program with what the files of its controller state. arm: see `ControllerConfiguration`.

    held: names of the program that they give a value.
    """

    program: Program
    arm: str | None = None
    findings: tuple[Diagnostic, ...] = ()
    held: Supplied = ()


def with_controller_configuration(
    program: Program, language: Language[Any], given: ControllerConfiguration
) -> ConfiguredProgram:
    """A program as the files of its controller have it."""
    before, names = program, _values_held(program, language, given)
    if names:
        program = _with_values_held(program, language, names)
    program = with_signals(program, given.signals)
    program = with_lines(
        program, {number: ChannelLine(*line) for number, line in given.lines.items()}
    )
    found: list[Diagnostic] = []
    if names:
        found.append(_CONFIGURATION_TAKEN(what=names_in_words([one.name for one, _ in names])))
    numbered = _signal_numbers(program) - _signal_numbers(before)
    if numbered:
        found.append(_SIGNALS_NUMBERED(count=len(numbered)))
    crossed = [name for name in program.signals if name.lower() in given.crossed]
    if crossed:
        found.append(_CROSS_CONNECTED(names=names_in_words(crossed)))
    arm = given.arm if program.robot is None else None
    if arm is not None:
        found.append(_CONFIGURATION_TAKEN(what=f"the robot `{given.told}`, which is `{arm}`"))
    begins = program.procedure(given.entry) if given.entry else None
    if begins is not None and not begins.parameters and begins.name != program.entry:
        program = replace(program, entry=begins.name)
        found.append(_CONFIGURATION_TAKEN(what=f"that the program begins with `{begins.name}`"))
    if program.origin is not None and given.called:
        program = replace(program, origin=replace(program.origin, called=frozenset(given.called)))
    entry = (program.entry or "").lower()
    for procedure in program.procedures:
        when = given.called.get(procedure.name.lower())
        if when is not None and procedure.name.lower() != entry:
            found.append(_CALLED_BY_CONTROLLER(name=procedure.name, when=when, span=procedure.span))
    return ConfiguredProgram(program, arm, tuple(found), tuple(names))


def without_restated(
    findings: Iterable[Diagnostic], held: Supplied, left: Supplied, arm: str | None
) -> tuple[Diagnostic, ...]:
    """Findings on what the controller's files state, without what a cell file states as well.

    held: names that those files give a value; left: those that the cell file does not. arm: the
    robot, if the cell file states one.
    """
    before, after = (
        _CONFIGURATION_TAKEN(what=names_in_words([one.name for one, _ in names])).message
        for names in (held, left)
    )
    found = []
    for one in findings:
        if one.code == _CONFIGURATION_TAKEN.code:
            if arm is not None and one.message.endswith(f"which is `{arm}`"):
                continue
            if one.message == before:
                if not left:
                    continue
                one = replace(one, message=after)
        found.append(one)
    return tuple(found)


def _values_held(
    program: Program, language: Language[Any], given: ControllerConfiguration
) -> Supplied:
    """Return the undeclared names that the controller holds a value of."""
    if program.origin is None or not given.values:
        return ()
    wanted = language.wanted_of(program.origin.trees, given.values)
    return [(one, given.values[one.kind, one.name.lower()]) for one in wanted]


def _with_values_held(program: Program, language: Language[Any], values: Supplied) -> Program:
    origin = program.origin
    assert origin is not None
    trees = language.with_supplied(origin.trees, values, STATED_TEXT_NAME)
    return language.lift(trees, origin.robot)


def _signal_numbers(program: Program) -> set[str]:
    return {name for name, signal in program.signals.items() if signal.number is not None}


def names_in_words(names: list[str] | tuple[str, ...]) -> str:
    shown = ", ".join(f"`{name}`" for name in names[:_MOST_NAMED])
    more = len(names) - _MOST_NAMED
    return f"{shown} and {more} more" if more > 0 else shown
