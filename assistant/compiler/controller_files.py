"""What the files of a controller state about its programs: signals, the arm, what it holds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, info, warning
from assistant.base.source_text import decode, read_bytes
from assistant.compiler.cell_file import with_lines, with_signals
from assistant.languages.language_types import ControllerConfiguration
from assistant.program.undeclared_names import ChannelLine

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.program.program import Program
    from assistant.program.undeclared_names import Supplied

SIGNALS_NUMBERED: Final = info(
    "CO043",
    "{count} signals of the program have the numbers that its controller's files state, each "
    "device behind the one before",
    "see that the other controller is wired so, or state other numbers in the process file",
)
CROSS_CONNECTED: Final = warning(
    "CO044",
    "the controller sets {names} from other signals, as its files state; this is not translated",
    "have the other controller or its wiring do that as well",
)
CONFIGURATION_UNREAD: Final = warning(
    "CO045",
    "{what} of `{name}` is not used: {reason}",
    "correct it, or state what it says in the process file",
)
CONFIGURATION_TAKEN: Final = info(
    "CO046",
    "the controller's files state {what}",
    "see that they are those of this program; a process file or a cell file counts instead",
)
CALLED_BY_CONTROLLER: Final = warning(
    "CO048",
    "the controller calls `{name}` {when}, as its files state; that call is not translated",
    "have the other controller call it then, or call it where the program begins",
)
STATED_TEXT_NAME: Final = "cell values"
"""Of the text of declarations that is made of what a cell states."""
WHOLE_TEXT: Final = "the text"
MOST_NAMED: Final = 5
CONFIGURATION_ENCODINGS: Final = ("utf-8-sig", "utf-8", "cp1252", "latin-1")


def controller_configuration(
    language: Language[Any], file: str | FilePath
) -> tuple[ControllerConfiguration, tuple[Diagnostic, ...]]:
    """What the files beside one of a program state; a file that cannot be read is a finding."""
    if language.surroundings is None:
        return ControllerConfiguration(), ()
    unread = list[Diagnostic]()

    def read(path: FilePath) -> str | None:
        try:
            return decode(read_bytes(path), str(path), CONFIGURATION_ENCODINGS).text
        except Refused as refused:
            reason = refused.findings[0].message
            unread.append(
                CONFIGURATION_UNREAD(what=WHOLE_TEXT, name=path.name, reason=reason, path=str(path))
            )
            return None

    found = language.surroundings(FilePath(file), read)
    source = found.source
    if source is not None and not found.known:
        reason = "it does not look like a file of system parameters"
        unread.append(
            CONFIGURATION_UNREAD(what=WHOLE_TEXT, name=source.name, reason=reason, path=str(source))
        )
    if source is not None and found.unread:
        reason = "it states no type of signal that there is"
        what = _names_in_words(found.unread)
        unread.append(
            CONFIGURATION_UNREAD(what=what, name=source.name, reason=reason, path=str(source))
        )
    return found, (*unread, *found.findings)


@dataclass(frozen=True, slots=True)
class ConfiguredProgram:
    """A program with what the files of its controller state. arm: see `ControllerConfiguration`."""

    program: Program
    arm: str | None = None
    findings: tuple[Diagnostic, ...] = ()


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
        found.append(CONFIGURATION_TAKEN(what=_names_in_words([one.name for one, _ in names])))
    numbered = _signal_numbers(program) - _signal_numbers(before)
    if numbered:
        found.append(SIGNALS_NUMBERED(count=len(numbered)))
    crossed = [name for name in program.signals if name.lower() in given.crossed]
    if crossed:
        found.append(CROSS_CONNECTED(names=_names_in_words(crossed)))
    arm = given.arm if program.robot is None else None
    if arm is not None:
        found.append(CONFIGURATION_TAKEN(what=f"the robot `{given.told}`, which is `{arm}`"))
    begins = program.procedure(given.entry) if given.entry else None
    if begins is not None and not begins.parameters and begins.name != program.entry:
        program = replace(program, entry=begins.name)
        found.append(CONFIGURATION_TAKEN(what=f"that the program begins with `{begins.name}`"))
    if program.origin is not None and given.called:
        program = replace(program, origin=replace(program.origin, called=frozenset(given.called)))
    entry = (program.entry or "").lower()
    for procedure in program.procedures:
        when = given.called.get(procedure.name.lower())
        if when is not None and procedure.name.lower() != entry:
            found.append(CALLED_BY_CONTROLLER(name=procedure.name, when=when, span=procedure.span))
    return ConfiguredProgram(program, arm, tuple(found))


def _values_held(
    program: Program, language: Language[Any], given: ControllerConfiguration
) -> Supplied:
    """What nobody declares and the controller holds a value of."""
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


def _names_in_words(names: list[str] | tuple[str, ...]) -> str:
    shown = ", ".join(f"`{name}`" for name in names[:MOST_NAMED])
    more = len(names) - MOST_NAMED
    return f"{shown} and {more} more" if more > 0 else shown
