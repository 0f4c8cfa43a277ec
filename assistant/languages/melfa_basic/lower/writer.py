"""The code lines of one unit as they are written, and what is known where the writing is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

from assistant.base.diagnostics import Declared, Diagnostic, Findings, Span
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.expressions import (
    Expressions,
    NoNumber,
    Undeclared,
    Unsayable,
    signed_number,
)
from assistant.languages.melfa_basic.lower.mounts import MOUNT_WORDS, RESTING, mount_keeper
from assistant.languages.melfa_basic.lower.names import Names
from assistant.languages.melfa_basic.tables.dialects import EMITTED_LINE, Dialect
from assistant.languages.melfa_basic.tables.equivalents import ARM_FUNCTIONS
from assistant.languages.melfa_basic.text.printer import line
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import block_word, statement_of
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import base_variable, texts_in
from assistant.program.geometry import BASE, FLANGE
from assistant.program.motion import Blend, Path, Speed
from assistant.program.passes.procedure_forms import has_functions, procedures_of
from assistant.program.program import Parameter, Procedure, Program, Variable, bodies, walk
from assistant.program.rewriting import head, records
from assistant.program.vendor_statements import effect_of

if TYPE_CHECKING:
    from assistant.robots import Robot


def marked(comment: p.Comment) -> str:
    return f"' {comment.text}" if comment.text else "'"


def _opens(item: s.Item) -> bool:
    """True if a line is the first of a block, so that its comment belongs to the block."""
    match item:
        case s.Line(statement=s.If(then=None) | s.For() | s.Command(keyword="While")):
            return True
    return False


_LACKING: Final[Mapping[bool, tuple[str, str]]] = {
    True: (
        "is declared, with a type that nothing in MELFA-BASIC is like",
        "write the statement without it",
    ),
    False: (
        "is declared in none of the files that were read",
        "give the file that declares it as well, or write the statement without it",
    ),
}
"""What a name lacks and the cure, by whether the source declares it."""


def _leaves_arm(statement: p.Statement) -> bool:
    """True if neither a statement nor what it holds moves the arm, apart from functions."""
    return all(isinstance(one, RESTING) for one in walk((statement,)))


def _may_end_in_corner(statement: p.Statement) -> bool:
    """True if a statement may leave the arm in the corner of a motion."""
    match statement:
        case p.Move(motion=motion) | p.MoveCircular(motion=motion) | p.MoveJoints(motion=motion):
            return not (isinstance(motion.blend, Blend) and motion.blend.fine)
        case p.Follow(path):
            return not all(isinstance(blend, Blend) and blend.fine for blend in path.blends)
        case p.Opaque():
            return True
    return False


class Writer:
    """Writes the procedures of a unit.

    unit: None for the main one. write: how each kind of statement is written. functions: True if
    procedures are `Function` blocks. items: code lines without step numbers. paths: first position
    number and path of each `Follow`. used: names that the unit's code refers to. shared: the
    program's constants that a unit needs a copy of. findings: constructs without equivalent.
    wanting: see `Adapted`.
    """

    write: ClassVar[Mapping[type, Callable[[Any, Any], None]]] = {}

    def __init__(
        self,
        program: Program,
        dialect: Dialect,
        names: Names,
        robot: Robot | None,
        unit: str | None,
    ) -> None:
        self.program, self.dialect, self.names = program, dialect, names
        self.robot, self.unit = robot, unit
        self.functions = has_functions(program, unit, dialect.functions)
        self.items: list[s.Item] = []
        self.paths: list[tuple[int, Path]] = []
        self.findings, self.wanting = Findings(), list[Diagnostic]()
        self.state: dict[str, object] = {}
        """Active value of each setting by its word, where known."""
        self.settings: set[int] = set()
        """Lines that set what a statement needs, by their identity."""
        self.previous: tuple[s.Expression, str, str] | None = None
        """Position, tool and frame of the move before, if that is known and stays as it is."""
        self.rounds = any(map(_may_end_in_corner, program.statements()))
        """True if a motion of the program may end with a corner."""
        self.interrupted = any(isinstance(one, p.Interrupt) for one in program.statements())
        self.stands = not self.rounds
        """True if the arm surely stands, whichever way led here."""
        self.parts: list[tuple[Procedure, int]] = []
        """Procedures with the index of their first line."""
        self.remounts = False
        """True if a line gives a tool or frame another value."""
        self.answers: list[p.Interrupt] = []
        """Interrupts whose lines follow the end of the program."""
        self.number = names.position
        self.made = 0
        self.spans: dict[int, Span] = {}
        """Source span of the statement that each written line is from, by the identity of the
        line.
        """
        self._at: Span | None = None
        self._noted = 0
        self._inner: int | None = None
        """Index where the first body of the statement being written begins."""
        self.owner: Procedure | None = None
        self.expressions = Expressions(program, dialect, names, robot, self.next_number)
        self.used, self.shared = self._used()
        self.elsewhere = {name for d in program.declarations for name in effect_of(d).names}
        lifted = () if program.origin is None else program.origin.lifted.declarations
        self.declared = self.elsewhere | {name for d in lifted for name in effect_of(d).names}
        """Words of declarations that were refused already: what they declare is no news."""
        self.mounts = {name.lower() for name in (*program.tools, *program.frames)}
        """Tools and frames, which are no values here."""
        self.keeps_mounts = mount_keeper(program)

    def _used(self) -> tuple[set[str], list[str]]:
        """Names that the unit refers to: targets, tools and frames; shared constants."""
        if self.unit is None:
            return set(), []
        mine = tuple(q for q in self.program.procedures if q.unit == self.unit)
        named = texts_in(mine)
        n = self.names
        used = {
            table[w]
            for table in (n.targets, n.joints, n.tools, n.frames)
            for w in named
            if w in table
        }
        return used, [v for v in self.program.variables if v.lower() in named]

    def procedures(self) -> tuple[Procedure | None, list[Procedure]]:
        """The one that the unit begins with, and the others."""
        return procedures_of(self.program, self.unit)

    def variables(self) -> Iterator[tuple[str, str, Variable | Parameter]]:
        """Owner (a procedure's name in lower case or empty), name and variable."""
        for name in self.program.variables if self.unit is None else self.shared:
            yield "", name, self.program.variables[name]
        for procedure in self.program.procedures:
            if procedure.unit == self.unit:
                for parameter in procedure.parameters:
                    yield procedure.name.lower(), parameter.name, parameter
                for name, variable in procedure.variables.items():
                    yield procedure.name.lower(), name, variable

    # ------------------------------------------------------------------------- findings

    def report(self, finding: Diagnostic) -> None:
        self.findings.append(finding)

    def cannot(self, what: str, cure: str, about: Declared | None = None) -> None:
        if about is None and self.owner is not None:
            about = Declared(self.owner.name, "procedures", in_full=True)
        self.report(rules.CANNOT_SAY(what=what, cure=cure, about=about))

    @contextmanager
    def saying(self, about: Declared | None = None) -> Iterator[None]:
        """Turn a construct without equivalent in this context into a finding."""
        try:
            yield
        except NoNumber as signal:
            self.report(rules.NO_NUMBER(name=signal.what, about=about))
        except Undeclared as name:
            if name.what.lower() in self.mounts:
                self.cannot(
                    f"`{name.what}` as a value, which is a tool or frame",
                    "declare one for each value that it has, and name these in the moves",
                    about,
                )
            else:
                what, cure = _LACKING[name.what.lower() in self.declared]
                finding = rules.UNDECLARED(name=name.what, what=what, cure=cure, about=about)
                known = name.what.lower() in self.elsewhere
                (self.wanting if known else self.findings).append(self.findings.placed(finding))
        except Unsayable as unsayable:
            self.cannot(unsayable.what, unsayable.cure, about)

    # ---------------------------------------------------------------------------- lines

    def add(self, statement: s.Statement) -> None:
        self.items.append(s.Line(statement=statement))

    def label(self, name: str) -> None:
        self.items.append(s.Line(label=name))
        self.forget()

    def part(self, word: s.Statement, body: tuple[p.Statement, ...] = ()) -> None:
        """Write a word that begins or ends a part of a block, and the content of that part."""
        self.add(word)
        self.forget()
        self.body(body)

    def forget(self) -> None:
        """Nothing is known any more: another way may lead here."""
        self.state.clear()
        self.previous, self.stands = None, not self.rounds

    def next_number(self) -> int:
        self.number += 1
        return self.number - 1

    def made_label(self, letter: str) -> str:
        self.made += 1
        return f"{letter}{self.made}"

    def enter(self, procedure: Procedure) -> None:
        """The lines that follow are a procedure's."""
        self.owner = self.expressions.procedure = procedure
        self.parts.append((procedure, len(self.items)))
        self.forget()
        # Others may call the first procedure of a unit, but not of the program.
        self.stands |= self.unit is None and self.is_first(procedure)

    def body(self, statements: tuple[p.Statement, ...]) -> None:
        around = self._at
        outer = len(self.items) if self._inner is None else self._inner
        before: p.Statement | None = None
        held: p.Comment | None = None
        for statement, below in zip(statements, (*statements[1:], None), strict=False):
            self._note()
            # A comment at the end of the next statement's line waits until that line is written.
            if isinstance(statement, p.Comment) and statement.stands_at_end_of(below):
                held = statement
                continue
            if not self._ends_block(statement, before):
                begin, self._at, self._inner = len(self.items), statement.span or around, None
                with self.findings.at(statement.span), self.saying():
                    self.statement(statement)
                if held is not None:
                    self._beside(held, begin, statement)
            before, held = statement, None
            self._note()
            self._at = around
        self._inner = outer

    def _ends_block(self, comment: p.Statement, before: p.Statement | None) -> bool:
        """Write a comment after the last word of a block, if it was there; return True if it is
        written.

        An `If` of one line has no such word: a comment at its end is read as one above it.
        """
        if not isinstance(comment, p.Comment) or before is None or not bodies(before):
            return False
        if (
            not comment.stands_at_end_of(before)
            or not block_word(statement_of(self.items[-1])).closes
        ):
            return False
        return self.behind(len(self.items) - 1, comment)

    def _beside(self, comment: p.Comment, begin: int, statement: p.Statement) -> None:
        """Writes a comment at the end of a statement's line, or above it."""
        lines, at = self.items[begin:], -1
        if bodies(statement):  # not the first line of a block inside of it
            own = self.items[begin : self._inner]
            at = next((k for k, item in enumerate(own) if _opens(item)), -1)
        elif not any(isinstance(item, s.Line) and item.label for item in lines):
            at = len(lines) - 1
        if at < 0 or not self.behind(begin + at, comment):
            self.items.insert(begin, s.Line(comment=marked(comment)))

    def behind(self, at: int, comment: p.Comment) -> bool:
        """Writes a comment at the end of a line, if that has room."""
        last = self.items[at] if at >= 0 else None
        if not isinstance(last, s.Line) or last.comment is not None or last.statement is None:
            return False
        said = replace(last, comment=marked(comment))
        if len(line(said).encode()) > EMITTED_LINE - len("32767 "):
            return False
        self.items[at] = self.replaced(last, said)
        return True

    def replaced(self, last: s.Line, said: s.Line) -> s.Line:
        """The new form of a line, which takes over what was noted by the identity of the old."""
        if id(last) in self.settings:
            self.settings.remove(id(last))
            self.settings.add(id(said))
        if (span := self.spans.pop(id(last), None)) is not None:
            self.spans[id(said)] = span
        return said

    def statement(self, statement: p.Statement) -> None:
        """Writes a statement; one that reads the position, under the tool and frame it names."""
        if not isinstance(statement, p.MoveStatement):  # which hold under their own
            self.stand(head(statement))
        if (write := self.write.get(type(statement))) is None:
            raise Unsayable(f"a {type(statement).__name__} statement", "say it in other statements")
        mounts: dict[str, object] = {
            word: self.state[word] for word in MOUNT_WORDS if word in self.state
        }
        stood = self.stands and _leaves_arm(statement)
        write(self, statement)
        # The lines of a statement may be a call or have labels, after which nothing is known.
        if mounts and self.keeps_mounts(statement):
            self.state.update(mounts)
        # A function of the program may change the settings and the position.
        inner = walk((statement,)) if stood else ()
        calls = any(self._is_call(part) for one in inner for part in records(head(one)))
        if any(map(self._is_call, records(head(statement)))):
            self.forget()
        # Blocks and loops of waits have labels and branches, but the arm stays where it was.
        self.stands |= stood and not calls

    def _is_call(self, record: Any) -> bool:
        """True for a call of a program function in an expression, which may set anything."""
        return (
            isinstance(record, e.Apply)
            and record.function not in e.FUNCTIONS
            and self.program.procedure(record.function) is not None
        )

    def stand(self, value: Any) -> None:
        """Sets the tool and frame in which a value reads the position, if it does."""
        for record in records(value):
            match record:
                case e.Here(tool, frame):
                    self.mount(tool, frame)
                # These functions count with the active tool and base, in the pseudo-program with
                # neither.
                case e.Apply(function) if function.lower() in ARM_FUNCTIONS:
                    self.mount(FLANGE, BASE)

    def mount(self, tool: str, frame: str) -> None:
        """Sets the tool, and the base to the frame where targets are no products with it."""
        names, frame = self.names, BASE if self.names.products else frame
        for word, name, table, status in (
            ("Tool", tool, names.tools, "P_NTool"),
            ("Base", frame, names.frames, "P_NBase"),
        ):
            known = table.get(name.lower(), self.expressions.word(status))
            number = names.numbers.get(known)
            self._set(word, name, s.Variable(known) if number is None else s.Number(number))

    def changed_tool(self, place: e.Expression) -> None:
        """After an assignment: a tool that was changed is set again before it is used."""
        if (name := base_variable(place)) in self.names.tools and self._mounts(name):
            # The variable has changed, but not what `Tool` took from it.
            self.state.pop("Tool", None)
            self.remounts = True

    def changed_place(self, place: e.Expression) -> None:
        """After an assignment: the position of the move before may be another value now."""
        name = base_variable(place)
        # What a call has by reference may be the same variable under another name.
        inout = self.owner is not None and any(q.mode != "in" for q in self.owner.parameters)
        if self.previous is None:
            return
        target = self.expressions.place(place)
        named = (x.key for x in nodes(self.previous[0]) if isinstance(x, s.Variable))
        # An interrupt may have changed it as well.
        if inout or self.interrupted or name in self.mounts or target.key in named:
            self.previous = None

    def changed_frame(self, place: e.Expression) -> s.Variable | None:
        """Return the variable for the pose of a frame, which is assigned as the inverse; `Base` is
        then set again.
        """
        if not isinstance(place, e.Name) or not self._mounts(place.name):
            return None
        known = None if self.names.products else self.names.frames.get(place.name.lower())
        if known is not None:
            self.state.pop("Base", None)
            self.remounts = True
        return None if known is None else s.Variable(known)

    def _mounts(self, name: str) -> bool:
        """True if a name that is assigned to is that of a tool or frame."""
        if name.lower() not in self.mounts or self.expressions.variable(name) is not None:
            return False
        if any(q.unit is not None for q in self.program.procedures):
            raise Unsayable(
                f"a change of `{name}`, which each program of several has for itself",
                "make one program of them",
            )
        return True

    def move_by(self, speed: Speed | p.ComputedSpeed, blend: Blend | p.ComputedBlend) -> None:
        """Sets the speed and the corner of the moves that follow."""
        if isinstance(speed, p.ComputedSpeed):
            self._set_computed_speed(speed)
        elif speed.joint is not None:
            self._set("JOvrd", speed.joint, signed_number(speed.joint))
        else:  # `Mov` does not depend on it
            fastest = s.Variable(self.expressions.word("M_NSpd"))
            self._set(
                "Spd", speed.tcp, fastest if math.isinf(speed.tcp) else signed_number(speed.tcp)
            )
        if isinstance(blend, p.ComputedBlend):
            radius = self.expressions.of(blend.radius)
            self._set_computed("Cnt", s.Number(1), radius, radius)
            return
        corner: list[s.Expression] = [s.Number(0 if blend.radius is None else 1)]
        if blend.radius is not None and not math.isinf(blend.radius):
            leave = blend.radius if blend.exit is None else blend.exit
            corner += [signed_number(blend.radius), signed_number(leave)]
        self._set("Cnt", blend, *corner)

    def _set_computed_speed(self, speed: p.ComputedSpeed) -> None:
        if speed.joint is not None:
            self._set_computed("JOvrd", self.expressions.of(speed.joint))
        elif speed.tcp is not None:
            self._set_computed("Spd", self.expressions.of(speed.tcp))
        else:
            self._set("Spd", math.inf, s.Variable(self.expressions.word("M_NSpd")))

    def _set_computed(self, word: str, *arguments: s.Expression) -> None:
        """A setting whose value is worked out: what it is then is not known below the move."""
        self.state.pop(word, None)
        self.add(s.Command(word, arguments))
        self.settings.add(id(self.items[-1]))

    def _set(self, word: str, value: object, *arguments: s.Expression) -> None:
        """A setting, if it does not hold already."""
        if self.state.get(word) != value:
            self.state[word] = value
            self.add(s.Command(word, arguments))
            self.settings.add(id(self.items[-1]))

    def _note(self) -> None:
        """The lines since the last time are those of the statement at hand."""
        if self._at is not None:
            self.spans.update((id(item), self._at) for item in self.items[self._noted :])
        self._noted = len(self.items)

    def is_first(self, procedure: Procedure) -> bool:
        """True if the procedure is the first of its unit."""
        if procedure.unit is None:
            return procedure.name.lower() == (self.program.entry or "").lower()
        return procedure is next(q for q in self.program.procedures if q.unit == procedure.unit)
