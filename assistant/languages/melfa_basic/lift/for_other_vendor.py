"""Lower what only MELFA-BASIC has, so that another language can express the program.

Statements that tune, watch or power the arm change no target and no order, so they are left out,
with a finding where an effect is lost. MELFA-BASIC itself keeps all of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Findings
from assistant.languages.language_types import Adapted
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lift.angle_units import with_degrees
from assistant.languages.melfa_basic.lift.position_angles import with_angles_beside, with_flags
from assistant.languages.melfa_basic.lift.vendor_only import is_end, with_endings, with_told
from assistant.languages.melfa_basic.reading.line import statement as read_statement
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.vendor_statements import DEPENDED_ON
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.analysis.motion_use import left_settings
from assistant.program.passes.jumps import without_needless_jumps
from assistant.program.program import (
    Declaration,
    Procedure,
    Program,
    labels_in_texts,
    last_statement,
    walk,
)
from assistant.program.rewriting import (
    Body,
    head,
    map_bodies,
    records,
    rewrite,
    with_vendor_statements_replaced,
)
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

_NO_NEED: Final = "none is needed, but see that the other controller watches the arm as you want"
_ARM_OF_PROGRAM: Final = (
    "the arm is the program's own: on the other controller a motion task has it",
    "see that no other task moves it",
)
_LOSSES: Final[Mapping[str, tuple[str, str]]] = {
    "SERVO ON": (
        "the program does not switch the motors on: they must be on when it starts",
        "switch them on before, as the operator or the cell's controller",
    ),
    "SERVO OFF": (
        "the motors stay on: the arm is held by them, not by its brakes",
        "switch them off as the operator or the cell's controller, before anybody goes near",
    ),
    "LOADSET": (
        "the load of hand and work piece is not chosen for the tuning of the arm",
        "state it in the data of the tool, or as the load that the arm holds",
    ),
    "OADL": ("accelerations are not fitted to the load in this way", "state the load of the tool"),
    "FINE": (
        "how near to its target the robot counts as being there",
        "none is needed where it stops: the other controller has its own tolerance",
    ),
    "PREC": ("the path is not followed more exactly than usual", "move slower there"),
    "MVTUNE": ("moves are not tuned for speed or for accuracy", "none is needed"),
    "SPDOPT": ("the speed is not raised where the axes could go faster", "none is needed"),
    "COLCHK": ("collisions are watched for as the other controller is set", _NO_NEED),
    "COLLVL": ("collisions are watched for as the other controller is set", _NO_NEED),
    "GETM": _ARM_OF_PROGRAM,
    "RELM": _ARM_OF_PROGRAM,
    "PRIORITY": (
        "the program gets no other share of the controller's time",
        "none is needed, but see that nothing beside it comes too late",
    ),
    "TITLE": ("the pendant shows no title", "none is needed"),
    "CAVCHK": ("common areas are not watched for by the program", "let the cell watch them"),
}  # fmt: skip
"""Loss with each command, by its word and the argument that decides it, and the cure (COSIROP help
and manual CR1D: Servo, LoadSet, Oadl, Fine, Prec, ColChk).
"""

_STOPPING_ERROR: Final = re.compile(r"Error\s+(9[01]\d\d)", re.IGNORECASE)
"""An error of the program's own that stops it; from 9200 on they are cautions (COSIROP: ERROR)."""
_CAUTION_ERROR: Final = re.compile(r"Error\s+(92\d\d)", re.IGNORECASE)
_CAUTIONED: Final = (
    "the caution is a message on the pendant, and no caution on the controller",
    "tell people or the cell's controller by an output above it",
)
_STOPPED: Final = (
    "the program ends there for good, with a message on the pendant and no error on the controller",
    "tell people or the cell's controller by an output above it",
)
_LINE_STATEMENT: Final = re.compile(
    r'C_Com\((\d+)\)\s*=\s*"ETH:\s*(\d+(?:\.\d+){3})\s*,\s*(\d+)\s*"', re.IGNORECASE
)
"""The line that a program states itself, the address of the other computer and its port (manual of
the Ethernet function)."""
_SIGNED_BITS: Final = (16, 32)
"""Signals that are read as one number with a sign, or without one: no manual says which."""
_STIFF_ALREADY: Final = (
    "the arm is taken to be stiff already, as nothing in the program makes it soft",
    "see that no other program does",
)
_STIFFNESS_WORDS: Final[Mapping[str, re.Pattern[str]]] = {
    "CMP": re.compile(r"\bCmp\s+(Jnt|Pos|Tool)\b", re.IGNORECASE),
    "CMPG": re.compile(r"\bCmp\s+(Jnt|Pos|Tool)\b", re.IGNORECASE),
    "FSC": re.compile(r"\bFsc\s+On\b", re.IGNORECASE),
}
"""By the word of a command about the softness of the arm, the pattern of the command that makes the
arm soft.
"""


def exported(program: Program) -> Adapted:
    """The program for another language; idempotent."""
    findings = Findings()
    findings += _uncalled(program)
    findings += _of_unknown_sign(program)
    findings += _left_open(program)
    program = _with_first_settings(with_flags(_with_stated_lines(program)))
    program = _with_errors_shown(with_told(program, findings), findings)
    program = without_needless_jumps(with_endings(_without_needless_ends(program)))
    program = _with_settings_of_cycle_end(program)
    program = with_degrees(with_angles_beside(program, findings), findings)
    texts = [record.text for record in records(program) if _is_vendor_text(record)]
    if not texts:
        return Adapted(program, tuple(findings))
    # Nothing in the program makes the arm soft, so commands that end softness change nothing.
    stiff = {key for key, soft in _STIFFNESS_WORDS.items() if not any(map(soft.search, texts))}
    losses = {**_LOSSES, **dict.fromkeys(stiff, _STIFF_ALREADY)}

    def told(node: p.Opaque) -> Iterator[p.Statement]:
        if node.reason == DEPENDED_ON and _is_vendor_text(node):
            return  # the moves that are translated state their settings themselves
        loss = losses.get(_loss_key(node))
        if loss is None:
            yield node
            return
        with findings.at(node.span):
            what, cure = loss
            findings.append(rules.LEFT_OUT(what=node.text.strip(), loss=what, cure=cure))

    return Adapted(with_vendor_statements_replaced(program, told), tuple(findings))


def _with_errors_shown(program: Program, findings: Findings) -> Program:
    """The program with a message in place of each error, and an end for good where that stops."""

    def told(node: p.Opaque) -> Iterator[p.Statement]:
        stops = _STOPPING_ERROR.fullmatch(node.text.strip()) if _is_vendor_text(node) else None
        caution = _CAUTION_ERROR.fullmatch(node.text.strip()) if _is_vendor_text(node) else None
        if stops is None and caution is None:
            yield node
            return
        with findings.at(node.span):
            what, cure = _STOPPED if stops else _CAUTIONED
            findings.append(rules.LEFT_OUT(what=node.text.strip(), loss=what, cure=cure))
        if stops:
            yield p.Message((e.Text(f"error {stops[1]}"),), span=node.span)
            yield p.Stop(end=True, span=node.span)
        if caution:
            yield p.Message((e.Text(f"caution {caution[1]}"),), span=node.span)

    return with_vendor_statements_replaced(program, told)


def _without_needless_ends(program: Program) -> Program:
    """The program without the `End`, `Return` or `GoTo` that an end for good is followed by.

    Other statements stay, whose author expects them to run: the checks report them.
    """

    def settled(one: Procedure) -> Procedure:
        # A jump that is left out may have been the only one to its label.
        while (made := _Reached(one).procedure()) != one:
            one = made
        return one

    # A function has to have a result at its end, reached or not.
    procedures = (one if one.result is not None else settled(one) for one in program.procedures)
    return replace(program, procedures=tuple(procedures))


class _Reached:
    """The statements of a procedure that control reaches, and what follows an end for good."""

    def __init__(self, whole: Procedure) -> None:
        self.whole = whole
        jumps = {one.label for one in walk(whole.body) if isinstance(one, p.Goto)}
        self.entered = jumps | labels_in_texts(whole.body)

    def procedure(self) -> Procedure:
        return replace(self.whole, body=self.body(self.whole.body))

    def body(self, statements: Body) -> Body:
        made: list[p.Statement] = []
        dead = False
        # Comments in front of statements that are left out stay.
        for one in statements:
            dead = dead and not (isinstance(one, p.Label) and one.name in self.entered)
            if not dead:
                made.append(map_bodies(one, self.body))
                dead = _ends_for_good(one)
            elif isinstance(one, p.Return | p.Goto) or is_end(one):
                # Behind statements that stay, the procedure would run into the lines below.
                above = last_statement(made)
                if not (_ends_for_good(above) or isinstance(above, p.Return)):
                    made.append(p.Return(span=one.span) if is_end(one) else one)
            elif not isinstance(one, p.Label):
                made.append(one)
        return tuple(made)


def _ends_for_good(node: p.Statement | None) -> bool:
    return isinstance(node, p.Stop) and node.end


def _with_stated_lines(program: Program) -> Program:
    """The program with clients for the lines that it states one address of."""
    texts = [
        match for one in records_in_procedures(program, p.Opaque) if (match := _stated_line(one))
    ]
    if not texts:
        return program
    ends: dict[int, set[tuple[str, int]]] = {}
    for match in texts:
        ends.setdefault(int(match[1]), set()).add((match[2], int(match[3])))
    # A line with two addresses is not known to connect to one of them.
    known = {line: next(iter(found)) for line, found in ends.items() if len(found) == 1}

    def opened(part: Any) -> Any:
        match part:
            case p.Attach(kind="line", place=(e.Number(number),)) if number in known:
                address, port = known[int(number)]
                return replace(part, kind="client", place=(e.Text(address), e.Number(port)))
        return part

    def left(node: p.Opaque) -> Iterator[p.Statement]:
        match = _stated_line(node)
        if match is None or int(match[1]) not in known:
            yield node

    return with_vendor_statements_replaced(rewrite(program, opened), left)


def _stated_line(node: p.Opaque) -> re.Match[str] | None:
    return _LINE_STATEMENT.fullmatch(node.text.strip())


def _with_settings_of_cycle_end(program: Program) -> Program:
    """With the settings at the top that a cycle ends with, as other controllers keep them then.

    The end of a program in MELFA-BASIC sets speeds and accelerations back (COSIROP: END).
    """
    entry = program.procedure(program.entry) if program.entry else None
    settings = left_settings(program, entry) if entry is not None else ()
    if entry is None or not settings:
        return program
    begun = replace(entry, body=(*settings, *entry.body))
    procedures = tuple(begun if one is entry else one for one in program.procedures)
    return replace(program, procedures=procedures)


def _with_first_settings(program: Program) -> Program:
    """With the variables that hold settings at what a cycle begins with: its end sets them back."""
    held = {
        told.target.name
        for one in records_in_procedures(program, p.Opaque)
        if one.reason == DEPENDED_ON
        for told in one.told
        if isinstance(told, p.Assign) and isinstance(told.target, e.Name)
    }
    begun = [
        p.Assign(e.Name(name), variable.initial)
        for name, variable in program.variables.items()
        if name in held and variable.initial is not None
    ]
    entry = program.procedure(program.entry) if program.entry else None
    if entry is None or not begun:
        return program
    made = replace(entry, body=(*begun, *entry.body))
    procedures = tuple(made if one is entry else one for one in program.procedures)
    return replace(program, procedures=procedures)


def _uncalled(program: Program) -> Iterator[Diagnostic]:
    """Procedures that move and that nothing calls, where something else runs."""
    entry = (program.entry or "").lower()
    called = {entry}
    for record in records((program.procedures, program.declarations)):
        match record:
            case p.Call(name) | e.Apply(name):
                called.add(name.lower())
            case p.Opaque() | e.Verbatim() | Declaration():
                called |= effect_of(record).names
    for procedure in program.procedures if entry else ():
        if procedure.name.lower() not in called and procedure.unit is None:
            if any(isinstance(node, p.Moving) for node in walk(procedure.body)):
                yield rules.UNCALLED(name=procedure.name, span=procedure.span)


def _left_open(program: Program) -> Iterator[Diagnostic]:
    """Calls of subroutines that may come to the same call again before they return."""
    calls = {
        q.name: [x for x in walk(q.body) if isinstance(x, p.Call) and x.unit is None]
        for q in program.procedures
        if not q.parameters and q.result is None
    }
    for name, made in calls.items():
        for call in made:
            reached = reachable(
                [call.procedure], lambda one: (x.procedure for x in calls.get(one, ()))
            )
            if name in reached and call.span is not None:
                yield rules.LEFT_OPEN(name=call.procedure, span=call.span)


def _of_unknown_sign(program: Program) -> Iterator[Diagnostic]:
    """Statements that read as many signals as the manuals leave the sign of open for."""
    wide = {n.lower(): s.bits for n, s in program.signals.items() if s.bits in _SIGNED_BITS}
    if not any(
        one.direction == "input" for one in program.signals.values() if one.bits in _SIGNED_BITS
    ):
        return
    for statement in program.statements():
        read = (r.name.lower() for r in records(head(statement)) if isinstance(r, e.Name))
        for name in dict.fromkeys(one for one in read if one in wide):
            if statement.span is not None:
                yield rules.UNSIGNED(name=name, bits=wide[name], span=statement.span)


def _is_vendor_text(record: Any) -> bool:
    kept = isinstance(record, p.Opaque | e.Verbatim | Declaration)
    return kept and record.language.startswith("melfa-basic")


def _loss_key(node: p.Opaque) -> str:
    """The word of the one command that a text says, with `On` or `Off` where it is about motors."""
    # A text of several lines is no single command.
    line = read_statement(node.text) if _is_vendor_text(node) and "\n" not in node.text else None
    if line is None or line.label is not None or not isinstance(line.statement, s.Command):
        return ""
    word, arguments = line.statement.keyword.upper(), line.statement.arguments
    match arguments:
        case (s.Word(text=way) | s.Variable(name=way), *_) if word == "SERVO":
            return f"{word} {way.upper()}"
    return word
