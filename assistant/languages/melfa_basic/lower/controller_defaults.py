"""Defaults that a program leaves to its controller, and that another controller must be given.

Such are the tool and the base that stay when the power is off, variables that begin with no value,
angles that a controller computes from an orientation, and moves of the tool that a path leads to
without any `Spd`, as fast as the arm can move. Distances in mm.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import Any, Final, Literal

import numpy as np

from assistant.base.diagnostics import Diagnostic, Span
from assistant.languages.line_blocks import EXIT, Blocks, Graph
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import values
from assistant.languages.melfa_basic.checks.values import incomplete_poses, incomplete_summands
from assistant.languages.melfa_basic.lift.computed_positions import (
    ARC_DIRECTION,
    FIXED_POSTURE,
    pallet_array_name,
)
from assistant.languages.melfa_basic.lift.procedures import Region, Structure, procedure_regions
from assistant.languages.melfa_basic.lift.settings import FRAME, TOOL
from assistant.languages.melfa_basic.lower.program import settings_for_vendor_text
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tables.equivalents import BIT_FUNCTIONS
from assistant.languages.melfa_basic.tables.variables import LAST_SET_PARAMETERS as PARAMETERS
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MOV, MoveRows, row_spans
from assistant.languages.melfa_basic.tree.control_flow import (
    blocks_of,
    graph_of,
    statement_of,
    with_labelled_jumps,
)
from assistant.languages.melfa_basic.tree.walk import (
    FORCE_COMMANDS,
    literal,
    nodes,
    program_key,
    program_name,
    statements_in,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.definite_assignment import (
    first_move,
    functions_of_signed_bits,
    loops_with_changing_limits,
    variables_read_unset,
)
from assistant.program.analysis.uses import unordered
from assistant.program.geometry import BASE, FLANGE
from assistant.program.program import Program

_JOINT_MOVES: Final = ("Mov", "Mva")
"""Moves whose speed `JOvrd` sets."""


def _unset_speeds(trees: Sequence[Any]) -> Iterator[Span | None]:
    """The lines of such moves, in a program of several files of which the first one begins."""
    starts, at = [], 0
    for tree in trees:
        starts.append(at)
        # The texts are joined with a line end, which counts as well.
        at += len(tree.source.text if tree.source else "") + 1
    code = [_FileCode(tree) for tree in trees]
    named = {program_key(program_name(tree)): k for k, tree in enumerate(trees)}
    # `sum` instead of `any`: each round lets every file settle. A file may open paths through
    # others.
    while sum(one.settle(code, named) for one in code):
        pass
    pending, seen = [0] if code else [], set[int]()
    while pending:
        if (number := pending.pop()) in seen:
            continue
        seen.add(number)
        one = code[number]
        for at in sorted(one.unset(one.start, code, named, into=True) - {EXIT}):
            item = one.items[at]
            pending += [named[key] for key in _called_programs(item) if key in named]
            for span in _tool_moves(item):
                yield None if span is None else span.moved(starts[number])


class _FileCode:
    """The lines of a file, and its subroutines from which a path leads back without `Spd`."""

    def __init__(self, tree: s.File) -> None:
        self.items, _ = with_labelled_jumps(tree.code)
        self.start = [0] if self.items else []
        blocks, functions = blocks_of(self.items), _function_regions(self.items)
        if functions is None:
            self.graph = graph_of(self.items, range(len(self.items)), blocks)
        else:
            self.graph, self.start = _function_graph(self.items, functions, blocks)
        self.transparent: set[int] = set()
        self.passes = False
        """True if a path leads through the whole file without `Spd`."""

    def settle(self, code: Sequence[_FileCode], named: Mapping[str, int]) -> bool:
        """Finds more of them by what is known of all files; true if there are any."""
        before = len(self.transparent), self.passes
        for entry in self.graph.called - self.transparent:
            if EXIT in self.unset([entry], code, named):
                self.transparent.add(entry)
        if self.start and not self.passes:
            found = self.unset(self.start, code, named)
            self.passes = EXIT in found or any(
                any(one == s.Command("End") for one in statements_in(statement_of(self.items[at])))
                for at in found - {EXIT}
            )
        return (len(self.transparent), self.passes) != before

    def unset(
        self,
        starts: Sequence[int],
        code: Sequence[_FileCode],
        named: Mapping[str, int],
        *,
        into: bool = False,
    ) -> set[int]:
        """The lines that some path leads to from others without `Spd`, EXIT among them.

        into: also those called.
        """
        found, pending = set[int](), list(starts)
        while pending:
            at = pending.pop()
            if at in found:
                continue
            found.add(at)
            if at == EXIT:
                continue
            item, calls = self.items[at], self.graph.calls.get(at, ())
            if into:
                pending += calls
            if _sets_speed(statement_of(item)):
                continue
            if _calls_surely(statement_of(item)) and any(c not in self.transparent for c in calls):
                continue
            programs = [named[key] for key in _called_programs(item) if key in named]
            # Control comes back from the called program only if some path through it does.
            if programs and not any(code[k].passes for k in programs):
                continue
            pending += self.graph.after[at]
        return found


def _sets_speed(node: s.Statement | s.Target | None) -> bool:
    """True if a statement sets the speed whatever its condition is."""
    match node:
        case s.Command(keyword="Spd"):
            return True
        case s.If(then=then, otherwise=otherwise) if then is not None:
            return _sets_speed(then) and _sets_speed(otherwise)
    return False


def _calls_surely(node: s.Statement | None) -> bool:
    """True if a statement calls all that it names; one of `On n GoSub` is called, or none."""
    return isinstance(node, s.Jump | s.Call | s.Assign)


def _function_regions(items: Sequence[Any]) -> list[Region] | None:
    """The procedures of a file of functions, the one that runs first before the others."""
    if not any(isinstance(statement_of(item), s.Function) for item in items):
        return None
    return procedure_regions(items, Structure(items).depth, {}, False)


def _function_graph(
    items: Sequence[Any], parts: Sequence[Region], blocks: Blocks
) -> tuple[Graph, list[int]]:
    """The paths through functions, and the line that the program begins with."""
    graph, first = Graph(), dict[str, int]()
    for part in parts:
        places = part.places()
        graph.after |= graph_of(items, places, blocks).after
        if places and part.function is not None:
            first[part.function.name.upper()] = places[0]
    for at in graph.after.keys() - {EXIT}:
        statement = statement_of(items[at])
        result = getattr(statement, "target", None)  # a function that gives itself a value
        named = (
            one.key for one in nodes(statement) if isinstance(one, s.Variable) and one is not result
        )
        if calls := [first[key] for key in named if key in first]:
            graph.calls[at] = calls
    return graph, parts[0].places()[:1]


def _called_programs(item: Any) -> Iterator[str]:
    """The programs that a line calls."""
    for node in statements_in(statement_of(item)):
        if isinstance(node, s.CallP) and isinstance(node.program, s.String):
            yield program_key(node.program.value)


def _tool_moves(item: Any) -> Iterator[Span | None]:
    """The lines of an item that move the tool by its own speed."""
    if isinstance(item, MoveRows):
        moves = (item.kinds != MOV).tolist()
        yield from (span for span, is_one in zip(row_spans(item), moves, strict=False) if is_one)
    elif any(
        isinstance(one, s.Motion) and one.keyword not in _JOINT_MOVES
        for one in nodes(statement_of(item))
    ):
        yield item.span


_RETAINED_SETTINGS: Final[tuple[tuple[str, int, Literal["tool", "frame"], str, str, str], ...]] = (
    ("Tool", TOOL, "tool", FLANGE, "P_NTool", "M_TOOL"),
    ("Base", FRAME, "frame", BASE, "P_NBase", "M_BSNO"),
)
"""Settings that stay when the power is off: statement, its number, what it sets, what counts
without it, that said in words, and the status variable that sets it as well."""

_STRAIGHT_TOLERANCE: Final = 1e-6
"""mm that places may be beside a line that they lie on."""
_COMPOSED_ANGLES: Final = frozenset({"P_CURR", "P_FBC", "ALIGN", "FRAM", "INV", "JTOP"})
"""Status variables and functions whose angles are calculated from an orientation."""
_INITIAL_VALUES: Final[Mapping[str, str]] = {"number": "0", "integer": "0", "text": "an empty text"}
"""Initial value of a variable in other languages, by its type."""


def assumed(program: Program, to: str) -> Iterator[Diagnostic]:
    """Findings on a lifted program, with its spans, that is written anew in the language `to`."""
    trees = () if program.origin is None else program.origin.trees
    commands = list(_statements_with_spans(trees))
    text = "\n".join(tree.source.text if tree.source else "" for tree in trees)
    left = settings_for_vendor_text(program) if to in DIALECTS else frozenset()
    for word, number, of, default, plain, status in _RETAINED_SETTINGS:
        set_at = [span for span, node in commands if _sets_mount(node, word, status)]
        if None in set_at:
            yield rules.KEPT_BY_A_PARAMETER(word=word, what=word.lower(), name=PARAMETERS[word])
        span = first_move(program, default, of)
        # A setting only after the first move leaves that move to what the controller has kept.
        if span is not None and all(one is not None and one.start > span.start for one in set_at):
            how = (
                "as it stands, like the texts that stay"
                if number in left
                else f"without a {word.lower()}"
            )
            yield rules.SETTING_KEPT(word=word, what=word.lower(), how=how, plain=plain, span=span)
    yield from _incomplete_positions(trees)
    there = {program_key(program_name(tree)) for tree in trees}
    for span, node in commands:
        if isinstance(node, s.CallP) and isinstance(node.program, s.String):
            name, what = node.program.value, _command_text(text, span)
            if what and to not in DIALECTS:
                yield rules.OUTSIDE(what=what, name=name, span=span)
            elif not what and program_key(name) not in there:
                yield rules.NOT_CALLED(name=name, span=span)
    if to not in DIALECTS:
        for span in _unset_speeds(trees):
            yield rules.FULL_SPEED(span=span)
        yield from _renamed_positions(program)
        yield from _changing_loops(program)
        yield from _signed_bits(program)
        yield from _unset_variables(program)
        yield from unordered(program, rules.CANNOT_SAY)
        worked_out = _composed_variables(node for _, node in commands)
        for span in _reading_lines(trees, "P_FBC"):
            yield rules.MEASURED(span=span)
        for span, node in commands:
            if isinstance(node, s.Assign) and node.target.key.startswith(("PFS", "MFS")):
                state = _matched_text(text, span, r"\b([PM]_Fs\w+)\s*=")
                if state:
                    yield rules.STATE(name=state, span=span)
            if isinstance(node, s.DefOther) and _is_straight_arc(node, program):
                yield rules.STRAIGHT_ARC(number=literal(node.arguments[0]), span=span)
            if isinstance(node, s.DefOther) and (name := _composed_corner(node, worked_out)):
                yield rules.PALLET_TURNED(number=literal(node.arguments[0]), name=name, span=span)
            if isinstance(node, s.Command) and node.keyword == "Cnt" and _rounds_nothing(node):
                yield rules.NO_CORNER(span=span)
            if isinstance(node, s.Command) and node.keyword == "JOvrd":
                yield rules.JOINT_OVERRIDE(span=span)


def _renamed_positions(program: Program) -> Iterator[Diagnostic]:
    """Positions of one stem that are too many to be separate targets."""
    for statement in program.statements():
        if isinstance(statement, p.Follow) and statement.path.original is not None:
            path = statement.path
            yield rules.RENAMED(
                first=path.row_name(0),
                last=path.row_name(len(path) - 1),
                count=len(path),
                name=path.name,
                span=statement.row_span(0),
            )


def _incomplete_positions(trees: tuple[Any, ...]) -> Iterator[Diagnostic]:
    """Positions with elements that have no value, taken as poses or added."""
    start = 0
    for tree in trees:
        for one in incomplete_poses(tree):
            span = None if one.item.span is None else one.item.span.moved(start)
            yield values.UNDEFINED(span=span, name=one.name, what=one.what)
        for item in tree.items:
            if isinstance(item, s.Line) and item.span is not None:
                for node in nodes(item.statement):
                    for constant in incomplete_summands(node) if isinstance(node, s.Binary) else ():
                        name = printer.expression(constant)
                        span = item.span.moved(start)
                        yield rules.ADDED(name=name, span=span)
        start += len(tree.source.text if tree.source else "") + 1


def _statements_with_spans(trees: tuple[Any, ...]) -> Iterator[tuple[Span | None, s.Statement]]:
    """Statements with their spans, which count on from one text to the next."""
    for span, statement in _lines(trees):
        for node in nodes(statement):
            if isinstance(node, s.Command | s.Assign | s.DefOther | s.CallP):
                yield span, node


def _reading_lines(trees: tuple[Any, ...], key: str) -> Iterator[Span | None]:
    """The lines that read a status variable."""
    for span, statement in _lines(trees):
        if any(isinstance(node, s.Variable) and node.key == key for node in nodes(statement)):
            yield span


def _lines(trees: tuple[Any, ...]) -> Iterator[tuple[Span | None, s.Statement]]:
    start = 0
    for tree in trees:
        for item in tree.items:
            if isinstance(item, s.Line) and item.statement is not None:
                yield None if item.span is None else item.span.moved(start), item.statement
        start += len(tree.source.text if tree.source else "") + 1


def _sets_mount(node: s.Statement, word: str, status: str) -> bool:
    match node:
        case s.Command(keyword=keyword):
            return keyword == word
        case s.Assign(target=target):
            return target.key == status
    return False


def _command_text(text: str, span: Span | None) -> str:
    """Return the text of a command that a call replaces; empty for a plain call."""
    return _matched_text(text, span, rf"\b((?:{'|'.join(FORCE_COMMANDS)})\b[^'\r\n]*)")


def _matched_text(text: str, span: Span | None, pattern: str) -> str:
    """Return the text that the group of a pattern matches in a line; empty if nothing matches."""
    line = text[span.start : span.end] if span is not None else ""
    found = re.search(pattern, line, re.IGNORECASE)
    return found[1].strip() if found else ""


def _is_straight_arc(node: s.DefOther, program: Program) -> bool:
    """True for a pallet on an arc whose points, as read, lie on a line."""
    if node.kind != "Plt" or literal(node.arguments[-1]) not in (
        ARC_DIRECTION,
        ARC_DIRECTION + FIXED_POSTURE,
    ):
        return False
    found = program.variables.get(pallet_array_name(literal(node.arguments[0]) or 0))
    if found is None or not isinstance(found.initial, e.Aggregate):
        return False
    places = [
        item.target.pose.position for item in found.initial.items if isinstance(item, e.TargetValue)
    ]
    # Points lie on a line if their differences span one dimension at most.
    return int(np.linalg.matrix_rank(np.subtract(places, places[0]), tol=_STRAIGHT_TOLERANCE)) <= 1


def _composed_variables(statements: Iterable[s.Statement]) -> frozenset[str]:
    """Position variables whose angles the controller calculates from an orientation."""
    given: dict[str, list[s.Expression]] = {}
    for node in statements:
        if isinstance(node, s.Assign) and not node.target.component:
            given.setdefault(node.target.key, []).append(node.value)
    found: set[str] = set()
    # A variable that is given another one takes over its calculated angles: repeat until stable.
    while new := {
        name
        for name, values in given.items()
        if name not in found and any(_has_composed_angles(value, found) for value in values)
    }:
        found |= new
    return frozenset(found)


def _has_composed_angles(value: s.Expression, names: Container[str]) -> bool:
    match value:
        case s.Variable(component=""):
            return value.key in names or value.key in _COMPOSED_ANGLES
        case s.Binary("*" | "/", _, by):
            # A plain number scales the position; anything else composes two orientations.
            return literal(by) is None
    return False


def _composed_corner(node: s.DefOther, names: Container[str]) -> str:
    """The first corner with calculated angles that a pallet interpolates; empty without one."""
    if node.kind != "Plt" or len(node.arguments) != 8:
        return ""
    direction = literal(node.arguments[7])
    # All places have the posture of the start, so no angles are divided.
    if direction is not None and direction > FIXED_POSTURE:
        return ""
    corners = [corner for corner in node.arguments[1:5] if corner is not None]
    return next(
        (printer.expression(one) for one in corners if _has_composed_angles(one, names)), ""
    )


def _rounds_nothing(node: s.Command) -> bool:
    match node.arguments:
        case (s.Number(value=1), *distances):
            return any(isinstance(d, s.Number) and d.value == 0 for d in distances)
    return False


def _unset_variables(program: Program) -> Iterator[Diagnostic]:
    """Variables that other languages begin with a value. A position that has none is no place
    there either; of arrays it is not known which elements are read.
    """
    for name, variable, span in variables_read_unset(program):
        if variable.type == "joints":
            yield rules.JOINTS_UNTOLD(name=name, span=span)
        elif variable.type in _INITIAL_VALUES:
            yield rules.BEGINS(name=name, value=_INITIAL_VALUES[variable.type], span=span)


def _signed_bits(program: Program) -> Iterator[Diagnostic]:
    """Bits of numbers that may be below 0: MELFA-BASIC takes those of their complement."""
    for function, span in functions_of_signed_bits(program, BIT_FUNCTIONS):
        yield rules.SIGNED_BITS(word=BIT_FUNCTIONS[function], span=span)


def _changing_loops(program: Program) -> Iterator[Diagnostic]:
    """Loops whose end or step changes inside: not every language works them out again."""
    for loop, changed in loops_with_changing_limits(program):
        names = ", ".join(f"`{name.upper()}`" for name in changed)
        yield rules.LOOP_CHANGED(names=names, span=loop.span)
