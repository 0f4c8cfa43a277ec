"""Effects of vendor statements: the signals that they use, and the active tool and work object.

Signals get their kind and direction from the signature of the instruction. Instructions with a
process (welding, dispensing, painting) use the signals of their equipment as well. Without a tool
or a work object `CRobT` reads the position in those of the robot's last move (RAPID reference
manual, CRobT). Which move that is depends on the path through the program, calls included; the
steps that vendor statements contribute to it are read from their instructions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.expressions import Expressions, frame_name, tool_name
from assistant.languages.rapid.tables import signals as table
from assistant.languages.rapid.tables.equivalents import CURRENT_TARGET
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tables.signals import PROCESS_MOVES
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import called, nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.motion_state import MotionStep
from assistant.program.passes.implicit_motion_state import (
    Said,
    with_active_places,
    with_present_places,
)
from assistant.program.program import Program, Signal


@dataclass(frozen=True, slots=True)
class Gun:
    """A spot welding gun and the data of its weld, None where it states none."""

    name: str
    spot: s.Expression | None


def guns(call: Called[s.Expression]) -> tuple[Gun, ...]:
    """The guns of a spot weld in the order of their arguments; none for any other call."""
    known = PROCESS_MOVES.get(call.word.lower())
    if known is None or known.kind != "spot":
        return ()
    # Without arguments between speed and zone, the weld names its guns by options.
    if not known.given:
        named = ((name, spot) for name, spot in call.options.items() if name in table.GUN_OPTIONS)
        return tuple(Gun(f"gun{name[1:]}", spot) for name, spot in named)
    if len(call.given) != known.points + known.given + 2:
        return ()
    gun, spot = call.given[known.points + 1 : known.points + 3]
    if isinstance(gun, s.NameRef):
        return (Gun(gun.name, spot),)
    number = None if gun is None else literal_number(gun)
    return (Gun(f"gun{number}", spot),) if isinstance(number, int) else ()


def retracting(call: Called[s.Expression]) -> tuple[str, ...]:
    """The outputs for guns that open wide behind the weld."""
    wide = "retract" in call.options
    return tuple(gun.name + table.RETRACT_SUFFIX for gun in guns(call)) if wide else ()


def process_signals(call: Called[s.Expression]) -> Iterator[tuple[str, Signal]]:
    """The signals that an instruction with a process sets and waits for."""
    word = call.word.lower()
    kind = (
        "paint"
        if word == table.BRUSH_INSTRUCTION
        else PROCESS_MOVES[word].kind
        if word in PROCESS_MOVES
        else ""
    )
    for gun in guns(call):
        yield gun.name + table.PROGRAM_SUFFIX, table.GROUP_OUTPUT
        yield gun.name + table.START_SUFFIX, table.DIGITAL_OUTPUT
        yield gun.name + table.READY_SUFFIX, table.DIGITAL_INPUT
    yield from ((name, table.DIGITAL_OUTPUT) for name in retracting(call))
    yield from _PROCESS_SIGNALS.get(kind, ())


_PROCESS_SIGNALS: Final[Mapping[str, tuple[tuple[str, Signal], ...]]] = {
    "arc": ((table.ARC_OUTPUT, table.DIGITAL_OUTPUT),),
    "bead": (
        (table.DISPENSE_OUTPUT, table.DIGITAL_OUTPUT),
        (table.BEAD_OUTPUT, table.GROUP_OUTPUT),
    ),
    "paint": ((table.BRUSH_OUTPUT, table.GROUP_OUTPUT),),
}


_SIGNAL_TYPES: Final = {
    f"signal{letter}{way[0]}": Signal(kind, way)  # type: ignore[arg-type]
    for letter, kind in (("d", "digital"), ("g", "group"), ("a", "analog"))
    for way in ("input", "output")
}
"""By type of data, what a signal is."""


def signals_in(
    statements: Iterable[p.Statement], known: Callable[[str], bool]
) -> Iterator[tuple[str, Signal]]:
    """Yield the signals that vendor statements name. known: returns True for a lower-case name of
    other data.
    """
    for statement in statements:
        if isinstance(statement, p.Opaque) and statement.language == verbatim.LANGUAGE:
            read = verbatim.understood(
                verbatim.error_handlers, statement.text
            ) or verbatim.understood(verbatim.statements, statement.text)
            for node in nodes(read or ()):
                if isinstance(node, s.ProcedureCall):
                    # A name of other data may stand for any signal.
                    yield from (
                        (n, x) for n, x in _instruction_signals(node) if not known(n.lower())
                    )


def _instruction_signals(call: s.ProcedureCall) -> Iterator[tuple[str, Signal]]:
    found = signature(call.name) if isinstance(call.name, str) else None
    if isinstance(call.name, str) and (known := called(call)) is not None:
        yield from process_signals(known)
    if found is None:
        return
    required = iter(found.required)
    named = {q.name.lower(): q.type for slot in found.slots for q in slot.alternatives}
    for argument in call.arguments:
        types: tuple[str, ...] = ()
        match argument:
            case s.Positional(_, None):
                slot = next(required, None)
                types = tuple(q.type for q in slot.alternatives) if slot else ()
            case s.Positional(_, str(name)) | s.Option(name, _):
                types = (named.get(name.lower(), ""),)
        value = getattr(argument, "value", None)
        if isinstance(value, s.NameRef) and len(types) == 1 and types[0] in _SIGNAL_TYPES:
            yield value.name, _SIGNAL_TYPES[types[0]]


_STANDSTILL_WAITS: Final = {
    ("waitrob", "inpos"), ("waitrob", "zerospeed"), ("waittime", "inpos"), ("waituntil", "inpos")
}  # fmt: skip
"""Instructions behind which the robot stands at its target, with their options (RAPID manual)."""


def vendor_steps(text: str) -> Sequence[MotionStep] | None:
    """None for what is no list of statements: an error handler, for one, which may move."""
    read = verbatim.understood(verbatim.statements, text)
    return None if read is None else [_vendor_step(node) for node in read]


def _vendor_step(node: s.StatementNode) -> MotionStep:
    """`ConfL` without an option watches configurations (RAPID reference manual)."""
    match node:
        case s.Data():
            return MotionStep.NOTHING
        case s.ProcedureCall(str(name), arguments):
            given = option_names(arguments)
            if name.lower() == "confl":
                return MotionStep.OPENS if "off" in given else MotionStep.WATCHES
            if any((name.lower(), one) in _STANDSTILL_WAITS for one in given):
                return MotionStep.STOPS
            known = signature(name)
            if known is None:
                return MotionStep.CALLS
            # A routine that is not listed in full may move with the tool that it is given.
            slots = () if known.open else known.slots
            tools = any(q.type == "tooldata" for slot in slots for q in slot.alternatives)
            return MotionStep.MOVES if known.open or tools else MotionStep.NOTHING
    return MotionStep.CALLS


def option_names(arguments: Iterable[s.Argument]) -> list[str]:
    """Names of the options among arguments, in lower case."""
    return [one.name.lower() for one in arguments if isinstance(one, s.Option)]


_DEPENDS_ON_PATH: Final = e.Reason(
    "it reads in the tool and work object of the move before, which the program does not tell",
    r"write both, as `CRobT(\Tool:=tool0\WObj:=wobj0)`",
)


def with_places(program: Program, original: Callable[[str], str] = str) -> Program:
    """The program with the tool and frame of each `CRobT` that leaves them to the move before.

    One that differs with the way stays as its text. original: gives a shortened name back.
    """
    return with_present_places(
        program, _reads_position, _with_explicit_frames(original), vendor_steps
    )


def with_active_tool_frame(program: Program) -> tuple[Program, list[Span | None]]:
    """Do the same for another language, with variables for a tool or frame that differs between
    branches.

    Also return the positions of reads that may precede the first move, with the flange and the
    base.
    """
    return with_active_places(program, _reads_position, _with_explicit_frames(str), vendor_steps)


def _with_explicit_frames(original: Callable[[str], str]) -> Said:
    expressions = Expressions(original)

    def said(x: e.Expression, tool: str | None, frame: str | None) -> e.Expression:
        assert isinstance(x, e.Verbatim)
        call = called(verbatim.expression(x.text))
        found = None if call is None else expressions.reading.fields(CURRENT_TARGET, call)
        where = {"tool": tool, "frame": frame, **(found or {})}
        if found is None or None in where.values():
            return replace(x, reason=_DEPENDS_ON_PATH)
        return e.Here(tool_name(where["tool"]), frame_name(where["frame"]))

    return said


def _reads_position(record: Any) -> bool:
    match record:
        case e.Verbatim(verbatim.LANGUAGE, text):
            return text.lower().startswith("crobt(")
    return False
