"""Blocks, jumps and subroutines: their rules and findings.

Blocks must close in order and within the depth that a controller takes; loop variables must not be
changed inside; subroutines must be entered by `GoSub` and left by `Return`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, error, info, warning
from assistant.languages.checks.control_flow import Subroutines
from assistant.languages.checks.registry import Found
from assistant.languages.line_blocks import Block, Blocks, Graph, Misfit
from assistant.languages.melfa_basic.checks.file_view import Look, Scope
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.control_flow import (
    CLOSING,
    block_word,
    blocks_of,
    graph_of,
    statement_of,
)
from assistant.languages.melfa_basic.tree.walk import statements_in, word_of
from assistant.languages.step_numbers import first_step, places_of_steps

_UNBALANCED: Final = error(
    "MB105",
    "`{word}` has no `{other}` (controller error {number})",
    "close each block in the order it was opened",
)
_CROSSED: Final = error(
    "MB131",
    "`{word}` stands inside a `{inner}` that is still open (controller error {number})",
    "close the inner block first",
)
_TOO_DEEP: Final = error(
    "MB132",
    "`{word}` stands {depth} blocks deep, more than {most} (controller error {number})",
    "move the inner blocks into a subroutine",
)
_NESTED_SELECT: Final = error(
    "MB133",
    "{title} takes no `Select` inside another one",
    "move the inner one into a subroutine, or write it with `If`",
)
_INTO_BLOCK: Final = warning(
    "MB134",
    "the jump leads to `{name}` inside a `{kind}` that it does not stand in itself{error}",
    "put the label before or behind the block",
)
_FALLS_IN: Final = warning(
    "MB135",
    "control can run into the subroutine `{name}` from above (controller error 3840 at `Return`)",
    "write `End` or a `GoTo` in front of the label",
)
_JUMPED_INTO: Final = warning(
    "MB136",
    "`GoTo` leads into the subroutine `{name}` (controller error 3840 at its `Return`)",
    "call it with `GoSub`",
)
_RETURN_ALONE: Final = warning(
    "MB137",
    "`Return` is reached without a `GoSub` (controller error 3840)",
    "write `End`, or call these lines with `GoSub`",
)
_NO_RETURN: Final = warning(
    "MB138",
    "the subroutine `{name}` never comes to a `Return`",
    "end it with `Return`, or go there with `GoTo`",
)
_HANDLER_RETURN: Final = error(
    "MB139",
    "the interrupt's subroutine `{name}` ends with a `Return` without number",
    "write `Return 0` to redo the interrupted line, `Return 1` to go on with the next one",
)
_NUMBERED_RETURN: Final = warning(
    "MB140",
    "`Return` has a number, but `{name}` is no subroutine of an interrupt",
    "write `Return` alone",
)
_UNREACHABLE: Final = warning(
    "MB141", "nothing leads here: {before}", "remove the lines, or jump to a label at them"
)
CALLED_TOO_DEEP: Final = error(
    "MB142",
    "`CallP` is {depth} programs deep here, more than {most} (controller error 3710)",
    "call fewer programs inside each other",
)
CALLS_ITSELF: Final = error(
    "MB143", "the program calls itself: {chain}; `CallP` knows no recursion", "write a loop"
)
READ_BEFORE_SET: Final = warning(
    "MB148",
    "`{program}`, which starts here in {slot}, reads `{name}` in line {reading}, and {setter} may "
    "not have set it by then: it finds 0, or what the last run left there",
    "set `{name}` before the line that starts `{program}`",
)
LAST_VALUE: Final = info(
    "MB149",
    "`{name}` is read here before this program has set it, and {program} sets it in another slot: "
    "until then it is 0, or what the last run left there",
    "set `{name}` before the line that starts {program}",
)
_LOOP_VARIABLE: Final = info(
    "MB144",
    "the variable `{name}` of the loop is changed inside it",
    "use a variable of its own, or write the loop with `While`",
)
_SAME_VARIABLE: Final = warning(
    "MB145",
    "a loop over `{name}` stands inside another one over it",
    "use a variable of its own for the inner loop",
)
_WRONG_NEXT: Final = error(
    "MB146",
    "`Next` names `{name}`, but the loop runs over `{wanted}` (controller error 3230)",
    "write `Next {wanted}`",
)
_TWO_ELSE: Final = error(
    "MB147",
    "`{word}` stands behind the `{other}` of its block{error}",
    "put `{other}` last, and once",
)


_BLOCK_ERRORS: Final = {"For": 3230, "While": 3250, "If": 3252, "Select": 3254}
"""Kind of a block → what the controller shows where its words do not fit."""
_CLOSERS: Final[Mapping[str, str]] = {kind: word for word, kind in CLOSING.items()}


@dataclass(slots=True)
class ScopePart:
    """A scope with its blocks, and the ways through it if they are sound."""

    scope: Scope
    blocks: Blocks
    ways: Graph | None


def scope_parts(look: Look) -> list[ScopePart]:
    """Each scope of a file, worked out once."""
    found = []
    # Only jumps to step numbers need the table of steps.
    jumps = any(isinstance(target.place, int) for _, target in look.all(s.Target))
    steps = places_of_steps(look.code) if jumps else {}
    for scope in look.scopes:
        blocks = blocks_of(look.code, scope.entries)
        ways = graph_of(look.code, scope.entries, blocks, steps) if blocks.sound else None
        found.append(ScopePart(scope, blocks, ways))
    return found


def _graphs(look: Look) -> Iterator[tuple[ScopePart, Graph]]:
    """The scopes that have lines and whose blocks are sound, with the ways through them."""
    for part in look.once(scope_parts):
        if part.ways is not None and part.scope.entries:
            yield part, part.ways


def structure(look: Look) -> Found:
    """Blocks that do not close, that close in another order, or that stand too deep."""
    for part in look.once(scope_parts):
        for wrong in part.blocks.wrong:
            yield from _misfit(look, wrong)
        for block in part.blocks.all:
            line, kind = look.code[block.first], block.kind
            if block.last is None:
                number = _BLOCK_ERRORS[kind]
                yield look.at(
                    _UNBALANCED, line, kind, word=kind, other=_CLOSERS[kind], number=number
                )
            yield from _depth(look, block)
            yield from _branch_order(look, block)


def _misfit(look: Look, wrong: Misfit) -> Found:
    line = look.code[wrong.at]
    word = word_of(statement_of(line))
    number = 3255 if word in ("Else", "ElseIf") else _BLOCK_ERRORS[wrong.kind]
    if wrong.inside is None:
        yield look.at(_UNBALANCED, line, word, word=word, other=wrong.kind, number=number)
    elif wrong.inside.last is not None:  # else it is told that the inner one does not close
        kind = wrong.inside.kind
        yield look.at(_CROSSED, line, word, word=word, inner=kind, number=number)


def _depth(look: Look, block: Block) -> Found:
    line, kind = look.code[block.first], block.kind
    if kind == "Select":
        nested = any(b.kind == "Select" for b in block.chain if b is not block)
        if nested and not look.dialect.nested_select:
            yield look.at(_NESTED_SELECT, line, kind, title=look.dialect.title)
        return
    most, number = (look.dialect.loops, 3240) if kind != "If" else (look.dialect.ifs, 3253)
    around = (b for b in block.chain if b.form == block.form)
    depth = sum(1 for _ in islice(around, most + 2))
    # Only the first block that is too deep; those inside it are so because of it.
    if depth == most + 1:
        yield look.at(_TOO_DEEP, line, kind, word=kind, depth=depth, most=most, number=number)


def _branch_order(look: Look, block: Block) -> Found:
    """Branches behind Else, and cases behind Default that it makes unreachable."""
    last = {"If": "Else", "Select": "Default"}.get(block.kind)
    seen = False
    for at in block.parts:
        line = look.code[at]
        word = word_of(statement_of(line))
        if seen and (word == last or block.kind == "If"):
            error = " (controller error 3255)" if block.kind == "If" else ""
            yield look.at(_TWO_ELSE, line, word, word=word, other=last, error=error)
        seen = seen or word == last


def loops(look: Look) -> Found:
    """Variables of For loops: changed inside, used by an inner loop, named wrongly by Next."""
    for part in look.once(scope_parts):
        over: dict[int, s.Variable] = {}
        told: set[int] = set()
        around = _Around(over)
        for block in part.blocks.all:
            line = look.code[block.first]
            if isinstance(loop := statement_of(line), s.For):
                variable = over[block.first] = loop.variable
                if around.of(block.around, variable):
                    yield look.at(_SAME_VARIABLE, line, variable, name=variable.name)
        for at in part.scope.entries:
            item = look.code[at]
            if isinstance(item.statement, s.Next):
                yield from _next(look, part, at, item, item.statement, over)
            inner, target = part.blocks.around.get(at), _changed(item.statement)
            if target is None or inner is None:
                continue
            for block in reversed(around.of(inner, target)):
                if block.first not in told:  # some leave their loops so, at many places
                    told.add(block.first)
                    yield look.at(_LOOP_VARIABLE, item, target, name=target.name)


class _Around:
    """The For loops around a place, by their variable; query the places in ascending order.

    over: place of a loop → its variable.
    """

    def __init__(self, over: Mapping[int, s.Variable]) -> None:
        self._over = over
        self._open: list[Block] = []
        self._known: set[int] = set()
        self._by_key: dict[str, list[Block]] = {}

    def of(self, inner: Block | None, variable: s.Variable) -> list[Block]:
        """Those around a place that count with a variable, the outer ones first.

        inner: the innermost block around the place.
        """
        fresh: list[Block] = []
        # Blocks that are not known yet, up to one that is.
        while inner is not None and id(inner) not in self._known:
            fresh.append(inner)
            inner = inner.around
        # Blocks of that stack which the place is no longer in.
        while self._open and self._open[-1] is not inner:
            left = self._open.pop()
            self._known.discard(id(left))
            if left.first in self._over:
                self._by_key[self._over[left.first].key].pop()
        for block in reversed(fresh):
            self._open.append(block)
            self._known.add(id(block))
            if block.first in self._over:
                self._by_key.setdefault(self._over[block.first].key, []).append(block)
        return self._by_key.get(variable.key, [])


def _changed(statement: s.Statement | None) -> s.Variable | None:
    match statement:
        case s.Assign(target) if target.arguments is None and not target.component:
            return target
        case s.If(_, s.Assign(target)) if target.arguments is None and not target.component:
            return target
    return None


def _next(
    look: Look, part: ScopePart, at: int, line: s.Entry, node: s.Next, over: dict[int, s.Variable]
) -> Found:
    for variable, block in zip(node.variables, part.blocks.closing.get(at, ()), strict=False):
        wanted = over.get(block.first)
        if wanted is not None and wanted.key != variable.key:
            yield look.at(_WRONG_NEXT, line, variable, name=variable.name, wanted=wanted.name)


# --------------------------------------------------------------------------------------- jumps


def into_blocks(look: Look) -> Found:
    """Jumps from outside to labels inside of a block."""
    for part, ways in _graphs(look):
        for at, places in ways.jumps.items():
            here = {id(b) for b in part.blocks.within(at)}
            for place in places:
                missed = [b for b in part.blocks.within(place) if id(b) not in here]
                line = look.code[place]
                if missed and isinstance(line, s.Line):
                    kind = missed[-1].kind
                    name = _line_name(look, place)
                    loop = kind in ("For", "While")
                    error = f" (controller error {_BLOCK_ERRORS[kind]})" if loop else ""
                    yield look.at(
                        _INTO_BLOCK, look.code[at], name, name=name, kind=kind, error=error
                    )


def subroutines(look: Look) -> Found:
    """Subroutines that are entered by the way, or left by none."""

    def returns(at: int) -> Iterator[bool]:
        for one in statements_in(look.code[at].statement):
            if isinstance(one, s.Command) and one.keyword == "Return":
                yield bool(one.arguments)

    for part, ways in _graphs(look):
        subs = Subroutines(ways, part.scope.entries[0], returns)
        into, alone = subs.entered()
        for at, before in into.items():
            name = _line_name(look, at)
            if at in ways.jumps.get(before, ()):
                yield look.at(_JUMPED_INTO, look.code[before], name, name=name)
            else:
                yield _found_at_callee(look, _FALLS_IN, at)
        for at in alone:
            yield look.at(_RETURN_ALONE, look.code[at], "Return")
        for at in subs.endless():
            # A stop for good, `Hlt` in a loop, calls nothing again, so the stack stays as it is.
            stopped = any(_halts(look.code[place]) for place in subs.within(at))
            if isinstance(look.code[at], s.Line) and not stopped:
                yield _found_at_callee(look, _NO_RETURN, at)
        for at, sub, numbered in subs.of_wrong_kind():
            rule = _NUMBERED_RETURN if numbered else _HANDLER_RETURN
            yield look.at(rule, look.code[at], "Return", name=_line_name(look, sub))


def _halts(item: s.Item) -> bool:
    statement = item.statement if isinstance(item, s.Line) else None
    return isinstance(statement, s.Command) and statement.keyword == "Hlt"


def _line_name(look: Look, at: int) -> str:
    """Return the name that jumps use for a line: its label, else its step number."""
    line = look.code[at]
    return str(first_step(line)) if line.label is None else f"*{line.label}"


def _found_at_callee(look: Look, rule: Rule, at: int) -> Diagnostic:
    """The rule's finding at a line that is called."""
    line, name = look.code[at], _line_name(look, at)
    where = look.word(line, name) if name.startswith("*") else None
    return look.finding(rule, where or line, name=name)


def unreachable(look: Look) -> Found:
    """The first line of each stretch that nothing leads to; what is no statement does not count."""
    for part, ways in _graphs(look):
        # Interrupts may run a handler that no line leads to.
        starts = [part.scope.entries[0], *ways.handlers]
        reached = ways.reached(starts, through_calls=True)
        quiet = False
        for at in part.scope.entries:
            item = look.code[at]
            if at in reached:
                quiet = False
                continue
            quiet = quiet or item.label is not None  # which is a finding of its own
            if _runs(item):
                if not quiet:
                    yield look.finding(_UNREACHABLE, item, before=_before(look, part, at))
                quiet = True


SILENT: Final = (
    s.DefNames, s.DefIo, s.DefFunction, s.DefOther, s.Dim, s.Const, s.Static, s.Include,
    s.Next, s.Jump,
)  # fmt: skip
_TAILS: Final = frozenset({"End", "Hlt", "Return", "FEnd", "Break", "EndIf", "End Select", "WEnd"})
"""Words that stand at an end as a habit, and do no harm where nothing comes to them."""


def _runs(item: s.Entry) -> bool:
    """True if a line does something that would be missed where control does not reach it."""
    statement = item.statement
    if statement is None:
        return isinstance(item, MoveRows)
    silent = isinstance(statement, SILENT) or block_word(statement).parts
    return not silent and word_of(statement) not in _TAILS


def _before(look: Look, part: ScopePart, at: int) -> str:
    """Return why control does not run on to a line, in words."""
    entries = part.scope.entries
    for place in reversed(entries[: entries.index(at)]):
        item = look.code[place]
        if item.statement is None:
            continue
        word = word_of(item.statement)
        if isinstance(item.statement, s.Select):
            return "it stands between `Select` and its first `Case`"
        if word in CLOSING:
            return "every way through the block above leaves it for good"
        return f"`{word}` stands in front of it" if word else "what is above leaves for good"
    return "nothing is above"
