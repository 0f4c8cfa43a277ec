r"""A program of RAPID as other languages are told it.

Instructions that say what a controller does anyway, or what changes no motion, are left out, with
a finding where an effect is lost. Waits for the robot to stop become stops at its targets, rows
of tables of tools and work objects tools and frames of their own, and predefined variables
variables of the program. RAPID itself keeps all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.language import Adapted
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.data import numbers
from assistant.languages.rapid.lift.instructions import Meaning, instruction
from assistant.languages.rapid.lift.program import routines
from assistant.languages.rapid.lift.switches import with_switches
from assistant.languages.rapid.lift.ways import options, stands_at_target, steps
from assistant.languages.rapid.tables.predefined import data as predefined
from assistant.languages.rapid.tables.words import VALUE_OF_TYPE
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.records import frame_of, tool_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import names_in
from assistant.program.analysis.ways import CORNER, STOP, UNKNOWN, Ways, corner_of
from assistant.program.diagnostics import Findings
from assistant.program.geometry import Frame, Tool
from assistant.program.motion import FINE
from assistant.program.passes.open_lines import with_open_lines
from assistant.program.program import Procedure, Program, Variable, identifier, walk
from assistant.program.rewriting import Body, map_bodies, records, rewrite

if TYPE_CHECKING:
    from assistant.robots import Robot

NOTHING: Final = {
    "confj", "confj on", "confl", "confl on", "singarea", "singarea off", "gripload load0",
    "cornerpathwarning true", "cornerpathwarning false",
}  # fmt: skip
"""Instructions that set what holds anyway, or concern the controller's own log alone.

With their options and arguments, in lower case (RAPID reference manual: ConfJ, ConfL, SingArea,
GripLoad)."""

LOSSES: Final[Mapping[str, tuple[str, str]]] = {
    "tperase": ("what stands on the teach pendant stays there", "none is needed"),
    "confl off": (
        "straight moves go on in the configuration that they begin in, whatever their targets "
        "state; another controller may stop where they state another",
        "state the configurations that the arm really takes, or name it with --robot",
    ),
}
"""What is lost with an instruction, and what to do about it."""

WRIST: Final = "singarea wrist"
_TURNED: Final = (
    "the tool keeps its orientation on straight moves and arcs: with a straight wrist the arm "
    "stops, where RAPID turns the tool a little",
    "see that no move passes a straight wrist",
)

REASONS: Final[Mapping[str, e.Reason]] = {
    "confj off": e.Reason(
        "joint moves take the nearest turn of the wrist, whatever their targets state",
        "teach the configurations that the arm takes, and leave it out",
    ),
    WRIST: e.Reason(
        "where the wrist is straight the tool is turned a little, and where that is, depends on "
        "the arm",
        "name the arm that will run the program: `--robot`",
    ),
}
IN_CORNER: Final = e.Reason(
    "the robot may be in a corner there, and would stop in it", "write `fine` for the moves before"
)

NEAR: Final = frozenset(("inpos20", "inpos50", "inpos100"))
"""Predefined stop points: the robot stops at its target, with more or less patience."""


def exported(program: Program, arm: Robot | None) -> Adapted:
    """The program for another language. arm: that will run it, None if it is not known."""
    findings = Findings()
    program = _with_rows(with_switches(program, routines))
    if any(_is_text(record) for record in records(program.procedures)):
        program = _with_plain_moves(program, findings)
        if arm is not None:
            program = with_open_lines(program, steps)
        program = _with_stops(program, arm, findings)
    return Adapted(_with_predefined(program), tuple(findings))


def _is_text(record: Any) -> bool:
    return isinstance(record, p.Opaque) and record.language == verbatim.LANGUAGE


def _call(node: p.Statement) -> s.ProcedureCall | None:
    """The one instruction that a text of RAPID says."""
    if not isinstance(node, p.Opaque) or node.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.statements, node.text):
        case (s.ProcedureCall(name=str()) as call,):
            return call
    return None


def _key(call: s.ProcedureCall) -> str:
    """Name, options and plain arguments, as the tables have them."""
    words = [str(call.name), *options(call.arguments)]
    for argument in call.arguments:
        match argument:
            case s.Positional(s.NameRef(name), None):
                words.append(name)
            case s.Positional(s.BoolLiteral(value), None):
                words.append(str(value))
    return " ".join(words).lower()


# ------------------------------------------------------------------------------ instructions


def _with_stops(program: Program, arm: Robot | None, findings: Findings) -> Program:
    """Without instructions that other languages need no word for."""
    ways = Ways(program, _is_text, steps)
    stopping = _stopping(program, ways)

    def said(owner: Procedure, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            call = _call(node)
            with findings.at(node.span):
                if isinstance(node, p.MoveStatement):
                    made.append(_stop(node) if corner_of(node) in stopping else node)
                elif call is None:
                    made.append(map_bodies(node, lambda inner: said(owner, inner)))
                elif stands_at_target(call):
                    stopped = not ways.at(owner, node)[CORNER] - {STOP} - stopping
                    made += _waiting(node, call) if stopped else [_because(node, IN_CORNER)]
                else:
                    made += _instruction(node, _key(call), arm, findings)
        return tuple(made)

    bodies = ((q, said(q, q.body)) for q in program.procedures)
    return replace(program, procedures=tuple(replace(q, body=body) for q, body in bodies))


def _stopping(program: Program, ways: Ways) -> set[str]:
    """Corners that no move goes through, because the program waits for the robot in all of them."""
    found: set[str] = set()
    for procedure in program.procedures:
        for node in walk(procedure.body):
            call = _call(node)
            if call is not None and stands_at_target(call):
                found |= ways.at(procedure, node)[CORNER]
    return found - ways.cut - {UNKNOWN, STOP}


def _stop(move: p.MoveStatement) -> p.Statement:
    return replace(move, motion=replace(move.motion, blend=FINE))


def _instruction(
    node: p.Statement, key: str, arm: Robot | None, findings: Findings
) -> Iterator[p.Statement]:
    losses = LOSSES if arm is None else {**LOSSES, WRIST: _TURNED}
    if key in losses:
        loss, cure = losses[key]
        findings.append(rules.LEFT_OUT(what=_shown(node), loss=loss, cure=cure))
    elif key in REASONS:
        yield _because(node, REASONS[key])
    elif key not in NOTHING:
        yield node


def _because(node: p.Statement, reason: e.Reason) -> p.Statement:
    return replace(node, reason=reason) if isinstance(node, p.Opaque) else node


def _shown(node: p.Statement) -> str:
    return node.text.rstrip(";") if isinstance(node, p.Opaque) else ""


def _waiting(node: p.Statement, call: s.ProcedureCall) -> Iterator[p.Statement]:
    """What is left of a wait for the robot to stand still: the time to wait there."""
    plain = tuple(one for one in call.arguments if not isinstance(one, s.Option))
    waiting = instruction(replace(call, arguments=plain), Meaning())
    if waiting is not None:
        yield replace(waiting, span=node.span)


# ------------------------------------------------------------------------------------- moves


def _with_plain_moves(program: Program, findings: Findings) -> Program:
    r"""With the moves that state `\Inpos` as moves that stop."""

    def plain(record: Any) -> Any:
        call = _call(record) if _is_text(record) else None
        near = None if call is None else _near(call)
        if call is None or near is None:
            return record
        move = instruction(near, Meaning())
        if not isinstance(move, p.MoveStatement):
            return record
        with findings.at(record.span):
            findings.append(rules.LEFT_OUT(
                what=r"\Inpos", loss="how near to its target the robot counts as being there",
                cure="none is needed where it stops",
            ))  # fmt: skip
        return replace(_stop(move), span=record.span)

    return replace(program, procedures=rewrite(program.procedures, plain))


def _near(call: s.ProcedureCall) -> s.ProcedureCall | None:
    r"""A move without its `\Inpos`, None if it has none that is known."""
    found = [one for one in call.arguments if _is_stop_point(one)]
    rest = tuple(one for one in call.arguments if one not in found)
    return replace(call, arguments=rest) if found else None


def _is_stop_point(argument: s.Argument) -> bool:
    match argument:
        case s.Option(option, s.NameRef(name)):
            return option.lower() == "inpos" and name.lower() in NEAR
    return False


# ------------------------------------------------------------------------------------ tables


@dataclass(slots=True)
class _Tables:
    """Tables of tools and work objects that nothing changes, by lower-case name.

    named: names of the rows that are used, by table and place from 1.
    """

    rows: dict[str, list[Tool | Frame]] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)
    named: dict[tuple[str, int], str] = field(default_factory=dict)

    def name(self, table: str, place: int) -> str:
        key = table.lower(), place
        if key not in self.named:
            self.named[key] = identifier(f"{table}_{place}", self.taken)
            self.taken.add(self.named[key].lower())
        return self.named[key]

    def plain(self, call: s.ProcedureCall) -> s.ProcedureCall:
        """With the rows that are named by a number as data of their own."""

        def change(part: Any) -> Any:
            match part:
                case s.Element(s.NameRef(table), (index,)) if table.lower() in self.rows:
                    place = None if isinstance(index, s.Whole) else literal_number(index)
                    if isinstance(place, int) and 0 < place <= len(self.rows[table.lower()]):
                        return s.NameRef(self.name(table, place))
            return part

        return rewrite(call, change, ())


def _with_rows(program: Program) -> Program:
    """With the rows of tables that moves use as tools and frames."""
    tables = _Tables(_rows(program), _names(program))
    if not tables.rows:
        return program

    def plain(record: Any) -> Any:
        call = _call(record) if _is_text(record) else None
        changed = None if call is None else tables.plain(call)
        if changed is None or changed is call:
            return record
        move = instruction(changed, Meaning())
        return record if move is None else replace(move, span=record.span)

    procedures = rewrite(program.procedures, plain)
    left = {name.lower() for name in names_in(procedures)} & tables.rows.keys()
    if left:  # something else reads or changes it
        return program
    rows = {name: tables.rows[table][at - 1] for (table, at), name in tables.named.items()}
    kept = tuple(d for d in program.declarations if _table(d.text)[0] not in tables.rows)
    return replace(
        program,
        procedures=procedures,
        declarations=kept,
        tools={**program.tools, **{n: v for n, v in rows.items() if isinstance(v, Tool)}},
        frames={**program.frames, **{n: v for n, v in rows.items() if isinstance(v, Frame)}},
    )


def _rows(program: Program) -> dict[str, list[Tool | Frame]]:
    found = {}
    for declaration in program.declarations:
        name, rows = _table(declaration.text)
        if rows and all(row is not None for row in rows):
            found[name] = [row for row in rows if row is not None]
    return found


ROW_OF: Final[Mapping[str, Callable[[Any], Tool | Frame | None]]] = {
    "tooldata": tool_of,
    "wobjdata": frame_of,
}


def _table(text: str) -> tuple[str, list[Tool | Frame | None]]:
    """The lower-case name and the rows of a table that a declaration says, else nothing."""
    match verbatim.understood(verbatim.items, text):
        case (s.Data(type=type, name=str(name), dimensions=(_,), value=s.AggregateNode(values)),):
            row = ROW_OF.get(type.lower())
            if row is not None:
                return name.lower(), [row(numbers(value)) for value in values]
    return "", []


def _names(program: Program) -> set[str]:
    tables: tuple[Mapping[str, Any], ...] = (program.tools, program.frames, program.variables)
    tables = (*tables, program.targets, program.joint_targets, program.signals)
    names = {name for table in tables for name in table} | {q.name for q in program.procedures}
    names |= {name for q in program.procedures for name in q.variables}
    return {name.lower() for name in names}


# --------------------------------------------------------------------------------- variables


def _with_predefined(program: Program) -> Program:
    """With the variables that every controller has, where the program declares none."""
    declared = _names(program) | {q.name.lower() for r in program.procedures for q in r.parameters}
    found = {}
    for name in names_in(program.procedures):
        known = predefined().get(name.lower())
        if known is not None and known.storage == "VAR" and name.lower() not in declared:
            type = VALUE_OF_TYPE.get(known.type)
            if type is not None:
                found[known.name] = Variable(type)
    return replace(program, variables={**program.variables, **found}) if found else program
