"""Changes of a program merged into the text that it was lifted from, and step numbers counted anew.

Lifting and building lose layout, order and spelling, so a changed program is built twice: as it
was lifted, and as it is now. What differs between the two is changed in the tree as well. Where a
change can go is found by trying, and a try counts only if the result means what the built tree
means.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages import step_numbers
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP
from assistant.languages.melfa_basic.tables.vocabulary import commands
from assistant.languages.melfa_basic.text import header
from assistant.languages.melfa_basic.text.printer import expression
from assistant.languages.melfa_basic.text.printer import statement as printed
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.control_flow import retargeted, steps_named
from assistant.languages.melfa_basic.tree.line_tables import gathered, rows_as_lines
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.languages.step_numbers import UNNUMBERED, Steps, steps_of, with_fitted_steps
from assistant.languages.texts.line_merge import DataMerger, LineMerger, LinePart
from assistant.program.rewriting import rewrite

_EMPTY_STEP: Final = "'"
"""The step that a blank line between others becomes: a bare one would end the program."""

STEPS: Final = Steps(
    s.Line,
    LAST_STEP,
    named=steps_named,
    retargeted=retargeted,
    falling=rules.NOT_ASCENDING,
    past_last=rules.PAST_LAST_STEP,
    unknown=rules.NO_STEP,
)


def renumbered(file: s.File, first: int, step: int) -> s.File:
    """The program with its steps numbered first, first + step …, jumps to them included.

    Lines without a number get one, but for variable lines; so does a program without any.
    Raises Refused where that cannot be done.
    """
    made = step_numbers.renumbered(_all_steps(file.items), first, step, STEPS, file.source)
    kept = len(made) == len(file.items) and all(
        a is b for a, b in zip(made, file.items, strict=True)
    )
    return file if kept else replace(file, items=tuple(made))


def _all_steps(items: Sequence[s.Item]) -> tuple[s.Item, ...]:
    """The items with every line that is to be a step marked as one, blank lines included."""
    numbered = [len(steps_of(item)) > 0 for item in items]
    code = [at for at, item in enumerate(items) if isinstance(item, s.Entry)]
    # In a file without step numbers, blank lines up to the last step become steps as well.
    last = code[-1] if code and not any(numbered) else -1
    made: list[s.Item] = []
    for at, item in enumerate(items):
        if isinstance(item, s.Blank) and at < last:
            item = s.Line(UNNUMBERED, comment=_EMPTY_STEP)
        elif isinstance(item, s.Line) and item.number is None:
            if not (any(numbered) and _looks_like_data(item)):
                item = replace(item, number=UNNUMBERED)
        made.append(item)
    return tuple(made)


def _looks_like_data(item: s.Line) -> bool:
    """True if an unnumbered line is a variable line to which a comment was added."""
    match item.statement:
        case s.Assign(value=s.Constant() | s.Number() | s.String() | s.Unary(operand=s.Number())):
            return item.label is None
    return False


_Spelling = Callable[[str], str]


def merge(tree: s.File, before: s.File, after: s.File, says: Callable[[s.File], bool]) -> s.File:
    """The tree with everything changed that differs between two built trees, else `after`.

    says: whether a tree says what `after` does.
    """
    old, new = (_named_as(file, tree) for file in (before, after))
    # The strategies place new lines differently; the first result with the right meaning is taken.
    for lines in _LINES.merged(tree.items, old, new):
        items = _DATA.merged(lines, old, new)
        numbered = (
            None if items is None else with_fitted_steps(items, DIALECTS[tree.dialect].step, STEPS)
        )
        if numbered is not None and says(merged := replace(tree, items=tuple(numbered))):
            return merged
    return after


class _Lines(LineMerger):
    line, table = s.Line, MoveRows
    header = f"' {header.MARK}melfa-basic", f"' {header.END}"

    def parts(self, line: s.Line) -> Iterator[LinePart]:
        if line.comment is not None:
            yield LinePart("comment", "' " + line.comment.removeprefix("'").strip())
        if line.label is not None:
            yield LinePart("label", "*" + line.label.upper())
        if (statement := line.statement) is not None:
            word = getattr(statement, "keyword", "")
            sets = isinstance(statement, s.Command) and word in commands("sets")
            key = printed(_spelled(statement, str.upper, str.upper), upper=True)
            yield LinePart("statement", key, (type(statement), word), word if sets else None)

    def rows_as_lines(self, rows: MoveRows) -> Iterator[s.Line | s.Data]:
        return rows_as_lines(rows)


class _Data(DataMerger):
    line, table, number = s.Data, PositionRows, "numbers"

    def name(self, line: s.Data) -> str:
        return expression(line.variable).upper()

    def stem(self, table: PositionRows) -> str:
        return table.stem.upper()

    def rows_as_lines(self, table: PositionRows) -> Iterable[s.Item]:
        return rows_as_lines(table)

    def gathered(self, lines: Iterable[s.Item]) -> Iterable[s.Item]:
        return gathered(lines)

    def changed(self, here: s.Data, old: s.Data | None, new: s.Data) -> s.Data:
        """A line with the numbers of the new one where it differs from the old one."""
        was, now, mine = (None if d is None else d.value for d in (old, new, here))
        if not (
            isinstance(was, s.Constant)
            and isinstance(now, s.Constant)
            and isinstance(mine, s.Constant)
            and len(was.values) == len(now.values) == len(mine.values)
        ):
            return replace(here, value=new.value)
        three = zip(mine.values, was.values, now.values, strict=True)
        # Only numbers that differ are exchanged; the others keep their spelling.
        values = tuple(m if w == n else n for m, w, n in three)
        flags = mine.flags if was.flags == now.flags else now.flags
        return replace(here, value=s.Constant(values, flags))


_LINES: Final = _Lines()
_DATA: Final = _Data()


# Names


def _named_as(file: s.File, tree: s.File) -> list[s.Item]:
    """Return the items of a built file with the names that the tree has for them.

    The headings say what each name means. A tree without a heading has the names of the source;
    one that an earlier version wrote may have shortened them in another way.
    """
    names, labels = _used(tree)
    own: dict[tuple[str, str], str | None] = {}
    for short, meant in _meanings(tree):
        own[meant] = None if meant in own else short  # loops may share a name
    known: dict[str, str] = {}
    marks: dict[str, str] = {}
    for short, meant in _meanings(file):
        there = (own.get(meant) or meant[1]).upper()
        for used, spelling in ((names, known), (labels, marks)):
            if there in used:
                spelling[short.upper()] = used[there]
    named: list[s.Item] = []
    for item in file.items:
        if isinstance(item, PositionRows | MoveRows):
            stem = item.stem.upper()
            # Most tables have no name that is spelled in another way, and stay one item.
            if not any(n.startswith(stem) and n[len(stem) :].isdigit() for n in known):
                named.append(item)
                continue
            rows: Sequence[s.Item] = list(rows_as_lines(item))
        else:
            rows = [item]
        for row in rows:
            spelled = _spelled(
                row, lambda n: known.get(n.upper(), n), lambda n: marks.get(n.upper(), n)
            )
            named.append(spelled)
    return named


def _meanings(file: s.File) -> Iterator[tuple[str, tuple[str, str]]]:
    """The names of a file, each with the kind and the source's name of what it means."""
    kept = header.read(_comments(file))
    for short, variable in kept.variables.items():
        yield short, (f"variable of {variable.owner.lower()}", variable.name.upper())
    for kind in header.NAME_KINDS:
        for short, name in kept.names[kind].items():
            yield short, (kind, name.upper())


def _comments(file: s.File) -> Iterator[str]:
    """The comments that begin a file, without their mark."""
    for item in file.items:
        if not isinstance(item, s.Line) or item.comment is None:
            return
        yield item.comment.removeprefix("'").strip()


def _used(tree: s.File) -> tuple[dict[str, str], dict[str, str]]:
    """Upper case → spelling of the names and the labels in a text, the first one of each."""
    names: dict[str, str] = {}
    labels: dict[str, str] = {}
    for node in nodes(tree.items):
        if isinstance(node, s.Variable):
            names.setdefault(node.name.upper(), node.name)
        elif isinstance(node, s.Line) and node.label is not None:
            labels.setdefault(node.label.upper(), node.label)
    return names, labels


def _spelled(node: Any, name: _Spelling, label: _Spelling) -> Any:
    """A line or a part of it with names and labels spelled in another way."""

    def change(one: Any) -> Any:
        match one:
            case s.Variable():
                return replace(one, name=name(one.name))
            case s.Target(str(place)):
                return s.Target(label(place))
            case s.Line(label=str(mark)):
                return replace(one, label=label(mark))
        return one

    return rewrite(node, change)
