"""Single lines as statements of the pseudo-program."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final

from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText
from assistant.languages import vendor_statements
from assistant.languages.melfa_basic.lift.settings.along_lines import SettingFlow, needed_settings
from assistant.languages.melfa_basic.lift.settings.followed import (
    followed_assignment,
    with_followed_settings,
)
from assistant.languages.melfa_basic.lift.settings.held import SETTING_WORDS
from assistant.languages.melfa_basic.lift.statements import waits
from assistant.languages.melfa_basic.lift.statements.moves import Moves
from assistant.languages.melfa_basic.lift.statements.paths import Runs, Values
from assistant.languages.melfa_basic.lift.structure.answers import Answers
from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.structure.regions import (
    RETURN_TO_PROGRAM,
    Region,
    target_name,
)
from assistant.languages.melfa_basic.lift.values import reasons
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import (
    VENDOR_ONLY_END,
    VENDOR_ONLY_NAME,
    Routine,
    Symbols,
    Unliftable,
)
from assistant.languages.melfa_basic.tables.statements import STATEMENT_ROWS
from assistant.languages.melfa_basic.text import effects
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.melfa_basic.tree.targets import labels_named, labels_of
from assistant.languages.melfa_basic.tree.walk import (
    nodes,
    program_key,
    program_stem,
    statements_in,
)
from assistant.languages.patterns import Called, Reading
from assistant.languages.settings.flow import UNKNOWN, UnknownSettings
from assistant.languages.settings.forms import Form
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.program import identifier


@dataclass(slots=True)
class OpenBlock:
    """An open block, by its word. places: of those that divide and end it. label: behind it."""

    kind: str
    places: Collection[int]
    label: str | None = None


PROGRAM_ENDS: Final = (s.Command("End"), s.Command("Return"))
EXPORTED_STATEMENTS: Final = (s.Assign, s.Motion, s.Print, s.Close)
"""Statements that other languages may have where the pseudo-program keeps their texts."""
HAND_COMMANDS: Final = ("HOpen", "HClose")
FORCED_COMMAND: Final = "HOpen"
"""Takes forces and a time beside its hand (COSIROP: HOPEN)."""
StatementLift = Callable[[Any, Any], list[p.Statement]]
"""What a statement says, given the reader and it; raises Unliftable."""


class Statements:
    """Lifts what is no block.

    routines: what each region is called, and what `GoSub` and functions mean. units, firsts:
    the programs that `CallP` names, and the procedures that those begin with. kept: lines whose
    setting has to stay, because something depends on it that is kept as its text. source: the
    text that the code was read from. label_names: of the procedure that is read, upper case → name.
    followed: names of what holds settings for other languages, see `settings.followed`.
    refused: why blocks, by their first line, stay as their text. leaving: the blocks around the
    line. lifts, commands: what statements by their kinds are read by, and commands by their words,
    with how many arguments these have.
    """

    lifts: ClassVar[Mapping[type, StatementLift]] = {}
    commands: ClassVar[Mapping[str, tuple[int, StatementLift]]] = {}

    def __init__(
        self,
        code: Code,
        symbols: Symbols,
        ways: SettingFlow,
        routines: list[Routine],
        calls: tuple[dict[str, str], dict[str, str]],
        main: bool,
        kept: frozenset[int],
        source: SourceText | None,
        followed: Mapping[int, str],
    ) -> None:
        self.code, self.symbols, self.called, self.source = code, symbols, ways.called, source
        self.regions, self.effect = ways.regions, ways.settings.effect
        self.routines, self.main, self.kept = routines, main, kept
        self.units, self.firsts = calls
        self.followed = followed
        self.unknown = UnknownSettings(ways.called.flow.lines, SETTING_WORDS, self.where)
        self.expressions = Expressions(symbols)
        self.runs = Runs(symbols, ways.single, symbols.own, self.one_move)
        self.moves = Moves(self.expressions, self.runs)
        self.reading: Reading[s.Expression] = Reading(
            {
                "value": lambda node, _: self.expressions.of(node),
                "hand": lambda node, _: self.hand(node),
            }
        )
        self.labels, self.named = labels_of(code), Counter(labels_named(code))
        self.blocks, self.asks_for_breaks = ways.structure.places, ways.breaks
        self.label_names: dict[str, str] = {}
        self.refused: dict[int, p.Reason | None] = {}
        self.leaving: list[OpenBlock] = []
        self.by_label = {r.label: k for k, r in enumerate(self.regions) if r.label}
        self.form: Form | None = None
        self.region = Region(0, 0)
        self.at = 0
        self.answers: Answers = {}
        """What interrupts call, see `answers`."""
        self.torn = False
        """Whether a text with a jump stands in a divided procedure, where it leads astray."""
        self.depending: list[tuple[Form, int, frozenset[int]]] = []
        """Lines kept as text, and the settings under which they do what they do."""

    @property
    def values(self) -> Values:
        assert self.form is not None
        return self.as_told(tuple(held.value for held in self.called.at(self.at, self.form)))

    def single(self, node: s.Statement) -> list[p.Statement]:
        """The branch of an `If` in one line, or its text as that of a line of its own.

        Raises Unliftable for `Break`, which would leave the `If` if that becomes a block.
        """
        if node == s.Command("Break"):
            return self.simple(node)
        return self.or_text(node, lambda: self.simple(node))

    def simple(self, node: s.Statement) -> list[p.Statement]:
        """A statement that is no block; raises Unliftable."""
        if (effect := self.effect(node)) is not None:
            if self.expressions.m.telling:
                given = followed_assignment(node, effect[1], self.followed, self.expressions)
                return [] if given is None else [given]
            if self.at in self.kept:
                raise Unliftable(vendor_statements.DEPENDED_ON)
            if effect[1] is not UNKNOWN or isinstance(node, s.Command):
                return []  # how the moves that follow are made
        lift = self.lifts.get(type(node))
        if lift is None:
            raise Unliftable
        return lift(self, node)

    def one_move(self, node: s.Motion, values: Values, span: Span | None) -> list[p.Statement]:
        """A move that is part of no path."""
        lifted = self.or_text(node, lambda: self.moves.move(node, self.as_told(values)))
        return [waits.with_span(statement, span) for statement in lifted]

    def or_text(
        self,
        node: s.Statement,
        read: Callable[[], list[p.Statement]],
        refused: p.Reason | None = None,
    ) -> list[p.Statement]:
        """What is read, else the statement's text. refused: why, if the reader does not tell."""
        try:
            return read()
        except Unliftable as found:
            set_here = self.effect(node) is not None
            hand = isinstance(node, s.Command) and node.keyword in (*HAND_COMMANDS, "SetMoTrg")
            defines = set_here or isinstance(node, s.DefOther)
            tells = defines or hand or isinstance(node, EXPORTED_STATEMENTS) or node in PROGRAM_ENDS
            told = self.expressions.told(read) if tells else None
            reason = found.reason or refused
            if defines and told is not None:
                reason = vendor_statements.DEPENDED_ON
            stood = self.runs.previous if told and isinstance(node, s.Motion) else None
            kept = self.opaque(node, reason, told or [])
            self.runs.previous = stood  # where others have the robot as well
            return [kept]

    def as_told(self, values: Values) -> Values:
        """Settings of a move while it is lowered for other languages."""
        return (
            with_followed_settings(values, self.followed) if self.expressions.m.telling else values
        )

    def opaque(
        self, statement: s.Statement, found: p.Reason | None, told: Sequence[p.Statement] = ()
    ) -> p.Opaque:
        self.runs.forget()
        self.runs.arc_pending = False
        self.note_dependence(statement)
        self.note_names(statement)
        if found is vendor_statements.SETTINGS_DIFFER and self.form is not None:
            state = self.called.at(self.at, self.form)
            found = self.unknown.reason(state, needed_settings(statement)) or found
        dialect = self.symbols.dialect
        if self.form is not None and self.form.passes:
            self.torn |= any(isinstance(part, s.Target) for part in nodes(statement))
        reason = reasons.reason_for(statement, found)
        text = reasons.statement_text(statement, dialect)
        effect = effects.of_node(statement, text)
        return p.Opaque(dialect, text, reason=reason, effect=effect, told=tuple(told))

    @cached_property
    def definitions(self) -> list[tuple[s.DefAct, bool]]:
        """Every `Def Act`, and whether it is the statement of a line or stands inside another."""
        return [
            (node, node is statement_of(item))
            for item in self.code
            for node in statements_in(statement_of(item))
            if isinstance(node, s.DefAct)
        ]

    def where(self, at: int) -> str:
        """What a line is called in a finding."""
        item = self.code[at]
        if not isinstance(item, s.Line) or item.statement is None:
            return "a block of moves"
        text = f"`{reasons.statement_text(item.statement, self.symbols.dialect)}`"
        if item.number is not None:
            return f"{item.number} {text}"
        if self.source is None or item.span is None:
            return text
        return f"{text} in line {self.source.line_column(item.span.start)[0]}"

    def note_names(self, statement: s.Statement) -> None:
        """Notes what a statement that stays as its text may call."""
        for part in nodes(statement):
            if isinstance(part, s.Target):
                self.symbols.in_texts.add(target_name(part))
            elif isinstance(part, s.Variable):
                self.symbols.in_texts.add(part.key)

    def note_dependence(self, statement: s.Statement) -> None:
        """Notes what a statement at hand, which stays as its text, depends on."""
        assert self.form is not None
        if settings := needed_settings(statement):
            self.depending.append((self.form, self.at, settings))

    def left(self, _: s.Command) -> list[p.Statement]:
        """`Exit Function`."""
        inside = self.symbols.inside
        if self.region.function is None:
            raise Unliftable
        result = inside.result if inside is not None else None
        return [p.Return(None if result is None else e.Name(result))]

    def call(self, node: s.Call) -> list[p.Statement]:
        key = node.function.key
        routine = self.symbols.routines.get(key)
        if routine is None or routine.parameters is None:
            raise Unliftable
        given = self.expressions.arguments(routine.parameters, node.function.arguments or ())
        self.runs.forget()
        return [p.Call(self.symbols.variants.get(key, routine.name), given)]

    def callp(self, node: s.CallP) -> list[p.Statement]:
        if not isinstance(node.program, s.String):
            raise Unliftable(reasons.COMPUTED_PROGRAM)
        short = program_key(node.program.value)
        unit = self.units.get(short) or identifier(program_stem(node.program.value))
        first = self.firsts.get(short) or unit
        self.runs.forget()
        return [p.Call(first, tuple(self.expressions.plain(a) for a in node.arguments), unit)]

    def command(self, node: s.Command) -> list[p.Statement]:
        count, lift = self.commands.get(node.keyword, (0, None))
        if lift is not None:
            if node == RETURN_TO_PROGRAM and self.region.answers == "GoSub":
                return [p.Return()]
            if len(node.arguments) != count or None in node.arguments:
                raise Unliftable
            return lift(self, node)
        arguments = node.arguments
        if node.keyword == FORCED_COMMAND and self.expressions.m.telling:
            arguments = arguments[:1]  # without force and time, see `told.kept`
        called: Called[s.Expression] = Called(node.keyword, arguments)
        said = STATEMENT_ROWS.read(called, self.reading)
        if said is None and node.keyword in HAND_COMMANDS and self.expressions.m.telling:
            match arguments:
                case (number,) if number is not None and self.hand(number) is None:
                    given = self.expressions.rounded(number)
                    return [p.Call(VENDOR_ONLY_NAME.format(node.keyword.upper()), (given,))]
        if said is None:
            raise Unliftable
        return [said]

    def hand(self, node: s.Expression) -> int | None:
        number = self.symbols.value(node)
        return round(number) if isinstance(number, float) else None

    def wait(self, node: s.Command) -> list[p.Statement]:
        (condition,) = node.arguments
        assert condition is not None
        return [waits.wait_for(condition, self.expressions)]

    def end(self, _: s.Command) -> list[p.Statement]:
        """`End` ends a cycle of the main program; one that was called goes back to its caller."""
        if self.region.answers == "GoTo":  # the cycle ends behind what an interrupt calls
            return [p.Return()]
        if not self.region.is_first:
            if self.expressions.m.telling and self.region.function is None:
                return [p.Call(VENDOR_ONLY_END)]
            raise Unliftable(
                vendor_statements.ENDS_CYCLE if self.main else vendor_statements.NOT_FIRST
            )
        return [p.Return()]

    def returned(self, _: s.Command) -> list[p.Statement]:
        if self.region.label is None and self.at in self._run:
            if self.expressions.m.telling and self.region.function is None:
                return [p.Stop(end=True)]  # controller error 3840
            raise Unliftable(reasons.NO_SUBROUTINE)
        return [p.Return()]

    @cached_property
    def _run(self) -> set[int]:
        """The lines of the first procedure that may run."""
        lines = self.called.flow.lines
        places, after = lines.procedures[0], lines.after[0]
        starts = {*places[:1], *lines.lost.intersection(places)}
        return reachable(starts, lambda at: after.get(at, ()))
