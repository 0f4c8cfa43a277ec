"""Text of RAPID to the typed tree: runs as columns first, the rest by the grammar.

A regular expression bounds a run of alike lines and its words; the columns are read from it:

    CONST robtarget p1:=[[600,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    MoveL p1,v100,z10,tool0;
    MoveL [[600,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;

The grammar reads the other lines; each of its rules has a row, or a method of `Nodes`, that makes
the node. A damaged text goes to `recovery`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from operator import itemgetter
from typing import Any, Final, Literal, TypeAlias

import numpy as np

from assistant.base.budgets import without_gc
from assistant.base.columns import Slots
from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText, with_line_feeds
from assistant.languages import nodes
from assistant.languages.grammar import RunInTheWay, Shortened, number_of
from assistant.languages.lalr import Stack
from assistant.languages.nodes import Children, Place, row, without_place
from assistant.languages.rapid import rules
from assistant.languages.rapid.reading import files
from assistant.languages.rapid.tables.constants import (
    LONGEST_NAME,
    MOST_NESTING,
    MOST_OPERATORS,
    RESERVED,
)
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import gathered
from assistant.languages.rapid.tree.syntax import (
    CIRCULAR,
    FEWEST_IN_RUN,
    JOINT,
    LINEAR,
    TARGET_GROUPS,
    TARGET_PARTS,
    File,
    Item,
    MotionNames,
    MoveRun,
    Origin,
    StatementNode,
    TargetRun,
    TargetRunNode,
)
from assistant.languages.runs.columns import Names, Store
from assistant.languages.runs.row_text import MOST, Found, Marks, entries, line_spans, stretches
from assistant.languages.runs.row_text import NameWords as Spelling

# Quantifiers are possessive (`*+`): a line that does not fit is given up without backtracking, so
# that finding runs takes linear time.
_B = r"[ \t]"
_NAME = r"[A-Za-z][A-Za-z0-9_]*+"
_SLOT = rf"{_B}*+[-+0-9.eE]++{_B}*+"
_EOL = rf";{_B}*+(?:\r?\n|\Z)"


def _slots(count: int) -> str:
    return r"\[" + ",".join([_SLOT] * count) + r"\]"


_WIDE = r"\[\[[-+0-9.eE,\[\]]++"
"""A value without blanks; that its brackets and commas stand right is seen in the columns."""
_SPACED = r"\[" + ",".join(_slots(stop - start) for start, stop in TARGET_PARTS) + r"\]"
_DECLARED = rf"{_B}++{_NAME}{_B}*+:={_B}*+(?:{_WIDE}{_EOL}|{_SPACED}{_EOL})"
_TARGET_HEAD = rf"(?P<head>(?:LOCAL{_B}++)?+CONST{_B}++robtarget)"
_SETTINGS = rf"{_B}*+,{_B}*+".join([_NAME] * 3)
_FRAME = rf"(?:{_B}*+,?+{_B}*+\\WObj{_B}*+:={_B}*+{_NAME})?+{_B}*+{_EOL}"
_TAIL = rf"{_B}*+,{_B}*+{_SETTINGS}{_FRAME}"
_MOVE = rf"{_B}*+Move(?:[JL]{_B}++{_NAME}|C{_B}++{_NAME}{_B}*+,{_B}*+{_NAME}){_TAIL}"
# `_WIDE` also takes the comma after the value, so the look-behind asks for `],` in place of a
# comma.
_INLINE = rf"{_B}*+Move[JL]{_B}*+(?:{_WIDE}(?<=\],){_SETTINGS}{_FRAME}|{_SPACED}{_TAIL})"
# The first row stands before the repeated ones, which have to begin with the same words.
_REST = f"{{{FEWEST_IN_RUN - 1},{MOST - 1}}}+"
_ALL = f"{{{FEWEST_IN_RUN},{MOST}}}+"

_RUNS: Final = re.compile(
    rf"^(?:{_B}*+{_TARGET_HEAD}{_DECLARED}(?:{_B}*+(?P=head){_DECLARED}){_REST}"
    rf"|(?P<moves>(?:{_MOVE}){_ALL})|(?P<inline>(?:{_INLINE}){_ALL}))",
    re.MULTILINE,
)
_BLANKS: Final = b" \t\r\n"
_NAME_SPELLING: Final = Spelling(LONGEST_NAME, RESERVED)
_MOVE_KINDS: Final = np.zeros(256, dtype=np.uint8)
_MOVE_KINDS[ord("C")], _MOVE_KINDS[ord("J")], _MOVE_KINDS[ord("L")] = CIRCULAR, JOINT, LINEAR


RunNode: TypeAlias = s.TargetRunNode | s.MoveRunNode
Runs: TypeAlias = Sequence[Found[RunNode]]


def find_runs(text: str) -> Iterator[Found[RunNode]]:
    """The runs of a text, in order; rows that are not exactly plain are left out."""
    # Every row ends with `;`, so their count is the most rows that there can be.
    store = Store(text.count(";"), TARGET_PARTS[-1][1])
    for match in _RUNS.finditer(text):
        head, inline = match["head"], match["inline"] is not None
        read: Callable[[bytes], RunNode] = partial(_move_run, store, inline)
        if head is not None:
            read = partial(_target_run, store, head)
        yield from stretches(text, *match.span(), FEWEST_IN_RUN, store, read)


# Rows without blanks, one behind the other


def _target_run(store: Store, head: str, data: bytes) -> s.TargetRunNode:
    """head: what stands before each name."""
    # Without blanks, marks and numbers of all rows are at the same place of their row.
    text = Slots(data.translate(None, _BLANKS))
    marks = Marks(text, b"=,", b";")
    values = store.take(len(marks.rows))
    equals = marks.offsets[marks.first]
    TARGET_GROUPS.read(text, marks, 1, equals + 1, b";", values)
    starts = marks.rows + len(re.sub(r"\s", "", head))
    scope = "LOCAL" if head.startswith("LOCAL") else ""
    names = _NAME_SPELLING.names(text, starts, equals - len(":"))
    return s.TargetRunNode(scope, TargetRun(names, values), rows=line_spans(data, b";", ended=True))


def _move_run(store: Store, inline: bool, data: bytes) -> s.MoveRunNode:
    text = Slots(data.translate(None, _BLANKS))
    marks = Marks(text, b",", b";")
    # MoveJ, MoveL and MoveC differ in their fifth letter alone.
    kinds = _MOVE_KINDS[text.bytes[marks.rows + len("Move")]]
    names = vias = Names.none(len(kinds))
    begins, values = marks.rows + len("MoveL"), None
    if inline:
        values = store.take(len(kinds))
        ends = TARGET_GROUPS.read(text, marks, 0, begins, b",", values)
    else:
        circular = kinds == CIRCULAR
        # Arcs have one more mark, behind their circle point.
        first, ends = marks.offsets[marks.first], marks.offsets[marks.first + circular]
        if circular.any():
            at = np.flatnonzero(circular)
            vias = _NAME_SPELLING.names(text, begins[at], first[at]).spread(at, len(kinds))
            begins = np.where(circular, first + 1, begins)
        names = _NAME_SPELLING.names(text, begins, ends)
    motions = entries(text, ends + 1, marks.stops, 4 * LONGEST_NAME + 24, _motion_names)
    run = MoveRun(kinds, names, vias, motions, values)
    return s.MoveRunNode(run, rows=line_spans(data, b";", ended=False))


def _motion_names(tail: bytes) -> MotionNames:
    # With a frame the words are `WObj` and its name.
    speed, zone, tool, *frame = re.findall(r"[A-Za-z]\w*", tail.decode("ascii"))
    names = (speed, zone, tool, *frame[1:])
    if any(len(name) > LONGEST_NAME or name.lower() in RESERVED for name in names):
        # The row stays in the text, and the grammar reports it.
        raise ValueError("a word is no name")
    return MotionNames(speed, zone, tool, frame[1] if frame else "")


_TABLE_PART: Final = re.compile(r"[\[\]]|([-+]?)([0-9.]+(?:[eE][-+]?[0-9]+)?)")
_ESCAPE: Final = re.compile(r'""|\\\\|\\([0-9a-fA-F]{2})')


def _unescaped(literal: str) -> str:
    """Return the text of a string literal, given with its quotes."""
    return _ESCAPE.sub(lambda m: chr(int(m[1], 16)) if m[1] else m[0][0], literal[1:-1])


def _module_attribute(children: Children) -> str:
    return str(children[0]).upper()


def _open_dimensions(children: Children) -> int:
    """Return the number of open dimensions of an array parameter, -1 for the hole that the pendant
    leaves.
    """
    return len(children) if children[0] == "*" else -1


# `gathered` makes runs of what the grammar read row by row, as `find_runs` does of a text.
_NODE_ROWS: Final = {
    **dict.fromkeys(("statements", "items", "block"), without_place(gathered)),
    **dict.fromkeys(("attributes", "component", "dimensions", "element"), without_place(tuple)),
    **dict.fromkeys(("parameters", "arguments"), without_place(tuple)),
    **dict.fromkeys(("placeholder", "hole"), row(s.Placeholder, text=str.upper)),
    "module": row(s.Module, "name attributes? items"),
    "attribute": without_place(_module_attribute),
    # declarations
    "record": row(s.Record, "local? name *components"),
    "alias": row(s.Alias, "local? type name"),
    "data": row(
        s.Data, "scope? storage type name dimensions? value", scope=str.upper, storage=str.upper
    ),
    "procedure": row(s.Routine, "local? name parameters? body *handlers", kind="PROC"),
    "function": row(s.Routine, "local? type name parameters? body *handlers", kind="FUNC"),
    "trap": row(s.Routine, "local? name body *handlers", kind="TRAP"),
    "required": row(s.ParameterGroup, "*alternatives", optional=False),
    "optional": row(s.ParameterGroup, "*alternatives", optional=True),
    "parameter": row(s.ParameterNode, "mode? type name dimensions?", mode=str.upper),
    "open_array": without_place(_open_dimensions),
    "backward": row(s.Handler, "body", kind="BACKWARD"),
    "error": row(s.Handler, "*numbers body", kind="ERROR"),
    "undo": row(s.Handler, "body", kind="UNDO"),
    # statements
    "assign": row(s.Assignment),
    "call": row(s.ProcedureCall),
    "late_call": row(s.ProcedureCall),
    "goto": row(s.GotoLabel),
    "label": row(s.LabelMark),
    "return": row(s.ReturnFrom),
    "raise": row(s.RaiseError),
    "exit": row(s.Word, "", word="EXIT"),
    "retry": row(s.Word, "", word="RETRY"),
    "try_next": row(s.Word, "", word="TRYNEXT"),
    "connect": row(s.Connect),
    "elseif": row(s.IfBranch),
    "else_hole": row(s.IfBranch, "_", condition=None, body=()),
    "compact_if": row(s.CompactIf),
    "for": row(s.ForLoop),
    "while": row(s.WhileLoop),
    "test": row(s.TestOf, "subject *cases otherwise"),
    "case": row(s.TestCase, "*values body"),
    "case_hole": row(s.TestCase, "_", values=(), body=()),
    # arguments
    "positional": row(s.Positional, "value"),
    "named_argument": row(s.Positional, "name value"),
    "argument_hole": row(s.Positional, "_", value=s.Placeholder("<ARG>")),
    "option": row(s.Option),
    "conditional": row(s.Conditional),
    # expressions
    "negation": row(s.Prefix, "operand", operator="NOT"),
    "signed": row(s.Prefix),
    "number": row(s.NumberLiteral),
    "string": row(s.StringLiteral, value=_unescaped),
    "true": row(s.BoolLiteral, "_", value=True),
    "false": row(s.BoolLiteral, "_", value=False),
    "aggregate": row(s.AggregateNode, "*items"),
    "group": row(s.Group),
    "function_call": row(s.FunctionCall),
    "member": without_place(itemgetter(0)),
    "whole": row(s.Whole, "_"),
}
"""Rules whose children are the fields of a node."""


class Nodes(nodes.Nodes, rows=_NODE_ROWS):
    """And the others.

    text: what the grammar read. offset: from an offset in it to one in the source, None for the
    same.
    """

    def __init__(self, text: str, offset: Callable[[int], int] | None, runs: Runs) -> None:
        super().__init__(offset)
        self._text, self._runs = text, runs
        self._offset: Callable[[int], int] = offset or (lambda at: at)

    def start(self, _: Place, c: Children) -> tuple[str | None, tuple[Any, ...]]:
        header, *parts = c
        return None if header is None else header[3:-3], tuple(parts)

    def note(self, place: Span, c: Children) -> s.CommentLine:
        at = place.start
        line = self._text[self._text.rfind("\n", 0, at) + 1 : at]
        return s.CommentLine(c[0][1:].strip(), bool(line.strip()), span=self.span(place))

    def targets(self, _: Place, c: Children) -> RunNode:
        found = self._runs[number_of(c[0])]
        return replace(found.node, span=Span(found.start, found.end))

    moves = targets

    def compound_if(self, place: Place, c: Children) -> s.IfThen:
        condition, body, *rest, otherwise = c
        first = s.IfBranch(condition, body)
        return s.IfThen((first, *rest), otherwise, span=self.span(place))

    def _infix(self, place: Place, c: Children) -> Any:
        value = c[0]
        for operator, right in zip(c[1::2], c[2::2], strict=True):
            value = s.Infix(operator.upper(), value, right, span=self.span(place))
        return value

    disjunction = conjunction = relation = sum = term = _infix

    def reference(self, place: Place, c: Children) -> Any:
        span = self.span(place)
        value: s.Variable = s.NameRef(c[0], span=span)
        for part in c[1:]:
            if isinstance(part, str):
                value = s.Component(value, part, span=span)
            else:
                value = s.Element(value, part, span=span)
        return value

    def table(self, place: Span, c: Children) -> s.AggregateNode:
        """Numbers in brackets as `aggregate` gives them."""
        stack: list[list[Any]] = [[]]
        begins: list[int] = []
        for part in _TABLE_PART.finditer(c[0]):
            start, end = place.start + part.start(), place.start + part.end()
            if part[0] == "[":
                begins.append(start)
                stack.append([])
            elif part[0] == "]":
                span = Span(self._offset(begins.pop()), self._offset(end))
                items = tuple(stack.pop())
                stack[-1].append(s.AggregateNode(items, span=span))
            else:
                last = self._offset(end)
                value: Any = s.NumberLiteral(part[2], span=Span(last - len(part[2]), last))
                if part[1]:
                    span = Span(self._offset(start), last)
                    value = s.Prefix("-" if part[1] == "-" else "+", value, span=span)
                stack[-1].append(value)
        (node,) = stack[0]
        assert isinstance(node, s.AggregateNode)
        return node


class _SingleNodes(
    Nodes, rows=dict.fromkeys(("statements", "items", "block"), without_place(tuple))
):
    """Builder with a separate node for every line, however many are alike."""


def parse(source: SourceText | str, *, runs: bool = True) -> File:
    """The tree of a file; of a damaged one what could be read, with a finding for each place.

    A list of modules (`.pgf`) has no parts: `files.listed` tells what it names.
    runs: False has the grammar read every line, which gives the same with a node a row.
    """
    text = source if isinstance(source, SourceText) else _source(source)
    unreadable = files.unreadable(text)
    if unreadable is None and files.is_list(text.text):
        return File((), None, Origin(text, ()), tuple(files.notes(text)))
    reading = unreadable or _read(text, "start", runs=runs)
    if isinstance(reading, Diagnostic):
        return File((), None, Origin(text, ()), (reading,))
    (header, parts), findings = reading
    if findings and not text.text.lstrip().startswith("%%%"):
        header = None  # a header that was put in to read on
    # Recovery reports a strange character at the same place with a cure of its own.
    told = {finding.span.start for finding in findings if finding.span}
    odd = (one for one in text.odd_characters() if one.span is None or one.span.start not in told)
    noted = (*odd, *files.notes(text), *findings)
    return File(parts, header, Origin(text, parts), noted)


def _source(text: str) -> SourceText:
    encoding = "ascii" if text.isascii() else "utf-8"
    return SourceText(text, encoding=encoding, newline=files.newline_of(text))


def parse_statements(text: str) -> tuple[StatementNode, ...] | Diagnostic:
    """A list of statements, or what is wrong with it."""
    read: tuple[StatementNode, ...] | Diagnostic = _read_part(text, "statements")
    return read


def parse_items(text: str) -> tuple[Item, ...] | Diagnostic:
    """A list of declarations and routines, or what is wrong with it."""
    read: tuple[Item, ...] | Diagnostic = _read_part(text, "items")
    return read


def parse_rows(
    text: str, spans: Sequence[Span], start: Literal["statements", "items"]
) -> list[Any]:
    """The lines of a run that are at these places of a text, a node each.

    start: moves are statements, declarations are items of a module. A damaged line, which was
    mended when it was read, is mended once more.
    """
    from assistant.languages.rapid.reading.scanner import grammar, table_words

    tables, words = grammar().tables[start], table_words()
    found: list[Any] = []
    for span in spans:
        line = with_line_feeds(text[span.start : span.end])
        line += ";" * (not line.endswith(";"))  # a statement ends before it
        # The plain drive is the fast path; it gives up at the first damage.
        stack = Stack(tables.first)
        read = words.sound(line, tables.rows, stack.states)
        if tables.drive(stack, read, _SingleNodes(line, span.start.__add__, ())) is None:
            found += stack.values[0]
            continue
        # The blanks move the spans of the line to its place in the text.
        mended = _read(SourceText(" " * span.start + line), start, runs=False)
        found += () if isinstance(mended, Diagnostic) else mended[0]
    return found


def _read_part(text: str, start: str) -> Any:
    source = SourceText(text)
    reading = files.unreadable(source) or _read(source, start, runs=False)
    if isinstance(reading, Diagnostic):
        return reading
    tree, findings = reading
    return findings[0] if findings else tree


@without_gc()
def _read(
    source: SourceText, start: str, *, runs: bool
) -> tuple[Any, tuple[Diagnostic, ...]] | Diagnostic:
    """Return the content of the typed tree and the findings, or the reason that the text cannot be
    read.
    """
    from assistant.languages.rapid.reading.scanner import grammar, table_words

    text = with_line_feeds(source.text)
    tables = grammar().tables[start]
    found: Runs = list(find_runs(text)) if runs else []
    while True:
        short = Shortened.of(text, found, _marks)
        # Asked before parsing: a chain of operators becomes a tree as deep as the chain is long,
        # which functions that recurse over trees cannot walk.
        if (long := _too_long(short.text)) is not None:
            at = short.offset(long)
            return source.finding(rules.TOO_LONG, Span(at, at + 1), most=MOST_OPERATORS)
        nodes = Nodes(short.text, short.offset if found else None, found)
        stack = Stack(tables.first)
        read = table_words().sound(short.text, tables.rows, stack.states)
        sound = tables.drive(stack, read, nodes) is None
        # Searching for the nesting costs more than the parse, so it is done for deep stacks and
        # damage only.
        if sound and stack.deepest < MOST_NESTING:
            return stack.values[0], ()
        if (deep := _too_deep(short.text)) is not None:
            at = short.offset(deep)
            return source.finding(rules.TOO_DEEP, Span(at, at + 1), most=MOST_NESTING)
        if sound:
            return stack.values[0], ()
        from assistant.languages.rapid.reading.recovery import reader

        reading = reader().read(source, text, short, tables, nodes)
        if not isinstance(reading, RunInTheWay):
            value = nodes.start(None, [None]) if reading.value is None else reading.value
            return value, reading.findings
        # What stands before the run wants its first row for itself: `IF x` and a line end.
        found = _without_first_row(text, found, reading.number)


def _marks(found: Found[RunNode]) -> tuple[str, str]:
    opening, closing = (
        files.RUN_MARKS[:2] if isinstance(found.node, TargetRunNode) else files.RUN_MARKS[2:]
    )
    return opening, closing


def _without_first_row(text: str, found: Runs, number: int) -> Runs:
    run = found[number]
    second = text.find("\n", run.start, run.end) + 1
    rest = find_runs(text[second : run.end]) if second else ()
    moved = (one.moved(second) for one in rest)
    return [*found[:number], *moved, *found[number + 1 :]]


# An operator and its operand take two characters at least, so shorter stretches need no count.
_LONG_STRETCH: Final = re.compile(rf"[^;]{{{2 * MOST_OPERATORS},}}")
_OPERATOR_COUNT: Final = re.compile(
    # Comments and strings match first, so that no operator, bracket or word inside them counts.
    r"![^\n]*|\"[^\"\n]*\"|(?P<open>[\[({])|(?P<close>[\])}])|(?P<end>,|:=)"
    r"|(?P<operator>[-+*/.<>=]|\b(?:and|or|xor|div|mod|not)\b)",
    re.IGNORECASE,
)


def _too_long(text: str) -> int | None:
    """Return the offset of the first operator beyond the maximum of an expression, None if every
    expression is short enough.
    """
    for stretch in _LONG_STRETCH.finditer(text):
        counts = [0]
        for match in _OPERATOR_COUNT.finditer(text, stretch.start(), stretch.end()):
            if match["open"]:
                counts.append(0)
            elif match["close"]:
                counts = counts[:-1] or [0]
            elif match["end"]:
                counts[-1] = 0
            elif match["operator"]:
                counts[-1] += 1
                if counts[-1] > MOST_OPERATORS:
                    return match.start()
    return None


_NESTING: Final = re.compile(
    r"![^\n]*|\"[^\"\n]*\"|(?P<open>[\[({]|\b(?:if|for|while|test)\b)"
    # Only an open IF without THEN makes a `;` count.
    r"|(?P<close>[\])}]|\bend(?:if|for|while|test)\b)|;|\bthen\b|(?P<routine>\b(?:proc|func|trap)\b)",
    re.IGNORECASE,
)


def _too_deep(text: str) -> int | None:
    """Offset at which brackets or blocks stand too deep inside each other, None if they do not."""
    depth = compact = 0
    for match in _NESTING.finditer(text):
        word = match[0].lower()
        if match["open"]:
            depth += 1
            compact += word == "if"
            if depth > MOST_NESTING:
                return match.start()
        elif match["close"]:
            depth = max(depth - 1, 0)
        # A routine begins anew, so that a missing end above it does not make it look nested.
        elif match["routine"]:
            depth = compact = 0
        elif word == "then":
            compact = max(compact - 1, 0)
        elif word == ";" and compact:  # IF without THEN ends with its statement
            depth, compact = max(depth - compact, 0), 0
    return None
