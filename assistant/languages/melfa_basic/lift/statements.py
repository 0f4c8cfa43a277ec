"""Readers of statements: code lines and blocks as statements of the pseudo-program.

`Control` lifts single lines, blocks, branches and jumps. A line that the
pseudo-program cannot express becomes a vendor statement. `Def Act` and `Act` become interrupts if
the program was written here or leads them to procedures; Mo triggers are conditions that they may
ask.
"""

from __future__ import annotations

import itertools
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText
from assistant.languages import vendor_statements
from assistant.languages.melfa_basic.lift import (
    computed_positions,
    simple_statements,
    untranslatable_reasons,
)
from assistant.languages.melfa_basic.lift.expressions import Expressions, operator_name
from assistant.languages.melfa_basic.lift.moves import Moves
from assistant.languages.melfa_basic.lift.paths import Runs, Values
from assistant.languages.melfa_basic.lift.procedures import (
    RETURN_TO_PROGRAM,
    Answers,
    Code,
    Region,
    next_word,
    target_name,
)
from assistant.languages.melfa_basic.lift.settings import (
    SETTING_WORDS,
    SettingFlow,
    followed_assignment,
    needed_settings,
    with_followed_settings,
)
from assistant.languages.melfa_basic.lift.symbols import (
    VENDOR_ONLY_END,
    VENDOR_ONLY_NAME,
    Routine,
    Symbols,
    Unliftable,
)
from assistant.languages.melfa_basic.lift.untranslatable_reasons import (
    FRACTIONAL_STEP,
    NO_LABEL,
    NO_PROCEDURE,
)
from assistant.languages.melfa_basic.tables.equivalents import STATEMENT_ROWS
from assistant.languages.melfa_basic.tables.variables import ALL_INTERRUPTS
from assistant.languages.melfa_basic.text import effects
from assistant.languages.melfa_basic.text.header import path_note
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import (
    block_word,
    labels_named,
    labels_of,
    statement_of,
)
from assistant.languages.melfa_basic.tree.walk import (
    literal,
    nodes,
    program_key,
    program_stem,
    statements_in,
)
from assistant.languages.patterns import Called, Reading
from assistant.languages.settings_flow import UNKNOWN, UnknownSettings
from assistant.languages.settings_forms import Form
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.passes.switches import SELECTED, Test, chosen
from assistant.program.program import Variable, identifier
from assistant.program.rewriting import is_steady, records


@dataclass(slots=True)
class _OpenBlock:
    """An open block. kind: by its word. places: of the words that divide and end it. label: after
    it.
    """

    kind: str
    places: Collection[int]
    label: str | None = None


_PROGRAM_ENDS: Final = (s.Command("End"), s.Command("Return"))
_EXPORTED_STATEMENTS: Final = (s.Assign, s.Motion, s.Print, s.Close)
"""Statements that other languages may have where the pseudo-program keeps their texts."""
_HAND_COMMANDS: Final = ("HOpen", "HClose")
_EXPORTED_COMMANDS: Final = (*_HAND_COMMANDS, "SetMoTrg", "Error")
_FORCED_COMMAND: Final = "HOpen"
"""Takes forces and a time beside its hand (COSIROP: HOPEN)."""
StatementLift = Callable[[Any, Any], list[p.Statement]]
"""Function that lifts a statement, given the reader and the statement; raises Unliftable."""


class Control:
    """Lift single lines, and what decides the order of the lines; raise Unliftable.

    routines: what each region is called, and what `GoSub` and functions mean. units, firsts:
    the programs that `CallP` names, and the procedures that those begin with. kept: lines whose
    setting has to stay, because something depends on it that is kept as its text. source: the
    text that the code was read from. label_names: of the procedure that is read, upper case → name.
    followed: names of what holds settings for other languages, see `with_followed_settings`.
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
        self.path_notes = frozenset(itertools.starmap(path_note, symbols.header.paths))
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
        self.leaving: list[_OpenBlock] = []
        self.by_label = {r.label: k for k, r in enumerate(self.regions) if r.label}
        self.form: Form | None = None
        self.region = Region(0, 0)
        self.at = 0
        self.answers: Answers = {}
        """Calls of interrupts, see `Answers`."""
        self.torn = False
        """True if a divided procedure contains vendor text with a jump, whose target may be wrong
        there.
        """
        self.depending: list[tuple[Form, int, frozenset[int]]] = []
        """Lines kept as text, and the settings under which they do what they do."""

    @property
    def values(self) -> Values:
        assert self.form is not None
        return self.as_told(tuple(held.value for held in self.called.at(self.at, self.form)))

    def single(self, node: s.Statement) -> list[p.Statement]:
        """Lift the branch of an `If` in one line, or return the text that it would have as a
        separate line.

        Raises Unliftable for `Break`, which would leave the `If` if that becomes a block.
        """
        if node == s.Command("Break"):
            return self.simple(node)
        return self.or_text(node, lambda: self.simple(node))

    def simple(self, node: s.Statement) -> list[p.Statement]:
        """Lift a statement that is not a block; raises Unliftable."""
        if (effect := self.effect(node)) is not None:
            # For other languages, variables hold the settings that are not certain at a move.
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
        return [simple_statements.with_span(statement, span) for statement in lifted]

    def or_text(
        self,
        node: s.Statement,
        read: Callable[[], list[p.Statement]],
        refused: p.Reason | None = None,
    ) -> list[p.Statement]:
        """Return the lifted statement, else its text. refused: why, if the reader gives no
        reason.
        """
        try:
            return read()
        except Unliftable as found:
            set_here = self.effect(node) is not None
            hand = isinstance(node, s.Command) and node.keyword in _EXPORTED_COMMANDS
            defines = set_here or isinstance(node, s.DefOther)
            tells = (
                defines or hand or isinstance(node, _EXPORTED_STATEMENTS) or node in _PROGRAM_ENDS
            )
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
        # Vendor text may move the robot: neither a path nor an arc continues after it.
        self.runs.forget()
        self.runs.arc_pending = False
        self.note_dependence(statement)
        self.note_names(statement)
        if found is vendor_statements.SETTINGS_DIFFER and self.form is not None:
            state = self.called.at(self.at, self.form)
            found = self.unknown.reason(state, needed_settings(statement)) or found
        dialect = self.symbols.dialect
        # Copies of a procedure for other settings rename their labels, but not those in vendor
        # text.
        if self.form is not None and self.form.passes:
            self.torn |= any(isinstance(part, s.Target) for part in nodes(statement))
        reason = untranslatable_reasons.reason_for(statement, found)
        text = untranslatable_reasons.statement_text(statement, dialect)
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
        """Return the words for a line in a finding."""
        item = self.code[at]
        if not isinstance(item, s.Line) or item.statement is None:
            return "a block of moves"
        text = f"`{untranslatable_reasons.statement_text(item.statement, self.symbols.dialect)}`"
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
            raise Unliftable(untranslatable_reasons.COMPUTED_PROGRAM)
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
        if node.keyword == _FORCED_COMMAND and self.expressions.m.telling:
            arguments = arguments[:1]  # without force and time, see `vendor_only`
        called: Called[s.Expression] = Called(node.keyword, arguments)
        said = STATEMENT_ROWS.read(called, self.reading)
        if said is None and node.keyword in _HAND_COMMANDS and self.expressions.m.telling:
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
        return [simple_statements.wait_for(condition, self.expressions)]

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
            raise Unliftable(untranslatable_reasons.NO_SUBROUTINE)
        return [p.Return()]

    @cached_property
    def _run(self) -> set[int]:
        """The lines of the first procedure that may run."""
        lines = self.called.flow.lines
        places, after = lines.procedures[0], lines.after[0]
        starts = {*places[:1], *lines.lost.intersection(places)}
        return reachable(starts, lambda at: after.get(at, ()))

    @abstractmethod
    def body(self, low: int, high: int) -> tuple[p.Statement, ...]:
        """The statements of a range of lines."""

    @abstractmethod
    def enter(self, at: int) -> Any:
        """Sets what holds where a line begins."""

    # ------------------------------------------------------------------------------ blocks

    def block(self, at: int, high: int, made: list[p.Statement]) -> int:
        """Lift the complete block that begins here; return the place after it, 0 if no block begins
        here.
        """
        found, item = self.blocks.get(at), self.code[at]
        # A block that ends beyond the range is read line by line: its parts belong to other blocks.
        if found is None or found[-1] > high or len(self.leaving) > _DEEPEST:
            return 0
        self.leaving.append(_OpenBlock(block_word(item.statement).opens, found[1:]))
        try:
            statement = self.whole(item.statement, found)
        except Unliftable as found_why:
            statement = None
            # The lines of the block are read one by one next, and report this reason.
            self.refused[at] = found_why.reason
        block = self.leaving.pop()
        if statement is None:
            return 0
        parts = statement if isinstance(statement, tuple) else (statement,)
        made += (simple_statements.with_span(part, item.span) for part in parts)
        if block.label is not None:
            made.append(p.Label(block.label))
        if found[-1] < high:  # else it is the last word of the outer block as well
            made += self.note(found[-1])
        return found[-1] + 1

    def whole(
        self, node: s.Statement | None, places: list[int]
    ) -> p.Statement | tuple[p.Statement, ...] | None:
        """A block from the places of its keywords."""
        of, condition_of = self.expressions.of, self.expressions.condition
        match node:
            case s.If(then=s.Target()):
                return self.jumping_if(places)
            case s.If():
                return self.if_block(places)
            case s.Command(keyword="While", arguments=(condition,)) if condition is not None:
                test = condition_of(condition)
                return p.While(test, self.body(places[0] + 1, places[-1]))
            case s.For(variable=variable, first=first, last=last, step=step):
                name = self.expressions.plain(variable)
                if not isinstance(name, e.Name):
                    raise Unliftable
                counted = p.ONE if step is None else of(step)
                # An integer loop variable rounds each step, which the pseudo-program's loop does
                # not.
                if self.expressions.type_of(variable) == "integer" and not _may_be_whole(counted):
                    raise Unliftable(FRACTIONAL_STEP)
                limits = of(first), of(last)
                inside = self.body(places[0] + 1, places[-1])
                return p.For(name.name, *limits, inside, counted)
            case s.Select(subject=subject):
                return self.select(subject, places)
        return None

    def note(self, at: int) -> list[p.Statement]:
        """The comment behind a word of a block."""
        item = self.code[at]
        if item.comment is None:
            return []
        return [p.Comment(simple_statements.comment_text(item.comment), span=item.span)]

    def part(self, place: int, following: int) -> tuple[p.Statement, ...]:
        """Lift the lines below a word that divides a block."""
        return (*self.note(place), *self.body(place + 1, following))

    def if_block(self, places: list[int]) -> p.If:
        branches: list[p.Branch] = []
        otherwise: tuple[p.Statement, ...] = ()
        for place, following in itertools.pairwise(places):
            node = self.code[place].statement
            inside = self.part if branches else lambda a, b: self.body(a + 1, b)
            if isinstance(node, s.If | s.ElseIf):
                condition = self.condition_at(place, node)
                branches.append(p.Branch(condition, inside(place, following)))
            else:
                otherwise = inside(place, following)
        return p.If(tuple(branches), otherwise)

    def jumping_if(self, places: list[int]) -> p.If:
        """`If` and jumps to made labels: condition, then, jump and next label by turns, end."""
        branches = []
        for i in range(0, len(places) - 1, 3):
            test, jump, _ = places[i : i + 3]
            node = self.code[test].statement
            if not isinstance(node, s.If):
                raise Unliftable
            condition = self.condition_at(test, node)
            branches.append(p.Branch(condition, self.body(test + 2, jump)))
        otherwise = self.body(places[-2] + 1, places[-1])
        return p.If(tuple(branches), otherwise)

    def condition_at(self, place: int, node: s.If | s.ElseIf) -> e.Expression:
        """Lift the condition of a line of an `If`, under the settings active there."""
        self.enter(place)
        return self.expressions.condition(node.condition)

    # ------------------------------------------------------------------------------ Select

    def select(self, subject: s.Expression, places: list[int]) -> tuple[p.Statement, ...]:
        """A choice; a value that the next reading may find changed is read into a variable."""
        value = self.expressions.of(subject)
        # Statements between `Select` and the first `Case` never run; a block of cases has no room
        # for them.
        if any(self.code[at].statement for at in range(places[0] + 1, places[1])):
            raise Unliftable  # lines that never run
        cases: list[tuple[s.Case, tuple[p.Statement, ...]]] = []
        otherwise: tuple[p.Statement, ...] = ()
        above = self.body(places[0] + 1, places[1])
        for place, following in itertools.pairwise(places[1:]):
            node = self.code[place].statement
            inside = (*above, *self.part(place, following))
            above = ()
            if isinstance(node, s.Case):
                cases.append((node, inside))
            elif following != places[-1]:
                raise Unliftable  # a Default before other cases
            else:
                otherwise = inside
        single = all(_is_single_value(item) for case, _ in cases for item in case.items)
        # Several tests read the value one after the other, and an input may change in between.
        read: tuple[p.Statement, ...] = ()
        if not single and not self._is_steady(value):
            if any(isinstance(part, e.Verbatim) for part in records(value)):
                raise Unliftable
            name = self.symbols.free(SELECTED)
            self.symbols.variables[name] = Variable(self.expressions.type_of(subject))
            read, value = (p.Assign(e.Name(name), value),), e.Name(name)
        made = chosen(value, [(self._tests(case), inside) for case, inside in cases], otherwise)
        return (*read, made)

    def _is_steady(self, value: e.Expression) -> bool:
        """True if a value is the same at each read: only this program changes it."""
        changing = {name.lower() for name in self.symbols.signals}
        names = {part.name.lower() for part in records(value) if isinstance(part, e.Name)}
        # External variables have `_` as second letter; programs in other slots may change them.
        return is_steady(value, changing) and not any(name[1:2] == "_" for name in names)

    def _tests(self, case: s.Case) -> list[Test]:
        """Return the alternative tests of a case on the value."""
        plain = self.expressions.plain
        found: list[Test] = []
        for item in case.items:
            if isinstance(item, s.CaseIs):
                found.append(((operator_name(item.operator), plain(item.value)),))
            elif item.last is None:
                found.append((("=", plain(item.first)),))
            else:
                found.append(((">=", plain(item.first)), ("<=", plain(item.last))))
        return found

    # ------------------------------------------------------------------------------- jumps

    def one_line_if(self, node: s.If) -> list[p.Statement]:
        if node.then is None:
            raise Unliftable
        condition = self.expressions.condition(node.condition)
        then = self.branch(node.then)
        otherwise = () if node.otherwise is None else self.branch(node.otherwise)
        self.runs.forget()
        return [p.If((p.Branch(condition, then),), otherwise)] if then or otherwise else []

    def branch(self, node: s.Statement | s.Target) -> tuple[p.Statement, ...]:
        if isinstance(node, s.Target):
            node = s.Jump("GoTo", node)
        return tuple(self.single(node))

    def jump(self, node: s.Jump) -> list[p.Statement]:
        return [self.go(node.keyword, node.target)]

    def go(self, keyword: str, target: s.Target) -> p.Statement:
        """`GoTo` or `GoSub`."""
        place = str(target.place).upper()
        if keyword == "GoSub":
            callee = self.by_label.get(place)
            if callee is None:
                raise Unliftable(NO_PROCEDURE)
            assert self.form is not None
            self.runs.forget()
            return p.Call(self.form.called[self.at][callee].name)
        if isinstance(target.place, int) or place not in self.label_names:
            raise Unliftable(NO_LABEL)
        return p.Goto(self.label_names[place])

    def on_jump(self, node: s.OnJump) -> list[p.Statement]:
        """Lift `On n GoTo` and `On n GoSub`; for a number without a target control continues
        below.
        """
        subject = self.expressions.rounded(node.subject)
        # The controller stops with an error at an empty place, where the pseudo-program would go
        # on.
        if any(target is None for target in node.targets):
            raise Unliftable
        cases = tuple(
            p.Case((e.Number(k),), (self.go(node.keyword, target),))
            for k, target in enumerate(node.targets, 1)
            if target is not None
        )
        self.runs.forget()
        return [p.Switch(subject, cases)]

    def broken(self, _: s.Command) -> list[p.Statement]:
        """Lift `Break`: leave the innermost block; at the end of a branch it has no effect."""
        if not self.leaving or self.asks_for_breaks:
            raise Unliftable
        block = self.leaving[-1]
        if block.kind in ("If", "Select") and next_word(self.code, self.at) in block.places:
            return []
        if block.label is None:
            block.label = identifier("leave", set(self.label_names.values()))
            self.label_names[f"*{block.label}"] = block.label  # no label of the file's own
        return [p.Goto(block.label)]


def _define_interrupt(reader: Control, node: s.DefAct) -> list[p.Statement]:
    """An interrupt that calls a procedure and goes on where the program was, or ends it."""
    condition = reader.expressions.condition(node.condition)
    answer = reader.answers.get(target_name(node.target))
    if answer is not None and node.keyword == "GoSub" and not node.stop:
        call, ends = answer
        over = None if ends is None else reader.expressions.condition(ends)
        return [
            p.Interrupt(
                _interrupt_name(reader, node.number),
                condition,
                p.Call(_called_procedure(reader, call)),
                over,
            )
        ]
    called = _answering_procedure(reader, node)
    if called is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    # `GoTo` abandons what the program was doing: the condition to end always holds.
    over = e.Number(1) if node.keyword == "GoTo" else None
    return [p.Interrupt(_interrupt_name(reader, node.number), condition, p.Call(called), over)]


def _answering_procedure(reader: Control, node: s.DefAct) -> str | None:
    """Return the name of the procedure that interrupts alone lead to; None if there is no such
    procedure in a single plain form.
    """
    number = reader.by_label.get(target_name(node.target))
    if number is None or not reader.regions[number].answers:
        return None
    forms = [*reader.called.forms[number].values()]
    return forms[0].name if len(forms) == 1 and not forms[0].passes else None


def _switch_interrupt(reader: Control, node: s.Command) -> list[p.Statement]:
    (given,) = node.arguments
    if not isinstance(given, s.Binary):
        raise Unliftable(vendor_statements.INTERRUPTS)
    state = literal(given.right)
    if state not in (0, 1):
        raise Unliftable(vendor_statements.INTERRUPTS)
    switched: p.SwitchInterrupt | p.SwitchInterrupts
    if literal(given.left) == ALL_INTERRUPTS:
        # `Act 0` switches all: correct only if the pseudo-program has every one of them.
        if not reader.answers and None in _defined_interrupts(reader).values():
            raise Unliftable(vendor_statements.INTERRUPTS)
        switched = p.SwitchInterrupts("on" if state else "off")
    else:
        switched = p.SwitchInterrupt(_interrupt_name(reader, given.left), "on" if state else "off")
    return [switched]


def _defined_interrupts(reader: Control) -> dict[float | None, str | None]:
    """Return the procedure that each interrupt calls, by number; None for one without
    equivalent.
    """
    found: dict[float | None, str | None] = {}
    for node, alone in reader.definitions:
        number, called = literal(node.number), _answering_procedure(reader, node)
        # A definition inside another statement may not run, so the interrupt's target is not
        # certain.
        same = found.get(number, called) == called and alone
        found[number] = called if same and number is not None else None
    return found


def _interrupt_name(reader: Control, node: s.Expression) -> str:
    number = literal(node)
    if number is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    known = reader.symbols.header.names["interrupt"].get(f"{number:g}")
    if known is None and _defined_interrupts(reader).get(number) is not None:
        known = f"act_{number:g}"
    if known is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    return known


def _called_procedure(reader: Control, call: s.Jump | s.Call) -> str:
    """The procedure that answers."""
    if isinstance(call, s.Jump):
        number = reader.by_label.get(target_name(call.target))
        if number is None:
            raise Unliftable(vendor_statements.INTERRUPTS)
        return reader.routines[number].name
    routine = reader.symbols.routines.get(call.function.key)
    if routine is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    return routine.name


# ------------------------------------------------------------------------------ Mo triggers


def mo_triggers(code: Code, symbols: Symbols) -> dict[int, tuple[str, s.Expression]]:
    """The condition of each Mo trigger that has one definition, and a name for whether it is on."""
    found: dict[int, list[s.Expression | None]] = {}
    for item in code:
        node = statement_of(item)
        if isinstance(node, s.DefOther) and node.kind == "MoTrg" and len(node.arguments) == 2:
            number = symbols.constants.value(node.arguments[0])
            if not isinstance(number, float):
                return {}
            found.setdefault(round(number), []).append(node.arguments[1])
    return {
        number: (symbols.free(f"mo_trigger_{number}"), conditions[0])
        for number, conditions in found.items()
        if len(conditions) == 1 and conditions[0] is not None
    }


def _watch_mo_triggers(reader: Control, node: s.Command) -> list[p.Statement]:
    """`SetMoTrg n`: from here on a Mo trigger is watched; with 0 none is."""
    symbols = reader.symbols
    number = symbols.value(node.arguments[0])
    if not symbols.telling or not isinstance(number, float) or not symbols.mo_triggers:
        raise Unliftable
    wanted = [round(number)] if number else sorted(symbols.mo_triggers)
    if not set(wanted) <= symbols.mo_triggers.keys():
        raise Unliftable
    names = [symbols.mo_triggers[one][0] for one in wanted]
    for name in names:
        symbols.variables.setdefault(name, Variable("integer", e.Number(0)))
    return [p.Assign(e.Name(name), e.Number(int(number != 0))) for name in names]


def _raise_error(reader: Control, node: s.Command) -> list[p.Statement]:
    """`Error MErr`: the program ends for good unless the number is that of a caution.

    Known numbers are lowered from their text, see `for_other_vendor`.
    """
    (number,) = node.arguments
    if not reader.symbols.telling or number is None or literal(number) is not None:
        raise Unliftable
    given = reader.expressions.rounded(number)
    first, last = CAUTIONS
    stops = e.Binary(
        "or",
        e.Binary("<", given, e.Number(first)),
        e.Binary(">", given, e.Number(last)),
    )
    shown = p.Message((e.Text("error "), given))
    return [shown, p.If((p.Branch(stops, (p.Stop(end=True),)),))]


CAUTIONS: Final = (9200, 9299)
"""Numbers of errors of the program's own that do not stop it (COSIROP: ERROR)."""
_DEEPEST: Final = 50
"""Deepest nesting of blocks that are read as blocks; controllers stop at 16."""


def _is_single_value(item: s.CaseRange | s.CaseIs) -> bool:
    """True if the item of a case tests for a single value."""
    return item.operator == "=" if isinstance(item, s.CaseIs) else item.last is None


STATEMENT_LIFTS: Final[Mapping[type, StatementLift]] = {
    s.Motion: lambda reader, node: reader.moves.move(node, reader.values),
    s.Command: Control.command,
    s.Assign: lambda reader, node: simple_statements.lift_assignment(
        node, reader.expressions, reader.runs
    ),
    s.Open: lambda reader, node: simple_statements.lift_open(node, reader.expressions),
    s.Close: lambda reader, node: simple_statements.lift_close(node, reader.expressions),
    s.Print: lambda reader, node: simple_statements.lift_print(node, reader.expressions),
    s.Input: lambda reader, node: simple_statements.lift_input(
        node, reader.expressions, reader.runs
    ),
    s.If: Control.one_line_if,
    s.Jump: Control.jump,
    s.OnJump: Control.on_jump,
    s.Call: Control.call,
    s.CallP: Control.callp,
    s.DefNames: lambda reader, node: simple_statements.declare_variables(
        node.variables, reader.expressions
    ),
    s.Dim: lambda reader, node: simple_statements.declare_variables(
        node.variables, reader.expressions
    ),
    s.Static: lambda reader, node: simple_statements.declare_variables(
        node.definition.variables, reader.expressions
    ),
    s.Const: lambda reader, node: simple_statements.lift_constant(node, reader.expressions),
    s.DefIo: lambda reader, node: simple_statements.lift_known_definition(
        node.variable.key in reader.symbols.io
    ),
    s.DefOther: lambda reader, node: computed_positions.define_pallet(node, reader.expressions),
    s.DefAct: _define_interrupt,
    s.DefFunction: lambda reader, node: simple_statements.lift_known_definition(
        node.name.upper() in reader.symbols.routines
    ),
}
COMMAND_LIFTS: Final[Mapping[str, tuple[int, StatementLift]]] = {
    "Wait": (1, Control.wait),
    "End": (0, Control.end),
    "Return": (0, Control.returned),
    "Exit Function": (0, Control.left),
    "Break": (0, Control.broken),
    "Act": (1, _switch_interrupt),
    "SetMoTrg": (1, _watch_mo_triggers),
    "Error": (1, _raise_error),
}


def _may_be_whole(step: e.Expression) -> bool:
    """True if a step may be an integer, as far as its text shows."""
    return not isinstance(step, e.Number) or float(step.value).is_integer()
