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

NUMBERED: Final = info(
    "CO043",
    "{count} signals of the program have the numbers that its controller's files state, each "
    "device behind the one before",
    "see that the other controller is wired so, or state other numbers in the process file",
)
CROSSED: Final = warning(
    "CO044",
    "the controller sets {names} from other signals, as its files state; this is not translated",
    "have the other controller or its wiring do that as well",
)
UNREAD: Final = warning(
    "CO045",
    "{what} of `{name}` is not used: {reason}",
    "correct it, or state what it says in the process file",
)
TAKEN: Final = info(
    "CO046",
    "the controller's files state {what}",
    "see that they are those of this program; a process file or a cell file counts instead",
)
CALLED: Final = warning(
    "CO048",
    "the controller calls `{name}` {when}, as its files state; that call is not translated",
    "have the other controller call it then, or call it where the program begins",
)
STATED: Final = "cell values"
"""Of the text of declarations that is made of what a cell states."""
ALL: Final = "the text"
MOST_NAMED: Final = 5
ENCODINGS: Final = ("utf-8-sig", "utf-8", "cp1252", "latin-1")


def configured(
    language: Language[Any], file: str | FilePath
) -> tuple[ControllerConfiguration, tuple[Diagnostic, ...]]:
    """What the files beside one of a program state; a file that cannot be read is a finding."""
    if language.surroundings is None:
        return ControllerConfiguration(), ()
    unread = list[Diagnostic]()

    def read(path: FilePath) -> str | None:
        try:
            return decode(read_bytes(path), str(path), ENCODINGS).text
        except Refused as refused:
            reason = refused.findings[0].message
            unread.append(UNREAD(what=ALL, name=path.name, reason=reason, path=str(path)))
            return None

    found = language.surroundings(FilePath(file), read)
    source = found.source
    if source is not None and not found.known:
        reason = "it does not look like a file of system parameters"
        unread.append(UNREAD(what=ALL, name=source.name, reason=reason, path=str(source)))
    if source is not None and found.unread:
        reason = "it states no type of signal that there is"
        what = _named(found.unread)
        unread.append(UNREAD(what=what, name=source.name, reason=reason, path=str(source)))
    return found, (*unread, *found.findings)


@dataclass(frozen=True, slots=True)
class Placed:
    """A program with what the files of its controller state. arm: see `ControllerConfiguration`."""

    program: Program
    arm: str | None = None
    findings: tuple[Diagnostic, ...] = ()


def as_configured(
    program: Program, language: Language[Any], given: ControllerConfiguration
) -> Placed:
    """A program as the files of its controller have it."""
    before, names = program, _held(program, language, given)
    if names:
        program = _holding(program, language, names)
    program = with_signals(program, given.signals)
    program = with_lines(
        program, {number: ChannelLine(*line) for number, line in given.lines.items()}
    )
    found: list[Diagnostic] = []
    if names:
        found.append(TAKEN(what=_named([one.name for one, _ in names])))
    numbered = _numbers(program) - _numbers(before)
    if numbered:
        found.append(NUMBERED(count=len(numbered)))
    crossed = [name for name in program.signals if name.lower() in given.crossed]
    if crossed:
        found.append(CROSSED(names=_named(crossed)))
    arm = given.arm if program.robot is None else None
    if arm is not None:
        found.append(TAKEN(what=f"the robot `{given.told}`, which is `{arm}`"))
    begins = program.procedure(given.entry) if given.entry else None
    if begins is not None and not begins.parameters and begins.name != program.entry:
        program = replace(program, entry=begins.name)
        found.append(TAKEN(what=f"that the program begins with `{begins.name}`"))
    if program.origin is not None and given.called:
        program = replace(program, origin=replace(program.origin, called=frozenset(given.called)))
    entry = (program.entry or "").lower()
    for procedure in program.procedures:
        when = given.called.get(procedure.name.lower())
        if when is not None and procedure.name.lower() != entry:
            found.append(CALLED(name=procedure.name, when=when, span=procedure.span))
    return Placed(program, arm, tuple(found))


def _held(program: Program, language: Language[Any], given: ControllerConfiguration) -> Supplied:
    """What nobody declares and the controller holds a value of."""
    if program.origin is None or not given.values:
        return ()
    wanted = language.wanted_of(program.origin.trees, given.values)
    return [(one, given.values[one.kind, one.name.lower()]) for one in wanted]


def _holding(program: Program, language: Language[Any], values: Supplied) -> Program:
    origin = program.origin
    assert origin is not None
    trees = language.with_supplied(origin.trees, values, STATED)
    return language.lift(trees, origin.robot)


def _numbers(program: Program) -> set[str]:
    return {name for name, signal in program.signals.items() if signal.number is not None}


def _named(names: list[str] | tuple[str, ...]) -> str:
    shown = ", ".join(f"`{name}`" for name in names[:MOST_NAMED])
    more = len(names) - MOST_NAMED
    return f"{shown} and {more} more" if more > 0 else shown
