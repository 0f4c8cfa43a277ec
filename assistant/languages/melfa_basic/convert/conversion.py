"""Conversion of a program from one dialect of MELFA-BASIC to another: the same statements.

Each file is restructured, renamed and renumbered as a tree, printed and parsed again. Then both
programs are lifted and compared. A program with a `Function`, for a dialect without, goes through
the pseudo-program instead.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.base.source_text import SourceText, finding_in, without_ends
from assistant.languages import step_numbers
from assistant.languages.language_types import Conversion
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.convert import dialect_words
from assistant.languages.melfa_basic.convert.blocks import Jumps, with_blocks
from assistant.languages.melfa_basic.convert.dialect_words import OriginalNames
from assistant.languages.melfa_basic.lift.program import file_stem, lift
from assistant.languages.melfa_basic.reading.files import recognises
from assistant.languages.melfa_basic.reading.parser import parse
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.text.layout import lay_out, render
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import (
    blocks_of,
    labels_of,
    labels_written,
    retargeted,
    targets_in,
    with_labelled_jumps,
)
from assistant.languages.melfa_basic.tree.walk import lines_with
from assistant.languages.texts.words import wrapped_text
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.comparison import Tolerance, compare
from assistant.program.program import Program
from assistant.program.rewriting import rewrite

if TYPE_CHECKING:
    from assistant.robots import Robot


def _without_steps(items: Sequence[s.Item]) -> list[s.Item]:
    """The lines without step numbers."""
    return [replace(i, number=None) if isinstance(i, s.Line) else i for i in items]


def _with_steps(
    items: Sequence[s.Item], step: int, as_steps: Collection[str] = ()
) -> list[s.Item] | None:
    """The lines with ascending step numbers; None if there are more than a program may have.

    step: between numbers, made smaller if they would not fit. as_steps: labels (upper case)
    that go again, with jumps to the number of the line below them.
    """
    kept, dropped = _without_labels(items, as_steps)
    if step_numbers.steps_in(kept) > LAST_STEP:
        return None
    lines = list(step_numbers.with_ascending_steps(kept, step, LAST_STEP))
    places = {name: step_numbers.first_step(lines[at]) for name, at in dropped.items()}
    return [retargeted(item, lambda to: places.get(str(to).upper()) or to) for item in lines]


def _without_labels(
    items: Sequence[s.Item], as_steps: Collection[str]
) -> tuple[list[s.Item], dict[str, int]]:
    """The items without such labels, and the place of the item that each of them stood above."""
    kept: list[s.Item] = []
    dropped: dict[str, int] = {}
    # A label goes only if it is alone on its line and a line with a step number follows.
    for at, item in enumerate(items):
        below = items[at + 1] if at + 1 < len(items) else None
        if (
            isinstance(item, s.Line)
            and item.label is not None
            and item.label.upper() in as_steps
            and item.statement is None
            and item.comment is None
            and isinstance(below, s.Entry)
        ):
            dropped[item.label.upper()] = len(kept)
        else:
            kept.append(item)
    return kept, dropped


def _with_lone_labels(items: Sequence[s.Item]) -> list[s.Item]:
    """Return the lines with each label on a separate line."""
    made: list[s.Item] = []
    for item in items:
        if isinstance(item, s.Line) and item.label is not None and item.statement is not None:
            made += [s.Line(label=item.label, span=item.span), replace(item, label=None)]
        else:
            made.append(item)
    return made


# Comments that are too long


def _with_fitting_comments(items: Sequence[s.Item], dialect: Dialect) -> list[s.Item]:
    """The lines with long comments above them, and over as many lines as they need."""
    made: list[s.Item] = []
    for item in items:
        comment = item.comment if isinstance(item, s.Line) else None
        if not isinstance(item, s.Line) or comment is None:
            made.append(item)
            continue
        room = dialect.line - _STEP_LENGTH
        if item.statement is not None or item.label is not None:
            # An `If` block becomes jumps, whose labels make the line longer.
            jumps = _JUMP_ROOM if isinstance(item.statement, s.If | s.ElseIf) else 0
            if len(printer.line(replace(item, number=None), True).encode()) <= room - jumps:
                made.append(item)
                continue
            made += [
                s.Line(comment=part, span=item.span) for part in wrapped_text(comment, room, "' ")
            ]
            made.append(replace(item, comment=None))
        else:
            parts = wrapped_text(comment, room, "' ")
            made += [item] if len(parts) == 1 else [replace(item, comment=p) for p in parts]
    return made


_STEP_LENGTH: Final = 6
"""Characters of a step number and its blank."""

_JUMP_ROOM: Final = 24
"""Characters that `IF` gets for jumps in the place of a block."""


_DEEPEST_BLOCK: Final = 51
"""Blocks inside one another that are converted; controllers stop at 16."""


@dataclass(frozen=True, slots=True)
class Converted:
    """The files of a program in another dialect.

    trees: in the order of the given ones, parsed from the written text; empty after an error.
    """

    trees: tuple[s.File, ...]
    findings: tuple[Diagnostic, ...] = ()


def convert(trees: Sequence[s.File], to: str) -> Converted:
    """Convert the files of one program, without syntax errors, to another dialect.

    A construct without equivalent in that dialect is a finding of severity error.
    """
    dialect = DIALECTS[to]
    files = [_ConvertedFile(tree, dialect) for tree in trees]
    for file in files:
        file.restructure()
    if dialect.level == 4:
        short = dialect_words.short_names([file.items for file in files], dialect)
        for file in files:
            file.shorten(short)
    written = tuple(file.written() for file in files)
    findings = tuple(finding for file in files for finding in file.findings)
    return Converted(() if has_errors(findings) else written, findings)


class _ConvertedFile:
    """One file on its way."""

    def __init__(self, tree: s.File, dialect: Dialect) -> None:
        self.tree, self.dialect, self.before = tree, dialect, DIALECTS[tree.dialect]
        self.items: list[s.Item] = list(tree.items)
        self.memory = OriginalNames()
        self.as_steps: set[str] = set()
        self.findings: list[Diagnostic] = []

    def complain(self, item: s.Item, what: str, cure: str) -> None:
        finding = finding_in(
            self.tree.source, rules.NOT_CONVERTED, item.span,
            title=self.dialect.title, what=what, cure=cure,
        )  # fmt: skip
        if finding not in self.findings:
            self.findings.append(finding)

    # --------------------------------------------------------------------------- passes

    @property
    def keeps_numbers(self) -> bool:
        """V and VI take each other's lines as they stand."""
        return 4 not in (self.dialect.level, self.before.level)

    def restructure(self) -> None:
        """Everything but names and numbers."""
        if self.dialect.level == self.before.level:
            return
        if self.keeps_numbers:
            self.sideways()
        elif self.dialect.level == 4:
            self.down()
        else:
            self.up()

    def sideways(self) -> None:
        if self.dialect.level < self.before.level:
            self.items = dialect_words.Words(self.dialect, self.memory, self.complain).lines(
                self.items
            )

    def down(self) -> None:
        items, self.memory = dialect_words.take_original_names(self.items)
        items, made = with_labelled_jumps(items)
        self.as_steps = {*made, *self.memory.steps}
        self.memory.steps.clear()
        items = _with_lone_labels(_without_steps(items))
        for line in dialect_words.unreachable_constants(items):
            self.complain(
                line, "a `Const` behind a jump or label", "move it to the head of the program"
            )
        items = _with_fitting_comments(items, self.dialect)
        blocks = blocks_of(items)
        if not blocks.sound or any(block.depth > _DEEPEST_BLOCK for block in blocks.all):
            self.complain(
                self.items[0],
                "blocks that cross each other or stand too deep",
                "close each in order",
            )
            return
        jumps = Jumps(items, blocks, self.dialect, self.complain)
        items = jumps.lines(range(len(items)))
        self.items = dialect_words.Words(self.dialect, self.memory, self.complain).lines(items)

    def up(self) -> None:
        items, self.memory = dialect_words.take_original_names(self.items)
        items, made = with_labelled_jumps(items)
        self.memory.steps |= dict.fromkeys(made)
        items = with_blocks(_without_steps(items), self.dialect)
        items = dialect_words.Words(self.dialect, self.memory, self.complain).lines(items)
        items = dialect_words.restored(items, self.memory)
        given = {
            "named": {n.upper() for n in dialect_words.variables_of(items)},
            "stems": set(),
            "labelled": set(labels_of(items)),
        }
        back = dialect_words.Names()
        # A long name comes back unless the file has got another thing of that name meanwhile.
        for kind, there in given.items():
            known = getattr(self.memory, kind)
            free = {k: v for k, v in known.items() if v.upper() not in there}
            setattr(back, kind, free)
            setattr(self.memory, kind, {k: v for k, v in known.items() if k not in free})
        items = dialect_words.with_names(items, back, upper=False)
        self.items = dialect_words.with_heading_names(items, back.named)

    def shorten(self, short: dialect_words.Names) -> None:
        """Names that the dialect takes; what they were goes into the heading."""
        if self.before.level == 4:
            return
        # also labels that are nowhere, and only jumps name
        named = (str(target.place) for target in targets_in(self.items))
        for kind, written in (
            ("named", dialect_words.variables_of(self.items)),
            ("stems", dialect_words.stems_of(self.items)),
            ("labelled", (*named, *labels_written(self.items))),
        ):
            known = {name.upper(): name for name in written}
            made = getattr(short, kind).items()
            getattr(self.memory, kind).update((new, known[n]) for n, new in made if n in known)
        self.items = dialect_words.with_names(self.items, short, upper=self.dialect.upper)
        self.items = dialect_words.with_heading_names(self.items, short.named)

    # -------------------------------------------------------------------------- writing

    def written(self) -> s.File:
        """The tree of the text that is written."""
        source = self.tree.source
        if self.keeps_numbers:
            items = tuple(
                dialect_words.put_original_names(self.items, self.memory, self.dialect.name)
            )
            changed = replace(self.tree, dialect=self.dialect.name, items=items)
            return _read_back(render(changed), self.dialect, self.tree)
        # Without a heading that names the dialect, a text may be taken for another one.
        text = self.numbered_text(marked=False)
        encoded = text.encode(source.encoding if source else "utf-8", "replace")
        others = (d for d in DIALECTS.values() if d.name != self.dialect.name)
        if any(recognises(encoded, other.level) for other in others):
            text = self.numbered_text(marked=True)
        return _read_back(text, self.dialect, self.tree)

    def numbered_text(self, *, marked: bool) -> str:
        items = dialect_words.put_original_names(
            self.items, self.memory, self.dialect.name, marked=marked
        )
        numbered = _with_steps(items, self.dialect.step, self.as_steps)
        if numbered is None:
            self.complain(self.items[0], "a program of so many lines", "split it into programs")
            return ""
        self.measure(numbered)
        text = render(s.File(self.dialect.name, tuple(numbered)))
        tree = parse(text, self.dialect.name)
        return text if has_errors(tree.findings) else lay_out(tree)

    def measure(self, items: Sequence[s.Item]) -> None:
        """Lines that are too long for the dialect."""
        for line in items:
            if not isinstance(line, s.Line):
                continue
            length = len(printer.line(line, self.dialect.upper).encode("utf-8"))
            if length > self.dialect.line:
                self.complain(
                    line,
                    f"a line of {length} bytes, more than {self.dialect.line}",
                    "split the statement, or write its comment on a line of its own",
                )


def _read_back(text: str, dialect: Dialect, tree: s.File) -> s.File:
    """The tree of a text as the file that it will be. tree: that it was made from."""
    source = tree.source
    plain = without_ends(text)
    if source is None:
        return parse(SourceText(plain), dialect.name)
    plain = plain.replace("\r\n", "\n").replace("\n", source.newline)
    path = None if source.path is None else PurePath(source.path).stem + ".prg"
    return parse(SourceText(plain, path, source.encoding, source.newline), dialect.name)


def conversion(
    program: Program, dialect: str, file_names: Sequence[str], robot: Robot | None
) -> Conversion[s.File] | None:
    """Return the files in the dialect; None if the program is not as it was read in another one.

    None also for programs with a `Function` if the dialect lacks it: they go through the
    pseudo-program. file_names: of the files of trees without a path, in their order. robot: the one
    that the program is to run on.
    """
    origin = program.origin
    if origin is None or origin.language not in DIALECTS or origin.language == dialect:
        return None
    trees = origin.trees
    if any(has_errors(tree.findings) for tree in trees):
        return None
    functions = any(any(lines_with(tree.items, s.Function)) for tree in trees)
    if functions and not DIALECTS[dialect].functions:
        return None  # the pseudo-program has procedures, which every dialect says in its way
    if origin.robot is None:
        read, as_read = None, program == origin.lifted
    else:
        # With or without the arm: whichever lift gives this very program is how it was read.
        arms = dict.fromkeys([None, robot])
        read, as_read = next(((a, True) for a in arms if lift(trees, a) == program), (None, False))
    if not as_read:
        return None
    if robot is not None and read is None and program.robot not in (None, robot.name):
        return None  # another arm: its branches are chosen anew
    converted = convert(trees, dialect)
    left = iter(file_names)
    files: dict[str, s.File] = {}
    for tree in converted.trees:
        path = tree.source.path if tree.source else None
        name = PurePath(path).stem + ".prg" if path else next(left, None)
        if name is None:
            return None
        files[name] = tree
    return Conversion(files, lambda back: compared_programs(trees, back, read), converted.findings)


# Whether it says the same: both sides lifted, in one spelling


def compared_programs(
    before: Sequence[s.File], after: Sequence[s.File], robot: Robot | None
) -> tuple[Program, Program]:
    """The pseudo-programs of both, which must be the same.

    A form that a lift reads in one dialect only is compared in the first one: the program is
    converted back.
    """
    expected, actual = _lifted_pair(before, after, robot)
    if compare(expected, actual, COMPARISON_TOLERANCE).same or not before:
        return expected, actual
    back = convert(after, before[0].dialect)
    if not back.trees:
        return expected, actual
    found = _lifted_pair(before, back.trees, robot)
    return found if compare(*found, COMPARISON_TOLERANCE).same else (expected, actual)


COMPARISON_TOLERANCE: Final = Tolerance(1e-9, 1e-9, 0.0)
"""Tolerance of the comparison itself: numbers are not recomputed."""


def _lifted_pair(
    before: Sequence[s.File], after: Sequence[s.File], robot: Robot | None
) -> tuple[Program, Program]:
    """The pseudo-programs of both, in the words that they share; one if these are the same."""
    lowest = min(DIALECTS[tree.dialect].level for tree in (*before, *after))
    # Equal trees have equal lifts, which are expensive.
    one, two = ([_comparable_tree(tree, lowest) for tree in trees] for trees in (before, after))
    said = _lifted_without_dialect(one, robot)
    return said, said if _lifted_text(one) == _lifted_text(two) else _lifted_without_dialect(
        two, robot
    )


def _lifted_text(trees: Sequence[s.File]) -> list[tuple[str | None, tuple[s.Item, ...]]]:
    """Return the lifted parts of trees, without their dialect."""
    return [(file_stem(tree), tree.items) for tree in trees]


def _lifted_without_dialect(trees: Sequence[s.File], robot: Robot | None) -> Program:
    program: Program = rewrite(lift(trees, robot, divide=False), _without_dialect)
    return program


def _comparable_tree(tree: s.File, lowest: int) -> s.File:
    items, memory = dialect_words.take_original_names(tree.items)
    items, made = with_labelled_jumps(_with_lone_labels(items))
    jumped = {label.upper() for label in made} | set(memory.steps)
    # Labels of steps differ from side to side, but their order does not.
    order = (label for label in labels_of(items) if label in jumped)
    numbers = {label: f"ATSTEP{n}" for n, label in enumerate(order)}
    if lowest == 4 and DIALECTS[tree.dialect].level > 4:
        lower = DIALECTS["melfa-basic-4"]
        items = dialect_words.Words(lower, OriginalNames(), _ignore_complaint).lines(
            _with_fitting_comments(items, lower)
        )
    elif lowest > 4:
        items = [rewrite(item, dialect_words.in_new_words) for item in items]
    table = dialect_words.Names(
        *(
            {k: v.upper() for k, v in getattr(memory, kind).items()}
            for kind in dialect_words.NAME_TABLES
        )
    )
    table.labelled |= numbers
    items = dialect_words.with_heading_names(
        dialect_words.with_names(items, table, upper=True), table.named
    )
    return replace(tree, items=tuple(items), parsed=())


def _ignore_complaint(item: s.Item, what: str, cure: str) -> None:
    """Ignore a construct without equivalent: an earlier step has reported it."""


def _without_dialect(part: Any) -> Any:
    if isinstance(part, p.Opaque | e.Verbatim):
        return replace(part, language="", text=_upper_outside_strings(part.text))
    return part


_STRING_LITERAL: Final = re.compile(r'("[^"]*")')


def _upper_outside_strings(text: str) -> str:
    """In upper case outside of strings."""
    return "".join(t if t.startswith('"') else t.upper() for t in _STRING_LITERAL.split(text))
